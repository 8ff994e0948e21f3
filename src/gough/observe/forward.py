"""Pose of the tool from the measured joints, a few Newton steps a sample, and the twist between samples.

    d = J(z)^-1 (q_m - q(z)),   z <- p + d_v, exp(d_w) R                 `iterations` times                          (1)
    V = [p - p_; log(R R_')] / Ts                                        _ the sample before                         (2)

Garagic and Srinivasan, ACC 2004, eq. (6): two iterations from the last sample's pose.  At 0.2 m/s and 1 ms the start
is 0.2 mm away and the error after two steps is below 1e-12 m: Newton squares it each time.  The step is taken on
SO(3), the paper adds it to Euler angles.  (2) is the mean twist of the last sample, half a sample old.  A machine of
other coordinates has its own step and its own velocities in their place (`Machine.newton_step`, `between`).
"""

from __future__ import annotations

from typing import Any, NamedTuple


class Pose(NamedTuple):
    """State of the observer: coordinates z of the machine."""

    pose: Any


def estimate(machine, p, state: Pose, q_m, period, iterations: int = 2):
    """Coordinates z and velocities v from joints q_m (n,) m, and the next state.  Eqs. (1), (2).

    `p` is the view of `machine` the law believes.
    """
    z = state.pose
    for _ in range(iterations):
        z = machine.normalised(p, machine.stepped(z, machine.newton_step(p, z, q_m)))
    return z, machine.between(state.pose, z) / period, Pose(z)
