"""Contour error by brute force: one sample at a time, a dense search along the path, refined by SciPy.

Written from CONTRACT.md 3 alone.  It shares with gough only the evaluation of points on the path, which the tests of
the segments check by themselves.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize_scalar


def point_at(path, s):
    """Position at the path length s."""
    i = int(np.searchsorted(path.s0, s, "right")) - 1
    i = min(max(i, 0), len(path) - 1)
    while path.length[i] == 0 and i > 0:
        i -= 1
    return path.point(np.array([i]), np.array([min(s - path.s0[i], path.length[i])]))[0]


def closest(path, p, s_r, window, spacing=2e-4):
    """Distance from p to the path within `window` of s_r, and the path length of the closest point."""
    lo, hi = max(0.0, s_r - window), min(path.s0[-1], s_r + window)
    # junctions belong to the grid: the closest point may be a corner
    inside = path.s0[(path.s0 > lo) & (path.s0 < hi)]
    grid = np.unique(np.concatenate([np.linspace(lo, hi, 3 + int((hi - lo) / spacing)), inside]))
    distance = np.array([np.linalg.norm(p - point_at(path, s)) for s in grid])
    best = int(np.argmin(distance))
    least, at = distance[best], grid[best]
    # every stretch beside a low sample is searched; the distance has one minimum in so short a stretch
    for j in range(len(grid) - 1):
        if min(distance[j], distance[j + 1]) > least + spacing:
            continue
        found = minimize_scalar(
            # counted from grid[j]: SciPy stops at 1.5e-8 of its argument
            lambda u, j=j: float(np.sum((p - point_at(path, grid[j] + u)) ** 2)),
            bounds=(0.0, grid[j + 1] - grid[j]),
            method="bounded",
            options={"xatol": 1e-13},
        )
        value = float(np.linalg.norm(p - point_at(path, grid[j] + found.x)))
        if value < least:
            least, at = value, float(grid[j] + found.x)
    return least, at


def angle_between(a, b):
    """Angle between two directions, rad, by the chord: accurate for small angles, without a cross product."""
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    return 2 * np.arcsin(min(1.0, np.linalg.norm(a - b) / 2))
