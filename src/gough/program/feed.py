"""The feed along a path: how far, how fast, at every time, within the limits of every block, with look-ahead.

The blocks of the path are a chain of cells (profiles/phases.py) with limits (limits.py) and stops (junctions.py); a
profile of the chain says when the feed is where: profiles/trapezoid.py with steps of the acceleration,
profiles/jerk_limited.py with a bounded jerk.  A shaper (profiles/shaped.py) makes every run between rests the mean of
itself and of itself some time later.

With corner = "constant" corners are no stops.  The velocity jumps there: "commanded velocity directions are changed
without acceleration/deceleration limits" (the corner test of garagic-srinivasan-2004).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..errors import ProgramError
from .joint_limits import JointLimits
from .junctions import stops
from .limits import Limits, block_limits
from .path import Path
from .profiles.jerk_limited import jerk_limited
from .profiles.phases import Cells
from .profiles.shaped import shaped
from .profiles.trapezoid import trapezoid
from .shaper import Shaper

PROFILES = {"trapezoid": trapezoid, "jerk_limited": jerk_limited}


class FeedState(NamedTuple):
    """Where the feed is at n times: block, extent travelled in it, and three derivatives of that by time.  (n,)."""

    block: np.ndarray
    u: np.ndarray
    ud: np.ndarray
    udd: np.ndarray
    uddd: np.ndarray


class Feed:
    """The feed profile of a path.  `duration` s; `times` (m + 1,) s of the junctions; of each block `extent`, and the
    `speed`, `acceleration` and `jerk` it may use.

    With a `machine` its joints stay below their greatest speed and acceleration too (joint_limits.py).

    Raises
    ------
    ProgramError
        a jerk-limited profile without a jerk; joints without limits.
    """

    def __init__(
        self, path: Path, limits: Limits, corner: str | None = None, profile: str = "trapezoid", machine=None,
        shaper: Shaper | None = None,
    ):  # fmt: skip
        if profile == "jerk_limited" and limits.jerk is None:
            raise ProgramError(
                "a jerk-limited profile needs a jerk", key="jerk",
                cure='write jerk = "50 m/s3" in [program], or in [feed] of the machine',
            )  # fmt: skip
        if profile == "trapezoid":
            limits = limits._replace(jerk=None)
        self.extent = path.extent
        self.speed, self.acceleration, self.jerk = block_limits(path, limits)
        every = np.arange(len(path))
        stop = np.concatenate([[True], stops(path, corner), [True]])
        cells = Cells(
            every, np.zeros(len(path)), self.extent, self.speed, self.acceleration, self.jerk, path.dwell, stop
        )
        self._make, self._shaper = PROFILES[profile], shaper
        if machine is None:
            self.run(cells)
        else:
            JointLimits(path, machine).applied(self, cells)
        first = np.searchsorted(self.cells.block, np.arange(len(path) + 1))
        self.times = self.profile.times[first]

    def run(self, cells: Cells) -> None:
        """Make the profile anew, for these cells."""
        self.cells = cells
        self.profile = self._make(cells) if self._shaper is None else shaped(self._make, cells, self._shaper)
        self.duration = float(self.profile.times[-1])

    def cell(self, t):
        """In which cell the feed is at times t (n,)."""
        c = np.searchsorted(self.profile.times, t, "right") - 1
        last = len(self.cells.length) - 1
        return np.where(t >= self.duration, last, np.where(c < 0, 0, c))

    def at(self, t) -> FeedState:
        """Exact position, speed, acceleration and jerk at times t (n,).  Before the start and behind the end: rest."""
        phases, cells = self.profile.phases, self.cells
        after, before, c = t >= self.duration, t < 0, self.cell(t)
        x, v, a, j = phases.at(phases.find(t), t)
        length = cells.length[c]
        x = x - self.profile.x[c]
        still = after | before | (length == 0)
        x = np.where(after, length, np.where(still | (x < 0), 0.0, np.where(x > length, length, x)))
        v, a, j = (np.where(still, 0.0, q) for q in (np.where(v < 0, 0.0, v), a, j))
        return FeedState(cells.block[c], cells.u[c] + x, v, a, j)
