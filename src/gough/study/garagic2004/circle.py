"""The first experiment of the paper: a horizontal circle of 0.2 m at 0.05 m/s, one turn from 240 degrees.

Strut i reverses where its length along the circle about c is greatest or least.  With w = (c + b_i - a_i), b_i and a_i
its joints on platform and base and the platform level,

    l^2 = |w + R e(theta)|^2,   dl^2/dtheta = 2 R w . e'(theta) = 0   at theta = atan2(w_y, w_x), and half a turn on (1)

which needs nothing of the program: the angles of the simulation are held against it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...log import Log
from ...measure.reversal import STUDIES, reversals
from ...program.standard.circle import Circle
from ...simulate.run import simulate
from ..study import Tick
from .setup import Case, believed, law, machine

RADIUS, FEED = 0.2, 0.05  # m, m/s
NEAR = (-0.02, 0.1)  # s about a reversal: where its peak is sought, the window of the studies' measure
LEARNED = ("parameters", "coulomb", "viscous", "weights")


class Glitch(NamedTuple):
    """A reversal: time s, strut from 0, glitch m, angle on the circle rad, strut length m, delay of its peak s."""

    time: float
    strut: int
    size: float
    angle: float
    length: float
    delay: float


class Turn(NamedTuple):
    """One turn under one law.  Rows of feed moves only."""

    law: str
    case: Case
    t: np.ndarray  # s
    contour: np.ndarray  # m
    orientation: np.ndarray  # rad
    glitches: list[Glitch]
    mean_length: float  # of a strut over the turn, m
    outside: float | None  # of an estimate beyond its bounds at worst, in halves of their range; None: no estimates
    drift: float | None  # the most that an inertial factor changed

    @property
    def worst(self) -> float:
        """The largest glitch, m."""
        return max(glitch.size for glitch in self.glitches)


def program() -> Circle:
    """The circle, from (-0.1, -0.1732, 0) m; 2 m/s2 at its ends."""
    return Circle(radius=RADIUS, feed=FEED, start=np.radians(240.0), acceleration=2.0)


def turn(name: str, case: Case, tick: Tick | None, told: float | None = None, **options) -> Turn:
    """Simulate one turn of a law of setup.LAWS.

    CCTPID knows the machine, the adaptive laws are told its numbers times `told` (default setup.WRONG).

    Raises
    ------
    RunError
        the run ended early.
    """
    true, circle = machine(case.encoder), program()
    if name == "CCTPID":
        known = true
    else:
        known = believed(true) if told is None else believed(true, told)
    control = law(name, case.gains, **options)
    kept = [f"controller.{state}" for state in LEARNED if state in getattr(control, "states", {})]
    log = simulate(
        known, control, circle, plant=true, period=case.period, progress=tick, on_fail="raise",
        signals=["contour_error", "orientation_error", "counted", *kept],
    )  # fmt: skip
    motion = circle.plan(known)
    row = motion.sample(0, motion.count(case.period), case.period)
    counted = log["counted"].astype(bool)
    found = reversals(case.period, row.qd, log["contour_error"], counted, STUDIES)
    drift = float(np.abs(log["controller.parameters"] - 1).max()) if "controller.parameters" in log else None
    return Turn(
        name, case, log.t[counted], log["contour_error"][counted], log["orientation_error"][counted],
        [_glitch(r, log, row) for r in found], float(row.q.mean()),
        _outside(log, control), drift,
    )  # fmt: skip


def angles_of_geometry(true) -> np.ndarray:
    """Where each strut reverses on the circle, eq. (1).  (12,) rad in 0 ... 2 pi, rising."""
    w = true.home[:3] + true.platform_joints_np() - true.joints.base
    first = np.arctan2(w[:, 1], w[:, 0])
    return np.sort(np.concatenate([first, first + np.pi]) % (2 * np.pi))


def distances(angles, wanted) -> np.ndarray:
    """How far each of `wanted` (n,) rad is from the nearest of `angles` (m,) rad on the circle.  (n,) rad."""
    apart = np.subtract.outer(np.asarray(wanted), np.asarray(angles))
    return np.abs((apart + np.pi) % (2 * np.pi) - np.pi).min(1, initial=np.pi)


def _glitch(found, log: Log, row) -> Glitch:
    t = log.t
    near = np.flatnonzero((t >= found.time + NEAR[0]) & (t <= found.time + NEAR[1]))
    peak = t[near[log["contour_error"][near].argmax()]]
    k = int(np.searchsorted(t, found.time)) - 1  # the row before
    part = slice(k, k + 2)
    share = (found.time - t[k]) / (t[k + 1] - t[k])
    x, y = row.x[part, 0], row.x[part, 1]
    angle = np.arctan2(*((1 - share) * v[0] + share * v[1] for v in (y, x)))
    return Glitch(
        found.time, found.joint, found.glitch, float(angle % (2 * np.pi)), float(row.q[k, found.joint]),
        float(peak - found.time),
    )  # fmt: skip


def _outside(log: Log, control) -> float | None:
    """How far the estimates ever left their projection set, in halves of its range: 0 on the edge, negative inside."""
    ends = {
        "parameters": getattr(control, "bounds", None),
        "coulomb": getattr(control, "friction_bounds", None),
        "viscous": getattr(control, "friction_bounds", None),
        "weights": [-control.strength, control.strength] if hasattr(control, "strength") else None,
    }
    found = []
    for state, bounds in ends.items():
        if bounds is not None and f"controller.{state}" in log:
            middle, half = (bounds[0] + bounds[1]) / 2, (bounds[1] - bounds[0]) / 2
            found.append(float(np.abs(log[f"controller.{state}"] - middle).max() / half - 1))
    return max(found) if found else None
