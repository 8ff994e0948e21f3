"""Faults of encoders, as options of the plant: what is read is no longer what is there.

    stuck     the reading stays what it was in the sample before
    dropout   no signal: the reading is 0 m, as a register that was cleared
    glitch    the reading is wrong by `size` m

each of one joint, from `start` for `duration` s (left out: to the end).  A glitch to the end is an encoder that has
lost counts.  Faults act on what the encoder reads, in the order in which they are given; the law, the following-error
trip and the log's q_m see the result.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from functools import lru_cache
from typing import Literal

import casadi as ca
import numpy as np
from pydantic import Field, model_validator

from ..declare import Part, quantity
from ..errors import InputError
from ..kernel import Schedule, Signal, Task

_NUMBERS = 6  # of a fault in the kernel: first tick, tick behind the last, joint, stuck, dropout, size


class EncoderFault(Part):
    """One fault of the encoder of one joint, with a beginning and an end."""

    kind: Literal["stuck", "dropout", "glitch"]
    joint: int = Field(ge=1, description="number of the joint, from 1")
    start: float = quantity("s", "when it begins", at_least=0)
    duration: float | None = quantity("s", "how long it lasts; to the end where left out", default=None, above=0)
    size: float | None = quantity("m", "what a glitch adds to the reading", default=None)

    @model_validator(mode="after")
    def _sized(self):
        if (self.size is not None) != (self.kind == "glitch"):
            raise InputError(
                "a glitch needs a size" if self.size is None else f"{self.kind} has no size",
                key="size",
                cure='write e.g. size = "0.1 mm"' if self.size is None else "leave it out",
            )
        return self

    def numbers(self, period: float) -> list[float]:
        """What the kernel is told, at a period of `period` s."""
        # 1e-9: a time read from a file in other units is off by rounding only
        first = np.ceil(self.start / period - 1e-9)
        last = (
            np.inf if self.duration is None else max(first + 1, np.ceil((self.start + self.duration) / period - 1e-9))
        )
        return [first, last, self.joint - 1, self.kind == "stuck", self.kind == "dropout", self.size or 0.0]


def numbers(faults: Sequence[EncoderFault], count: int, period: float) -> np.ndarray:
    """The parameter "faults" for `count` faults; those that are not there never begin.  (6 count,)."""
    never = [np.inf, np.inf, 0, 0, 0, 0]
    rows = [fault.numbers(period) for fault in faults] + [never] * (count - len(faults))
    return np.array(rows, float).reshape(-1)


def clocked(schedule: Schedule) -> tuple[Signal, ...]:
    """The signals of a schedule with the input "clock", the number of the tick, among them."""
    known = "clock" in schedule.by_name
    return schedule.signals if known else (*schedule.signals, Signal("clock", 1, "input"))


@lru_cache(maxsize=64)
def with_faults(schedule: Schedule, n: int, count: int) -> Schedule:
    """The schedule with `count` faults between the encoders of n joints and the law.

    It has the parameter "faults" (`numbers`), the input "clock", the number of the tick, and the state "held", the
    reading of the sample before.
    """
    faults, clock = ca.SX.sym("faults", _NUMBERS * count), ca.SX.sym("clock")
    q_m, held = ca.SX.sym("q_m", n), ca.SX.sym("held", n)
    before = ca.if_else(clock <= 0, q_m, held)
    reading = q_m
    for i in range(count):
        first, last, joint, stuck, dropout, size = ca.vertsplit(faults[_NUMBERS * i : _NUMBERS * (i + 1)])
        on = ca.logic_and(clock >= first, clock < last)
        wrong = ca.if_else(stuck, before, ca.if_else(dropout, 0, reading + size))
        hit = ca.vertcat(*[ca.logic_and(on, joint == j) for j in range(n)])
        reading = ca.if_else(hit, wrong, reading)
    function = ca.Function("fault", [faults, clock, q_m, held], [reading, reading])
    task = Task("fault", function, ("faults", "clock", "q_m", "held"), ("q_m", "held"))
    at = [t.name for t in schedule.tasks].index("sense") + 1
    signals = [Signal("faults", _NUMBERS * count, "parameter"), Signal("held", n, "state")]
    return dataclasses.replace(
        schedule,
        signals=(*clocked(schedule), *signals),
        tasks=(*schedule.tasks[:at], task, *schedule.tasks[at:]),
    )
