"""The motion of the paper: X = a cos(w t), Y = b sin(w t), at full speed from the first instant on.

Its parameter runs evenly, so that along an ellipse the feed swings between b w and a w.  With s(phi) the arc length and
s' = ds/dphi = sqrt(a^2 sin^2 phi + b^2 cos^2 phi),

    u = s(w t),   u' = w s',   u'' = w^2 (a^2 - b^2) sin phi cos phi / s'                                          (1)

The path itself begins and ends `SPARE` before and behind the motion, so that a tool beside the reference is still
measured against the ellipse and not against its end.
"""

from __future__ import annotations

import numpy as np

from ...declare import Array, quantity
from ...frames import rotation_of_abc_np
from ...program import blocks
from ...program.base import Program
from ...program.course import course_of
from ...program.feed import FeedState
from ...program.limits import Limits
from ...program.path import Path
from ...program.reference import Motion

SPARE = 0.1  # rad


class Harmonic(Program):
    """An ellipse with the half axes `semi` along x and y of the program's frame, run evenly in its parameter."""

    semi: Array = quantity("m", "half axes along x and y, the first not smaller", above=0, shape=(2,))
    rate: float = quantity("rad/s", "w, of the parameter", above=0)
    time: float = quantity("s", "how long", above=0, at_most=1000)

    def path(self) -> Path:
        a, b = self.semi
        curve = blocks.Ellipse((0, 0, 0), (a, 0, 0), (0, b, 0), -SPARE, self.rate * self.time + 2 * SPARE)
        return Path([blocks.Block(curve, (0, 0, 0), (0, 0, 0), a * self.rate)])

    def plan(self, machine) -> Motion:
        origin = machine.program_zero if self.origin is None else self.origin
        path = self.path().placed(np.asarray(origin[:3], float), rotation_of_abc_np(np.asarray(origin[3:], float)))
        feed = machine.feed
        limits = Limits(feed.rapid, feed.acceleration, feed.angular_rate, feed.angular_acceleration, None)
        course = course_of(path, self.rules, limits)
        return Motion(path, course, EvenParameter(self, path), machine, settle=0.0)


class EvenParameter:
    """The feed of eq. (1), as `program.feed.Feed` answers."""

    def __init__(self, program: Harmonic, path: Path):
        self.a, self.b = program.semi
        self.rate, self.duration, self.extent = program.rate, program.time, path.extent
        self.speed = np.array([self.a * self.rate])
        sweep = program.rate * program.time + SPARE
        grid = np.linspace(-SPARE, sweep, max(int((sweep + SPARE) * 2000), 2))
        self._grid, self._s = grid, np.concatenate([[0.0], np.cumsum(self._panels(grid))])

    def _slope(self, phi):
        return np.hypot(self.a * np.sin(phi), self.b * np.cos(phi))

    def _panels(self, grid):
        """Arc length between neighbours of the grid: Gauss's rule of four points, exact to rounding at 3 mrad."""
        x, w = np.polynomial.legendre.leggauss(4)
        low, high = grid[:-1, None], grid[1:, None]
        return ((high - low) / 2 * self._slope((low + high) / 2 + (high - low) / 2 * x) * w).sum(1)

    def at(self, t) -> FeedState:
        t = np.asarray(t, float)
        phi = self.rate * np.clip(t, 0.0, self.duration)
        i = np.clip(np.searchsorted(self._grid, phi, "right") - 1, 0, len(self._grid) - 2)
        x, w = np.polynomial.legendre.leggauss(4)
        half = (phi - self._grid[i]) / 2
        rest = (half[:, None] * self._slope(self._grid[i][:, None] + half[:, None] * (1 + x)) * w).sum(1)
        u, slope = np.minimum(self._s[i] + rest, self.extent[0]), self._slope(phi)
        ud = self.rate * slope
        udd = self.rate**2 * (self.a**2 - self.b**2) * np.sin(phi) * np.cos(phi) / slope
        return FeedState(np.zeros(len(t), int), u, ud, udd, np.zeros(len(t)))
