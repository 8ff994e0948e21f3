"""Where on the programmed path a recorded motion is, row by row: it only ever goes forward.

The planner rounds corners, so its tip is beside the path.  From row to row the place s moves on by what the tip has
travelled since the last place that is known, and then to the closest point of the path within a window of 5 mm and
what 0.1 s of feed run.  A turn at rest has one place and a range of angles: rows of its line, where the tip rests, are
on it by the angle that is closest.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import NamedTuple

import numpy as np

from ..measure.contour import ContourMeter
from ..program.reference import WINDOW_LENGTH, WINDOW_TIME
from ..program.segments import norm

_ROWS = 64  # found together; the tip leaves the path by little in that time, so the next guess is good
_RESTING = 1e-6  # m of path: a turn at rest stands there


class Places(NamedTuple):
    """Places on a path, (n,) each: block, extent in it (m or rad), path length m."""

    block: np.ndarray
    u: np.ndarray
    s: np.ndarray


def follow(path, tip, abc, speed, line) -> Places:
    """Places of tips (n, 3) m in W with angles abc (n, 3) rad of the program, speed (n,) m/s and NC line (n,)."""
    meter = ContourMeter(SimpleNamespace(path=path))
    travelled = np.concatenate([[0.0], np.cumsum(norm(np.diff(tip, axis=0)))])
    n, end = len(tip), float(path.s0[-1])
    block, s = np.zeros(n, int), np.zeros(n)
    at, known = 0.0, 0.0
    for k in range(0, n, _ROWS):
        part = slice(k, min(k + _ROWS, n))
        guess = np.minimum(at + travelled[part] - known, end)
        window = WINDOW_LENGTH + WINDOW_TIME * speed[part]
        i, _ = path.locate(guess)
        guess = np.minimum(guess, path.s0[i + 1])
        _, i, found = meter.closest(tip[part], guess, window, i)
        found = np.maximum.accumulate(np.maximum(found, at))
        # a place that was held back belongs to the block that is there
        held = (found < path.s0[i]) | (found > path.s0[i + 1])
        i = np.where(held, path.locate(found)[0], i)
        block[part], s[part] = i, found
        at, known = float(found[-1]), float(travelled[part][-1])
    u = np.clip(s - path.s0[block], 0.0, path.length[block])
    for b in np.flatnonzero(path.turning_at_rest):
        change = path.turn[b] * path.extent[b]
        rows = np.flatnonzero((line == path.line[b]) & (np.abs(s - path.s0[b]) <= _RESTING))
        share = (abc[rows] - path.abc0[b]) @ change / (change @ change)
        block[rows], u[rows] = b, path.extent[b] * np.clip(share, 0.0, 1.0)
    return Places(block, u, s)
