"""The speed that a machine's joints allow at every place of a path, whatever the feed words say.

The programmed path is cut into cells.  In each cell two speeds count, V along the path and a its change:

    V_c = greatest V <= F with  use(V, 0) <= 1        held steadily                                               (1)
    V_r = greatest V <= F with  use(V, +-A) <= 1      changed as fast as the controller changes it, by A           (2)

`use` is that of demand.py, of the joints' speed, acceleration and force together.  A feed of V_c at every place is the
fastest that words can say; where the planner's own ramps then ask for too much, `lower` takes what is over away.
"""

from __future__ import annotations

import numpy as np

from .advice import fitting
from .course import rows, state, stretches
from .demand import Demand

CELL = 1e-3  # m or rad
_MOST = 300_000  # cells; with more, cells grow
_ROWS = 16_384
SPARE = 3e-4  # that feeds are kept below the caps by: a third of what a limit may be off by
_SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)


class Caps:
    """Caps of cells of the programmed path: of each its block, where it begins and ends (extent), and `speed` m/s.

    `first` (m + 1,) is the first cell of each block, `top` (m,) the speed at which it is driven without caps.
    """

    def __init__(self, motion, demand: Demand):
        self.demand = demand
        path = motion.course.programmed
        size = max(CELL, float(path.extent.sum()) / _MOST)
        self.count = np.maximum(np.ceil(path.extent / size - 1e-9).astype(int), 1)
        self.first = np.concatenate([[0], np.cumsum(self.count)])
        self.block = np.repeat(np.arange(len(path)), self.count)
        part = np.arange(len(self.block)) - self.first[self.block]
        self.size = path.extent / self.count
        self.moving = path.extent[self.block] > 0
        self.begin = part * self.size[self.block]
        self.end = np.where(
            part == self.count[self.block] - 1, path.extent[self.block], (part + 1) * self.size[self.block]
        )
        self.top = self._tops(motion)
        self.speed = self.top[self.block]
        self.ramp = self.speed.copy()
        self._ask(motion)

    @staticmethod
    def _tops(motion) -> np.ndarray:
        """The greatest speed that the controller takes each programmed block at: F, or its own limits.  (m,)."""
        course, feed = motion.course, motion.feed
        every = np.arange(len(course.path))
        tops = np.zeros(len(course.programmed))
        np.maximum.at(tops, course.place(every, course.path.extent / 2).block, feed.speed)
        return tops

    def _ask(self, motion):
        """Equations (1) and (2) at both ends and in the middle of what lies in each cell of the course."""
        path, feed = motion.course.path, motion.feed
        size = max(CELL, float(path.extent.sum()) / _MOST)
        moving = np.flatnonzero(path.extent > 0)
        count = np.maximum(np.ceil(path.extent[moving] / size - 1e-9).astype(int), 1) * 2 + 1
        j = np.repeat(moving, count)
        k = np.arange(len(j)) - np.repeat(np.cumsum(count) - count, count)
        u = path.extent[j] * (k / np.repeat(count - 1, count))
        for part in np.array_split(np.arange(len(j)), len(j) // _ROWS + 1):
            top, a = feed.speed[j[part]], feed.acceleration[j[part]]
            zero = np.zeros(len(part))
            steady, _ = fit(motion, self.demand, j[part], u[part], top, zero)
            up, _ = fit(motion, self.demand, j[part], u[part], steady, a)
            down, _ = fit(motion, self.demand, j[part], u[part], up, -a)
            place = motion.course.place(j[part], u[part])
            slower, harder = steady < top * (1 - 1e-9), down < top * (1 - 1e-9)
            self.lower(place.block[slower], place.u[slower], steady[slower])
            self._least(self.ramp, place.block[harder], place.u[harder], down[harder])

    def lower(self, block, u, speed) -> None:
        """No more than `speed` (n,) at the extents u (n,) of blocks (n,) of the programmed path."""
        self._least(self.speed, block, u, speed)

    def _least(self, caps, block, u, speed):
        moving = self.size[block] > 0
        size = np.where(moving, self.size[block], 1.0)
        for side in (-1e-6, 1e-6):  # a place on the edge of two cells counts for both
            k = self.first[block] + np.clip(np.floor(u / size + side).astype(int), 0, self.count[block] - 1)
            np.minimum.at(caps, k, np.where(moving, speed * (1 - SPARE), np.inf))

    def ramps(self, blocks) -> None:
        """Caps of whole blocks down to the speeds of eq. (2)."""
        cells = np.isin(self.block, blocks)
        self.speed[cells] = np.minimum(self.speed[cells], self.ramp[cells])


def fit(motion, demand: Demand, block, u, ud, udd) -> tuple[np.ndarray, np.ndarray]:
    """The greatest rate of the extent, at most ud (n,), at which the joints keep their limits, and their use at ud."""
    k = demand.pose_count

    def ask(rows, v):
        here = state(motion, block[rows], u[rows], v, udd[rows])
        return demand.uses(here.x, here.xd, here.xdd)[0][:, k:].max(1)

    every = np.arange(len(block))
    use = ask(every, ud)
    out = ud.copy()
    much = np.flatnonzero(use > 1)
    if len(much):
        out[much] *= fitting(lambda v: ask(much, v), ud[much])
    return out, use


def excess(motion, demand: Demand):
    """Where the joints exceed a limit: block, extent, rates of the extent (n,), and the rate at which they do not."""
    whole = stretches(motion)
    parts = []
    for k in range(0, len(whole), _ROWS):
        part = whole.chosen(slice(k, k + _ROWS))
        for share in _SHARES:
            here = rows(motion, part, share)
            uses, _ = demand.uses(here.x, here.xd, here.xdd)
            bad = (uses[:, demand.pose_count :] > 1).any(1)
            parts.append(tuple(column[bad] for column in here[:4]))
    block, u, ud, udd = (np.concatenate(column) for column in zip(*parts, strict=True))
    speed, _ = fit(motion, demand, block, u, ud, udd)
    return block, u, ud, udd, speed
