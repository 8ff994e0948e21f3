"""The closest point of a curve, many at a time: sampling finds the valley, a safeguarded Newton method its floor."""

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
    n = len(lo)
    count = 2 + int(np.ceil(np.max(hi - lo, initial=0.0) / _SPACING))
    k = np.arange(n)
    grid = lo[:, None] + (hi - lo)[:, None] * np.linspace(0, 1, count)
    value = distance(k, grid)
    best = np.where(value[:, 0] <= value[:, -1], lo, hi)
    least = np.where(value[:, 0] <= value[:, -1], value[:, 0], value[:, -1])
    padded = np.pad(value, ((0, 0), (1, 1)), constant_values=np.inf)
    valley = (value <= padded[:, :-2]) & (value <= padded[:, 2:])
    depth = np.where(valley, value, np.inf)
    for _ in range(min(_VALLEYS, count)):
        j = np.argmin(depth, 1)
        left = grid[k, np.where(j > 0, j - 1, 0)]
        right = grid[k, np.where(j < count - 1, j + 1, count - 1)]
        u = _floor(slope, k, left, right, grid[k, j])
        found = distance(k, u[:, None])[:, 0]
        better = (found < least) & np.isfinite(depth[k, j])
        best, least = np.where(better, u, best), np.where(better, found, least)
        depth[k, j] = np.inf
    return np.where(np.isnan(value).any(1), np.nan, best)


def _floor(slope, k, left, right, u):
    """Root of `slope` between left and right by Newton's method, by halving wherever a step leaves the bracket."""
    for _ in range(80):
        g, dg = (a[:, 0] for a in slope(k, u[:, None]))
        left, right = np.where(g < 0, u, left), np.where(g > 0, u, right)
        with np.errstate(divide="ignore", invalid="ignore"):
            step = u - g / dg
        step = np.where((step > left) & (step < right), step, (left + right) / 2)
        step = np.where(g == 0, u, step)
        moved = np.abs(step - u)
        u = step
        if not (moved > 4e-16 * (1 + np.abs(u))).any():  # NaN does not go on either
            break
    return u
