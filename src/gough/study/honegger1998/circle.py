"""Figures 7 and 8 and Table 2: a circle of 15 mm in the plane of x and y, and the error of its radius.

The radius is not printed.  A PD law without feed-forward is a spring, its error the inertial force over its stiffness:
along the rails (x), where the six carriages move with the platform, about (6 m_S + m_7) v^2 / r / (6 k), whatever the
geometry is; the published least error of 56 um at 0.4 m/s gives r = 15 to 16 mm.  `springs` has the geometry in it,
and what else is linear.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...program.standard.circle import Circle
from ...simulate.linear import linearize
from ...simulate.run import simulate
from ..study import Tick
from .setup import DAMPING, PERIOD, STIFFNESS, machine

RADIUS = 0.015  # m
KEYS = ("min", "max", "mean", "sigma")  # of Table 2
ACCELERATION = 12.0  # m/s2; 0.4 m/s on 15 mm is 10.7 towards the centre, and the sheet's 10 would slow it down
TURNS = 3  # the second one is measured: what the start has stirred is gone


class Turn(NamedTuple):
    """One turn at a steady feed: where on the circle, and how much too large the radius is there."""

    speed: float  # m/s
    angle: np.ndarray  # (n,) rad
    error: np.ndarray  # (n,) m, outside +

    @property
    def table(self) -> dict[str, float]:
        """min, max, mean and sigma, m: a row of Table 2."""
        e = self.error
        return {"min": float(e.min()), "max": float(e.max()), "mean": float(e.mean()), "sigma": float(e.std())}


def program(speed: float) -> Circle:
    """The circle at `speed` m/s."""
    return Circle(radius=RADIUS, feed=speed, turns=TURNS, acceleration=ACCELERATION)


def turn(law, speed: float, tick: Tick | None = None, true=None, believed=None) -> Turn:
    """One turn under a law at `speed` m/s, on the machine or another true one, or with another one believed.

    Raises
    ------
    RunError
        the run ended early.
    """
    believed = believed or machine()
    log = simulate(
        believed, law, program(speed), plant=true, period=PERIOD, progress=tick, on_fail="raise",
        signals=["x_r", "s_r", "radial_error"],
    )  # fmt: skip
    length = 2 * np.pi * RADIUS
    on = (log["s_r"] >= length) & (log["s_r"] < 2 * length)
    # the circle stands about the machine's home, and begins on its +x side
    x, y = (log["x_r"][on, i] - believed.home[i] for i in (0, 1))
    return Turn(speed, np.unwrap(np.arctan2(y, x)), log["radial_error"][on])


def springs(true, speed: float, angle) -> np.ndarray:
    """Radial errors at `angle` (n,) of PD joints at `speed` m/s, without friction: linear, at home.  (n,) m.

    With d the displacement of the tool behind the reference, A_21 d what gravity and the resting forces make of a
    displacement (simulate/linear.py), and w = v / r,

        M d'' + d_J J' J d' + k J' J d = M (x_r'' - A_21 x_r),    x_r = r [cos wt, sin wt, 0 ...]
    """
    still = linearize(true, true.home)
    d = len(true.task)
    J, M = true.jacobian(true.home), true.mass_matrix(true.home)
    w, x = speed / RADIUS, np.zeros(d, complex)
    x[:2] = RADIUS, -1j * RADIUS
    K = (STIFFNESS + 1j * w * DAMPING) * J.T @ J - w**2 * M
    behind = np.linalg.solve(K, M @ (-(w**2) * x - still.A[d:, :d] @ x))[:2]
    turned = np.exp(1j * np.asarray(angle))
    return -(np.cos(angle) * (behind[0] * turned).real + np.sin(angle) * (behind[1] * turned).real)
