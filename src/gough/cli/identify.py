"""gough identify: what a log says of a machine's parameters, as a table or as JSON."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from ..errors import ExperimentError
from ..files import write_atomic
from ..identify.fit import identify
from ..log import Log
from ..machine.sheet import load_machine
from ..units import to_si
from .end import Outcome, plain


def identify_log(
    log: Path,
    machine: str,
    free: Sequence[str] | None,
    friction: str,
    cutoff: str,
    out: Path | None,
    force: bool,
    quiet: bool,
    outcome: Outcome,
) -> None:
    """Print the table of a fit; with `out` also write it, or its object where the name ends in .json."""
    if out is not None and out.exists() and not force:  # before the work, not behind it
        raise ExperimentError("there is a file already", file=str(out), cure="choose another name, or add --force")
    sought = None if not free else [word for text in free for word in _words(text)]
    kinds = () if friction == "none" else friction if friction == "known" else _words(friction)
    low = None if cutoff == "none" else to_si(cutoff, "Hz")
    fit = identify(Log.load(log), load_machine(machine), sought, friction=kinds, cutoff=low)
    outcome.data.update(machine=fit.machine.name, log=str(log), **fit.to_json())
    if not quiet and not outcome.as_json:
        outcome.say(fit)
    if out is not None:
        as_json = out.suffix.lower() == ".json"
        text = json.dumps(plain(outcome.data), indent=1, allow_nan=False) if as_json else str(fit)
        write_atomic(out, text + "\n")
        outcome.data["file"] = str(out)


def _words(text: str) -> tuple[str, ...]:
    return tuple(word.strip() for word in text.split(",") if word.strip())
