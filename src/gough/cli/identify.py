"""gough identify: what logs say of a machine's parameters, as a table or as JSON."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from ..errors import ExperimentError
from ..files import write_atomic
from ..identify.compare import compare, text
from ..identify.figure import check_name, save
from ..identify.fit import identify
from ..identify.rows import joined, rows_of_log
from ..identify.signals import CUTOFF
from ..log.outside import load_map
from ..log.outside.whole import read
from ..machine.sheet import load_machine
from ..units import to_si
from .end import Outcome, plain

FRICTION = ("coulomb", "viscous")  # kinds estimated where nobody says


def identify_log(
    logs: Sequence[Path],
    machine: str,
    map_file: Path | None,
    free: Sequence[str] | None,
    friction: str | None,
    cutoff: str | None,
    compared: bool,
    out: Path | None,
    plot: Path | None,
    force: bool,
    quiet: bool,
    outcome: Outcome,
) -> None:
    """Print the table of a fit; with `out` also write it, or its object where the name ends in .json.

    `plot` is the file of its figure.
    """
    for path in (out, plot):
        if path is not None and path.exists() and not force:  # before the work, not behind it
            raise ExperimentError("there is a file already", file=str(path), cure="choose another name, or add --force")
    if plot is not None:
        check_name(plot)
    believed = load_machine(machine)
    mapping = None if map_file is None else load_map(map_file)
    told = mapping or getattr(believed, "record", None)  # what the record's own map takes where nothing is said
    if friction is None:
        friction = ",".join((told and told.identify.friction) or FRICTION)
    if cutoff is None:
        cutoff = f"{(told and told.identify.cutoff) or CUTOFF!r} Hz"
    sought = None if not free else [word for text in free for word in _words(text)]
    kinds = () if friction == "none" else friction if friction == "known" else _words(friction)
    low = None if cutoff == "none" else to_si(cutoff, "Hz")
    records = [read(log, believed, mapping) for log in logs]
    fit = identify(records, believed, sought, friction=kinds, cutoff=low)
    outcome.data.update(
        machine=fit.machine.name,
        log=str(logs[0]),
        logs=list(map(str, logs)),
        cutoff=low,
        friction=friction,
        **fit.to_json(),
    )
    outcome.data["rows_of"] = of = max(1, round(fit.estimate.rows.samples / len(fit.estimate.rows.u)))
    told = f"{fit}\n{'no filter' if low is None else f'low-pass {low:g} Hz'}, then means of {of} samples"
    if not quiet and not outcome.as_json:
        outcome.say(told)
    if compared:
        parts = [rows_of_log(record, believed, ("coulomb", "viscous"), low) for record in records]
        laws = compare(joined(parts))
        outcome.data["friction_laws"] = [one.to_json() for one in laws]
        told += f"\n\n{text(laws)}"
        if not quiet and not outcome.as_json:
            outcome.say("", text(laws))
    if out is not None:
        as_json = out.suffix.lower() == ".json"
        written = json.dumps(plain(outcome.data), indent=1, allow_nan=False) if as_json else told
        write_atomic(out, written + "\n")
        outcome.data["file"] = str(out)
    if plot is not None:
        save(fit, plot)
        outcome.data["figure"] = str(plot)
        if not outcome.as_json:
            outcome.say(f"figure: {plot}")


def _words(text: str) -> tuple[str, ...]:
    return tuple(word.strip() for word in text.split(",") if word.strip())
