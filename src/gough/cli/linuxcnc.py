"""gough linuxcnc run: an NC program in LinuxCNC, and its commands simulated."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..errors import ExperimentError
from ..experiment import Experiment, load_experiment
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
        from ..export.linuxcnc import options_of
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

    run_experiment(experiment, out, force, quiet, strict, outcome, prepare, "gough linuxcnc run")
