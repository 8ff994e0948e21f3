"""compile(schedule) -> Kernel: machine code, from the cache where it is there, or the interpreter, which says so."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

from ..errors import InputError
from .build import library, no_native, width_of
from .engines import Interpreter, Native
from .layout import Layout
from .schedule import Schedule
from .simulation import Simulation


class KernelWarning(UserWarning):
    """Something works, but slowly."""


@dataclass(frozen=True, eq=False)
class Kernel:
    """A schedule ready to run, `lanes` runs at a time; `columns` says where a signal lies in a log row."""

    schedule: Schedule
    layout: Layout
    lanes: int
    engine: Any
    native: bool
    cached: bool = False  # the code came from the cache

    @property
    def columns(self) -> dict[str, slice]:
        return self.layout.columns

    @property
    def width(self) -> int:
        """Numbers in a log row."""
        return self.layout.width

    @property
    def operations(self) -> int:
        """Operations of one tick in which every task fires."""
        count = {name: tape.operations for name, tape in self.schedule.tapes.items()}
        once = sum(count.get(t.name, 0) for t in self.schedule.tasks)
        once += count.get(self.schedule.limits.name, 0) if self.schedule.limits else 0
        return once + self.schedule.substeps * sum(count.get(t.name, 0) for t in self.schedule.substep)

    def start(
        self, parameters=None, states=None, seed: int = 0, runs: int = 1, first_run: int = 0, keys=None
    ) -> Simulation:
        """A simulation at tick 0.  Each parameter and state is (size,), or (runs, size) for values of their own.

        `first_run` is the number of the first run as the noise counts them: a batch in parts gives the same bits as
        in one.  `keys` gives each run its key (`noise.run_key`) instead.  InputError for missing, unknown or misshapen
        values, NaN, and states that are not finite.
        """
        return Simulation(self, parameters, states, seed, runs, first_run, keys)


def compile(schedule: Schedule, lanes: int | str = 1, cache: bool = True, native: bool | str = "auto") -> Kernel:
    """Machine code that simulates `lanes` runs at a time (1, 2, 4, 8 or "auto": what this processor does best).

    native="auto" takes CasADi's interpreter where there is no machine code, with one KernelWarning; True raises
    InputError instead; False asks for the interpreter.  InputError also for an impossible number of lanes.
    """
    layout = Layout.of(schedule)
    reason = _no_native(schedule) if native else "it was asked for"
    if reason:
        if native is True:
            raise InputError("no machine code can be made", value=reason, cure='native="auto" takes the interpreter')
        if native:
            warnings.warn(
                f"{reason}: the interpreter runs it, 20 to 60 times slower than machine code of one lane and 130 to "
                "300 times slower than of eight",
                KernelWarning,
                stacklevel=2,
            )
        return Kernel(schedule, layout, 1, Interpreter(schedule, layout), native=False)
    width = width_of(lanes)
    code, found = library("run", _description(schedule), width, lambda lanes: _text(schedule, layout, lanes), cache)
    return Kernel(schedule, layout, width, Native(code), native=True, cached=found)


def _no_native(schedule: Schedule) -> str | None:
    plain = [task.name for task in schedule.all_tasks if not task.symbolic]
    return f"task {', '.join(plain)} is plain Python" if plain else no_native()


def _text(schedule: Schedule, layout: Layout, lanes):
    from . import module  # needs llvmlite

    return module.text(schedule, layout, lanes)


def _description(schedule: Schedule) -> tuple:
    """All of a schedule that decides its code."""
    tasks = [(t.reads, t.writes, t.every, schedule.tapes[t.name].digest) for t in schedule.all_tasks]
    signals = [(s.name, s.size, s.kind) for s in schedule.signals]
    return (
        signals,
        tasks,
        len(schedule.tasks),
        len(schedule.substep),
        schedule.substeps,
        bool(schedule.limits),
        schedule.log,
    )
