"""The trapezoidal profile of a chain of cells, in closed form.

Each cell accelerates at a, runs at the speed v_p <= V and decelerates at a:

    v_p^2 = min(V^2, a L + (v_0^2 + v_1^2) / 2)                                  L the cell's length               (3)
    t_a = (v_p - v_0) / a,   t_d = (v_p - v_1) / a,   t_c = (L - (2 v_p^2 - v_0^2 - v_1^2) / 2a) / v_p             (4)

v_0 and v_1, the speeds at the ends, are the largest that a forward and a backward pass with v_1^2 <= v_0^2 + 2 a L
leave; they are zero at stops and at most the lower V of the two neighbours elsewhere.  docs/theory/feed.md, section 3.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .phases import Cells, Phases, Profile


class Trapezoids(NamedTuple):
    """Of each cell, (n,): the speeds v0 and v1 at its ends and `peak` between, m/s, and how long each part takes, s."""

    v0: np.ndarray
    v1: np.ndarray
    peak: np.ndarray
    t_up: np.ndarray
    t_cruise: np.ndarray
    t_down: np.ndarray


def trapezoids(cells: Cells) -> Trapezoids:
    """Equations (3) and (4) for each cell; a pause is a cruise at rest."""
    ends = _end_speeds(cells)
    v0, v1, a, L = ends[:-1], ends[1:], cells.acceleration, cells.length
    moving = L > 0
    peak = np.minimum(cells.speed, np.sqrt(a * L + (v0**2 + v1**2) / 2))
    t_up, t_down = (peak - v0) / a, (peak - v1) / a
    left = L - (t_up * (v0 + peak) + t_down * (v1 + peak)) / 2
    cruise = np.where(left > 1e-15 * L, left, 0.0)
    t_cruise = np.where(moving, cruise / np.where(moving, peak, 1.0), cells.pause)
    t_up, t_down = (np.where(moving & (t > 0), t, 0.0) for t in (t_up, t_down))
    return Trapezoids(v0, v1, peak, t_up, t_cruise, t_down)


def trapezoid(cells: Cells) -> Profile:
    """The trapezoidal profile: three phases a cell, and each cell a stretch of its own."""
    v0, v1, peak, t_up, t_cruise, t_down = trapezoids(cells)
    lasts = np.stack([t_up, t_cruise, t_down], 1)
    times = np.concatenate([[0.0], np.cumsum(lasts.sum(1))])
    begin, end = times[:-1, None], times[1:, None]
    starts = begin + np.stack([0 * t_up, t_up, t_up + t_cruise], 1)
    zero = np.zeros(len(v0))
    anchor = np.concatenate([begin, starts[:, 1:2], end], 1)  # down: from the end, which is then exact
    x = np.stack([zero, t_up * (v0 + peak) / 2, cells.length], 1)
    v = np.stack([v0, np.where(cells.length > 0, peak, 0.0), v1], 1)
    a = np.stack([cells.acceleration, zero, -cells.acceleration], 1)
    # rounding may put the start of the last phase behind the end of its cell
    starts = np.minimum(starts, end)
    rows = (np.append(starts.ravel(), times[-1]), *(q.ravel() for q in (anchor, x, v, a)), np.zeros(3 * len(v0)))
    return Profile(Phases(*rows), times, zero)


def _end_speeds(cells):
    """The speeds at all ends of cells, (n + 1,)."""
    v = np.zeros(len(cells.length) + 1)
    v[1:-1] = np.where(cells.stop[1:-1], 0.0, np.minimum(cells.speed[:-1], cells.speed[1:]))
    squares, gain = (v * v).tolist(), (2 * cells.acceleration * cells.length).tolist()
    for i in range(len(gain)):
        squares[i + 1] = min(squares[i + 1], squares[i] + gain[i])
    for i in reversed(range(len(gain))):
        squares[i] = min(squares[i], squares[i + 1] + gain[i])
    return np.sqrt(squares)
