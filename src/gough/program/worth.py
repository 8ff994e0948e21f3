"""Which corners are passed sooner round a blend than with a stop.

Each corner is planned by itself, by the feed's own profile, from rest at the far end of the block before it to rest at
the far end of the block behind: once round its blend, once with a stop at the corner.  A tight blend must be slow
along its whole length, and a stop takes no length at all: under a low jerk the stop is often the sooner.
"""

from __future__ import annotations

import numpy as np

from .assemble import pieces_of
from .blend import Blends
from .limits import Limits
from .profiles.jerk_limited import jerk_limited
from .profiles.phases import Cells
from .profiles.trapezoid import trapezoid

SHALLOW = np.radians(20)  # rad: a corner that turns less is never worth a stop


def worth(base, blends: Blends, limits: Limits) -> np.ndarray:
    """Whether each blend of the path `base` saves time.  (n,) bool."""
    out = np.ones(len(blends.after), bool)
    k = np.flatnonzero(blends.turn > SHALLOW)
    if len(k):
        blends = blends.chosen(k)
        out[k] = _round(base, blends, limits) < _stopping(base, blends, limits)
    return out


def _round(base, blends, limits):
    """Duration of each corner by its blend.  (n,) s."""
    i, n = blends.after, len(blends.after)
    pieces = pieces_of(blends)
    with np.errstate(divide="ignore"):
        cap = np.sqrt(limits.acceleration / pieces.curves.sharpest())
        if limits.jerk is not None:
            cap = np.minimum(cap, np.cbrt(limits.jerk / pieces.curves.third()))
    speed = np.where(base.rapid, limits.rapid, base.feed)
    cap = np.minimum(cap, np.minimum(speed[i], speed[i + 1])[pieces.blend])
    # block, pieces, block: in the order of the corners
    corner = np.concatenate([np.arange(n), pieces.blend, np.arange(n)])
    order = np.argsort(corner, kind="stable")
    length = np.concatenate(
        [base.length[i] - blends.back, pieces.end - pieces.begin, base.length[i + 1] - blends.ahead]
    )
    top = np.concatenate([speed[i], cap, speed[i + 1]])
    return _durations(corner[order], length[order], top[order], limits)


def _stopping(base, blends, limits):
    """Duration of each corner with a stop.  (n,) s."""
    both = np.stack([blends.after, blends.after + 1], 1).ravel()
    speed = np.where(base.rapid, limits.rapid, base.feed)
    times = _durations(np.arange(len(both)), base.length[both], speed[both], limits)
    return times[::2] + times[1::2]


def _durations(group, length, speed, limits):
    """Durations of groups of cells that follow each other, each group from rest to rest.  (groups,) s."""
    m, first = len(group), np.append(True, group[1:] != group[:-1])
    a, zero = np.full(m, limits.acceleration), np.zeros(m)
    jerk = np.full(m, np.inf if limits.jerk is None else limits.jerk)
    cells = Cells(np.arange(m), zero, np.maximum(length, 0.0), speed, a, jerk, zero, np.append(first, True))
    times = (trapezoid if limits.jerk is None else jerk_limited)(cells).times
    return np.diff(times[np.append(first, True)])
