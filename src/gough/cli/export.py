"""gough export: a machine in the file of another program."""

from __future__ import annotations

from pathlib import Path

from ..errors import ExperimentError
from ..export import TARGETS, export
from ..files import write_atomic
from ..machine.sheet import load_machine
from ..units import to_si
from .end import Outcome


def export_file(
    what: str, target: str, loops: str, timestep: str | None, out: Path | None, force: bool, outcome: Outcome
) -> None:
    """Write a machine for `target` to a file, or to stdout."""
    machine = load_machine(what)
    step = None if timestep is None else to_si(timestep, "s")
    text = export(machine, target, loops=loops, timestep=step)
    outcome.data.update(name=machine.name, target=target)
    if out is None:
        outcome.data["text"] = text
        if not outcome.as_json:
            outcome.say(text.rstrip())
        return
    if out.exists() and not force:
        raise ExperimentError("there is a file already", file=str(out), cure="choose another name, or add --force")
    write_atomic(out, text)
    outcome.data["file"] = str(out)
    outcome.say(f"{out} is written: {TARGETS[target][1]} of {machine.name}")
