"""Cascade control of each joint, P-PI(D), as machine tools ship it.

    v   = (q - q_) / Ts                                                  speed from the encoder, _ the sample before (1)
    v_c = k_ff q_r' + K_v (q_r - q)                                      position loop                               (2)
    i+  = i + Ts (v_c - v)                                               held while the drive is saturated           (3)
    u   = m w [ (v_c - v) + w_i i - T_D (v - v_) / Ts ] + m k_a q_r''    speed loop                                  (4)

Tuned by one number, the `bandwidth` f of the position loop: K_v = 2 pi f, w = `speed_ratio` K_v, w_i = K_v / 2.  Or by
three `poles` of a joint of mass m with k_ff = 1 and T_D = 0, whose error is u / m = K_D e' + K_P e + K_I int e:

    K_D = w,   K_P = w K_v + w w_i,   K_I = w w_i K_v,   s^3 + K_D s^2 + K_P s + K_I = (s + w1)(s + w2)(s + w3)    (5)
    K_D K_v^2 - K_P K_v + K_I = 0,   the larger K_v of the two;   w = K_D,   w_i = K_I / (K_D K_v)                 (6)

The smaller K_v gives the same poles with more of them in the speed loop's integral: K_v and w_i change places in (5).
Poles near one another ask for a K_v that is not real, and no cascade has them: K_P^2 >= 4 K_D K_I is checked.
Bouzgarrou et al. 2001, section 3.1 (k_P = w, k_I = w w_i, k_V = K_v), place the poles of their cascade so.

m is the mass a joint feels while the others are held: the diagonal of M_q = J^-T M J^-1 at home, or `mass`.  The
joints of a parallel machine are coupled and a diagonal law cannot know it: on the octahedral hexapod
the speed loop of single directions is 0.44 to 4.1 times as fast as w.  That bounds the bandwidth (simulate.stability).
"""

from __future__ import annotations

from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import model_validator

from ..declare import Array, quantity
from ..errors import ExperimentError, InputError
from .base import Command, Controller, saturated


class State(NamedTuple):
    """What the law remembers."""

    position: Any  # joints of the last sample, (n,) m
    speed: Any  # of the last sample, (n,) m/s
    integral: Any  # of the speed error, (n,) m


class PID(Controller):
    """Joint-space cascade, eqs. (1)-(6)."""

    states: ClassVar = {
        "position": ("joint", "m", "joint coordinates of the last sample"),
        "speed": ("joint", "m/s", "joint speed of the last sample"),
        "integral": ("joint", "m", "integral of the speed error"),
    }

    tuned: ClassVar = ("bandwidth", "poles")

    kind: Literal["pid"] = "pid"
    bandwidth: float | None = quantity("Hz", "bandwidth of the position loop", default=None, above=0)
    poles: Array | None = quantity(
        "1/s", "magnitudes of the three poles of a joint, in the place of bandwidth", default=None, above=0, shape=(3,)
    )
    speed_ratio: float = quantity(
        "1", "speed loop bandwidth over position loop bandwidth; poles need none", default=3.0, above=0
    )
    derivative: float = quantity("s", "derivative time T_D of the speed loop", default=0.0, at_least=0)
    feedforward: float = quantity("1", "share k_ff of the reference speed fed forward", default=1.0, at_least=0)
    acceleration_feedforward: float = quantity(
        "1", "share k_a of the reference acceleration fed forward", default=0.0, at_least=0
    )
    mass: float | Array | None = quantity("kg", "mass m felt by each joint", default=None, above=0, shape=(-1,))

    @model_validator(mode="after")
    def _tuned(self):
        if self.bandwidth is None and self.poles is None:
            raise InputError("is missing", key="bandwidth", cure='write bandwidth = "10 Hz", or give three poles')
        if self.bandwidth is not None and self.poles is not None:
            raise InputError("give either bandwidth or poles", key="bandwidth", cure="take one of them out")
        if self.poles is not None:
            K_D, K_P, K_I = error_gains(self.poles)
            if K_P**2 < 4 * K_D * K_I:
                raise InputError(
                    "no cascade has these poles: K_v would not be real", key="poles",
                    value=f"K_P^2 / (4 K_D K_I) = {K_P**2 / (4 * K_D * K_I):.4g}", limit="at least 1",
                    cure="move the poles apart, for example 1 : 3 : 9",
                )  # fmt: skip
        return self

    def on(self, machine, period):
        law = super().on(machine, period)
        if np.ndim(law.mass) and len(law.mass) != law.machine.joints_count:
            raise ExperimentError(
                f"must be one value or {law.machine.joints_count}", key="mass", value=f"{len(law.mass)} values"
            )
        return law if law.mass is not None else law.replace(mass=joint_mass(law.machine))

    def gains(self, p):
        """K_v, w, w_i of eqs. (2)-(4), 1/s."""
        if self.poles is not None:
            K_D, K_P, K_I = error_gains(p.poles)
            K_v = (K_P + (K_P**2 - 4 * K_D * K_I) ** 0.5) / (2 * K_D)
            return K_v, K_D, K_I / (K_D * K_v)
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


def error_gains(poles):
    """K_D, K_P, K_I of three poles, eq. (5): numbers or symbols, 1/s, 1/s2, 1/s3."""
    a, b, c = poles[0], poles[1], poles[2]
    return a + b + c, a * b + b * c + a * c, a * b * c


def joint_mass(machine) -> np.ndarray:
    """Diagonal of the joint-space mass matrix J^-T M J^-1 at home.  (n,) kg."""
    J = machine.jacobian(machine.home)
    return np.diag(np.linalg.inv(J @ np.linalg.solve(machine.mass_matrix(machine.home), J.T))).copy()
