"""The second experiment of the paper: a corner of 90 degrees at 0.2 m/s, taken by the reference without slowing down.

A previewed corner has a ramp in the place of the jump, C the corner and dv the change of the velocity v (T_0, T_1):

    p(tau) = C + v (T_0 + T_1) / 2 tau + dv (tau^2 / (2 T) + T / 8),   |tau| <= T / 2                             (1)

with its derivatives (docs/theory/corner.md).  When the corner falls between two samples, the controller hears of it up
to a sample later; `wait` is that time as a share of a sample.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...declare import quantity
from ...program.reference import Motion, Reference
from ...program.standard.polyline import Polyline
from ...simulate.run import simulate
from ..study import Tick
from .setup import FAST, WRONG, believed, law, machine

POINTS = np.array([[0.0, 0.0, 0.0], [0.05, 0.05, 0.01], [0.0, 0.098, 0.02]])  # m
FEED, ACCELERATION = 0.2, 2.0  # m/s, m/s2
BEFORE = 1e-9  # s that the corner is before "its" sample, so that rounding does not decide which side it is on
LEAD = 0.01  # s of rest before the start
SEEN = 4  # times a sample of the law that the contour error is looked at: a peak may be shorter than a sample
LAST = 0.99  # `wait` of nearly a whole sample


class Corner(Polyline):
    """Two lines passed at constant feed; with `ramp`, the reference's velocity turns linearly over that time.

    The ramp, eq. (1), is centred on the corner: the reference knows of it half of `ramp` before.
    """

    ramp: float = quantity("s", "time over which the velocity turns, centred on the corner", default=0.0, at_least=0)

    def plan(self, machine) -> Motion:
        """The motion, with the ramp in the place of the jump."""
        return Ramped(super().plan(machine), self.points, self.feed, self.ramp)


class Ramped(Motion):
    """A motion along two lines whose velocity turns from one to the other within `ramp` s, at constant acceleration."""

    def __init__(self, sharp: Motion, points, feed: float, ramp: float):
        super().__init__(sharp.path, sharp.course, sharp.feed, sharp.machine, sharp.settle, sharp.lead_in)
        legs = np.diff(np.asarray(points, float), axis=0)
        length = np.linalg.norm(legs, axis=1)
        self.ramp = ramp
        self.velocity = feed * legs / length[:, None]  # before and behind, m/s
        start = np.array(sharp.path.point(np.array([0]), np.zeros(1))[0])
        self.corner = start + legs[0]
        # feed / (2 a) longer than at constant speed, for the start from rest
        self.at = self.lead_in + length[0] / feed + feed / (2 * ACCELERATION)

    def sample(self, k0: int, k1: int, Ts: float) -> Reference:
        """Samples k0 ... k1 - 1; eq. (1) within the ramp, which ends before the sample at T / 2."""
        row = super().sample(k0, k1, Ts)
        T, tau = self.ramp, np.arange(k0, k1) * Ts - self.at
        on = (tau >= -T / 2) & (tau < T / 2)
        if not on.any():
            return row
        tau = tau[on][:, None]
        before, behind = self.velocity
        mean, change = (before + behind) / 2, behind - before
        x, xd, xdd = row.x.copy(), row.xd.copy(), row.xdd.copy()
        x[on, :3] = self.corner + mean * tau + change * (tau**2 / (2 * T) + T / 8)
        xd[on, :3] = mean + change * tau / T
        xdd[on, :3] = change / T
        q, qd, qdd = self.machine.joint_motion(x, xd, xdd)
        return row._replace(x=x, xd=xd, xdd=xdd, q=q, qd=qd, qdd=qdd)


class Passed(NamedTuple):
    """A corner under one law."""

    error: float  # largest contour error, m
    orientation: float  # rad
    torque: float  # largest of a motor, N m
    t: np.ndarray  # s from the corner
    contour: np.ndarray  # m


def program(period: float, wait: float = 0.0, samples: int = 0) -> Corner:
    """The corner `wait` samples of `period` s before the next sample, its velocity turned within `samples` samples."""
    plain = Corner(points=POINTS, feed=FEED, acceleration=ACCELERATION, corner="constant", lead_in=LEAD)
    first = plain.plan(machine()).at - samples * period / 2  # when the velocity begins to turn
    lead = LEAD + (-first / period - wait) % 1.0 * period - BEFORE
    return plain.replace(lead_in=lead, ramp=samples * period)


def passed(
    name: str, gains, period: float, tick: Tick | None, *, wait: float = 0.0, samples: int = 0,
    torque_limit: float | None = None, told: float = WRONG, **options,
) -> Passed:  # fmt: skip
    """Take the corner under a law of setup.LAWS with the gains of a case.  CCTPID knows the machine, as on the circle.

    Raises
    ------
    RunError
        the run ended early.
    """
    true = machine(FAST.encoder if period < 1e-3 else 1e-6, torque_limit)
    known = true if name == "CCTPID" else believed(true, told)
    corner = program(period, wait, samples)
    control = law(name, gains, **options).replace(period=period)
    log = simulate(
        known, control, corner, plant=true, period=period / SEEN, progress=tick, on_fail="raise",
        signals=["contour_error", "orientation_error", "counted", "u"],
    )  # fmt: skip
    counted = log["counted"].astype(bool)
    torque = float(np.abs(log["u"]).max() * true.drive.lead / (2 * np.pi))
    error, turned = log["contour_error"][counted], log["orientation_error"][counted]
    return Passed(float(error.max()), float(turned.max()), torque, log.t[counted] - corner.plan(known).at, error)
