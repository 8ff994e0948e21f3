"""Experiments: a TOML file, schema "gough-experiment-1", as checked objects ready to run.

    [machine]       use = "nist-octahedral"; further keys override the sheet: what is believed
    [plant]         what is true and nobody told the controller: "friction.coulomb" = "1.2 x", payload = "20 kg"
    [program]       file = "part.ngc", or kind = "circle", ...
    [tools]         file = "tool.tbl", or 1 = { length = "80 mm" }: lengths of an NC program's tools
    [[controller]]  kind = "pid", ...; several run side by side
    [observer]      kind = "disturbance", ...: beside each of them, for the log
    [compensation]  height, air, ...: the tool leans against the cut by what the observer finds
    [run]           period, substeps, seed, log_every, signals
    [sweep]         what `gough sweep` varies from run to run: gough.sweep
    [tune]          what `gough tune` may change, and what is wanted: gough.tune

Every mistake is found at once and said with file, line, key, rule, value and cure.  Nothing in a file is executed:
kinds are looked up in fixed tables and among the entry points `gough.controllers` of installed packages.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import ExperimentError, InputError, Problem, did_you_mean, nearest
from ..files import Document, read_toml
from ..machine import sheet
from ..names import slug
from . import observers, parts
from .laws import START
from .parts import Controller

if TYPE_CHECKING:
    from ..machine.base import Machine
    from ..observe.base import Observer
    from ..simulate.leaning import Compensation
    from ..simulate.run import Run

SCHEMA = "gough-experiment-1"
TABLES = (
    "machine", "plant", "program", "tools", "controller", "observer", "compensation", "run", "sweep", "tune",
)  # fmt: skip
SUFFIXES = (".ngc", ".nc", ".gcode", ".tap", ".cnc")  # of NC programs


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
    observer: Observer | None = None
    compensation: Compensation | None = None

    def locate(self, error: InputError, i: int) -> InputError:
        """An error of running controller i with its place in the file."""
        placed, own = [], set(type(self.controllers[i].law).model_fields) - {"machine", "period"}
        for problem in error.problems:
            key = problem.key or ""
            head, _, rest = key.partition(".")
            if head == "controller" or head in own:  # a law that does not fit the machine names its own numbers
                inner = rest if head == "controller" else key
                problem = Problem(**{**problem.__dict__, "key": f"controller.{i}.{inner}".rstrip(".")})
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
    path = nc_file(path)
    if path.suffix.lower() in SUFFIXES:
        document = _CommandLine(path, "", {"schema": SCHEMA, "program": {"file": path.name}}, {})
    elif path.suffix.lower() == ".toml":
        document = read_toml(path)
    else:
        cure = f"give an experiment (.toml) or an NC program ({', '.join(SUFFIXES)})"
        raise ExperimentError("cannot be run", file=str(path), cure=cure)
    return experiment_of(_changed(document, machine, list(controllers), seed))


def nc_file(path: str | Path) -> Path:
    """The path itself, or that of the NC program of gough's library which has this name.

    Raises
    ------
    ExperimentError
        there is no such file, and the name is much like one of the library.
    """
    path = Path(path)
    if path.suffix or path.exists():
        return path
    from ..program.load import pieces

    name, known = str(path), pieces()
    near = nearest(name, known) or next((one for one in known if one.startswith(name)), None)
    if name not in known and near:
        rule = "no file, and no NC program of the library, has this name"
        raise ExperimentError(rule, value=repr(name)[:60], cure=f"did you mean {near}?")
    return known.get(name, path)


def experiment_of(document: Document) -> Experiment:
    """The experiment that a document describes; errors as `load_experiment`."""
    return _Builder(document).build()


class _CommandLine(Document):
    """What the arguments of `gough run part.ngc` say, with their names in errors."""

    def locate(self, error: InputError, prefix: str = "") -> InputError:
        placed = super().locate(error, prefix)
        options = {"machine": "--machine", "controller": "--controller"}
        moved = []
        for problem in placed.problems:
            if problem.file == str(self.path) and problem.line is None and problem.key:
                option = "--seed" if problem.key == "run.seed" else options.get(problem.key.partition(".")[0])
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
    elif isinstance(document, _CommandLine):
        cure = f"give one of {', '.join(sheet.library())}, or a data sheet (.toml)"
        raise ExperimentError("is missing", key="--machine", cure=cure)
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
        schema = sheet.schema_problems(self.data.get("schema"), SCHEMA)
        if str(self.data.get("schema")).startswith("gough-machine-"):  # then nothing else in it is of use
            cure = f"give it to a program: gough run part.ngc -m {self.document.path.name}"
            wrong = [dataclasses.replace(problem, cure=cure) for problem in schema]
            raise self.document.locate(ExperimentError(problems=wrong))
        self._note(schema)
        for key in self.data:
            if key not in (*TABLES, "schema"):
                self._note([Problem("no such table", key=key, cure=did_you_mean(key, TABLES))])
        for key in ("sweep", "tune"):  # gough.sweep and gough.tune check what they say
            if key in self.data and not isinstance(self.data[key], Mapping):
                self._note([Problem("must be a table", key=key, cure=parts.EXAMPLES[key])])
        known = self._make("machine", parts.sheet_machine, self.folder)
        machine = self._make("machine", parts.believed, known) if known else None
        plant = self._make("plant", parts.plant_of, machine or known) if known and "plant" in self.data else None
        tools = self._make("tools", parts.tools_of, self.folder) if "tools" in self.data else None
        program = self._make("program", parts.program_of, self.folder, tools)
        if tools is not None and program is not None and "file" not in self.data["program"]:
            self._note([Problem("only an NC program uses tools", key="tools", cure="remove the table")])
        controllers = self._controllers()
        observer = self._make("observer", observers.observer_of) if "observer" in self.data else None
        leaning = self._make("compensation", parts.compensation_of) if "compensation" in self.data else None
        run = self._make("run", parts.run_of) if "run" in self.data else parts.run_of({})
        if machine and run:
            self._try(parts.check_supervision, machine, run)
            self._try(observers.check_observer, observer, machine, run)
        if known and plant:
            self._try(parts.check_faults, plant)
        if machine and leaning and (observer or "observer" not in self.data):
            self._try(parts.check_compensation, machine, observer, leaning)
        if run and "observer" not in self.data:
            self._try(observers.check_signals, run.signals, controllers, key="run")
        if self.problems:
            here = str(self.document.path)
            raise ExperimentError(problems=sorted(self.problems, key=lambda p: (p.file != here, p.line or 0)))
        name = slug(self.document.path.stem)
        made = tuple(controllers)
        return Experiment(name, machine, plant, program, made, run, self.document, observer, leaning)

    def _note(self, problems: list[Problem], prefix: str = "") -> None:
        if problems:
            self.problems += self.document.locate(ExperimentError(problems=problems), prefix).problems

    def _make(self, key: str, make: Callable, *more: Any) -> Any:
        """What `make` makes of the table at `key`; None and problems noted if it is wrong."""
        table = self.data.get(key)
        if table is None:
            self._note([Problem("the table is missing", key=key, cure=parts.EXAMPLES[key])])
        elif not isinstance(table, Mapping):
            self._note([Problem("must be a table", key=key, value=parts.brief(table), cure=parts.EXAMPLES[key])])
        else:
            try:
                return make(table, *more)
            except InputError as error:
                self._note(list(error.problems), key)
        return None

    def _try(self, check: Callable, *what: Any, key: str = "") -> None:
        """Note what a check of parts together finds."""
        try:
            check(*what)
        except InputError as error:
            self._note(list(error.problems), key)

    def _controllers(self) -> list[Controller]:
        tables = self.data.get("controller")
        if isinstance(tables, Mapping):
            self._note([Problem("must be an array of tables", key="controller", cure="write [[controller]]")])
        elif not isinstance(tables, list) or not tables:
            self._note([Problem("the table is missing", key="controller", cure=parts.EXAMPLES["controller"])])
        else:
            made = []
            for i, table in enumerate(tables):
                try:
                    made.append(parts.controller_of(table))
                except InputError as error:
                    self._note(list(error.problems), f"controller.{i}")
            return made
        return []
