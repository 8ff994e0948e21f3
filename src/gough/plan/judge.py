"""Along a whole motion: how much of each limit is used at most, on which NC line and when.

Each stretch is looked at in five rows, equally far apart in time.  With f the use of a limit and f'' bounded by
what the second differences d of the rows say,

    max f <= max f_k + h^2 max |f''| / 8,    h^2 |f''| taken as 2 max |d|                                          (1)

a stretch in which (1) leaves open whether a limit is exceeded, or by how much, is cut in four and looked at again.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .course import Stretches, rows, stretches
from .demand import Demand

_SHARES = np.linspace(0, 1, 5)
_ROWS = 8192  # stretches looked at together
_ROUNDS = 7  # of cutting in four: 1/16384 of a stretch, below a micrometre
_SURE = 1e-4  # of a limit: what may be missed of an excess
_EXCESS = 5e-3  # of an excess that is found: within which it is told
_THIN = 16  # the condition number, which costs more than all the rest, is asked at one stretch in so many
_MOST = 400_000  # stretches that are cut in one round
MOST = 2000  # excesses that are told one by one
SLOTS = 1000  # of the program's time, of each of which the greatest use of a limit of each kind is kept


class Found(NamedTuple):
    """What was found.  Per NC line `lines` (m,): greatest use, of which column, and when; per column the same."""

    lines: np.ndarray
    use: np.ndarray
    column: np.ndarray
    time: np.ndarray  # s
    place: np.ndarray  # (m, 4): block of the course, extent in it, rate of the extent, its rate
    top: np.ndarray  # (k,) greatest use of each column, over the program
    top_line: np.ndarray
    top_time: np.ndarray
    top_place: np.ndarray  # (k, 4), as `place`
    beyond: list[Beyond]  # lines and columns above 1, worst first, `MOST` of them
    exceeded: int  # how many there are
    unreachable: dict[int, tuple[float, np.ndarray]]  # NC line: first time s, and task coordinates
    condition: float  # greatest condition number of J
    condition_line: int
    condition_time: float
    rows: int
    along: dict[str, np.ndarray]  # kind of a limit: greatest use in each slot of time (SLOTS,); NaN: no row fell there


class Beyond(NamedTuple):
    """A limit that is exceeded on a line."""

    line: int
    column: int
    use: float
    time: float
    block: int
    u: float
    ud: float
    udd: float


def judge(motion, demand: Demand, tell=None) -> Found:
    """Look at every stretch of a motion.

    `tell(done)` is called with the share that is done.

    Raises
    ------
    ProgramError
        a motion that is given over time.
    """
    whole = stretches(motion)
    keeper = _Keeper(motion, demand)
    open_ = []
    for k in range(0, len(whole), _ROWS):
        part = whole.chosen(slice(k, k + _ROWS))
        left = keeper.look(part, first=True)
        if left.any():
            open_.append(part.chosen(left))
        if tell is not None:
            tell(min(k + _ROWS, len(whole)) / len(whole))
    for _ in range(_ROUNDS):
        if not open_:
            break
        todo = Stretches(*(np.concatenate(column) for column in zip(*open_, strict=True)))
        if len(todo) > _MOST:  # those that exceed a limit surely need no finer look
            todo = todo.chosen(slice(0, _MOST))
        todo, open_ = todo.split(4), []
        for k in range(0, len(todo), _ROWS):
            part = todo.chosen(slice(k, k + _ROWS))
            left = keeper.look(part)
            if left.any():
                open_.append(part.chosen(left))
    return keeper.found()


class _Keeper:
    """Keeps the greatest uses while stretches go by."""

    def __init__(self, motion, demand: Demand):
        self.motion, self.demand = motion, demand
        path = motion.course.programmed
        self.number = np.unique(path.line)
        m, k = len(self.number), len(demand)
        self.use, self.column, self.time = np.full(m, -np.inf), np.zeros(m, int), np.zeros(m)
        self.place = np.zeros((m, 4))
        self.top, self.top_line, self.top_time = np.full(k, -np.inf), np.zeros(k, int), np.zeros(k)
        self.top_place = np.zeros((k, 4))
        self.beyond: list[tuple] = []
        self.unreachable: dict[int, tuple[float, np.ndarray]] = {}
        self.number_of_J, self.seen, self.rows = (0.0, 0, 0.0), 0, 0
        self.slot = SLOTS / max(motion.feed.duration, 1e-9)  # of a second
        self.along = {str(kind): np.full(SLOTS, -np.inf) for kind in dict.fromkeys(demand.kinds)}

    def look(self, part: Stretches, first: bool = False) -> np.ndarray:
        """Look at stretches; which of them must be looked at more finely.  (m,) bool."""
        found, states, broken = [], [], np.zeros(len(part), bool)
        for share in _SHARES:
            here = rows(self.motion, part, share)
            uses, bad = self.demand.uses(here.x, here.xd, here.xdd)
            if bad.any():
                self._note_unreachable(part, here, share, bad)
                broken |= bad
            found.append(uses)
            states.append(here)
        f = np.stack(found)  # (5, m, k)
        self.rows += f.shape[0] * f.shape[1]
        most = f.max(0)
        self._keep(part, f, most, states)
        self._along(part, f)
        if first:
            self._condition(part, states[0], broken)
        d = np.abs(f[:-2] - 2 * f[1:-1] + f[2:]).max(0)
        might = most + d / 4
        known = most > 1
        coarse = d / 4 > np.where(known, _EXCESS * most, _SURE)
        undecided = (might > 1) & coarse & (~known | (might > (1 + _EXCESS) * self._known(part)))
        return undecided.any(1) & ~broken

    def _lines(self, part, state):
        """Index into `number` of the programmed line at each row."""
        place = self.motion.course.place(state.block, state.u)
        return np.searchsorted(self.number, self.motion.course.programmed.line[place.block])

    def _known(self, part):
        """Of each column what is known to be reached on the line of a stretch, at least 1; (m, k).

        Only the greatest excess of a line is told finely.
        """
        return np.maximum(self.use[self._line], 1.0)[:, None]

    def _keep(self, part, f, most, states):
        which = f.argmax(0) if (most > 1).any() else None
        places = np.stack(
            [np.stack([np.asarray(state[k], float) for k in range(4)], 1) for state in states]
        )  # (5, m, 4)
        self._line = line = self._lines(part, states[2])
        column = most.argmax(1)
        every = np.arange(len(part))
        use = most[every, column]
        better = use > self.use[line]
        if better.any():
            rows_ = np.flatnonzero(better)
            rows_ = rows_[np.argsort(use[rows_], kind="stable")]  # of several of one line the greatest is written last
            row = f[:, rows_, column[rows_]].argmax(0)
            self.use[line[rows_]], self.column[line[rows_]] = use[rows_], column[rows_]
            self.time[line[rows_]] = part.t0[rows_] + _SHARES[row] * (part.t1 - part.t0)[rows_]
            self.place[line[rows_]] = places[row, rows_]
        best = most.argmax(0)
        higher = np.flatnonzero(most[best, np.arange(len(best))] > self.top)
        for c in higher:
            i = best[c]
            k = int(f[:, i, c].argmax())
            self.top[c], self.top_line[c] = most[i, c], self.number[line[i]]
            self.top_place[c] = places[k, i]
            self.top_time[c] = part.t0[i] + _SHARES[k] * (part.t1[i] - part.t0[i])
        if which is None:
            return
        i, c = np.nonzero(most > 1)
        key = line[i].astype(np.int64) * len(self.demand) + c
        order = np.lexsort((-most[i, c], key))
        key, i, c = key[order], i[order], c[order]
        lead = np.append(True, key[1:] != key[:-1])
        key, i, c = key[lead], i[lead], c[lead]
        row = which[i, c]
        t = part.t0[i] + _SHARES[row] * (part.t1 - part.t0)[i]
        self.beyond.append((key, most[i, c], np.column_stack([t, places[row, i]])))

    def _along(self, part, f):
        t = part.t0 + _SHARES[:, None] * (part.t1 - part.t0)
        slot = np.clip((t * self.slot).astype(int), 0, SLOTS - 1).ravel()
        for kind, kept in self.along.items():
            np.maximum.at(kept, slot, f[:, :, self.demand.kinds == kind].max(2).ravel())

    def _beyond(self) -> tuple[list[Beyond], int]:
        """The worst of what is exceeded, worst first, and how many limits of how many lines are."""
        if not self.beyond:
            return [], 0
        key, use, told = (np.concatenate(column) for column in zip(*self.beyond, strict=True))
        order = np.lexsort((-use, key))
        lead = order[np.append(True, key[order][1:] != key[order][:-1])]  # the greatest of each line and column
        lead = lead[np.lexsort((key[lead], -use[lead]))]
        line, column = self.number[key // len(self.demand)], key % len(self.demand)
        found = [
            Beyond(int(line[n]), int(column[n]), float(use[n]), float(told[n, 0]) + self.motion.lead_in,
                   int(told[n, 1]), *told[n, 2:].tolist())
            for n in lead[:MOST]
        ]  # fmt: skip
        return found, len(lead)

    def _note_unreachable(self, part, here, share, bad):
        i = np.flatnonzero(bad)
        line, t = self._lines(part, here)[i], (part.t0 + share * (part.t1 - part.t0))[i]
        order = np.lexsort((t, line))
        lines, lead = np.unique(line[order], return_index=True)
        for key, n in zip(self.number[lines].tolist(), order[lead], strict=True):
            if key not in self.unreachable or t[n] < self.unreachable[key][0]:
                self.unreachable[key] = (float(t[n]), here.x[i[n]])

    def _condition(self, part, state, broken):
        from ..machine.workspace import condition

        some = np.arange(-self.seen % _THIN, len(part), _THIN)
        self.seen += len(part)
        some = some[~broken[some]]
        if not len(some):
            return
        machine = self.demand.machine
        numbers = condition(machine, machine.jacobian(state.x[some]))
        k = int(np.argmax(np.where(np.isnan(numbers), np.inf, numbers)))
        if numbers[k] > self.number_of_J[0]:
            self.number_of_J = (float(numbers[k]), int(self.number[self._line[some[k]]]), float(part.t0[some[k]]))

    def found(self) -> Found:
        lead = self.motion.lead_in
        beyond, exceeded = self._beyond()
        seen = np.isfinite(self.use)
        late = {line: (t + lead, x) for line, (t, x) in sorted(self.unreachable.items())}
        number, line, t = self.number_of_J
        return Found(
            self.number[seen], self.use[seen], self.column[seen], self.time[seen] + lead, self.place[seen], self.top,
            self.top_line, self.top_time + lead, self.top_place, beyond, exceeded, late, number, line, t + lead,
            self.rows, {kind: np.where(np.isfinite(kept), kept, np.nan) for kind, kept in self.along.items()},
        )  # fmt: skip
