"""Settings of a run, {"plant.friction.coulomb": "1.2 x"}: an experiment with other values in these places of its file.

A setting takes the place of its key in the file, so it says what it would say there.  "1.2 x" multiplies: in [machine]
the sheet's own number, in [plant] that of the believed machine, elsewhere what the experiment has.  Only the parts that
a setting touches are made anew; parts that come out alike are the same objects, by which batches know them.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

from .. import units
from ..complaints import under
from ..declare import Part
from ..errors import ExperimentError, InputError, did_you_mean, nearest
from ..experiment import Experiment, parts
from ..experiment.observers import observer_of
from ..experiment.parts import Controller
from ..files import Document
from ..quantities import written

TABLES = ("machine", "plant", "program", "controller", "observer", "run")
_KEPT = 1024  # parts of a table that are kept; a batch has fewer
_TOLD = 12  # names, where none is near
_NOT_MEASURED = ("log_every", "signals")  # of [run]: what a log keeps is no factor of what is measured

Settings = Mapping[str, Any]


class Setter:
    """Gives the experiment that an experiment becomes by settings; may be sent to other processes.

    `setter({"controller.bandwidth": "50 Hz"})` sets it in every [[controller]] that has one, "controller.0.bandwidth"
    in the first alone.
    """

    def __init__(self, experiment: Experiment):
        self.experiment = experiment
        self.data = experiment.document.data
        self.folder = experiment.document.path.parent
        self.sheet = parts.sheet_machine(self.data["machine"], self.folder)  # as no table has changed it
        self._known: dict[str, dict[Any, Any]] = {}

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_known": {}}

    def __call__(self, settings: Settings) -> Experiment:
        """The experiment with these settings; values are what a file would say.

        Raises
        ------
        InputError
            a key that is not there, or a value that cannot be; its key is that of the setting.
        """
        told: dict[str, dict[str, Any]] = {}
        for name, value in self.expanded(settings).items():
            table, _, key = name.partition(".")
            told.setdefault(table, {})[key] = value
        base, data = self.experiment, dict(self.data)
        sheet, machine = self._make("machine", told, data, self._machine) or (self.sheet, base.machine)
        made = self._make("plant", told, data, self._plant, machine) if "plant" in told or "machine" in told else None
        plant = made if made is not None or machine is not base.machine else base.plant
        program = self._make("program", told, data, self._program) or base.program
        observer = self._make("observer", told, data, self._observer) or base.observer
        run = self._make("run", told, data, self._run) or base.run
        controllers = self._controllers(told.get("controller", {}), data)
        document = Document(base.document.path, base.document.text, data, base.document.lines)
        return dataclasses.replace(
            base, machine=machine, plant=plant, program=program, controllers=controllers, observer=observer, run=run,
            document=document,
        )  # fmt: skip

    def expanded(self, settings: Settings) -> dict[str, Any]:
        """The settings with "controller.x" written out for every controller that has x.

        Raises
        ------
        ExperimentError
            no such table, controller or key of all of them; the nearest right name is said.
        """
        out: dict[str, Any] = {}
        for name, value in settings.items():
            for one in self.places(name):
                out[one] = value
        return out

    def places(self, name: str) -> list[str]:
        """Every key of the file that a name stands for: itself, or one for each controller that has it."""
        table, _, key = name.partition(".")
        if table not in TABLES or not key or (table == "run" and key in _NOT_MEASURED):
            raise ExperimentError("names nothing of this experiment", key=name, cure=self.near(name))
        if table == "observer" and self.experiment.observer is None:
            raise ExperimentError("the experiment has no [observer]", key=name, cure="write that table, or drop this")
        if table != "controller":
            return [name]
        head, _, rest = key.partition(".")
        laws = [controller.law for controller in self.experiment.controllers]
        if head.isdecimal():
            if int(head) >= len(laws) or not rest:
                raise ExperimentError(
                    "there is no such controller", key=name, limit=f"{len(laws)} of them, counted from 0",
                    cure=self.near(name),
                )  # fmt: skip
            return [name]
        found = [f"controller.{i}.{key}" for i, law in enumerate(laws) if head in type(law).model_fields]
        if not found:
            raise ExperimentError("names nothing of this experiment", key=name, cure=self.near(name))
        return found

    def of_controller(self, settings: Settings, i: int) -> dict[str, Any]:
        """Those of the settings that controller i's run hangs on."""
        mine = f"controller.{i}."
        return {
            name: value
            for name, value in self.expanded(settings).items()
            if name.startswith(mine) or not name.startswith("controller.")
        }

    def near(self, name: str) -> str:
        """The cure for a name that is none: the nearest right one, else some of its table."""
        names = self.names()
        if nearest(name, names):
            return did_you_mean(name, names)
        own = [one for one in names if one.startswith(f"{name.partition('.')[0]}.")] or names
        more = ", ..." if len(own) > _TOLD else ""
        return f"there is {', '.join(own[:_TOLD])}{more}"

    def names(self) -> list[str]:
        """Every name that a setting of this experiment may have, but for those of parts that are absent."""
        base = self.experiment
        plant = [name for name in _plant_fields() if name != "machine"]
        out = [f"plant.{name}" for name in plant]
        if base.plant is not None and base.plant.cutting is not None:
            out += [f"plant.cutting.{name}" for name in base.plant.cutting._keys()]
        keys = _varied(base.machine)
        out += [f"plant.{key}" for key in keys] + [f"machine.{key}" for key in keys]
        laws = [controller.law for controller in base.controllers]
        out += dict.fromkeys(f"controller.{key}" for law in laws for key in _varied(law))
        out += [f"controller.{i}.{key}" for i, law in enumerate(laws) for key in _varied(law)]
        out += [f"program.{key}" for key in _varied(base.program)]
        out += [f"observer.{key}" for key in _varied(base.observer)] if base.observer is not None else []
        return out + [f"run.{key}" for key in _varied(base.run) if key not in _NOT_MEASURED]

    # -- one table each -----------------------------------------------------------------------------------------------

    def _make(self, table: str, told: Mapping[str, dict], data: dict, make: Callable, *more: Any) -> Any:
        """What `make` makes of the settings of a table, and the table itself in `data`; None where there are none."""
        changes = told.get(table, {})
        if not changes and not (more and table in self.data):
            return None
        key = repr(sorted(changes.items())), *(id(one) for one in more)
        known = self._known.setdefault(table, {})
        if key not in known:
            while len(known) >= _KEPT:
                del known[next(iter(known))]
            try:
                # `more` is kept with the part: an id is of a living object
                known[key] = (*make(changes, *more), more)
            except InputError as error:
                raise type(error)(problems=[under(problem, table) for problem in error.problems]) from None
        made, data[table], _ = known[key]
        return made

    def _machine(self, changes: Settings) -> tuple[Any, dict]:
        table = self._table("machine", changes)
        sheet = parts.sheet_machine(table, self.folder) if "use" in changes else self.sheet
        return (sheet, parts.believed(table, sheet)), table

    def _plant(self, changes: Settings, machine: Any) -> tuple[Any, dict]:
        own, base = _plant_fields(), self.experiment.plant
        changes = {
            key: _absolute(base, key, raw) if key.partition(".")[0] in own and base is not None else raw
            for key, raw in changes.items()
        }
        table = self._table("plant", changes, {key.partition(".")[0] for key in changes} & set(own))
        plant = parts.plant_of(table, machine)
        parts.check_faults(plant)
        return plant, table

    def _program(self, changes: Settings) -> tuple[Any, dict]:
        base = self.experiment.program
        if {key.partition(".")[0] for key in changes} <= set(type(base).model_fields):  # no file is read for these
            changes = {key: _absolute(base, key, raw) for key, raw in changes.items()}
            return base.replace_from_file(changes), self._table("program", changes, nested=True)
        table = self._table("program", changes, nested=True)
        tools = parts.tools_of(self.data["tools"], self.folder) if "tools" in self.data else None
        return parts.program_of(table, self.folder, tools), table

    def _observer(self, changes: Settings) -> tuple[Any, dict]:
        changes = {key: _absolute(self.experiment.observer, key, raw) for key, raw in changes.items()}
        table = self._table("observer", changes, nested=True)
        return observer_of(table), table

    def _run(self, changes: Settings) -> tuple[Any, dict]:
        changes = {key: _absolute(self.experiment.run, key, raw) for key, raw in changes.items()}
        table = self._table("run", changes, nested=True)
        return parts.run_of(table), table

    def _controllers(self, changes: Settings, data: dict) -> tuple[Controller, ...]:
        if not changes:
            return self.experiment.controllers
        of: dict[int, dict[str, Any]] = {}
        for key, raw in changes.items():
            number, _, inner = key.partition(".")
            of.setdefault(int(number), {})[inner] = raw
        made, tables = list(self.experiment.controllers), list(self.data["controller"])
        for i, inner in of.items():
            known = self._known.setdefault(f"controller.{i}", {})
            key = repr(sorted(inner.items()))
            if key not in known:
                while len(known) >= _KEPT:
                    del known[next(iter(known))]
                try:
                    known[key] = self._controller(i, inner)
                except InputError as error:
                    problems = [under(problem, f"controller.{i}") for problem in error.problems]
                    raise type(error)(problems=problems) from None
            made[i], tables[i] = known[key]
        data["controller"] = tables
        return tuple(made)

    def _controller(self, i: int, changes: Settings) -> tuple[Controller, dict]:
        law = self.experiment.controllers[i].law
        changes = {key: _absolute(law, key, raw) for key, raw in changes.items()}
        table = dict(self.data["controller"][i])
        for key, raw in changes.items():
            table = put(table, key, raw, nested=True)
        return parts.controller_of(table), table

    def _table(self, name: str, changes: Settings, own: set[str] | None = None, nested: bool = False) -> dict:
        table = dict(self.data.get(name, {}))
        for key, raw in changes.items():
            table = put(table, key, raw, nested or key.partition(".")[0] in (own or ()))
        return table


def put(table: Mapping[str, Any], key: str, value: Any, nested: bool) -> dict[str, Any]:
    """The table with `value` at a dotted key, spelled as the table spells it; where it has none, `nested` or dotted."""
    out = dict(table)
    if key in out:
        out[key] = value
        return out
    for name, inner in out.items():
        rest = key.removeprefix(f"{name}.")
        if rest == key:
            continue
        if isinstance(inner, Mapping):
            out[name] = put(inner, rest, value, nested)
            return out
        number, _, deeper = rest.partition(".")
        if isinstance(inner, list) and number.isdecimal() and int(number) < len(inner):
            entries, place = list(inner), int(number)
            known = entries[place] if isinstance(entries[place], Mapping) else {}
            entries[place] = put(known, deeper, value, nested) if deeper else value
            out[name] = entries
            return out
    out = {name: inner for name, inner in out.items() if not name.startswith(f"{key}.")}  # all below is set with it
    head, _, rest = key.partition(".")
    out[head if nested else key] = put({}, rest, value, nested) if nested and rest else value
    return out


def _plant_fields() -> list[str]:
    from ..simulate.plant import Plant

    return [name for name in Plant.model_fields if name != "machine"]


def _varied(part: Part) -> list[str]:
    """Dotted names of what can be varied in a part: its numbers and options, and those of the parts in it."""
    out = []
    for name in type(part).model_fields:
        value = getattr(part, name)
        if isinstance(value, Part):
            out += [f"{name}.{key}" for key in _varied(value)]
        elif name not in ("name", "kind", "machine", "source", "text", "subroutines"):
            out.append(name)
    return out


def _absolute(part: Part, key: str, raw: Any) -> Any:
    """A value that multiplies, "1.2 x", as the number that it comes to in this part; any other as it is."""
    if not (isinstance(raw, str) and raw.strip().endswith("x")):
        return raw
    owner, (*above, last) = part, key.split(".")
    for name in above:
        owner = getattr(owner, name, None)
    spec = owner.specs().get(last) if isinstance(owner, Part) else None
    if spec is None or getattr(owner, last) is None:
        times, dimension = units.parse(raw)
        if not any(dimension):
            raise ExperimentError("cannot be scaled: the file gives no number here", key=key, value=repr(raw))
        return raw
    scaled = owner.replace_from_file({last: raw})
    return written(getattr(scaled, last), spec)
