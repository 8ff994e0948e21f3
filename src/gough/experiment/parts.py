"""The parts of an experiment, each made from its table.

Errors carry keys relative to the table; the file and its lines are added by gough.experiment.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ..complaints import beside, under
from ..errors import ExperimentError, InputError, Problem, did_you_mean, nearest
from ..machine import sheet
from .laws import law_class, laws
from .observers import EXAMPLE

if TYPE_CHECKING:
    from ..machine.base import Machine
    from ..observe.base import Observer
    from ..simulate.leaning import Compensation
    from ..simulate.run import Run


class Controller(NamedTuple):
    """One law of an experiment."""

    kind: str
    law: Any


EXAMPLES = {
    "machine": 'write [machine] and use = "nist-octahedral"',
    "plant": 'write [plant] and e.g. payload = "20 kg"',
    "program": 'write [program] and file = "part.ngc"',
    "tools": 'write [tools] and 1 = { length = "80 mm" }, or file = "tool.tbl"',
    "controller": 'write [[controller]] and kind = "pid"',
    "observer": EXAMPLE,
    "compensation": 'write [compensation], height = "18 mm" and air = ["5 mm", "30 mm"]',
    "run": 'write [run] and e.g. period = "1 ms"',
    "tune": 'write [tune] and vary = { "controller.bandwidth" = ["5 Hz", "80 Hz"] }',
    "sweep": 'write [sweep] and vary = { "controller.bandwidth" = ["10 Hz", "20 Hz"] }',
}


def controller_of(table: Any) -> Controller:
    """The law that a [[controller]] table describes.

    Raises
    ------
    InputError
        no such kind, or a wrong key; `key` is set, file and line are not.
    """
    if not isinstance(table, Mapping):
        raise ExperimentError("must be a table", value=brief(table), cure=EXAMPLES["controller"])
    if "kind" not in table:
        raise ExperimentError("is missing", key="kind", cure=f"one of {', '.join(laws())}")
    kind = table["kind"]
    try:
        law = law_class(kind)
    except ExperimentError as error:
        others = beside(kind, laws(), lambda near: controller_of({**table, "kind": near}))
        raise ExperimentError(problems=[*error.problems, *others]) from None
    if "machine" in table:
        raise ExperimentError("no such key", key="machine", cure="a controller believes the machine of [machine]")
    if "law" in law.model_fields and "law" in table:  # one that wraps another
        try:
            table = {**table, "law": controller_of(table["law"]).law}
        except InputError as error:
            raise ExperimentError(problems=[under(problem, "law") for problem in error.problems]) from None
    has_kind = "kind" in law.model_fields
    return Controller(kind, law.from_file({key: raw for key, raw in table.items() if key != "kind" or has_kind}))


def sheet_machine(table: Mapping[str, Any], folder: Path) -> Machine:
    use = table.get("use")
    if not isinstance(use, str):
        rule = "must be a text" if "use" in table else "is missing"
        cure = f"write a path or one of {', '.join(sheet.library())}"
        raise ExperimentError(rule, key="use", value=brief(use) if "use" in table else None, cure=cure)
    try:
        path = sheet.find(use, folder)
    except InputError as error:
        raise error.at(key="use") from None
    if not path.exists():
        raise ExperimentError("no such file", key="use", value=ascii(str(path)))
    return sheet.load_machine(path)


def believed(table: Mapping[str, Any], machine: Machine) -> Machine:
    return sheet.overridden(machine, {key: raw for key, raw in table.items() if key != "use"})


def plant_of(table: Mapping[str, Any], machine: Machine) -> Any:
    from ..simulate.plant import Plant

    own = [name for name in Plant.model_fields if name != "machine"]
    theirs = {key: raw for key, raw in table.items() if key.partition(".")[0] not in own}
    problems, true = [], machine
    try:
        true = sheet.overridden(machine, theirs)
    except InputError as error:
        for problem in error.problems:
            if problem.rule == "has no unit":  # in [plant] a bare number most often stands for a factor
                cure = f'write "{problem.value} x" for so many times the machine\'s own, or its unit'
                problem = replace(problem, cure=cure)
            near = nearest(problem.key or "", own)
            if near and problem.rule == "no such key":
                problem = Problem(problem.rule, key=problem.key, cure=f"did you mean {near}?")
            problems.append(problem)
    try:
        plant = Plant.from_file({"machine": true, **{key: raw for key, raw in table.items() if key not in theirs}})
    except InputError as error:
        problems += error.problems
    if problems:
        raise ExperimentError(problems=problems)
    return plant


def tools_of(table: Mapping[str, Any], folder: Path) -> Any:
    from ..program.load import load_tools
    from ..program.ngc.tools import tools_of as made_of

    if "file" not in table:
        return made_of(table, from_file=True)
    if len(table) > 1:
        raise ExperimentError("tools are in a file or in the table, not both", key="file", cure="remove one")
    if not isinstance(table["file"], str):
        raise ExperimentError("must be the name of a file", key="file", value=brief(table["file"]))
    return load_tools(folder / table["file"])


def program_of(table: Mapping[str, Any], folder: Path, tools: Any = None) -> Any:
    from ..program import program_from_table

    return program_from_table(dict(table), folder, tools)


def compensation_of(table: Mapping[str, Any]) -> Compensation:
    """The leaning against the cut that a [compensation] table describes."""
    from ..simulate.leaning import Compensation

    return Compensation.from_file(table)


def check_compensation(machine: Machine, observer: Observer | None, compensation: Compensation) -> None:
    """Refuse a compensation that has no force to go by, or a machine that cannot lean its tool."""
    from ..simulate.leaning import check

    if observer is None:
        raise ExperimentError("needs an observer of the force on the tool", key="compensation", cure=EXAMPLE)
    check(machine, observer, compensation)


def run_of(table: Mapping[str, Any]) -> Run:
    from ..log.build import VARIABLES
    from ..simulate.run import Run

    problems: list[Problem] = []
    try:
        run = Run.from_file(table)
    except InputError as error:
        problems += error.problems
    signals = table.get("signals")
    for i, name in enumerate(signals if isinstance(signals, list) else ()):
        if (
            isinstance(name, str)
            and name not in VARIABLES
            and not name.startswith(("controller.", "observer.", "plant."))
        ):
            rule, cure = "the log has no such variable", did_you_mean(name, VARIABLES)
            problems.append(Problem(rule, key=f"signals.{i}", value=ascii(name)[:60], cure=cure))
    if problems:
        raise ExperimentError(problems=problems)
    return run


def check_supervision(machine: Machine, run: Run) -> None:
    """Refuse options of a run that its machine cannot serve, or that ask for nothing."""
    from ..simulate.supervise import supervision_of
    from ..simulate.trip import trip_of

    supervision_of(machine, run, trip_of(machine, run.ferror, run.min_ferror))


def check_faults(plant: Any) -> None:
    """Refuse a fault of an encoder that the machine has not."""
    from ..simulate.start import check_faults as check

    check(plant, plant.machine)


def brief(value: Any) -> str:
    text = ascii(value)
    return text if len(text) <= 60 else text[:57] + "..."
