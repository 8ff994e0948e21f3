"""Cascade control of each joint, P-PI(D), as machine tools ship it.

    v   = (q - q_) / Ts                                                  speed from the encoder, _ the sample before (1)
    v_c = k_ff q_r' + K_v (q_r - q)                                      position loop                               (2)
    i+  = i + Ts (v_c - v)                                               held while the drive is saturated           (3)
    u   = m w [ (v_c - v) + w_i i - T_D (v - v_) / Ts ] + m k_a q_r''    speed loop                                  (4)

Tuned by one number, the `bandwidth` f of the position loop: K_v = 2 pi f, w = `speed_ratio` K_v, w_i = K_v / 2.
m is the mass a joint feels while the others are held: the diagonal of M_q = J^-T M J^-1 at home, or `mass`.  The
joints of a parallel machine are coupled and a diagonal law cannot know it: on the octahedral hexapod
the speed loop of single directions is 0.44 to 4.1 times as fast as w.  That bounds the bandwidth (simulate.stability).
"""

from __future__ import annotations

from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from ..declare import Array, quantity
from ..errors import ExperimentError
from .base import Command, Controller, saturated


class State(NamedTuple):
    """What the law remembers."""

    position: Any  # joints of the last sample, (n,) m
    speed: Any  # of the last sample, (n,) m/s
    integral: Any  # of the speed error, (n,) m


class PID(Controller):
    """Joint-space cascade, eqs. (1)-(4)."""

    states: ClassVar = {
        "position": ("joint", "m", "joint coordinates of the last sample"),
        "speed": ("joint", "m/s", "joint speed of the last sample"),
        "integral": ("joint", "m", "integral of the speed error"),
    }

    tuned: ClassVar = ("bandwidth",)

    kind: Literal["pid"] = "pid"
    bandwidth: float = quantity("Hz", "bandwidth of the position loop", above=0)
    speed_ratio: float = quantity("1", "speed loop bandwidth over position loop bandwidth", default=3.0, above=0)
    derivative: float = quantity("s", "derivative time T_D of the speed loop", default=0.0, at_least=0)
    feedforward: float = quantity("1", "share k_ff of the reference speed fed forward", default=1.0, at_least=0)
    acceleration_feedforward: float = quantity(
        "1", "share k_a of the reference acceleration fed forward", default=0.0, at_least=0
    )
    mass: float | Array | None = quantity("kg", "mass m felt by each joint", default=None, above=0, shape=(-1,))

    def on(self, machine, period):
        law = super().on(machine, period)
        if np.ndim(law.mass) and len(law.mass) != law.machine.joints_count:
            raise ExperimentError(
                f"must be one value or {law.machine.joints_count}", key="mass", value=f"{len(law.mass)} values"
            )
        return law if law.mass is not None else law.replace(mass=joint_mass(law.machine))

    def gains(self, p):
        """K_v, w, w_i of eqs. (2)-(4), 1/s."""
        K_v = 2 * np.pi * p.bandwidth
        w = p.speed_ratio * K_v
        return K_v, w, K_v / 2

    def init(self, r0, u0) -> State:
        """The state from which the first step gives u0 at r0."""
        _, w, w_i = self.gains(self)
        return State(np.ravel(r0.q), np.zeros(len(np.ravel(r0.q))), np.ravel(u0) / (self.mass * w * w_i))

    def step(self, state: State, r, y, theta):
        p, m = self.at(theta), self.machine
        K_v, w, w_i = self.gains(p)
        v = (y.q - state.position) / p.period
        v_c = p.feedforward * r.qd + K_v * (r.q - y.q)
        damping = p.derivative * (v - state.speed) / p.period
        u = p.mass * (w * (v_c - v + w_i * state.integral - damping) + p.acceleration_feedforward * r.qdd)
        held = saturated(m, p.machine, y.u)
        go_on = 1 if held is None else 1 - held
        return Command(u), State(y.q, v, state.integral + go_on * p.period * (v_c - v))


def joint_mass(machine) -> np.ndarray:
    """Diagonal of the joint-space mass matrix J^-T M J^-1 at home.  (n,) kg."""
    J = machine.jacobian(machine.home)
    return np.diag(np.linalg.inv(J @ np.linalg.solve(machine.mass_matrix(machine.home), J.T))).copy()
