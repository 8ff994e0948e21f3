"""What is to be run: named signals, the tasks that read and write them, and the order of one tick.

One tick k:
    the row k of every input, new noise
    -> tasks, in order, each when k % every == 0
    -> the logged signals become row k of the log
    -> `substeps` times the sub-step
    -> the limits task; every limit must be >= 0, every state and logged value finite
    -> the states are kept.  A lane that failed keeps those of the tick before.

All of it is data; a mistake in it is found here, not at tick 10 000.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import casadi as ca

from ..errors import InputError, did_you_mean
from .tape import Tape, trace

KINDS = {
    "parameter": "constant over the run, each run its own",
    "input": "a row of a table every tick, the same for all runs",
    "noise": "standard normal, new every tick",
    "state": "kept from tick to tick",
    "wire": "computed by a task of the same run of ticks; of a task with every > 1, kept between its ticks",
}


@dataclass(frozen=True)
class Signal:
    """A named vector of `size` numbers.  `kind` is one of KINDS; `labels` name the entries in messages."""

    name: str
    size: int
    kind: str
    labels: tuple[str, ...] | None = None

    def __post_init__(self):
        where = f"signal {self.name}"
        if self.kind not in KINDS:
            raise InputError(
                "the kind of a signal is unknown", where=where, value=self.kind, cure=did_you_mean(self.kind, KINDS)
            )
        if not isinstance(self.size, int) or self.size < 0:
            raise InputError("the size of a signal must be a whole number >= 0", where=where, value=repr(self.size))
        if self.labels is not None:
            object.__setattr__(self, "labels", tuple(self.labels))
            if len(self.labels) != self.size:
                raise InputError(f"{self.size} labels are needed", where=where, value=str(len(self.labels)))

    def label(self, index: int) -> str:
        """How entry `index` is called in a message."""
        return self.labels[index] if self.labels else f"{self.name}[{index}]"


@dataclass(frozen=True, eq=False)
class Task:
    """A function, and the signals its inputs read and its outputs write; it runs every `every` ticks.

    `function` is a casadi.Function over SX.  A plain Python callable (arrays (size,) in, an array or a tuple of arrays
    out) is accepted too, through a slow path that says it is slow.
    """

    name: str
    function: ca.Function | Callable
    reads: tuple[str, ...] = ()
    writes: tuple[str, ...] = ()
    every: int = 1

    def __post_init__(self):
        object.__setattr__(self, "reads", _names(self.reads))
        object.__setattr__(self, "writes", _names(self.writes))
        where = f"task {self.name}"
        if not callable(self.function):
            raise InputError("a task needs a function", where=where, value=type(self.function).__name__)
        if not isinstance(self.every, int) or self.every < 1:
            raise InputError(
                "a task runs every 1, 2, 3 ... ticks", where=where, value=repr(self.every), cure="see period_ticks"
            )
        if len(set(self.writes)) < len(self.writes):
            raise InputError("a task writes a signal once", where=where, value=", ".join(self.writes))

    @property
    def symbolic(self) -> bool:
        return isinstance(self.function, ca.Function)


@dataclass(frozen=True, eq=False)
class Schedule:
    """The signals and what happens to them in one tick of `period` seconds.  InputError where it does not fit together.

    `substep` is one task or several in order (a function that several of them name is compiled once).
    `limits` is a task that writes one signal, by custom called "limits"; a run stops when an entry is not >= 0.
    `log` names the signals of a log row.
    """

    signals: tuple[Signal, ...]
    tasks: tuple[Task, ...] = ()
    substep: tuple[Task, ...] = ()
    substeps: int = 1
    limits: Task | None = None
    log: tuple[str, ...] = ()
    period: float = 1.0
    by_name: dict[str, Signal] = field(init=False, repr=False)
    tapes: dict[str, Tape] = field(init=False, repr=False)  # task name -> its tape; plain Python has none

    def __post_init__(self):
        put = lambda name, value: object.__setattr__(self, name, value)  # noqa: E731
        put("signals", tuple(self.signals))
        put("tasks", (self.tasks,) if isinstance(self.tasks, Task) else tuple(self.tasks))
        put("substep", (self.substep,) if isinstance(self.substep, Task) else tuple(self.substep or ()))
        put("log", _names(self.log))
        put("by_name", {signal.name: signal for signal in self.signals})
        if not (math.isfinite(self.period) and self.period > 0):
            raise InputError("the period must be above 0 s", where="schedule", value=repr(self.period))
        if not isinstance(self.substeps, int) or self.substeps < 1:
            raise InputError("the number of sub-steps must be 1, 2, 3 ...", where="schedule", value=repr(self.substeps))
        _distinct("signals", [s.name for s in self.signals])
        _distinct("tasks", [t.name for t in self.all_tasks])
        self._check_names()
        self._check_order()
        traced: dict[ca.Function, Tape] = {}
        put("tapes", {t.name: self._tape(t, traced) for t in self.all_tasks if t.symbolic})

    @property
    def all_tasks(self) -> tuple[Task, ...]:
        return self.tasks + self.substep + ((self.limits,) if self.limits else ())

    @property
    def limit_signal(self) -> str | None:
        return self.limits.writes[0] if self.limits else None

    def sizes(self, names: Iterable[str]) -> tuple[int, ...]:
        return tuple(self.by_name[name].size for name in names)

    def of_kind(self, kind: str) -> list[Signal]:
        return [signal for signal in self.signals if signal.kind == kind]

    def _check_names(self):
        for task in self.all_tasks:
            for verb, names in (("reads", task.reads), ("writes", task.writes)):
                for name in names:
                    self._known(name, f"task {task.name}", verb)
            for name in task.writes:
                kind = self.by_name[name].kind
                if kind not in ("state", "wire"):
                    raise InputError(
                        f"writes {name}, a signal of kind {kind}",
                        where=f"task {task.name}",
                        cure="only states and wires are written",
                    )
        for task in self.substep + ((self.limits,) if self.limits else ()):
            if task.every != 1:
                raise InputError(
                    "sub-steps and limits run every tick", where=f"task {task.name}", value=f"every={task.every}"
                )
        for name in self.log:
            self._known(name, "log", "names")
        _distinct("logged signals", list(self.log))
        if self.limits and (len(self.limits.writes) != 1 or self.by_name[self.limits.writes[0]].kind != "wire"):
            raise InputError(
                "the limits task writes one wire, the limits",
                where=f"task {self.limits.name}",
                value=", ".join(self.limits.writes) or "nothing",
            )

    def _known(self, name: str, where: str, verb: str):
        if name not in self.by_name:
            raise InputError(f"{verb} the unknown signal {name!r}", where=where, cure=did_you_mean(name, self.by_name))

    def _check_order(self):
        """A wire carries nothing from tick to tick: whoever reads it must come after whoever writes it."""
        written: set[str] = set()

        def fresh(names, where):
            for name in names:
                if self.by_name[name].kind == "wire" and name not in written:
                    raise InputError(
                        f"reads the wire {name} before a task has written it",
                        where=where,
                        cure=f"order the tasks, or make {name} a state",
                    )

        for task in self.tasks:
            fresh(task.reads, f"task {task.name}")
            written.update(task.writes)
        fresh(self.log, "log")
        for task in self.all_tasks[len(self.tasks) :]:
            fresh(task.reads, f"task {task.name}")
            written.update(task.writes)

    def _tape(self, task: Task, traced: dict) -> Tape:
        where = f"task {task.name}"
        tape = traced.get(task.function)
        if tape is None:
            try:
                tape = traced[task.function] = trace(task.function)
            except InputError as error:
                raise error.at(where=where) from None
        for verb, names, sizes in (("reads", task.reads, tape.inputs), ("writes", task.writes, tape.outputs)):
            expected = self.sizes(names)
            if len(expected) != len(sizes):
                raise InputError(
                    f"{tape.name} has {len(sizes)} {'inputs' if verb == 'reads' else 'outputs'}, the task {verb} "
                    f"{len(expected)} signals",
                    where=where,
                    value=", ".join(names) or "none",
                )
            for position, (name, want, got) in enumerate(zip(names, expected, sizes, strict=True)):
                if want != got:
                    raise InputError(
                        f"{verb} {name} of size {want} at position {position} of {tape.name}",
                        where=where,
                        value=f"size {got}",
                    )
        return tape


def period_ticks(period: float, base: float) -> int:
    """How many base ticks of `base` seconds a period of `period` seconds has.  InputError when not a whole number."""
    ratio = period / base if base > 0 and math.isfinite(period) else math.nan
    # 1e-9: a period read from a file in other units ("0.9 ms") is off by rounding only, 1e-16 relative
    if not (ratio >= 0.5 and abs(ratio - round(ratio)) <= 1e-9 * ratio):
        raise InputError(
            f"the period of a task must be a multiple of the base tick of {base:g} s",
            value=f"{period:g} s",
            cure="choose a base tick that divides all periods",
        )
    return round(ratio)


def _names(names) -> tuple[str, ...]:
    return (names,) if isinstance(names, str) else tuple(names)


def _distinct(what: str, names: list[str]):
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError(f"the names of {what} must differ", where="schedule", value=", ".join(twice))
