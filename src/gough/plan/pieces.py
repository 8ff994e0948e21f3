"""From caps along a path to pieces of its moves, each with one feed: few pieces, little time lost."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .caps import Caps

STEP = 0.02  # between the greatest and the least cap under one feed: staircases lose half of it at most
MOST = 400  # pieces of a move; with more, steps grow
END = 5e-3  # m or rad, of pieces at the ends of a move: a corner's rounding takes a part of a move, and not beyond it
_PER_TOLERANCE = 20  # a corner of 30 degrees rounded by P takes 10 P of both moves
_SAME = 1e-9


class Piece(NamedTuple):
    """A part of a move, up to the extent `end` m or rad, at `feed` m/s or rad/s; None: as fast as a rapid goes."""

    end: float
    feed: float | None


def pieces_of(caps: Caps, path, blocks, tolerance: float) -> dict[int, list[Piece]]:
    """The pieces of those `blocks` of `path` whose feed must change, by block.

    `tolerance` m is that of corners under G64 without P.
    """
    slow = caps.speed < caps.top[caps.block] * (1 - _SAME)
    out = {}
    for i in np.intersect1d(caps.block[slow], blocks).tolist():
        cells = slice(caps.first[i], caps.first[i + 1])
        rounded = path.tolerance[i - 1 : i + 1].max(initial=0.0)  # of the corners at both ends
        ends = max(END, _PER_TOLERANCE * (rounded if np.isfinite(rounded) else tolerance))
        out[i] = _stairs(caps.speed[cells], caps.end[cells], int(np.ceil(ends / caps.size[i])))
    return out


def _stairs(speed, end, ends: int) -> list[Piece]:
    """Pieces under caps `speed` (n,) of cells that end at `end` (n,), first and last of `ends` cells or more."""
    step, n = STEP, len(speed)
    while True:
        starts = _starts(speed, step)
        if len(starts) <= MOST:
            break
        step *= 1.5
    if starts[-1] > n - ends:
        starts = [k for k in starts if k <= n - ends] + [n - ends]
    starts = [0] + [k for k in sorted(set(starts)) if ends <= k]
    last = [*starts[1:], n]
    return [Piece(float(end[b - 1]), float(speed[a:b].min())) for a, b in zip(starts, last, strict=True)]


def _starts(speed, step) -> list[int]:
    """First cells of pieces along which the caps differ by no more than the share `step`."""
    starts, low, high = [0], speed[0], speed[0]
    for k, value in enumerate(speed.tolist()):
        low_, high_ = min(low, value), max(high, value)
        if high_ > low_ * (1 + step):
            starts.append(k)
            low = high = value
        else:
            low, high = low_, high_
    return starts
