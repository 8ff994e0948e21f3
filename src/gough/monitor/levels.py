"""Forces that nothing but friction and encoders can feign: below them a monitor calls nothing an event.

    B_k   = sum_i |(T J')_ki| g(0)                                          friction of joints at rest               (1)
    s_k   = c r / (sqrt(12) Ts^2) |row k of T M J^-1|,   c^2 = sum h_j^2    an encoder's steps of r                  (2)
    level = |B_f| + 6 |s_f|                                                 of the force, not the moment             (3)
    jump  = 2 (1 - exp(-2 pi f D)) |B_f| + 6 sqrt(2) |s_f|                  of what it changes by within D           (4)

(4): where a joint turns back, friction that is believed wrongly one way becomes friction that is believed wrongly the
other way, a step of twice (1); of a step the low pass of f Hz shows so much within D.  Two noises are sqrt(2) of one.
h is the answer of the observer's low pass to the second difference of one reading.  (1) is eq. (4) of
observe/kinetic.py at rest.  docs/theory/disturbance.md says how far (2) is from what is measured.
"""

from __future__ import annotations

import numpy as np

from ..observe.disturbance import DisturbanceObserver
from ..observe.recorded import Recorder
from ..observe.wrench import tool_map_np

SPREADS = 6.0


def friction_level(observer: DisturbanceObserver, x) -> np.ndarray:
    """B of eq. (1) at the pose x (d,).  (6,) N, N m."""
    q = observer.machine.inverse_kinematics(x)[None]
    return Recorder(observer, x).rows(q, np.zeros_like(q))["hidden"][0]


def noise_level(observer: DisturbanceObserver, x) -> np.ndarray:
    """s of eq. (2) at the pose x (d,), with the encoder's noise.  (6,) N, N m."""
    machine, period = observer.machine, observer.period
    drive = machine.drive
    r = np.hypot((drive.encoder or 0.0) / np.sqrt(12), drive.noise or 0.0)
    if observer.form == "static":
        return np.zeros(6)
    k = 1 - np.exp(-2 * np.pi * observer.bandwidth * period)
    h = np.convolve(k * (1 - k) ** np.arange(2000), [1, -2, 1])
    rows = tool_map_np(machine, x) @ machine.velocity_mass(x) @ np.linalg.inv(machine.velocity_jacobian(x))
    return np.sqrt((h**2).sum()) * r / period**2 * np.linalg.norm(rows, axis=1)


def jump_level(observer: DisturbanceObserver, x, span: float) -> float:
    """Eq. (4) for D = `span` s, N."""
    B, s = friction_level(observer, x), noise_level(observer, x)
    share = 1 - np.exp(-2 * np.pi * observer.bandwidth * span)
    return float(2 * share * np.linalg.norm(B[:3]) + SPREADS * np.sqrt(2) * np.linalg.norm(s[:3]))


def default_level(observer: DisturbanceObserver, x) -> float:
    """Eq. (3), N."""
    B, s = friction_level(observer, x), noise_level(observer, x)
    return float(np.linalg.norm(B[:3]) + SPREADS * np.linalg.norm(s[:3]))
