"""Laws around a law: the inner one is handed another reference and knows of nothing.

    [[controller]]
    kind = "gravity_compensation"
    law  = { kind = "computed_torque", bandwidth = "20 Hz" }

The inner law's State is `inner` of the wrapper's, its tasks are the wrapper's tasks, its numbers are law.* in theta.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from ..declare import quantity
from ..errors import ExperimentError
from .base import Command, Controller, Task


class State(NamedTuple):
    """What a wrapper remembers: the inner law's State, the time since the start, and its own."""

    inner: Any
    clock: Any  # s, until the takeover is over
    own: Any  # a NamedTuple, or an array


class Wrapping(Controller):
    """Base of laws that hand an inner law another reference, faded in from the start on, so that nothing jumps."""

    law: Controller
    takeover: float = quantity("s", "time over which it sets in from the start, smoothly", default=0.2, above=0)

    # -- what a wrapper states ------------------------------------------------------------------------------------

    @abstractmethod
    def moved(self, p, own, r, weight) -> tuple[Any, Any]:
        """The reference for the inner law, and what is remembered next; `weight` as `ramp` gives it."""

    def first(self, r0) -> Any:
        """What is remembered at rest at r0, at the start."""
        return np.zeros(0)

    # -- a law ----------------------------------------------------------------------------------------------------

    def state_told(self, name: str):
        inner = name.removeprefix("inner.")
        return super().state_told(name) if inner == name else self.law.state_told(inner)

    def learns(self, name: str) -> bool:
        return name.startswith("inner.") and self.law.learns(name.removeprefix("inner."))

    def on(self, machine, period):
        given = machine if self.machine is None else self.machine
        inner = self.law.on(given, period if self.period is None else self.period)
        if not inner.symbolic:
            raise ExperimentError(
                "only a law in CasADi's operations can be wrapped", key="law", value=type(inner).__name__,
                cure="write its step without NumPy, or run it alone",
            )  # fmt: skip
        return self.replace(law=inner, machine=given, period=inner.period)

    def believing(self, machine):
        return self.replace(machine=machine, law=self.law.believing(machine))

    def standing(self):
        """The inner law: its loop at rest is this one, but for how much the displacement changes with the place."""
        return self.law.standing()

    def doubts(self):
        return self.law.doubts()

    def check_motion(self, motion, period):
        self.law.check_motion(motion, period)

    def init(self, r0, u0) -> State:
        """The state from which the first step gives u0 at r0."""
        return State(self.law.init(r0, u0), np.zeros(1), self.first(r0))

    def tasks(self):
        def step(task):
            def around(state, r, y, theta):
                r, _ = self._told(state, r, theta)
                return state._replace(inner=task.step(state.inner, r, y, self._inner(theta)))

            return around

        return tuple(Task(task.name, task.period, step(task)) for task in self.law.tasks())

    def step(self, state: State, r, y, theta) -> tuple[Command, State]:
        r, own = self._told(state, r, theta)
        command, inner = self.law.step(state.inner, r, y, self._inner(theta))
        p = self.at(theta)
        return command, State(inner, ca.fmin(state.clock + p.period, p.takeover), own)

    def _told(self, state, r, theta):
        p = self.at(theta)
        return self.moved(p, state.own, r, ramp(state.clock / p.takeover, 1 / p.takeover))

    def _inner(self, theta):
        """The entries of theta that are the inner law's."""
        mine = [i for i, name in enumerate(self.names) if name.startswith("law.")]
        return theta[mine[0] : mine[-1] + 1]


def ramp(share, rate):
    """0 to 1 with two continuous derivatives while share goes from 0 to 1 at `rate` 1/s: value, its rate, and theirs.

    10 s^3 - 15 s^4 + 6 s^5: the shortest polynomial that is at rest at both ends, twice.
    """
    s = ca.fmin(ca.fmax(share, 0), 1)
    value = s * s * s * (10 + s * (6 * s - 15))
    slope = 30 * s * s * (1 - s) ** 2
    bend = 60 * s * (1 - s) * (1 - 2 * s)
    return value, slope * rate, bend * rate * rate


def faded(weight, d):
    """weight * d with its rates; both (value, rate, rate of the rate)."""
    (w, wd, wdd), (d, dd, ddd) = weight, d
    return w * d, w * dd + wd * d, w * ddd + 2 * wd * dd + wdd * d
