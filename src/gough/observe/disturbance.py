"""Force on the tool from the forces of the drives: disturbance observer.

One sample of period Ts, _ the sample before; pose z from the readings and V the mean twist since then
(observe/forward.py), u the force that the drives applied in that time:

    a = (V - V_) / Ts,   Vm = (V + V_) / 2,   um = (u + u_) / 2                             all at the pose z_       (1)
    d = M a + h(z_, Vm) - J' (um - F) - F_p                      momentum form                                      (2)
    d = h(z, 0) - J' (u - F) - F_p                               static form                                        (3)
    w+ = w + k (d - w),   k = 1 - exp(-2 pi f Ts)                                                                   (4)

w is the force on the independent velocities, for a platform the wrench [f; m] on the tool at its tip, in W (for the
others observe/wrench.py makes one of it); f is the `bandwidth`; F and F_p are the frictions of observe/kinetic.py.

(2) is the balance of momentum p = M V over one sample, p - p_ = Ts (J'(um - F) + F_p + M' V - h + w), in which the
two M' V cancel; nothing is differentiated but the pose, and (4) answers a force as a first-order low pass behind a
delay of one sample.  (3) is the estimate of Okuda, Ibaraki, Kakino, Nakagawa, Matsushita, Disturbance estimation on a
hexapod-type parallel kinematic machine tool, 2006, eqs. (4)-(13), with the inertial force of their (14) neglected as
they allow, all six components where they give three, and the signs repaired; d of their eq. (5) is -w.

A sample counts only if all of (1) is known: readings that are there and that the joints can have reached at their
greatest speed, drives below their limit (a clipped current says nothing of the force), and an innovation d - w below
`greatest`.  Until three samples later w is held and `held` is 1.  So neither saturation nor a missing sample is read
as force.
docs/theory/disturbance.md derives (1)-(4) and says what follows from what nobody knows.
"""

from __future__ import annotations

from typing import Any, ClassVar, Literal, NamedTuple

import casadi as ca
import numpy as np
from pydantic import model_validator

from ..control.base import saturated
from ..declare import Array, quantity
from ..errors import InputError
from ..machine.drives import force_limit
from . import forward, kinetic
from .base import Observer
from .wrench import tool_map

WAIT = 3  # samples that a bad one spoils behind it: (1) reaches back two, and the pose settles in one more


class State(NamedTuple):
    """What the observer remembers."""

    pose: forward.Pose
    twist: Any  # V, as many as the machine has freedoms
    reading: Any  # last good readings, (n,) m
    force: Any  # last good forces, (n,) N
    load: Any  # w, on the velocities
    wait: Any  # samples until w follows again
    missed: Any  # samples since the last good reading


class Disturbance(NamedTuple):
    """What is found at a sample."""

    wrench_hat: Any  # on the tool, (6,) N, N m
    hidden: Any  # what friction near rest may hide, (6,) N, N m: kinetic eq. (4)
    held: Any  # 1 where w is held from before


class DisturbanceObserver(Observer):
    """Wrench on the tool from joint readings and drive forces, eqs. (1)-(4)."""

    found: ClassVar = {
        "wrench_hat": ("wrench_axis", "N, N m", "estimated wrench on the tool, at the tip, in W"),
        "hidden": ("wrench_axis", "N, N m", "what friction of joints near rest may hide in the estimate"),
        "held": ("", "1", "the estimate is held: a sample before it is missing, clipped or impossible"),
    }

    kind: Literal["disturbance"] = "disturbance"
    bandwidth: float = quantity("Hz", "of the low pass that the force comes through", default=20.0, above=0)
    form: Literal["momentum", "static"] = "momentum"
    rest: float = quantity("m/s", "joint speed below which the direction of friction fades", default=1e-3, above=0)
    base_torque: float | Array | None = quantity(
        "N m", "friction torque in each base joint of a hexapod, one value or six", default=None, at_least=0,
        shape=(-1,),
    )  # fmt: skip
    greatest: float | None = quantity(
        "N", "change of force from sample to sample beyond which a sample is no force", default=None, above=0
    )

    @model_validator(mode="after")
    def _fits(self):
        if self.machine is None:
            return self
        if self.base_torque is not None:
            if not hasattr(self.machine, "struts"):
                raise InputError("only a machine of struts has base joints with a torque", key="base_torque")
            if np.ndim(self.base_torque) and len(self.base_torque) != 6:
                raise InputError("must be one value or six", key="base_torque", value=str(len(self.base_torque)))
        return self

    def on(self, machine, period):
        """`Observer.on`; `greatest` is what all drives together can push, where nothing else is said."""
        bound = super().on(machine, period)
        limit = None if bound.greatest is not None else force_limit(bound.machine.drive)
        return bound if limit is None else bound.replace(greatest=float(limit) * bound.machine.joints_count)

    def init(self, x0) -> State:
        """At rest at the pose x0 (d,), with no force known yet."""
        m, x0 = self.machine, np.ravel(x0)
        zero, none = np.zeros(len(m.task)), np.zeros(len(m.velocities))
        q0, u0 = m.inverse_kinematics(x0), m.inverse_dynamics(x0, zero, zero)
        return State(forward.Pose(m.coordinates(x0)), none, q0, u0, none, float(WAIT), 0.0)

    def step(self, state: State, y, good, theta):
        p, m = self.at(theta), self.machine
        there = ca.logic_and(good > 0, self._reachable(p, state, y.q))
        q = ca.if_else(there, y.q, state.reading)
        clipped = saturated(m, p.machine, y.u)
        driven = good > 0 if clipped is None else ca.logic_and(good > 0, ca.mmax(clipped) == 0)
        u = ca.if_else(driven, y.u, state.force)
        z, V, pose = forward.estimate(m, p.machine, state.pose, q, p.period)
        T = tool_map(m, p.machine, z)
        d, doubt = self._balance(p, state, z, V, u, T)
        sound = ca.logic_and(there, driven)
        if self.greatest is not None:
            sound = ca.logic_and(sound, ca.norm_2((T @ (d - state.load))[:3]) <= p.greatest)
        wait = ca.if_else(sound, ca.fmax(state.wait - 1, 0), WAIT)
        follows = ca.logic_and(sound, state.wait <= 0)
        k = 1 - ca.exp(-2 * np.pi * p.bandwidth * p.period)
        w = ca.if_else(follows, state.load + k * (d - state.load), state.load)
        after = State(pose, V, q, u, w, wait, ca.if_else(there, 0, state.missed + 1))
        return Disturbance(T @ w, doubt, 1 - follows), after

    def _reachable(self, p, state: State, q):
        """Whether the joints can have come to q (n,) since the last good reading; 0 where q is no number."""
        if self.machine.limits.speed is None:
            return ca.mmin(ca.fabs(q) < np.inf)
        most = self.machine.limits.speed * p.period * (1 + state.missed)
        return ca.mmin(ca.fabs(q - state.reading) <= most)

    def _balance(self, p, state: State, z, V, u, T):
        """d of eq. (2) or (3), on the velocities, and what friction may hide of the wrench T makes of it, (6,)."""
        m, view = self.machine, p.machine
        pi = {key: value for key, (value, _) in m.inertial(view).items()}
        zero = ca.SX.zeros(V.shape)
        if self.form == "momentum":
            at, v, a, um = state.pose.pose, (V + state.twist) / 2, (V - state.twist) / p.period, (u + state.force) / 2
            own = m.inverse_force(view, pi, at, v, a)
        else:
            at, v, a, um = z, V, zero, u
            own = m.inverse_force(view, pi, at, zero, zero)
        J = m.jacobian_of(view, at)
        qd = J @ v
        numbers = kinetic.numbers_at(m, view, pi, at, v, a)
        net = um - kinetic.drive_friction(numbers, qd, p.rest)
        torque = None if self.base_torque is None else p.base_torque
        passive = kinetic.passive_friction(m, view, at, v, a, net, torque, p.rest)
        return own - J.T @ net - passive, kinetic.hidden(numbers, T @ J.T, qd, p.rest)
