"""The closest point of a curve, many at a time: sampling finds the valley, a safeguarded Newton method its floor.

The answer to one problem does not depend on the others it is asked with, to the last bit.
"""

from __future__ import annotations

import numpy as np

_SPACING = 0.15  # rad between samples: the squared distance to an arc of that angle has one minimum at most
_VALLEYS = 2  # the two deepest valleys of the samples are followed


def closest_parameter(distance, slope, lo, hi):
    """Parameter in [lo, hi] at which `distance` is least.

    `distance(k, u)` gives the squared distance of problem k (n,) at parameters u (n, m); `slope(k, u)` gives half its
    derivative and half its second derivative.  The parameter is an angle or like one: along 0.15 of it the curve
    has no more than one point closest to anything.  lo, hi (n,).  Answers (n,); NaN where the distance is NaN.
    """
    span = np.where(hi - lo > _SPACING, (hi - lo) / _SPACING, 1.0)
    level = np.ceil(np.log2(span)).astype(int)
    out = np.empty(len(lo))
    for each in np.unique(level):  # problems sampled equally often go together
        k = np.flatnonzero(level == each)
        out[k] = _closest(distance, slope, k, lo[k], hi[k], 2 + 2 ** int(each))
    return out


def _closest(distance, slope, k, lo, hi, count):
    row = np.arange(len(k))
    grid = lo[:, None] + (hi - lo)[:, None] * np.linspace(0, 1, count)
    value = distance(k, grid)
    best = np.where(value[:, 0] <= value[:, -1], lo, hi)
    least = np.where(value[:, 0] <= value[:, -1], value[:, 0], value[:, -1])
    padded = np.pad(value, ((0, 0), (1, 1)), constant_values=np.inf)
    valley = (value <= padded[:, :-2]) & (value <= padded[:, 2:])
    depth = np.where(valley, value, np.inf)
    for _ in range(min(_VALLEYS, count)):
        j = np.argmin(depth, 1)
        left = grid[row, np.where(j > 0, j - 1, 0)]
        right = grid[row, np.where(j < count - 1, j + 1, count - 1)]
        u = _floor(slope, k, left, right, grid[row, j])
        found = distance(k, u[:, None])[:, 0]
        better = (found < least) & np.isfinite(depth[row, j])
        best, least = np.where(better, u, best), np.where(better, found, least)
        depth[row, j] = np.inf
    return np.where(np.isnan(value).any(1), np.nan, best)


def _floor(slope, k, left, right, u):
    """Root of `slope` between left and right by Newton's method, by halving wherever a step leaves the bracket."""
    going = np.ones(len(u), bool)
    for _ in range(80):
        g, dg = (a[:, 0] for a in slope(k, u[:, None]))
        left, right = np.where(g < 0, u, left), np.where(g > 0, u, right)
        with np.errstate(divide="ignore", invalid="ignore"):
            step = u - g / dg
        step = np.where((step > left) & (step < right), step, (left + right) / 2)
        step = np.where(g == 0, u, step)
        moved = np.abs(step - u)
        u = np.where(going, step, u)
        going &= moved > 4e-16 * (1 + np.abs(u))  # NaN does not go on
        if not going.any():
            break
    return u
