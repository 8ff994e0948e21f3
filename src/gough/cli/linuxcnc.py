"""gough linuxcnc run: an NC program in LinuxCNC, its commands simulated; gough export --target linuxcnc."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..errors import ExperimentError
from ..experiment import Experiment, load_experiment
from ..files import write_atomic
from ..program.nc import NCProgram
from ..units import to_si
from .end import Outcome, show_warning
from .progress import preparing
from .run import run_experiment


class Asked(NamedTuple):
    """How LinuxCNC is run."""

    speed: int
    timeout: str


def run_in_linuxcnc(
    file: Path,
    machine: str | None,
    kinds: Iterable[str],
    seed: int | None,
    asked: Asked,
    out: Path | None,
    force: bool,
    quiet: bool,
    strict: bool,
    outcome: Outcome,
) -> None:
    """Run an NC program in LinuxCNC, simulate what it commanded, write the results folder.

    The folder has in linuxcnc/ the exported machine, configuration and log, and commands.npz: every row recorded.
    """
    from ..linuxcnc import sandbox

    sandbox.check()
    warnings.showwarning = show_warning
    timeout = to_si(asked.timeout, "s")
    experiment = load_experiment(file, machine, kinds, seed)
    if not isinstance(experiment.program, NCProgram):
        raise ExperimentError(
            "LinuxCNC runs NC programs", file=str(file), key="program.kind", cure='write file = "part.ngc" in [program]'
        )

    def prepare(experiment: Experiment, folder: Path) -> Experiment:
        from ..linuxcnc import RecordedProgram, record

        with preparing(f"{experiment.name} in LinuxCNC", quiet):
            recording = record(
                experiment.program, experiment.machine, speed=asked.speed, timeout=timeout,
                keep=folder / "linuxcnc", **options_of(experiment),
            )  # fmt: skip
        np.savez(folder / "linuxcnc" / "commands.npz", period=recording.period, **recording.rows)
        outcome.data["linuxcnc"] = {
            "version": recording.version, "duration": recording.duration, "period": recording.period,
            "rows": len(recording.axis), "said": list(recording.said),
        }  # fmt: skip
        if not quiet:
            outcome.say(*(f"LinuxCNC: {text}" for text in recording.said))
        return replace(experiment, program=RecordedProgram.of(experiment.program, recording, experiment.machine))

    run_experiment(experiment, out, force, quiet, strict, outcome, prepare)


def options_of(experiment: Experiment) -> dict[str, Any]:
    """What an experiment says of an export: observer, servo period, following error."""
    run = experiment.run
    found: dict[str, Any] = {"period": run.period}
    if experiment.observer is not None:
        found["observer"] = experiment.observer
    if run.ferror is not None:
        found |= {"ferror": run.ferror, "min_ferror": run.min_ferror or run.ferror}
    return found


def export_folder(files: dict[str, str], out: Path, outcome: Outcome) -> None:
    """Write the files of an export into a folder that is not there yet, all or none.

    Raises
    ------
    ExperimentError
        there is something in its place.
    """
    import shutil

    target = out.absolute()
    if target.exists() or target.is_symlink():
        raise ExperimentError("there is something already", file=str(out), cure="give a folder that is not there yet")
    partial = target.with_name(f".{target.name}.partial")
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.rmtree(partial, ignore_errors=True)
    try:
        partial.mkdir()
        for name, text in files.items():
            write_atomic(partial / name, text)
        partial.rename(target)
    finally:
        shutil.rmtree(partial, ignore_errors=True)
    outcome.data.update(folder=str(out), files=sorted(files))
