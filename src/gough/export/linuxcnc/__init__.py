"""A machine for LinuxCNC: kinematics module, HAL components and a simulation configuration that starts.

files_of(machine) gives the texts of all files by name; `gough export MACHINE --target linuxcnc -o DIR` writes them.
"""

from __future__ import annotations

from typing import Any

from ...errors import ExperimentError
from ...observe.disturbance import DisturbanceObserver
from . import config, core

KINDS = ("hexapod", "hexaglide", "tripod")
PERIOD, FERROR, MIN_FERROR = 1e-3, 1e-3, 0.1e-3  # s, m, m: LinuxCNC's servo period; what a good drive stays well below

__all__ = ["KINDS", "files_of", "linuxcnc_files", "options_of"]


def linuxcnc_files(what, name: str | None = None, theta: str = "constant") -> dict[str, str]:
    """Texts of the files of a machine, or of the machine, observer and supervision of an experiment, by file name.

    Raises
    ------
    ExperimentError
        as `files_of`; `theta` is not "constant": the modules have the sheet's numbers in them.
    """
    if theta != "constant":
        raise ExperimentError(
            "modules of LinuxCNC have the machine's numbers in them", key="--theta", value=ascii(theta)[:60],
            cure="leave --theta out, and export again when the sheet changes",
        )  # fmt: skip
    if hasattr(what, "controllers"):
        return files_of(what.machine, name, **options_of(what))
    return files_of(what, name)


def options_of(experiment) -> dict[str, Any]:
    """What an experiment says of an export: observer, servo period, following error."""
    run, observer = experiment.run, experiment.observer
    found: dict[str, Any] = {"period": run.period}
    if observer is not None:
        if not isinstance(observer, DisturbanceObserver):
            raise ExperimentError(
                "only a disturbance observer is exported to LinuxCNC", key="observer.kind", value=observer.kind,
                cure='write kind = "disturbance", or leave [observer] out',
            )  # fmt: skip
        if observer.period not in (None, run.period):
            raise ExperimentError(
                "in LinuxCNC the observer runs at the servo period", key="observer.period",
                value=f"{observer.period:g} s", limit=f"{run.period:g} s",
            )  # fmt: skip
        found["observer"] = observer
    if run.ferror is not None:
        found |= {"ferror": run.ferror, "min_ferror": run.min_ferror or run.ferror}
    return found


def files_of(
    machine,
    name: str | None = None,
    *,
    observer=None,
    period: float = PERIOD,
    ferror: float = FERROR,
    min_ferror: float = MIN_FERROR,
) -> dict[str, str]:
    """Texts of the files of a machine for LinuxCNC, by file name.

    name        a C identifier that all files begin with; by default the machine's
    observer    a DisturbanceObserver; by default one of 20 Hz that believes the machine
    period      s, of the servo thread
    ferror, min_ferror  m, following error allowed at limits.speed and at rest

    Raises
    ------
    ExperimentError
        the machine is of a kind without kinematics for LinuxCNC, has no limits, or the name is no C identifier.
    """
    if getattr(machine, "kind", None) not in KINDS:
        raise ExperimentError(
            "no kinematics for LinuxCNC for this kind of machine", key="machine",
            value=f"{getattr(machine, 'name', '')}: {getattr(machine, 'kind', type(machine).__name__)}",
            cure=f"one of {', '.join(KINDS)}",
        )  # fmt: skip
    machine = machine.rigid
    word = core.identifier(machine, name)
    config.check_limits(machine)
    if not 0 < min_ferror <= ferror:
        raise ExperimentError("min_ferror must not be above ferror", key="run.min_ferror", value=f"{min_ferror:g} m")
    if not 20e-6 <= period <= 20e-3:
        raise ExperimentError(
            "LinuxCNC's servo thread cannot run at this period", key="run.period", value=f"{period:g} s",
            limit="20 us ... 20 ms",
        )  # fmt: skip
    found = (observer or DisturbanceObserver()).on(machine, period)
    words = core.words_of(machine, found, word)
    words["MIN_FERROR"] = repr(min_ferror * 1e3)
    words["SLOPE"] = repr(0.0 if min_ferror == ferror else ferror / machine.limits.speed)
    files = core.maths(machine, found, word)
    files[f"{word}_kins.c"] = core.filled(core.template("kins.c"), words)
    for part in ("observer", "feedforward", "following"):
        files[f"{word}_{part}.comp"] = core.filled(core.template(f"{part}.comp"), words)
    files["Makefile"] = core.filled(core.template("Makefile"), words)
    files[f"{word}.ini"] = config.ini(machine, words, period, ferror, min_ferror)
    files[f"{word}.hal"] = config.hal(machine, words)
    files[f"{word}.tbl"] = "T1 P1 D0 Z0 ;the tool of the data sheet\n"
    files[f"{word}.var"] = ""
    files["README.md"] = core.filled(core.template("README.md"), words)
    return files
