"""The jerk-limited profile of a chain of cells: neighbours with equal limits merged, stretches, phases, and times."""

from __future__ import annotations

import numpy as np

from .phases import Cells, Phases, Profile
from .seven import phases
from .stretches import stretches

_ROUNDS = 200  # of a root in a bracket; halving alone needs 60


def jerk_limited(cells: Cells) -> Profile:
    """The jerk-limited profile of a chain of cells, as fast as stretches.py makes it."""
    moving = np.flatnonzero(cells.length > 0)
    pause = np.where(cells.length > 0, 0.0, cells.pause)
    waits = np.concatenate([[0.0], np.cumsum(pause)])  # before each cell
    if not len(moving):
        return Profile(Phases(*np.zeros((6, 1))), waits, np.zeros(len(pause)))
    merged, members = _merged(cells, moving)
    found = stretches(merged)
    begin = found.cell[:-1]
    row, first = phases(found, merged.jerk[begin], np.maximum.reduceat(merged.acceleration, begin))
    # when: the phases one behind the other, each stretch after the pauses before its first cell
    opening = moving[members[begin]]
    ended, wait = np.cumsum(row.lasts), np.repeat(waits[opening], np.diff(first))
    starts, ends = np.concatenate([[0.0], ended[:-1]]) + wait, ended + wait
    table = Phases(np.append(starts, ends[-1]), np.where(row.ends, ends, starts), row.x, row.v, row.a, row.j)
    # where each moving cell begins in its stretch, and when
    before = np.cumsum(np.isin(np.arange(len(moving)), members[begin])) - 1
    X = np.concatenate([[0.0], np.cumsum(cells.length[moving])])
    x = np.zeros(len(pause))
    x[moving] = X[:-1] - X[members[begin]][before]
    times = np.zeros(len(pause) + 1)
    times[moving] = _when(table, first, found.length, before, x[moving], ends)
    times[opening] = starts[first[:-1]]
    # pauses follow what has moved before them
    still = np.flatnonzero(cells.length == 0)
    moved = np.concatenate([[0.0], ended])[first]
    times[still] = moved[np.searchsorted(opening, still)] + waits[still]
    times[-1] = ended[-1] + waits[-1]
    return Profile(table, np.maximum.accumulate(times), x)


def _merged(cells, moving):
    """Moving neighbours with equal limits and no stop between as one cell; `members` (k + 1,): where each begins."""
    V, A, J = cells.speed[moving], cells.acceleration[moving], cells.jerk[moving]
    stops = np.cumsum(cells.stop)  # from behind one cell to before the next
    halt = np.concatenate([[True], stops[moving[1:]] > stops[moving[:-1]], [True]])
    change = halt.copy()
    change[1:-1] |= (V[1:] != V[:-1]) | (A[1:] != A[:-1]) | (J[1:] != J[:-1])
    members = np.flatnonzero(change)
    begin = members[:-1]
    length = np.add.reduceat(cells.length[moving], begin)
    none = np.zeros(len(begin))
    return Cells(begin, none, length, V[begin], A[begin], J[begin], none, halt[members]), members


def _when(table, first, S, stretch, x, ends):
    """The times at which the feed is at x (n,) of the stretches (n,)."""
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
