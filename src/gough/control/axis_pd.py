"""PD control of each joint by stiffness and damping, about the forces at rest.

    u = u_0 + k e + d (e - e_) / Ts,    e = q_r - q,   _ the sample before                                          (1)

k is the static stiffness: a steady force F on a joint moves it by F / k.  Nothing is fed forward and nothing is
integrated, so what the motion needs shows as an error, M_q q'' / k and friction over k.  u_0, what holds the machine at
the start, is its counterbalance.  d left out damps each joint critically, 2 sqrt(k m), m the mass it feels while the
others are held (pid.joint_mass).

Source: Honegger 1998: "linear PD controllers with a static stiffness of 20 N/um"; d is not printed there.
"""

from __future__ import annotations

from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from ..declare import Array, quantity
from ..errors import ExperimentError
from .base import Command, Controller
from .pid import joint_mass


class State(NamedTuple):
    """What the law remembers."""

    error: Any  # of the last sample, (n,) m
    rest: Any  # u_0, (n,) N


class AxisPD(Controller):
    """Joint-space PD, eq. (1)."""

    states: ClassVar = {
        "error": ("joint", "m", "following error of the last sample"),
        "rest": ("joint", "N", "forces at rest"),
    }

    kind: Literal["axis_pd"] = "axis_pd"
    stiffness: float | Array = quantity("N/m", "k, of each joint", above=0, shape=(-1,))
    damping: float | Array | None = quantity(
        "N s/m", "d, of each joint; critical if left out", default=None, at_least=0, shape=(-1,)
    )

    def on(self, machine, period):
        law = super().on(machine, period)
        for key in ("stiffness", "damping"):
            value, n = getattr(law, key), law.machine.joints_count
            if np.ndim(value) and len(value) != n:
                raise ExperimentError(f"must be one value or {n}", key=key, value=f"{len(value)} values")
        if law.damping is not None:
            return law
        return law.replace(damping=2 * np.sqrt(law.stiffness * joint_mass(law.machine)))

    def init(self, r0, u0) -> State:
        """The state from which the first step gives u0 at r0."""
        return State(np.zeros(len(np.ravel(u0))), np.ravel(u0))

    def step(self, state: State, r, y, theta):
        p = self.at(theta)
        e = r.q - y.q
        u = state.rest + p.stiffness * e + p.damping * (e - state.error) / p.period
        return Command(u), State(e, state.rest)
