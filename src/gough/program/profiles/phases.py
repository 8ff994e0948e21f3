"""Phases: motion along a path as pieces of constant jerk, and the cells that it runs through.

A phase begins at the time t_k and is the cubic about its anchor (T, x, v, a)

    x(t) = x + v (t - T) + a (t - T)^2 / 2 + j (t - T)^3 / 6                                                       (1)

The anchor is the start of the phase or its end, so that a stretch ends exactly where and as fast as it should.
x counts from the start of the phase's stretch, a chain of cells; each cell knows where it begins in its stretch.
See docs/theory/feed.md, section 1.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

_ROUNDS = 200  # of a root in a bracket; halving alone needs 60


class Cells(NamedTuple):
    """What the feed runs through: pieces of blocks in order, with what bounds it there.  (n,) each, SI.

    `block` and `u` say where a cell begins, `length` is its extent, 0 for a pause of `pause` s.
    `stop` (n + 1,) says at which ends the feed is at rest; at the first and the last always.
    """

    block: np.ndarray
    u: np.ndarray
    length: np.ndarray
    speed: np.ndarray
    acceleration: np.ndarray
    jerk: np.ndarray
    pause: np.ndarray
    stop: np.ndarray


class Phases(NamedTuple):
    """Phases (p,): `times` (p + 1,) of their ends, anchor and jerk, equation (1)."""

    times: np.ndarray
    T: np.ndarray
    x: np.ndarray
    v: np.ndarray
    a: np.ndarray
    j: np.ndarray

    def find(self, t):
        """In which phase the times t (n,) are; the first before all of them, the last behind."""
        k = np.searchsorted(self.times, t, "right") - 1
        last = len(self.T) - 1
        return np.where(k < 0, 0, np.where(k > last, last, k))

    def at(self, k, t):
        """x, v, a, j of the phases k (n,) at the times t (n,)."""
        d, v, a, j = t - self.T[k], self.v[k], self.a[k], self.j[k]
        x = self.x[k] + d * (v + d * (a / 2 + d * j / 6))
        return x, v + d * (a + d * j / 2), a + d * j, j


class Profile(NamedTuple):
    """Phases, with the times (n + 1,) of the ends of the cells and the x (n,) at which each cell begins."""

    phases: Phases
    times: np.ndarray
    x: np.ndarray


def reached(table: Phases, first, S, stretch, x, ends) -> np.ndarray:
    """The times at which the feed is at x (n,) of the stretches (n,).

    Stretch k, S_k long, has the phases first_k to first_(k+1); they last until `ends` (p,).
    """
    owner = np.repeat(np.arange(len(S)), np.diff(first))
    base = np.concatenate([[0.0], np.cumsum(S)])
    starts = table.times[:-1]
    begins = table.at(np.arange(len(starts)), starts)[0]
    k = np.searchsorted(base[owner] + begins, base[stretch] + x, "right") - 1
    k = np.clip(k, first[stretch], first[stretch + 1] - 1)
    low, high = starts[k], ends[k]
    t, out, todo = (low + high) / 2, np.zeros(len(k)), np.arange(len(k))
    for _ in range(_ROUNDS):
        at, v, _, _ = table.at(k, t)
        low, high = np.where(at < x, t, low), np.where(at < x, high, t)
        with np.errstate(divide="ignore", invalid="ignore"):
            new = t - (at - x) / v
        new = np.where((new > low) & (new < high), new, (low + high) / 2)
        out[todo] = new
        go = np.abs(new - t) > 4e-16 * new
        if not go.any():
            break
        todo, k, t, low, high, x = todo[go], k[go], new[go], low[go], high[go], x[go]
    return out
