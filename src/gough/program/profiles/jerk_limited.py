"""The jerk-limited profile of a chain of cells: neighbours with equal limits merged, stretches, phases, and times."""

from __future__ import annotations

import numpy as np

from .phases import Cells, Phases, Profile, reached
from .seven import phases
from .stretches import stretches


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
    times[moving] = reached(table, first, found.length, before, x[moving], ends)
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
