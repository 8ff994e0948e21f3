"""Computed torque with PID in Cartesian coordinates (CCTPID).

    e   = [p_r - p; log(R_r R')],   e_V = V_r - V                        rotation as a rotation vector               (1)
    i+  = i + Ts e                                                       held while a drive is saturated             (2)
    a   = V_r' + K_D e_V + K_P e + K_I i                                                                             (3)
    u   = J^-T (M a + h(z, V))                                                                                       (4)

K_D, K_P, K_I place the poles of the decoupled error, s^3 + K_D s^2 + K_P s + K_I = (s + w1)(s + w2)(s + w3):
`bandwidth` f gives w = (1, 1, 2) 2 pi f, `poles` gives them one by one, `error_gains` gives K_D, K_P, K_I themselves,
of which two poles may be a swinging pair.  Garagic and Srinivasan, ACC 2004, call this
CCTPID and take it as their baseline with w0 = 100 rad/s; poles (100, 100, 200) 1/s bring out their corner error.

Pose and twist come from the measured joints (observe.forward).  Two deviations from the paper: the error of
orientation is a rotation vector, not a difference of Euler angles; the model is the believed machine without friction.
On a machine whose velocities are no twist, (1)-(4) are in its own velocities: on the 3-PRS in those of the sliders, on
the hybrid machine in s', where they are eqs. (7)-(9) of Bouzgarrou et al. 2001.
"""

from __future__ import annotations

from typing import Any, ClassVar, Literal, NamedTuple

import casadi as ca
import numpy as np
from pydantic import model_validator

from ..declare import Array, quantity
from ..errors import InputError
from ..mechanics.linear import solve_square_transposed
from ..observe import forward
from .base import Command, Controller, saturated, unknown_force


class State(NamedTuple):
    """What the law remembers."""

    observer: forward.Pose
    integral: Any  # of e, (len(v),) m s, rad s
    started: Any  # forces at rest minus the model's, (len(v),) on v


class ComputedTorque(Controller):
    """Cartesian computed-torque PID, eqs. (1)-(4)."""

    states: ClassVar = {
        "observer.pose": ("coordinate", "m, 1", "estimated pose: position and quaternion of the tool in W"),
        "integral": ("twist", "m s, rad s", "integral of the pose error"),
        "started": ("twist", "N, N m", "force at rest that the model did not know"),
    }

    tuned: ClassVar = ("bandwidth", "poles")

    kind: Literal["computed_torque"] = "computed_torque"
    bandwidth: float | None = quantity("Hz", "of the error: poles at (1, 1, 2) 2 pi bandwidth", default=None, above=0)
    poles: Array | None = quantity("1/s", "magnitudes of the three error poles", default=None, above=0, shape=(3,))

    error_gains: Array | None = quantity(
        "1/s, 1/s2, 1/s3", "K_D, K_P, K_I themselves", default=None, above=0, shape=(3,)
    )

    @model_validator(mode="after")
    def _one_of_three(self):
        given = [name for name in ("bandwidth", "poles", "error_gains") if getattr(self, name) is not None]
        if not given:
            raise InputError("is missing", key="bandwidth", cure='write bandwidth = "16 Hz", or give three poles')
        if len(given) > 1:
            raise InputError(f"give one of {' and '.join(given)}", key="bandwidth", cure="take the others out")
        if self.error_gains is not None:
            K_D, K_P, K_I = self.error_gains
            if K_D * K_P <= K_I:
                raise InputError(
                    "the error would grow: K_D K_P must be above K_I", key="error_gains",
                    value=f"{K_D * K_P:.4g} 1/s3", limit=f"{K_I:.4g} 1/s3",
                )  # fmt: skip
        return self

    def gains(self, p):
        """K_D, K_P, K_I of eq. (3)."""
        if self.error_gains is not None:
            return p.error_gains[0], p.error_gains[1], p.error_gains[2]
        if self.poles is None:
            w = 2 * np.pi * p.bandwidth
            return 4 * w, 5 * w**2, 2 * w**3
        a, b, c = p.poles[0], p.poles[1], p.poles[2]
        return a + b + c, a * b + b * c + a * c, a * b * c

    def init(self, r0, u0) -> State:
        """The state from which the first step gives u0 at r0."""
        z0 = self.machine.coordinates(np.ravel(r0.x))
        return State(forward.Pose(z0), np.zeros(len(self.machine.velocities)), unknown_force(self.machine, r0, u0))

    def step(self, state: State, r, y, theta):
        p, m = self.at(theta), self.machine
        z, V, observer = forward.estimate(m, p.machine, state.observer, y.q, p.period)
        K_D, K_P, K_I = self.gains(p)
        e, V_r, A_r = m.target(p.machine, r, z)
        a = A_r + K_D * (V_r - V) + K_P * e + K_I * state.integral
        pi = {key: value for key, (value, _) in m.inertial(p.machine).items()}
        force = m.inverse_force(p.machine, pi, z, V, a) + state.started
        u = solve_square_transposed(m.jacobian_of(p.machine, z), force)
        held = saturated(m, p.machine, y.u)
        go_on = 1 if held is None else 1 - ca.mmax(held)
        return Command(u), State(observer, state.integral + go_on * p.period * e, state.started)
