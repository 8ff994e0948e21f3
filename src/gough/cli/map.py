"""gough map: what a machine can do over its workspace, as NetCDF, figures and a table."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..errors import ExperimentError, InputError, did_you_mean
from ..files import write_atomic
from ..machine.sheet import load_machine
from ..results import results_folder
from ..units import to_si
from .end import Outcome, plain

_OPTIONS = ("what", "over", "at", "points")


def map_machine(
    name: str, what: Sequence[str], over: str | None, at: Sequence[str], points: str, out: Path | None, force: bool,
    quiet: bool, outcome: Outcome,
) -> None:  # fmt: skip
    """Write maps of a machine into a results folder, and what they say to stdout."""
    from ..log.file import save
    from ..plan.findings import findings, text_of
    from ..plan.maps import machine_map
    from ..report.map_figures import map_figure

    machine = load_machine(name)
    units = dict(machine.task)
    asked = [word.strip() for one in what for word in one.split(",")]
    fixed = dict(assigned("--at", one, units) for text in at for one in text.split(","))
    try:
        dataset = machine_map(
            machine, asked, over=None if over is None else _ranges(over, units), at=fixed, points=_points(points),
            progress=_shown(quiet or outcome.as_json),
        )  # fmt: skip
    except InputError as error:
        raise _on_the_line(error) from None
    found = findings(dataset)
    told: dict[str, Any] = {"machine": machine.name, "what": asked, **found}
    target = out or Path("results") / f"{machine.name}-map"
    with results_folder(target, force) as folder:
        save(dataset, folder / "map.nc")
        for one in asked:
            map_figure(dataset, one).savefig(folder / f"{one}.png", dpi=150)
        write_atomic(folder / "map.json", json.dumps(plain(told), indent=1))
    names = ["map.nc", *(f"{one}.png" for one in asked), "map.json"]
    outcome.data.update(told, files=[str(target / one) for one in names])
    if not quiet:
        outcome.say(text_of(found))
    if not outcome.as_json:
        outcome.say(f"maps: {target}")


def _shown(quiet: bool):
    if quiet or not sys.stderr.isatty():
        return None

    def progress(share: float) -> None:
        print(f"\r{100 * share:3.0f} % of the poses", end="\n" if share >= 1 else "", file=sys.stderr, flush=True)

    return progress


def assigned(option: str, text: str, units: dict[str, str]) -> tuple[str, float]:
    """z=50 mm as a name and a number, SI."""
    name, equal, value = (part.strip() for part in text.partition("="))
    if not equal or not value:
        first = next(iter(units))
        raise ExperimentError("is NAME=VALUE", key=option, value=repr(text)[:60], cure=f'write "{first}=50 mm"')
    if name not in units:
        cure = did_you_mean(name, units)
        raise ExperimentError("the machine has no such coordinate", key=option, value=repr(name)[:60], cure=cure)
    try:
        return name, to_si(value, units[name])
    except InputError as error:
        raise error.at(key=f"{option} {name}") from None


def _ranges(text: str, units: dict[str, str]) -> dict[str, tuple[float, float] | None]:
    """x,y=-0.1 m..0.1 m as names and ranges; a name alone runs over the declared workspace."""
    out: dict[str, tuple[float, float] | None] = {}
    for one in text.split(","):
        name, equal, value = (part.strip() for part in one.partition("="))
        if not equal:
            out[name] = None
            continue
        low, dots, high = value.partition("..")
        if not dots:
            raise ExperimentError("a range is FROM..TO", key="--over", value=repr(one)[:60],
                                  cure=f'write "{name}=-0.1 m..0.1 m"')  # fmt: skip
        out[name] = tuple(assigned("--over", f"{name}={end}", units)[1] for end in (low, high))
    return out


def _points(text: str) -> int | list[int]:
    try:
        counts = [int(one) for one in text.split(",")]
    except ValueError:
        raise ExperimentError(
            "whole numbers", key="--points", value=repr(text)[:60], cure="write 41, or 41,41,5"
        ) from None
    return counts[0] if len(counts) == 1 else counts


def _on_the_line(error: InputError) -> InputError:
    """The error with the option's name in place of the argument's."""
    import dataclasses

    renamed = [
        dataclasses.replace(p, key=f"--{p.key}") if p.key and p.key.partition(".")[0] in _OPTIONS else p
        for p in error.problems
    ]  # fmt: skip
    return type(error)(problems=renamed)
