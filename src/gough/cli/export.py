"""gough export: a machine in the file of another program, or a machine or experiment in a folder of files."""

from __future__ import annotations

from pathlib import Path

from ..errors import ExperimentError
from ..export import FOLDERS, TARGETS, export, export_folder
from ..machine.sheet import load_machine
from ..units import to_si
from .end import Outcome, deliver
from .show import is_experiment


def export_file(
    what: str, target: str, loops: str, timestep: str | None, name: str | None, theta: str, out: Path | None,
    force: bool, outcome: Outcome,
) -> None:  # fmt: skip
    """Write a machine for `target` to a file, or to stdout; or what makes a folder into the folder `out`."""
    if target in FOLDERS:
        _folder(what, target, {"name": name, "theta": theta}, out, force, outcome)
        return
    machine = load_machine(what)
    step = None if timestep is None else to_si(timestep, "s")
    text = export(machine, target, loops=loops, timestep=step)
    outcome.data.update(name=machine.name, target=target)
    if deliver(text, out, force, outcome):
        outcome.say(f"{out} is written: {TARGETS[target][1]} of {machine.name}")


def _folder(what: str, target: str, options: dict, out: Path | None, force: bool, outcome: Outcome) -> None:
    if out is None:
        raise ExperimentError("this target writes a folder", key="--out", cure="add -o FOLDER")
    if is_experiment(Path(what)):
        from ..experiment import load_experiment

        found = load_experiment(what)
    else:
        found = load_machine(what)
    files = export_folder(found, target, out, force, **options)
    outcome.data.update(name=found.name, target=target, folder=str(out), files=sorted(files))
    outcome.say(f"{out} is written: {FOLDERS[target][1]} of {found.name}")
