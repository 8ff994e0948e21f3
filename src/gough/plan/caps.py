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
from .demand import ACCELERATION, SPEED, Demand

CELL = 1e-3  # m or rad
_MOST = 300_000  # cells; with more, cells grow
_ROWS = 4096  # rows asked at once: what is worked on stays in the cache
SPARE = 3e-4  # that feeds are kept below the caps by: a third of what a limit may be off by
_ROUNDING = 1e-9
_SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)


class Caps:
    """Caps of cells of the programmed path: of each its block, where it begins and ends (extent), and `speed` m/s.

    `first` (m + 1,) is the first cell of each block, `top` (m,) the speed at which it is driven without caps.  Blocks
    have caps from when they are asked for on.
    """

    def __init__(self, motion, demand: Demand):
        self.motion, self.demand = motion, demand
        path = motion.course.programmed
        size = max(CELL, float(path.extent.sum()) / _MOST)
        self.count = np.maximum(np.ceil(path.extent / size - 1e-9).astype(int), 1)
        self.first = np.concatenate([[0], np.cumsum(self.count)])
        self.block = np.repeat(np.arange(len(path)), self.count)
        part = np.arange(len(self.block)) - self.first[self.block]
        self.size = path.extent / self.count
        self.moving = path.extent[self.block] > 0
        last = part == self.count[self.block] - 1
        self.end = np.where(last, path.extent[self.block], (part + 1) * self.size[self.block])
        course, every = motion.course, np.arange(len(motion.course.path))
        # a blend belongs to two blocks, and of a short block its two blends may leave nothing between them
        self._owners = [course.place(every, share * course.path.extent).block for share in (0.0, 0.5, 1.0)]
        self.top = self._tops(motion)
        self.speed = self.top[self.block]
        self._asked = np.zeros(len(path), bool)

    def ask(self, blocks) -> None:
        """Caps by eq. (1) for those of `blocks` that have none yet."""
        new = np.setdiff1d(blocks, np.flatnonzero(self._asked))
        self._asked[new] = True
        for j, u in self._nodes(new):
            top = self.motion.feed.speed[j]
            speed, _ = fit(self.motion, self.demand, j, u, top, np.zeros(len(j)))
            self._lower(j, u, speed, top)

    def ramps(self, blocks) -> None:
        """Caps of whole blocks down to the speeds of eq. (2)."""
        for j, u in self._nodes(blocks):
            top, a = self.motion.feed.speed[j], self.motion.feed.acceleration[j]
            up, _ = fit(self.motion, self.demand, j, u, top, a)
            speed, _ = fit(self.motion, self.demand, j, u, up, -a)
            self._lower(j, u, speed, top)

    def _nodes(self, blocks):
        """Places of the course in and beside the programmed `blocks`, a cell's ends and middle; batches of (j, u)."""
        path = self.motion.course.path
        near = np.any([np.isin(owner, blocks) for owner in self._owners], axis=0)
        size = max(CELL, float(path.extent.sum()) / _MOST)
        moving = np.flatnonzero((path.extent > 0) & near)
        count = np.maximum(np.ceil(path.extent[moving] / size - 1e-9).astype(int), 1) * 2 + 1
        j = np.repeat(moving, count)
        k = np.arange(len(j)) - np.repeat(np.cumsum(count) - count, count)
        u = path.extent[j] * (k / np.repeat(count - 1, count))
        for part in np.array_split(np.arange(len(j)), len(j) // _ROWS + 1):
            yield j[part], u[part]

    def _lower(self, j, u, speed, top):
        slower = speed < top * (1 - 1e-9)
        place = self.motion.course.place(j[slower], u[slower])
        self.lower(place.block, place.u, speed[slower])

    def _tops(self, motion) -> np.ndarray:
        """The greatest speed that the controller takes each programmed block at: F, or its own limits.  (m,)."""
        tops = np.zeros(len(motion.course.programmed))
        for owner in self._owners:
            np.maximum.at(tops, owner, motion.feed.speed)
        return tops

    def lower(self, block, u, speed) -> None:
        """No more than `speed` (n,) at the extents u (n,) of blocks (n,) of the programmed path."""
        moving = self.size[block] > 0
        size = np.where(moving, self.size[block], 1.0)
        for side in (-1e-6, 1e-6):  # a place on the edge of two cells counts for both
            k = self.first[block] + np.clip(np.floor(u / size + side).astype(int), 0, self.count[block] - 1)
            np.minimum.at(self.speed, k, np.where(moving, speed * (1 - SPARE), np.inf))


def fit(motion, demand: Demand, block, u, ud, udd) -> tuple[np.ndarray, np.ndarray]:
    """The greatest rate of the extent, at most ud (n,), at which the joints keep their limits, and their use at ud.

    With q' = g V and q'' = g a + g' V^2 (program/joint_limits.py) speed and acceleration give it in closed form; where
    the force then is too much, bisection does.
    """
    k = demand.pose_count

    def ask(rows, v):
        here = state(motion, block[rows], u[rows], v, udd[rows])
        return demand.uses(here.x, here.xd, here.xdd)[0][:, k:].max(1)

    use = ask(np.arange(len(block)), ud)
    out = ud.copy()
    much = np.flatnonzero(use > 1)
    if len(much):
        one = state(motion, block[much], u[much], np.ones(len(much)), np.zeros(len(much)))
        found = demand.values(one.x, one.xd, one.xdd)
        g, h = found[SPEED], found[ACCELERATION]
        v = ud[much]
        with np.errstate(divide="ignore", invalid="ignore"):
            if demand.limits[SPEED] is not None:
                v = np.minimum(v, (demand.limits[SPEED] / np.abs(g)).min(1))
            if demand.limits[ACCELERATION] is not None:
                spare = np.maximum(demand.limits[ACCELERATION] - np.sign(h) * g * udd[much, None], 0.0)
                v = np.minimum(v, np.sqrt(np.where(h == 0, np.inf, spare / np.abs(h)).min(1)))
        out[much] = v = v * (1 - _ROUNDING)
        over = np.flatnonzero(ask(much, v) > 1)
        if len(over):
            out[much[over]] *= fitting(lambda v: ask(much[over], v), v[over])
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
