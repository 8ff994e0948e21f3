"""gough export: a machine in the file of another program, or a machine or experiment in a folder of files."""

from __future__ import annotations

import warnings
from pathlib import Path

from ..errors import ExperimentError
from ..export import BINARIES, FOLDERS, TARGETS, export, export_folder
from ..machine.sheet import load_machine
from ..units import to_si
from .end import Outcome, deliver, show_warning
from .show import is_experiment


def export_file(
    what: str, target: str, loops: str, timestep: str | None, name: str | None, theta: str, out: Path | None,
    force: bool, outcome: Outcome,
) -> None:  # fmt: skip
    """Write a machine for `target` to a file, or to stdout; or what makes a folder into the folder `out`."""
    warnings.showwarning = show_warning
    if target in FOLDERS:
        _folder(what, target, {"name": name, "theta": theta}, out, force, outcome)
        return
    if target in BINARIES:
        _binary(what, target, name, out, force, outcome)
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
    found = _found(what)
    files = export_folder(found, target, out, force, **options)
    outcome.data.update(name=found.name, target=target, folder=str(out), files=sorted(files))
    outcome.say(f"{out} is written: {FOLDERS[target][1]} of {found.name}")


def _binary(what: str, target: str, name: str | None, out: Path | None, force: bool, outcome: Outcome) -> None:
    if out is None:
        raise ExperimentError("this target writes a file", key="--out", cure=f"add -o FILE.{target}")
    if out.is_dir():
        raise ExperimentError("a folder is there", file=str(out), cure="choose another name")
    if out.exists() and not force:
        raise ExperimentError("there is a file already", file=str(out), cure="choose another name, or add --force")
    found = _found(what)
    export(found, target, out, name=name)
    outcome.data.update(name=found.name, target=target, file=str(out))
    outcome.say(f"{out} is written: {BINARIES[target][1]} of {found.name}")


def _found(what: str):
    """A machine, or an experiment."""
    if is_experiment(Path(what)):
        from ..experiment import load_experiment

        return load_experiment(what)
    return load_machine(what)
