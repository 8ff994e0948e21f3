"""From two climbs to phases: up to a peak, on at the peak, down; at most seven phases where no cap bends the climbs.

For a speed V the forward climb is followed to the piece on which its level passes V, and tapered there; the backward
climb likewise.  Their distances r_up(V) and r_down(V) grow with V, so the peak, the largest V with

    r_up(V) + r_down(V) <= S,   V <= top                                                                           (6)

is found by halving, for all stretches at once.  What is left of S is run at V.  docs/theory/feed.md, section 5.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .stretches import Stretches

_ROUNDS = 200


class _Climbs:
    """One climb of each stretch: its pieces are rows `at[:, 0]` to `at[:, 1]` of d, v, a, j; J its jerk."""

    def __init__(self, pieces, at, J):
        self.d, self.v, self.a, self.j = pieces.T
        self.at, self.J = at, J
        owner = np.repeat(np.arange(len(at)), at[:, 1] - at[:, 0])
        self.simple = at[:, 1] - at[:, 0] == 1
        rows = _ranges(at)
        self.level = np.full(len(pieces), np.inf)
        self.level[rows] = self.v[rows] + self.a[rows] ** 2 / (2 * J[owner])

    def piece(self, V, m):
        """The piece on which the level of the climb of the stretches m passes V."""
        low, high = self.at[m, 0].copy(), self.at[m, 1].copy()
        many = np.flatnonzero(high - low > 1)
        while len(many):
            middle = (low[many] + high[many]) // 2
            before = self.level[middle] <= V[many]
            low[many] = np.where(before, middle, low[many])
            high[many] = np.where(before, high[many], middle)
            many = many[high[many] - low[many] > 1]
        return low

    def taper(self, V, m):
        """Tapered at V (k,) in the stretches m (k,): piece k, time t on it, time t2 of the taper, the distance."""
        k = self.piece(V, m)
        d, v, a, j, J = self.d[k], self.v[k], self.a[k], self.j[k], self.J[m]
        rise = V - v
        z = np.where(j > 0, np.sqrt(np.maximum(a * a / 2 + J * rise, a * a)), a)
        hold = j == 0
        t = np.where(
            hold, np.maximum((rise - a * a / (2 * J)) / np.where(hold, a, 1.0), 0.0), np.where(j > 0, (z - a) / J, 0.0)
        )
        v1 = v + t * (a + z) / 2
        t2 = z / J
        return k, t, t2, d + t * (v + t * (a / 3 + z / 6)) + t2 * (v1 + z * t2 / 3)


class Row(NamedTuple):
    """Phases in order, (p,): how long each lasts, its anchor and jerk, and whether the anchor is its end."""

    lasts: np.ndarray
    x: np.ndarray
    v: np.ndarray
    a: np.ndarray
    j: np.ndarray
    ends: np.ndarray


def phases(found: Stretches, J, A) -> tuple[Row, np.ndarray]:
    """The phases of all stretches, and which of them each stretch begins with, (m + 1,).

    `J` (m,) is the jerk of each stretch, `A` (m,) no less than any acceleration in it.
    """
    ups, downs = _Climbs(found.ups, found.up, J), _Climbs(found.downs, found.down, J)
    V = _peaks(found, ups, downs, A)
    every, S = np.arange(len(V)), found.length
    ku, tu, tu2, ru = ups.taper(V, every)
    kd, td, td2, rd = downs.taper(V, every)
    left = S - ru - rd
    cruise = np.where(left > 0, left, 0.0) / np.where(V > 0, V, 1.0)
    # of each stretch: whole pieces of the way up, the last one and its taper, the cruise, and the same downwards
    whole_up, whole_down = ku - found.up[:, 0], kd - found.down[:, 0]
    first = np.concatenate([[0], np.cumsum(whole_up + whole_down + 5)])
    n = first[-1]
    row = Row(*(np.zeros(n) for _ in range(5)), np.zeros(n, bool))

    def put(at, *values, ends=False):
        for column, value in zip(row, (*values, ends), strict=True):
            column[at] = value

    rows = _ranges(np.stack([found.up[:, 0], ku], 1))
    at = np.repeat(first[:-1], whole_up) + _counts(whole_up)
    put(at, _time(ups, rows), ups.d[rows], ups.v[rows], ups.a[rows], ups.j[rows])
    at = first[:-1] + whole_up
    put(at, tu, ups.d[ku], ups.v[ku], ups.a[ku], ups.j[ku])
    put(at + 1, tu2, ru, V, 0.0, -J, ends=True)
    put(at + 2, cruise, ru, V, 0.0, 0.0)
    put(at + 3, td2, S - rd, V, 0.0, -J)
    put(at + 4, td, S - downs.d[kd], downs.v[kd], -downs.a[kd], downs.j[kd], ends=True)
    rows = _ranges(np.stack([found.down[:, 0], kd], 1))
    at = np.repeat(first[1:] - 1, whole_down) - _counts(whole_down)
    owner = np.repeat(every, whole_down)
    put(at, _time(downs, rows), S[owner] - downs.d[rows], downs.v[rows], -downs.a[rows], downs.j[rows], ends=True)
    some = row.lasts > 0
    return Row(*(column[some] for column in row)), np.concatenate([[0], np.cumsum(some)])[first]


def _time(climbs, rows):
    """How long whole pieces last: until the next one begins."""
    a, j = climbs.a[rows], climbs.j[rows]
    hold = j == 0
    t = np.where(hold, climbs.v[rows + 1] - climbs.v[rows], climbs.a[rows + 1] - a) / np.where(hold, a, j)
    return np.maximum(t, 0.0)


def _ranges(ends):
    """All the numbers from ends[i, 0] to ends[i, 1] - 1, one range behind the other."""
    count = ends[:, 1] - ends[:, 0]
    return np.repeat(ends[:, 0], count) + _counts(count)


def _counts(count):
    """0 ... count[0] - 1, 0 ... count[1] - 1, ..."""
    return np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)


def _peaks(found, ups, downs, A):
    """The largest V of equation (6), (m,)."""
    S = found.length
    low = np.maximum(found.first, found.last)
    # no climb gains more than 2 A S on the square of its speed
    high = np.minimum(found.top, np.sqrt(low * low + 2 * A * S))
    every = np.arange(len(S))

    def spare(V, m):
        return S[m] - ups.taper(V, m)[3] - downs.taper(V, m)[3]

    fits = spare(high, every) >= 0
    low = np.where(fits, high, low)
    m = np.flatnonzero(low < high)
    a, b = low[m], high[m]
    for _ in range(_ROUNDS):
        V = (a + b) / 2
        go = (a < V) & (b > V)
        if not go.any():
            break
        m_, V_ = m, V
        ok = spare(V_, m_) >= 0
        a, b = np.where(ok, V, a), np.where(ok, b, V)
        low[m] = a
        if not go.all():
            m, a, b = m[go], a[go], b[go]
    return low
