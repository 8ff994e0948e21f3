"""The motion of a program as smooth stretches: between two of their ends nothing jumps, acceleration included.

A stretch is the part of a phase of the feed (program/profiles/phases.py) that lies in one cell of the course.  Rows are
asked for at times within a stretch, its ends too, and belong to that stretch alone: at an end that two stretches share,
where the acceleration jumps, each answers with its own side.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..errors import ProgramError
from ..program.blocks import REST
from ..program.tool_motion import tool_motion

LONGEST = 25e-3  # m or rad / 8: of a stretch looked at as one
_TURN = 0.4  # rad, of the direction of the path along it
_PER_RADIAN = 8.0  # a turn of the tool by 1/8 rad carries joints 0.2 m away by 25 mm
_INSTANT = 1e-9  # s: a shorter stretch is the rounding of two ends that are one


class Stretches(NamedTuple):
    """m stretches: phase and cell of the feed, and times s on the feed from `t0` to `t1`.  (m,) each."""

    phase: np.ndarray
    cell: np.ndarray
    t0: np.ndarray
    t1: np.ndarray

    def __len__(self) -> int:
        return len(self.t0)

    def chosen(self, k) -> Stretches:
        """The stretches k alone."""
        return Stretches(*(column[k] for column in self))

    def split(self, parts: int) -> Stretches:
        """Each cut into `parts` of equal time."""
        edge = np.linspace(0, 1, parts + 1)
        t0, span = np.repeat(self.t0, parts), np.repeat(self.t1 - self.t0, parts)
        low, high = np.tile(edge[:-1], len(self)), np.tile(edge[1:], len(self))
        return Stretches(np.repeat(self.phase, parts), np.repeat(self.cell, parts), t0 + low * span, t0 + high * span)


class State(NamedTuple):
    """Rows of a motion: block of the course, extent in it, its rates, and the task coordinates with theirs."""

    block: np.ndarray
    u: np.ndarray
    ud: np.ndarray
    udd: np.ndarray
    x: np.ndarray
    xd: np.ndarray
    xdd: np.ndarray


def stretches(motion) -> Stretches:
    """All stretches of a motion, none longer than `LONGEST`, nor bent by more than a fraction of a radian.

    Raises
    ------
    ProgramError
        a motion that is given over time has no feed along a path.
    """
    feed = getattr(motion, "feed", None)
    if feed is None:
        raise ProgramError(
            "has no path with a feed along it", cure="give an NC program, or a kind that is cut along a path"
        )
    events = np.unique(np.concatenate([feed.profile.phases.times, feed.profile.times]))
    events = events[(events >= 0) & (events <= feed.duration)]
    keep = np.diff(events) > _INSTANT
    t0, t1 = events[:-1][keep], events[1:][keep]
    middle = (t0 + t1) / 2
    found = Stretches(feed.profile.phases.find(middle), feed.cell(middle), t0, t1)
    return _cut(motion, found)


def _cut(motion, found: Stretches) -> Stretches:
    feed, path = motion.feed, motion.course.path
    first, last = (_extent(feed, found, t) for t in (found.t0, found.t1))
    block = feed.cells.block[found.cell]
    way = last - first
    turning = path.turning()[0][block]  # rad per unit of extent
    bent = np.where(path.kind[block] == REST, 0.0, path.sharpest()[block])
    straight = np.where(path.kind[block] == REST, 0.0, way)
    most = np.maximum(np.maximum(straight, way * turning / _PER_RADIAN) / LONGEST, way * bent / _TURN)
    parts = np.maximum(np.ceil(most - 1e-9).astype(int), 1)
    owner = np.repeat(np.arange(len(parts)), parts)
    part = np.arange(len(owner)) - np.repeat(np.cumsum(parts) - parts, parts)
    step = (found.t1 - found.t0)[owner] / parts[owner]
    t0 = found.t0[owner] + part * step
    t1 = np.where(part == parts[owner] - 1, found.t1[owner], t0 + step)
    return Stretches(found.phase[owner], found.cell[owner], t0, t1)


def _extent(feed, found, t):
    profile, cells = feed.profile, feed.cells
    x = profile.phases.at(found.phase, t)[0] - profile.x[found.cell]
    length = cells.length[found.cell]
    return cells.u[found.cell] + np.minimum(np.maximum(x, 0.0), length)


def rows(motion, found: Stretches, share) -> State:
    """The motion at `share` (m,), 0 to 1, of the time of each stretch."""
    feed = motion.feed
    t = found.t0 + share * (found.t1 - found.t0)
    _, v, a, _ = feed.profile.phases.at(found.phase, t)
    still = feed.cells.length[found.cell] == 0
    ud, udd = np.where(still, 0.0, np.maximum(v, 0.0)), np.where(still, 0.0, a)
    return state(motion, feed.cells.block[found.cell], _extent(feed, found, t), ud, udd)


def state(motion, block, u, ud, udd) -> State:
    """The motion at the extents u (n,) of blocks (n,) of the course, with rates of the extent."""
    told = tool_motion(motion.course.path, block, u, ud, udd)
    return State(block, u, ud, udd, *motion.machine.rigid.task_motion(told.x, told.xd, told.xdd))
