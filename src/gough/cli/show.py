"""gough machines, gough show: machines with all their numbers, programs with all their moves."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import ExperimentError, SheetError
from ..files import Document, read_toml, write_atomic
from ..machine.sheet import find, library, machine_of, source_of
from ..units import show
from .end import Outcome
from .progress import preparing

if TYPE_CHECKING:
    from ..declare import Part
    from ..program import Program


def list_machines(outcome: Outcome) -> None:
    """Name, kind and what the first comment of its sheet says."""
    rows = []
    for name, path in library().items():
        document = read_toml(path, SheetError)
        rows.append(
            {"name": name, "kind": document.data.get("kind"), "about": _about(document.text), "path": str(path)}
        )
    outcome.data["machines"] = rows
    if not outcome.as_json:
        width = max(len(row["name"]) for row in rows)
        outcome.say(*(f"{row['name']:{width}}  {row['kind']}  {row['about']}" for row in rows))


def _about(text: str) -> str:
    first = text.partition("\n")[0]
    return first.removeprefix("#").strip() if first.startswith("#") else ""


def show_anything(name: str, outcome: Outcome, out: Path | None = None, force: bool = False) -> None:
    """A machine, the NC program of a file or of gough's library, or the program of an experiment.

    Raises
    ------
    ExperimentError
        a drawing of what is no machine; a file that is there.
    """
    from ..experiment import SUFFIXES, load_experiment, nc_file
    from ..program import load_program

    path = nc_file(name)
    if out is not None and (path.suffix.lower() in SUFFIXES or _is_experiment(path)):
        raise ExperimentError("only machines are drawn", key="--out", value=name, cure="gough run draws the path")
    if path.suffix.lower() in SUFFIXES:
        show_program(path.name, lambda: load_program(path), outcome)
    elif _is_experiment(path):
        show_program(path.name, lambda: load_experiment(path).program, outcome)
    else:
        show_machine(name, outcome, out, force)


def _is_experiment(path: Path) -> bool:
    if path.suffix.lower() != ".toml" or not path.exists():
        return False
    schema = read_toml(path).data.get("schema")
    return isinstance(schema, str) and schema.startswith("gough-experiment")


def show_machine(name: str, outcome: Outcome, out: Path | None = None, force: bool = False) -> None:
    """A drawing of a machine, and every number with unit, meaning and source; or the drawing as PNG into `out`."""
    path = find(name)
    document = read_toml(path, SheetError)
    machine = machine_of(document)
    if out is not None:
        _draw(machine, out, force, outcome)
        return
    sources = document.data.get("source", {})
    rows = [
        {"key": key, "value": value, "unit": unit, "meaning": meaning, "source": source_of(key, sources)}
        for key, value, unit, meaning in numbers(machine, document)
    ]
    outcome.data.update(name=machine.name, kind=machine.kind, path=str(path), numbers=rows)
    if outcome.as_json:
        return
    outcome.say(f"{machine.name}  ({machine.kind})  {path}", _about(document.text), "")
    if (sys.stdout.encoding or "").lower().replace("-", "") == "utf8":
        from ..report.sketch import sketch

        outcome.say(sketch(machine), "")
    width = max(len(row["key"]) for row in rows)
    for row in rows:
        first, *more = _shown(row["value"], row["unit"])
        outcome.say(f"{row['key']:{width}}  {first:24}  {row['meaning']}")
        outcome.say(*(f"{'':{width}}  {line}" for line in more))
        if row["source"]:
            outcome.say(f"{'':{width}}  {'':24}  - {row['source']}")


def _draw(machine, out: Path, force: bool, outcome: Outcome) -> None:
    """Write the machine's drawing as PNG."""
    import io

    from ..report.sketch import machine_figure

    if out.exists() and not force:
        raise ExperimentError("there is a file already", file=str(out), cure="choose another name, or add --force")
    data = io.BytesIO()
    machine_figure(machine).savefig(data, format="png", dpi=130)
    write_atomic(out, data.getvalue())
    outcome.data["file"] = str(out)
    if not outcome.as_json:
        outcome.say(f"drawing: {out}")


def show_program(name: str, load: Callable[[], Program], outcome: Outcome) -> None:
    """The moves of a program, one line each: NC line, word, end, centre, feed, and what may happen behind it."""
    from ..program.listing import listing

    with preparing(name, outcome.as_json):
        path = load().path()
    if not outcome.as_json:
        outcome.say(listing(path, most=len(path)))
        return
    every = np.arange(len(path))
    pose = np.concatenate([path.point(every, path.length), path.angles(every, path.extent)], 1)
    columns = {"line": path.line, "rapid": path.rapid, "feed": path.feed, "dwell": path.dwell, "end": pose}
    outcome.data["moves"] = [
        dict(zip(columns, row, strict=True)) for row in zip(*(c.tolist() for c in columns.values()), strict=True)
    ]


def numbers(part: Part, document: Document, above: str = "") -> list[tuple[str, Any, str, str]]:
    """(dotted key of the sheet, value, unit, meaning) of every number of a part, in the order of declaration."""
    from ..declare import Part

    out = []
    specs = part.specs()
    for name in type(part).model_fields:
        value = getattr(part, name)
        if isinstance(value, list) and value and isinstance(value[0], Part):
            for i, one in enumerate(value):
                for key, number, unit, meaning in numbers(one, document, f"{above}{name}.{i}."):
                    out.append((key, number, unit, f"{one.joint}: {meaning}"))
        elif isinstance(value, Part):
            out += numbers(value, document, f"{above}{name}.")
        elif name in specs and value is not None:
            key = above + name
            # the one number that has a table to itself
            key = next((f"{key}.{own}" for own in ("pose", "tip", "place") if document.line(f"{key}.{own}")), key)
            value = value.tolist() if isinstance(value, np.ndarray) else value
            out.append((key, value, specs[name].unit, specs[name].meaning))
    return out


def _shown(value: Any, unit: str) -> list[str]:
    """The lines of a number: one for a single value or a row, one a row for a matrix."""
    units = [u.strip() for u in unit.split(",")]
    if not isinstance(value, list):
        return [show(value, units[0], 6)]
    if isinstance(value[0], list):
        return [f"({len(value)} x {len(value[0])}) {unit}", *("  ".join(f"{v:12.6g}" for v in row) for row in value)]
    units = units if len(units) == len(value) else units[:1] * len(value)
    if len(set(units)) == 1:
        return [f"[{', '.join(f'{v:.6g}' for v in value)}] {units[0]}"]
    return [f"[{', '.join(show(v, u, 6) for v, u in zip(value, units, strict=True))}]"]
