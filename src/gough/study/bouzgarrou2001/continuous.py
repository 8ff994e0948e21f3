"""Both laws in continuous time on the rigid machine, as the paper simulates them: no sample is held, no speed is late.

    computed torque   u = M_S (s_d'' + k_d e' + k_p e + k_i int e) + C_S s' + G_S                                  (1)
    cascade           u = m (k_P w + k_I int w),   w = s_d' - s' + k_V e                                           (2)

e = s_d - s, at rest at the first place until t = 0, the integral of (2) holding the weight.  It shares masses and
kinematics with the tick of simulate/, and neither laws nor integration.
"""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca
import numpy as np

from ...control.pid import PID
from ...kernel.building import BUILDING
from ...machine.hybrid import Hybrid
from ...simulate import tick
from .setup import TIME, Gains, cascade, move

RTOL, ATOL = 1e-9, 1e-12  # of the integration; m and m/s
ROWS = 2001


class Errors(NamedTuple):
    """What comes of a run."""

    t: np.ndarray  # s
    e: np.ndarray  # (n, 3) m


def follow(name: str, gains: Gains, m: Hybrid) -> Errors:
    """The move under a law of setup.LAWS that knows the machine `m`."""
    from scipy.integrate import solve_ivp

    program, dynamics, pid = move(), _dynamics(m), name == "PID"
    if pid:
        law = cascade(gains)
        mass, (k_V, k_P, k_I) = law.mass, _of_cascade(law)

    def reference(t):
        p, pd, pdd, *_ = program.poses(np.array([t]))
        return tuple(part[0] for part in m.joint_motion(m.home + p, pd, pdd))

    def rate(t, y):
        s, v, total = y[:3], y[3:6], y[6:]
        s_d, sd_d, sdd_d = reference(t)
        M, h = dynamics(s, v)
        if pid:
            w = sd_d - v + k_V * (s_d - s)
            u, grown = mass * (k_P * w + k_I * total), w
        else:
            ahead = sdd_d + gains.k_d * (sd_d - v) + gains.k_p * (s_d - s) + gains.k_i * total
            u, grown = M @ ahead + h, s_d - s
        return np.concatenate([v, np.linalg.solve(M, u - h), grown])

    s_0 = reference(0.0)[0]
    weight = dynamics(s_0, np.zeros(3))[1]
    held = weight / (mass * k_I) if pid else np.zeros(3)
    times = np.linspace(0.0, TIME, ROWS)
    found = solve_ivp(
        rate, (0.0, TIME), np.concatenate([s_0, np.zeros(3), held]), method="DOP853", t_eval=times, rtol=RTOL,
        atol=ATOL, max_step=2e-3,
    )  # fmt: skip
    s_d = np.array([reference(t)[0] for t in times])
    return Errors(times, s_d - found.y[:3].T)


def _of_cascade(law: PID) -> tuple[float, float, float]:
    """k_V, k_P and k_I of the paper's Fig. 2."""
    K_v, w, w_i = law.gains(law)
    return K_v, w, w * w_i


def _dynamics(m: Hybrid):
    """(s, s') -> M_S (3, 3) and C_S s' + G_S (3,)."""
    with BUILDING:
        p, theta, z, v, _ = tick.symbols_of(m)
        pi = {key: value for key, (value, _) in m.inertial(p).items()}
        f = ca.Function("f", [theta, z, v], list(m.mass_and_bias(p, pi, z, v)))
    b, numbers = m.base.half_width, np.array(m.theta)

    def at(s, v):
        phi = np.arcsin((s[1] - s[0]) / (2 * b))
        M, h = f(numbers, [*s, 2 * b * np.cos(phi), phi, phi], v)
        return np.array(M), np.array(h).ravel()

    return at
