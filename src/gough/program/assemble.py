"""A course out of a path and its blends: what is left of the blocks, and the blends between them, in order.

A block has one greatest speed.  A blend that turns far is cut into pieces, so that only its sharpest part is run as
slowly as that asks: with one piece a right angle would take longer than with a stop.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .blend import Blends
from .blocks import CURVE, REST
from .curves import Curves, restricted
from .cut import cut
from .path import Path

_LEFT = 1e-9  # m, of a block between two blends: less is rounding, the blends meet
# by the turn, rad; with half as many a corner within 0.5 mm at 0.3 m/s takes 1 % more than it must, on 0.2 m of path
_PIECES = ((np.radians(5), 1), (np.radians(20), 8), (np.radians(45), 16), (np.inf, 32))
# of all blends of a path together: where there are more each is cut into at most so many.  200 000 are some 150 MB; two
# of a blend would be no gain, both would have its sharpest point
_ROOM = ((50_000, 16), (100_000, 8), (200_000, 4), (200_000, 1))


class Stretches(NamedTuple):
    """What each block of a course belongs to: blocks of the programmed path before and behind the knot, the path
    lengths at its start, knot and end, m, and the length to the knot, m.  (m,) each."""

    first: np.ndarray
    second: np.ndarray
    start: np.ndarray
    knot: np.ndarray
    end: np.ndarray
    to_knot: np.ndarray


class Pieces(NamedTuple):
    """Pieces of blends, in order: number of the blend, curves, angles, and the lengths along the blend at the ends."""

    blend: np.ndarray
    curves: Curves
    angles: np.ndarray
    begin: np.ndarray
    end: np.ndarray


def assembled(base, sharp, tolerance, blends: Blends, rapid: float = np.inf) -> tuple[Path, Stretches]:
    """The path `base` with the blends put in, and what belongs to what on `sharp`, which has the same blocks.

    No blend beside a rapid is faster than `rapid`, m/s.
    """
    m, pieces = len(base), pieces_of(blends)
    i = blends.after[pieces.blend]
    lo, hi = np.zeros(m), base.length.copy()
    lo[blends.after + 1], hi[blends.after] = blends.ahead, base.length[blends.after] - blends.back
    kept = np.flatnonzero((base.kind == REST) | (hi - lo > _LEFT))
    lo, hi = lo[kept], hi[kept]
    # in the order of the course: block i before the blend behind it
    order = np.argsort(np.concatenate([2 * kept, 2 * i + 1]), kind="stable")
    batches, index = cut(base, kept, lo, hi)
    old = len(batches[CURVE].length)
    batches[CURVE] = Curves.joined([batches[CURVE], pieces.curves])
    moving = base.kind[kept] != REST
    u0, u1 = np.where(moving, lo, 0.0), np.where(moving, hi, base.extent[kept])
    whole = pieces.angles.sum(1)
    last = np.append(pieces.blend[1:] != pieces.blend[:-1], True)[: len(i)]
    whole[last] = base.angles(i[last] + 1, blends.ahead)
    parts = {
        "kind": (base.kind[kept], np.full(len(i), CURVE, np.int8)),
        "index": (index, old + np.arange(len(i))),
        "abc0": (base.angles(kept, u0), pieces.angles[:, 0]),
        "abc1": (base.angles(kept, u1), whole),
        "feed": (base.feed[kept], _slower(base, i, rapid)),
        "rapid": (base.rapid[kept], base.rapid[i] & base.rapid[i + 1]),
        "dwell": (base.dwell[kept], np.zeros(len(i))),
        "tolerance": (tolerance[kept], tolerance[i]),
    } | {name: (getattr(base, name)[kept], getattr(base, name)[i]) for name in ("tool", "spindle", "line")}
    columns = {name: np.concatenate(pair)[order] for name, pair in parts.items()}
    place = np.empty(len(order), np.int64)
    place[order] = np.arange(len(order))
    path = Path.of(columns, batches, _bent(base, kept, lo, hi, pieces, place), base)
    return path, _stretches(base, sharp, kept, lo, hi, blends, pieces, order)


def pieces_of(blends: Blends) -> Pieces:
    """The blends, cut into the pieces that have a speed of their own."""
    bounds, numbers = zip(*_PIECES, strict=True)
    count = np.array(numbers)[np.searchsorted(bounds, blends.turn)]
    for room, most in _ROOM:
        if count.sum() > room:
            count = np.minimum(count, most)
    n = np.repeat(np.arange(len(count)), count)
    share = count[n].astype(float)
    k = np.arange(len(n)) - np.repeat(np.cumsum(count) - count, count)
    t0, t1 = k / share, (k + 1) / share
    several = np.flatnonzero(share > 1)
    single = np.flatnonzero(share == 1)
    both = [blends.curves.chosen(n[single]), Curves(restricted(blends.curves.c[n[several]], t0[several], t1[several]))]
    place = np.empty(len(n), np.int64)
    place[np.concatenate([single, several])] = np.arange(len(n))
    begin, end = (blends.curves.arc_length(n, t) for t in (t0, t1))
    length = blends.curves.length[n]
    angles = restricted(blends.angles[n], begin / length, np.where(t1 == 1, 1.0, end / length))
    return Pieces(n, Curves.joined(both).chosen(place), angles, begin, end)


def _slower(base, i, rapid):
    """The lower of the feeds on both sides, where that of a rapid is `rapid`; 0 between two rapids, which need none."""
    a, b = (np.where(base.rapid[k], rapid, base.feed[k]) for k in (i, i + 1))
    return np.where(base.rapid[i] & base.rapid[i + 1], 0.0, np.minimum(a, b))


def _bent(base, kept, lo, hi, pieces, place):
    """Angles that are polynomials: of blends that turn, and of what is left of such blocks."""
    turning = np.flatnonzero(pieces.angles[:, 1:].any((1, 2)))
    rows, angles = [place[len(kept) + turning]], [pieces.angles[turning]]
    if base.turns is not None:
        old = np.flatnonzero(base.bent[kept] >= 0)
        i = kept[old]
        rows.append(place[old])
        part = restricted(base.turns.k[base.bent[i]], lo[old] / base.length[i], hi[old] / base.length[i])
        angles.append(part)
    return np.concatenate(rows), np.concatenate(angles)


def _stretches(base, sharp, kept, lo, hi, blends, pieces, order):
    """Lengths along the sharp path, in proportion to those along the base's blocks and, for blends, their halves."""

    def along(i, u):
        share = np.where(base.length[i] > 0, u / np.where(base.length[i] > 0, base.length[i], 1.0), 0.0)
        return sharp.s0[i] + sharp.length[i] * share

    n, i = pieces.blend, blends.after[pieces.blend]
    table = blends.curves.table[n]
    knot, length = table[:, table.shape[1] // 2], table[:, -1]
    begin, corner, finish = along(i, base.length[i] - blends.back[n]), sharp.s0[i + 1], along(i + 1, blends.ahead[n])

    def across(u):
        before = begin + (corner - begin) * (u / knot)
        behind = corner + (finish - corner) * ((u - knot) / (length - knot))
        return np.where(u == knot, corner, np.where(u < knot, before, np.where(u < length, behind, finish)))

    through = (pieces.begin < knot) & (knot < pieces.end)  # the corner lies inside this piece
    end, stop = along(kept, hi), across(pieces.end)
    first = np.where(pieces.begin < knot, i, i + 1)
    own = pieces.end - pieces.begin
    parts = [
        (kept, first),
        (kept, np.where(through, i + 1, first)),
        (along(kept, lo), across(pieces.begin)),
        (end, np.where(through, corner, stop)),
        (end, stop),
        (np.where(hi > lo, hi - lo, 1.0), np.where(through, knot, own)),
    ]
    return Stretches(*(np.concatenate(pair)[order] for pair in parts))
