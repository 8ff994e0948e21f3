"""Where the feed must stop: at corners, at rests, at a new tool, and between rapids and feed moves."""

from __future__ import annotations

import numpy as np

from .path import Path
from .segments import norm

CORNER = np.radians(0.01)  # a change of direction that counts as a corner
_ARM = 0.1  # m up the tool: a turn begins or ends with a corner where a point there would see one


def stops(path: Path, corner: str | None = None) -> np.ndarray:
    """At which inner junctions the feed stops.  (m - 1,) bool.

    `path.tolerance` says what is allowed behind each block: below 0 a stop in any case, 0 a stop at corners, above 0
    the same, and a rapid may run into a feed move.  With corner = "constant" corners and exact stops do not count.
    """
    resting, tool = path.length == 0, path.tool
    stop = resting[:-1] | resting[1:] | (tool[1:] != tool[:-1]).any(1)
    constant = corner == "constant"
    change = path.rapid[:-1] != path.rapid[1:]
    stop |= change if constant else change & ~(path.tolerance[:-1] > 0)
    return stop if constant else stop | (path.tolerance[:-1] < 0) | corners(path)


def corners(path: Path) -> np.ndarray:
    """At which inner junctions the path or the turning of the tool changes its direction.  (m - 1,) bool."""
    every = np.arange(len(path))
    begin, end = np.zeros(len(path)), path.extent
    arrive, leave = path.tangent(every, path.length)[:-1], path.tangent(every, begin)[1:]
    sharp = norm(leave - arrive) > 2 * np.sin(CORNER / 2)
    turn = path.angle_rate(every, begin)[1:] - path.angle_rate(every, end)[:-1]
    return sharp | (norm(turn) * _ARM > CORNER)
