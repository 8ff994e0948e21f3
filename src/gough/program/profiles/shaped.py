"""Profiles shaped between their rests: each run is the mean of itself at the shaper's times.

With x(t) the way of a run, from one rest to the next, and the impulses A_i, t_i of program/shaper.py,

    X(t) = sum of A_i x(t - t_i)                                                                                   (11)

again has phases of constant jerk; it ends t_n later, as exactly at rest.  The path is not touched.  Speed, acceleration
and jerk of X at a place s are means of those of x at other places of the same run, none farther from s than what x
travels in t_n.  So X keeps the limits L(s) of the cells where x keeps

    L~(s) = least L of the cells that come within t_n V of s, V the speed of such a cell                           (12)

Where all cells of a run have the same limits, L~ = L.  docs/theory/feed.md, section 8.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .phases import Cells, Phases, Profile, reached

_GRID = 10**9  # places of a run at which the limits may change


def shaped(make: Callable[[Cells], Profile], cells: Cells, shaper) -> Profile:
    """The profile that `make` gives, shaped; of `cells`, within their limits."""
    moving = np.flatnonzero(cells.length > 0)
    stops = np.cumsum(cells.stop)
    first = moving[np.concatenate([[True], stops[moving[1:]] > stops[moving[:-1]]])] if len(moving) else moving
    last = np.append(moving[np.searchsorted(moving, first)[1:] - 1], moving[-1:])
    widened, runs = _widened(cells, first, last, shaper.delay)
    plain = make(widened)
    if not len(first):
        return plain
    S = np.concatenate([[0.0], np.cumsum(cells.length)])
    begin, end = plain.times[runs[0]], plain.times[runs[1] + 1]
    late = shaper.delay * np.arange(len(first))
    length = S[last + 1] - S[first]
    table, run = _mean(_by_run(plain, widened, begin, end, runs[0]), shaper, begin, end, late, length)
    # where each cell begins in its run, and when
    owner = np.clip(np.searchsorted(first, np.arange(len(S) - 1), "right") - 1, 0, None)
    x = np.where(cells.length > 0, S[:-1] - S[first[owner]], 0.0)
    times = np.zeros(len(S))
    inner = moving[~np.isin(moving, first)]
    times[first] = begin + late
    ended = end + late + shaper.delay
    rows = np.searchsorted(run, np.arange(len(first) + 1))
    ends = table.times[1:].copy()
    ends[rows[1:] - 1] = ended
    if len(inner):
        times[inner] = reached(table, rows, length, owner[inner], x[inner], ends)
    _pauses(times, cells, last, ended)
    return Profile(table, np.maximum.accumulate(times), x)


def _pauses(times, cells, last, ended):
    """Times at which cells without length begin, and of the end: each as long behind the run before as unshaped."""
    still = np.append(np.flatnonzero(cells.length == 0), len(cells.length))
    waits = np.concatenate([[0.0], np.cumsum(np.where(cells.length > 0, 0.0, cells.pause))])
    before = np.searchsorted(last, still) - 1  # the run behind which a pause lies, -1: none
    opening = np.where(before < 0, 0.0, ended[before] - waits[np.where(before < 0, 0, last[before] + 1)])
    times[still] = opening + waits[still]


def _widened(cells: Cells, first, last, delay: float) -> tuple[Cells, tuple[np.ndarray, np.ndarray]]:
    """Cells with the limits of eq. (12), and which of them begin and end each run."""
    made, at, ends = [], [], []
    count, behind = 0, 0
    for a, b in zip(first, last, strict=True):
        pause = slice(behind, a)
        made.append([column[pause] for column in cells[2:7]] + [cells.stop[pause]])
        piece = _run(cells, a, b, delay)
        made.append(piece)
        count += a - behind
        at.append(count)
        count += len(piece[0])
        ends.append(count - 1)
        behind = b + 1
    made.append([column[behind:] for column in cells[2:7]] + [cells.stop[behind:]])
    columns = [np.concatenate(parts) for parts in zip(*made, strict=True)]
    n = len(columns[0])
    return Cells(np.arange(n), np.zeros(n), *columns), (np.array(at, int), np.array(ends, int))


def _run(cells: Cells, a: int, b: int, delay: float) -> list[np.ndarray]:
    """Length, speed, acceleration, jerk, pause and stop of the cells of one run, eq. (12)."""
    rows = slice(a, b + 1)
    limits = np.stack([cells.speed[rows], cells.acceleration[rows], cells.jerk[rows]])
    ends = np.concatenate([[0.0], np.cumsum(cells.length[rows])])
    total = ends[-1]
    if (limits == limits[:, :1]).all():
        length, found = np.array([total]), limits[:, :1]
    else:
        far = delay * limits[0]
        low = np.floor(np.maximum(ends[:-1] - far, 0.0) / total * _GRID)
        high = np.ceil(np.minimum(ends[1:] + far, total) / total * _GRID)
        places = np.unique(np.concatenate([low, high]))
        found = _least(limits, np.searchsorted(places, low), np.searchsorted(places, high), len(places) - 1)
        change = np.concatenate([[True], (found[:, 1:] != found[:, :-1]).any(0)])
        places = np.append(places[:-1][change], places[-1])
        length, found = np.diff(places) * (total / _GRID), found[:, change]
    stop = np.zeros(len(length), bool)
    stop[0] = True
    return [length, *found, np.zeros(len(length)), stop]


def _least(limits, low, high, n: int):
    """The least of each row of limits (3, m) in every one of n places, column k holding from place low_k to high_k."""
    levels = int(np.log2(max(n, 1))) + 1
    table = np.full((levels, len(limits), n), np.inf)
    level = np.log2(high - low).astype(int)
    for one in range(levels):
        here = np.flatnonzero(level == one)
        for row in range(len(limits)):
            np.minimum.at(table[one, row], low[here], limits[row, here])
            np.minimum.at(table[one, row], high[here] - 2**one, limits[row, here])
    for one in range(levels - 1, 0, -1):  # what holds over 2^k places holds over both their halves
        half = 2 ** (one - 1)
        table[one - 1] = np.minimum(table[one - 1], table[one])
        table[one - 1, :, half:] = np.minimum(table[one - 1, :, half:], table[one, :, : n - half])
    return table[0]


def _by_run(plain: Profile, cells: Cells, begin, end, first) -> tuple[Phases, np.ndarray]:
    """The phases of a profile in time within their runs, x counted from each run's start, and the run of each."""
    phases, times = plain.phases, plain.phases.times
    S = np.concatenate([[0.0], np.cumsum(cells.length)])
    middle = (times[:-1] + times[1:]) / 2
    run = np.searchsorted(begin, middle, "right") - 1
    kept = np.flatnonzero((np.diff(times) > 0) & (run >= 0) & (middle < end[np.maximum(run, 0)]))
    run = run[kept]
    cell = np.searchsorted(plain.times, middle[kept], "right") - 1
    start = S[cell] - plain.x[cell] - S[first[run]]  # of the phase's stretch in its run
    x, v, a, j = phases.at(kept, times[kept])
    return Phases(np.append(times[kept], end[-1]), times[kept], x + start, v, a, j), run


def _mean(given, shaper, begin, end, late, length) -> tuple[Phases, np.ndarray]:
    """Eq. (11): phases of the mean, at the times of the shaped program, and the run of each."""
    phases, run = given
    runs, n = len(begin), len(shaper.size)
    # each phase, and the rest behind each run, begins n times
    T = np.concatenate([phases.T - begin[run], end - begin])
    owner = np.concatenate([run, np.arange(runs)])
    T, owner = np.add.outer(shaper.time, T).ravel(), np.tile(owner, n)
    order = np.lexsort((T, owner))
    T, owner = T[order], owner[order]
    same = owner[1:] == owner[:-1]
    kept = np.flatnonzero(np.append((T[1:] > T[:-1]) & same, False))
    T, until, owner = T[kept], T[kept + 1], owner[kept]
    middle = (T + until) / 2
    total = np.zeros((4, len(T)))
    first = np.searchsorted(run, np.arange(runs))
    for size, at in zip(shaper.size, shaper.time, strict=True):
        inside = begin[owner] + middle - at
        k = np.clip(np.searchsorted(phases.T, inside, "right") - 1, first[owner], None)
        found = np.stack(phases.at(k, begin[owner] + T - at))
        before, behind = middle < at, inside > end[owner]
        found = np.where(before | behind, 0.0, found)
        found[0] = np.where(behind, length[owner], found[0])
        total += size * found
    starts = begin[owner] + late[owner] + T
    last = end[-1] + late[-1] + shaper.delay
    return Phases(np.append(starts, last), starts, *total), owner
