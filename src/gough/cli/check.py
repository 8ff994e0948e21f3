"""gough check: every mistake of a file, found without running it."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

from ..errors import ExperimentError, InputError, RunError, SheetError
from ..experiment import SUFFIXES, Experiment, experiment_of, load_experiment, nc_file
from ..files import Document, read_toml
from ..machine import sheet
from .end import Outcome, show_warning
from .progress import preparing


def check_file(file: Path, machine: str | None, quiet: bool, outcome: Outcome) -> None:
    """Say what a file is and that it is right, or raise what is wrong with it.

    Raises
    ------
    InputError
        with every mistake.
    RunError
        the path of the tool leaves what the machine can do.
    """
    warnings.showwarning = show_warning
    file = nc_file(file)
    with preparing(file.name, quiet):
        if file.suffix.lower() in SUFFIXES:
            kind, told = _nc_program(file, machine)
        elif file.suffix.lower() == ".toml":
            kind, told = _toml(read_toml(file), machine)
        else:
            raise ExperimentError(
                "cannot be checked", file=str(file), cure=f"give a .toml file or an NC program ({', '.join(SUFFIXES)})"
            )
    outcome.data.update(file=str(file), kind=kind, **told)
    if not quiet:
        home = told.pop("home", {})
        parts = ", ".join(
            _LABELS.get(key, key) + ("" if value is True else f" {_text(key, value)}") for key, value in told.items()
        )
        outcome.say(f"{file}: {kind}, no mistakes; {parts}", *home.get("words", []))


_LABELS = {"machine_kind": "kind", "box": "from home"}
_NC_PERIOD = 1e-3  # s, at which the path of a bare NC program is looked at
_UNITS = {"duration": "s", "length": "m", "period": "s", "sweep": "runs", "tune": "candidates"}


def _nc_program(file: Path, machine: str | None) -> tuple[str, dict[str, Any]]:
    from ..program import load_program
    from ..program.size import box, too_large

    program = load_program(file)
    if machine is None:
        path = program.path()
        return "NC program", {"length": round(float(path.s0[-1]), 6), "box": box(path).tolist()}
    from ..simulate.reach import check_motion

    found = sheet.load_machine(machine)
    motion = program.plan(found)
    large = too_large(motion.course.path, found, program.text)
    if large is not None:
        warnings.warn(large, stacklevel=2)
    check_motion(found, motion, _NC_PERIOD)
    return "NC program", {"machine": machine, "duration": round(float(motion.duration), 3)}


def _toml(document: Document, machine: str | None) -> tuple[str, dict[str, Any]]:
    if str(document.data.get("schema", "")).startswith("gough-log-map"):
        from ..log.outside.mapping import map_of

        found = map_of(document)
        if machine is not None:
            found.fits(sheet.load_machine(machine))
        return "map of a log", {"joints": len(found.joints.columns), "period": found.time.period}
    if _is_sheet(document):
        try:
            found = sheet.machine_of(document)
        except InputError as error:
            raise SheetError(problems=error.problems) from None
        told = {"machine": found.name, "machine_kind": found.kind, "numbers": len(found.theta)}
        return "data sheet", told | {"home": _at_home(found)}
    experiment = load_experiment(document.path, machine) if machine else experiment_of(document)
    return "experiment", _experiment(experiment)


def warn_of(machine: Any) -> Any:
    """The machine's Standing, warned of what is seldom meant; None where it cannot stand at home."""
    from ..plan.standing import standing

    try:
        found = standing(machine)
    except RunError as error:
        warnings.warn(f"{machine.name} cannot stand at home: {error}", stacklevel=2)
        return None
    for remark in found.remarks:
        warnings.warn(remark, stacklevel=2)
    return found


def own_sheet(experiment: Experiment) -> bool:
    """Whether the believed machine is of a file, not of the library."""
    use = experiment.document.data.get("machine", {}).get("use", "")
    return "/" in use or use.endswith(".toml")


def _at_home(machine: Any) -> dict[str, Any]:
    """What the machine is where it rests; warns of what is seldom meant."""
    found = warn_of(machine)
    if found is None:
        return {}
    return {
        "joints": found.joints.tolist(), "condition": found.condition, "load": found.load,
        "remarks": list(found.remarks), "words": [found.words(machine)],
    }  # fmt: skip


def _experiment(experiment: Experiment) -> dict[str, Any]:
    from ..simulate.reach import check_motion

    try:
        motion = experiment.program.plan(experiment.machine)
    except InputError as error:
        raise experiment.document.locate(error, "program") from None
    sweep = _sweep(experiment) | _tune(experiment)
    _check_cut(experiment, motion)
    _check_loops(experiment, motion.duration)
    check_motion(experiment.machine, motion, experiment.run.period)
    if own_sheet(experiment):
        warn_of(experiment.machine)
    return {
        "machine": experiment.machine.name,
        "controllers": [controller.kind for controller in experiment.controllers],
        **({} if experiment.observer is None else {"observer": experiment.observer.kind}),
        **({} if experiment.compensation is None else {"compensation": True}),
        "duration": round(float(motion.duration), 3),
        **sweep,
    }


def _sweep(experiment: Experiment) -> dict[str, Any]:
    """What the [sweep] table asks for, checked; nothing where there is none."""
    if "sweep" not in experiment.document.data:
        return {}
    from ..sweep.design import design_of

    return {"sweep": len(design_of(experiment)) * len(experiment.controllers)}


def _tune(experiment: Experiment) -> dict[str, Any]:
    """What the [tune] table asks for, checked; nothing where there is none."""
    if "tune" not in experiment.document.data:
        return {}
    from ..tune.table import task_of

    return {"tune": task_of(experiment).table.budget}


def _check_cut(experiment: Experiment, motion: Any) -> None:
    """Refuse a cut that the program does not make, or air that it does not pass."""
    from ..simulate.cut import check
    from ..simulate.leaning import check_air

    try:
        check(None if experiment.plant is None else experiment.plant.cutting, motion)
        check_air(experiment.compensation, motion)
    except InputError as error:
        raise experiment.document.locate(error) from None


def _check_loops(experiment: Experiment, duration: float) -> None:
    """Warn where a controller and the period do not go together; refuse sub-steps that cannot be stable."""
    from ..simulate.plant import Plant
    from ..simulate.stability import check_loop, substeps_of

    run, plant = experiment.run, experiment.plant or Plant(machine=experiment.machine)
    wrong = []
    for i, controller in enumerate(experiment.controllers):
        try:
            substeps = substeps_of(plant.true_machine, plant, duration, run)
            check_loop(experiment.machine, controller.law.on(experiment.machine, run.period), run.period, substeps)
        except InputError as error:
            wrong += [p for p in experiment.locate(error, i).problems if p not in wrong]
    if wrong:
        raise ExperimentError(problems=wrong)


def _is_sheet(document: Document) -> bool:
    """Told by the schema; without one by what only a sheet has."""
    schema = document.data.get("schema")
    if isinstance(schema, str) and schema.startswith(("gough-machine", "gough-experiment")):
        return schema.startswith("gough-machine")
    return "kind" in document.data or "platform" in document.data


def _text(key: str, value: Any) -> str:
    if key == "length":
        return f"{value:.4g} m"
    if key == "box":
        ends = zip("XYZ", *value, strict=True)
        return ", ".join(f"{axis} {1e3 * low:.5g} to {1e3 * high:.5g}" for axis, low, high in ends) + " mm"
    return " and ".join(value) if isinstance(value, list) else f"{value} {_UNITS.get(key, '')}".strip()
