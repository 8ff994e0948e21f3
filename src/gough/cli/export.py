"""gough export: a machine in the file of another program."""

from __future__ import annotations

from pathlib import Path

from ..export import TARGETS, export
from ..machine.sheet import load_machine
from ..units import to_si
from .end import Outcome, deliver


def export_file(
    what: str, target: str, loops: str, timestep: str | None, out: Path | None, force: bool, outcome: Outcome
) -> None:
    """Write a machine for `target` to a file, or to stdout."""
    machine = load_machine(what)
    step = None if timestep is None else to_si(timestep, "s")
    text = export(machine, target, loops=loops, timestep=step)
    outcome.data.update(name=machine.name, target=target)
    if deliver(text, out, force, outcome):
        outcome.say(f"{out} is written: {TARGETS[target][1]} of {machine.name}")
