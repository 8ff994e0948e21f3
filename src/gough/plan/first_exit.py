"""How far along a way everything stays >= 0: the first exit, though a limit may be left and entered again.

A way is sampled at equal steps from its start.  A sample k inside whose neighbours are not lower is a place where a
limit may dip below 0 between samples.  With the second difference D = m[k-1] - 2 m[k] + m[k+1], a parabola through the
three has its least value at or above m[k] - D / 8; where

    m[k] - D / 4 < 0                                                                                                (7)

the two steps around k are sampled 64 times as densely, and so on, three times.  So an excursion is overlooked only if
the limit's curvature more than doubles within one step and the excursion is over within it: with steps of 0.5 mm and
0.05 deg and legs of decimetres, one that ends sooner than about a thousandth of a leg.  Between the last sample inside
and the first outside bisection finds the edge to rounding.  docs/theory/maps.md, section 5.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

_BLOCK = 256  # samples of a way at a time
_FINER = 64
_DEEPEST = 3
_PARTS = 16  # a bracket is cut into at a time
_CUTS = 16

# (number of the way (N,), distance (N,)) -> margins (N, k)
Margins = Callable[[np.ndarray, np.ndarray], np.ndarray]


def first_exits(margins: Margins, ways: int, step: float, longest: float) -> tuple[np.ndarray, np.ndarray]:
    """Distance (ways,) at which each way leaves, and the margins just behind (ways, k); inf and NaN where none does.

    Every way must be inside at distance 0.  Distances are not looked for beyond `longest`.
    """
    inner, outer = np.full(ways, np.inf), np.full(ways, np.inf)
    open_ways, start = np.arange(ways), 0
    last = int(np.ceil(longest / step))
    while len(open_ways) and start <= last:
        numbers = np.arange(start - 1, min(start + _BLOCK, last) + 2)  # one more on both sides, for (7)
        s = np.maximum(numbers, 0) * step
        m = _at(margins, open_ways, s)
        found = [_bracket(margins, way, s, rows) for way, rows in zip(open_ways, m, strict=True)]
        for way, bracket in zip(open_ways, found, strict=True):
            if bracket is not None:
                inner[way], outer[way] = bracket
        open_ways = open_ways[[bracket is None for bracket in found]]
        start += _BLOCK
    return _bisected(margins, inner, outer)


def _at(margins: Margins, ways, s) -> np.ndarray:
    """Margins of all `ways` at all distances s.  (len(ways), len(s), k)."""
    flat = margins(np.repeat(ways, len(s)), np.tile(s, len(ways)))
    return flat.reshape(len(ways), len(s), -1)


def _bracket(margins: Margins, way: int, s, m, depth: int = 0) -> tuple[float, float] | None:
    """The first pair of distances, inside and outside, among samples s of one way with margins m (len(s), k)."""
    outside = ~(m >= 0).all(-1)
    end = int(outside.argmax()) if outside.any() else len(s)
    for k in possible_dips(m[: end + 1]) if depth < _DEEPEST else ():
        finer = np.linspace(s[k - 1], s[k + 1], 2 * _FINER + 1)
        found = _bracket(margins, way, finer, _at(margins, np.array([way]), finer)[0], depth + 1)
        if found is not None:
            return found
    return (float(s[end - 1]), float(s[end])) if 0 < end < len(s) else None


def possible_dips(m) -> np.ndarray:
    """Samples k of margins (n, k) around which eq. (7) holds, in their order."""
    if len(m) < 3:
        return np.zeros(0, int)
    before, here, behind = m[:-2], m[1:-1], m[2:]
    with np.errstate(invalid="ignore"):
        low = (here >= 0) & (here <= before) & (here <= behind)
        low &= here - (before - 2 * here + behind) / 4 < 0
    return 1 + np.flatnonzero(low.any(-1))


def _bisected(margins: Margins, inner, outer) -> tuple[np.ndarray, np.ndarray | None]:
    """The edges between `inner` and `outer`, cut until nothing is left to cut, and the margins behind them."""
    some = np.flatnonzero(np.isfinite(inner))
    if not len(some):
        return inner, None
    low, high, part = inner[some], outer[some], np.arange(1, _PARTS) / _PARTS
    rows = np.arange(len(some))
    for _ in range(_CUTS):
        cuts = low[:, None] + part * (high - low)[:, None]
        cuts = np.concatenate([low[:, None], cuts, high[:, None]], 1)
        m = margins(np.repeat(some, _PARTS - 1), cuts[:, 1:-1].ravel())
        outside = np.ones((len(some), _PARTS), bool)
        outside[:, :-1] = ~(m >= 0).all(-1).reshape(len(some), -1)
        first = outside.argmax(1)
        narrower = cuts[rows, first], cuts[rows, first + 1]
        if (narrower[0] == low).all() and (narrower[1] == high).all():
            break
        low, high = narrower
    found = margins(some, high)
    behind = np.full((len(inner), found.shape[1]), np.nan)
    inner, behind[some] = inner.copy(), found
    inner[some] = low
    return inner, behind
