"""Experiments: a TOML file, schema "gough-experiment-1", as checked objects ready to run.

    [machine]       use = "nist-octahedral"; further keys override the sheet: what is believed
    [plant]         what is true and nobody told the controller: "friction.coulomb" = "1.2 x", payload = "20 kg"
    [program]       file = "part.ngc", or kind = "circle", ...
    [[controller]]  kind = "pid", ...; several run side by side
    [run]           period, substeps, seed, log_every, signals

Every mistake is found at once and said with file, line, key, rule, value and cure.  Nothing in a file is executed:
kinds are looked up in fixed tables and among the entry points `gough.controllers` of installed packages.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from .errors import ExperimentError, InputError, Problem, did_you_mean, nearest
from .files import Document, read_toml
from .laws import START, law_class, laws
from .machine import sheet
from .names import slug

if TYPE_CHECKING:
    from .machine.base import Machine
    from .simulate.run import Run

SCHEMA = "gough-experiment-1"
TABLES = ("machine", "plant", "program", "controller", "run", "sweep")
SUFFIXES = (".ngc", ".nc", ".gcode", ".tap", ".cnc")  # of NC programs


class Controller(NamedTuple):
    """One law of an experiment."""

    kind: str
    law: Any


@dataclass(frozen=True)
class Experiment:
    """What `gough run` runs."""

    name: str
    machine: Machine
    plant: Any
    program: Any
    controllers: tuple[Controller, ...]
    run: Run
    document: Document

    def locate(self, error: InputError, i: int) -> InputError:
        """An error of running controller i with its place in the file."""
        placed = []
        for problem in error.problems:
            head, _, rest = (problem.key or "").partition(".")
            if head == "controller":
                problem = Problem(**{**problem.__dict__, "key": f"controller.{i}.{rest}".rstrip(".")})
            placed.append(problem)
        return self.document.locate(type(error)(problems=placed))

    @property
    def labels(self) -> list[str]:
        """A name for each controller, "pid", "pid-2": also of its log file."""
        kinds = [controller.kind for controller in self.controllers]
        return [
            kind if kinds[:i].count(kind) == 0 else f"{kind}-{kinds[:i].count(kind) + 1}"
            for i, kind in enumerate(kinds)
        ]


def load_experiment(
    path: str | Path, machine: str | None = None, controllers: Iterable[str] = (), seed: int | None = None
) -> Experiment:
    """The experiment of a TOML file or of a bare NC program; the other arguments take the place of what it says.

    Raises
    ------
    ExperimentError
        with every mistake of the file; mistakes of the machine's sheet and the NC program are among them.
    """
    path = Path(path)
    if path.suffix.lower() in SUFFIXES:
        document = _CommandLine(path, "", {"schema": SCHEMA, "program": {"file": path.name}}, {})
    elif path.suffix.lower() == ".toml":
        document = read_toml(path)
    else:
        cure = f"give an experiment (.toml) or an NC program ({', '.join(SUFFIXES)})"
        raise ExperimentError("cannot be run", file=str(path), cure=cure)
    return experiment_of(_changed(document, machine, list(controllers), seed))


def experiment_of(document: Document) -> Experiment:
    """The experiment that a document describes; errors as `load_experiment`."""
    return _Builder(document).build()


class _CommandLine(Document):
    """What the arguments of `gough run part.ngc` say, with their names in errors."""

    def locate(self, error: InputError, prefix: str = "") -> InputError:
        placed = super().locate(error, prefix)
        options = {"machine": "--machine", "controller": "--controller", "run": "--seed"}
        moved = []
        for problem in placed.problems:
            if problem.file == str(self.path) and problem.line is None and problem.key:
                option = options.get(problem.key.partition(".")[0])
                parts = {**problem.__dict__, "key": option}
                problem = Problem(**({**parts, "file": None} if option else parts))
            moved.append(problem)
        return type(error)(problems=moved)


def _changed(document: Document, machine: str | None, kinds: list[str], seed: int | None) -> Document:
    """The document as if the arguments stood in it.  A law that the file has keeps its numbers."""
    data = dict(document.data)
    if machine is not None:
        # a path of the command line starts at the working directory, one of the file at the file's folder
        place = str(sheet.find(machine).absolute()) if "/" in machine or machine.endswith(".toml") else machine
        data["machine"] = {**_table(data.get("machine")), "use": place}
    if kinds:
        given = data.get("controller")
        tables = [t for t in given if isinstance(t, Mapping)] if isinstance(given, list) else []
        data["controller"] = [
            next((t for t in tables if t.get("kind") == kind), {"kind": kind, **START.get(kind, {})}) for kind in kinds
        ]
    elif isinstance(document, _CommandLine):
        data["controller"] = [{"kind": "pid", **START["pid"]}]
    if seed is not None:
        data["run"] = {**_table(data.get("run")), "seed": seed}
    return type(document)(document.path, document.text, data, document.lines)


def _table(value: Any) -> Mapping[str, Any]:
    return value if isinstance(value, Mapping) else {}


class _Builder:
    """Makes the parts of an experiment one by one and collects what is wrong with each."""

    def __init__(self, document: Document):
        self.document = document
        self.data = document.data
        self.folder = document.path.parent
        self.problems: list[Problem] = []

    def build(self) -> Experiment:
        self._note(sheet.schema_problems(self.data.get("schema"), SCHEMA))
        for key in self.data:
            if key not in (*TABLES, "schema"):
                self._note([Problem("no such table", key=key, cure=did_you_mean(key, TABLES))])
        if "sweep" in self.data:
            cure = "remove the table"
            self._note([Problem("sweeps are not in this version of gough", key="sweep", cure=cure)])
        machine = self._make("machine", _machine, self.folder)
        plant = self._make("plant", _plant, machine) if machine and "plant" in self.data else None
        program = self._make("program", _program, self.folder)
        controllers = self._controllers()
        run = self._make("run", _run) if "run" in self.data else _run({})
        if self.problems:
            raise ExperimentError(problems=self.problems)
        name = slug(self.document.path.stem)
        return Experiment(name, machine, plant, program, tuple(controllers), run, self.document)

    def _note(self, problems: list[Problem], prefix: str = "") -> None:
        if problems:
            self.problems += self.document.locate(ExperimentError(problems=problems), prefix).problems

    def _make(self, key: str, make: Callable, *more: Any) -> Any:
        """What `make` makes of the table at `key`; None and problems noted if it is wrong."""
        table = self.data.get(key)
        if table is None:
            self._note([Problem("the table is missing", key=key, cure=_EXAMPLES[key])])
        elif not isinstance(table, Mapping):
            self._note([Problem("must be a table", key=key, value=_brief(table), cure=_EXAMPLES[key])])
        else:
            try:
                return make(table, *more)
            except InputError as error:
                self._note(list(error.problems), key)
        return None

    def _controllers(self) -> list[Controller]:
        tables = self.data.get("controller")
        if isinstance(tables, Mapping):
            self._note([Problem("must be an array of tables", key="controller", cure="write [[controller]]")])
        elif not isinstance(tables, list) or not tables:
            self._note([Problem("the table is missing", key="controller", cure=_EXAMPLES["controller"])])
        else:
            made = []
            for i, table in enumerate(tables):
                try:
                    made.append(controller_of(table))
                except InputError as error:
                    self._note(list(error.problems), f"controller.{i}")
            return made
        return []


_EXAMPLES = {
    "machine": 'write [machine] and use = "nist-octahedral"',
    "plant": 'write [plant] and e.g. payload = "20 kg"',
    "program": 'write [program] and file = "part.ngc"',
    "controller": 'write [[controller]] and kind = "pid"',
    "run": 'write [run] and e.g. period = "1 ms"',
}


def controller_of(table: Any) -> Controller:
    """The law that a [[controller]] table describes.

    Raises
    ------
    InputError
        no such kind, or a wrong key; `key` is set, file and line are not.
    """
    if not isinstance(table, Mapping):
        raise ExperimentError("must be a table", value=_brief(table), cure=_EXAMPLES["controller"])
    if "kind" not in table:
        raise ExperimentError("is missing", key="kind", cure=f"one of {', '.join(laws())}")
    kind = table["kind"]
    law = law_class(kind)
    if "machine" in table:
        raise ExperimentError("no such key", key="machine", cure="a controller believes the machine of [machine]")
    has_kind = "kind" in law.model_fields
    return Controller(kind, law.from_file({key: raw for key, raw in table.items() if key != "kind" or has_kind}))


def _machine(table: Mapping[str, Any], folder: Path) -> Machine:
    use = table.get("use")
    if not isinstance(use, str):
        rule = "must be a text" if "use" in table else "is missing"
        cure = f"write a path or one of {', '.join(sheet.library())}"
        raise ExperimentError(rule, key="use", value=_brief(use) if "use" in table else None, cure=cure)
    try:
        path = sheet.find(use, folder)
    except InputError as error:
        raise error.at(key="use") from None
    if not path.exists():
        raise ExperimentError("no such file", key="use", value=ascii(str(path)))
    machine = sheet.load_machine(path)
    changes = {key: raw for key, raw in table.items() if key != "use"}
    return sheet.overridden(machine, changes) if changes else machine


def _plant(table: Mapping[str, Any], machine: Machine) -> Any:
    from .simulate.plant import Plant

    own = [name for name in Plant.model_fields if name != "machine"]
    theirs = {key: raw for key, raw in table.items() if key.partition(".")[0] not in own}
    problems, true = [], machine
    try:
        true = sheet.overridden(machine, theirs)
    except InputError as error:
        for problem in error.problems:
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


def _program(table: Mapping[str, Any], folder: Path) -> Any:
    from .program import program_from_table

    return program_from_table(dict(table), folder)


def _run(table: Mapping[str, Any]) -> Run:
    from .log_build import VARIABLES
    from .simulate.run import Run

    run = Run.from_file(table)
    problems = [
        Problem(
            "the log has no such variable",
            key=f"signals.{i}",
            value=ascii(name)[:60],
            cure=did_you_mean(name, VARIABLES),
        )
        for i, name in enumerate(run.signals or ())
        if name not in VARIABLES and not name.startswith(("controller.", "observer.", "plant."))
    ]
    if problems:
        raise ExperimentError(problems=problems)
    return run


def _brief(value: Any) -> str:
    text = ascii(value)
    return text if len(text) <= 60 else text[:57] + "..."
