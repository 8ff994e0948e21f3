"""Events in a force over time, found as it comes.

    alarm       |f| >= alarm; over when below 80 % of it for 0.1 s
    collision   |f(t) - f(t - 10 ms)| >= collision: faster than a cut begins, and more than friction can feign.  It
                lasts until the force is back at what it was before, to half of `collision` or 30 % of its peak; a jump
                on the way back is its end, until there is none for 10 ms, and one farther away another collision
    breakage    |f| falls within 20 ms below 30 % of its mean of the 50 ms before, which was at least `breakage`, while
                the joints go on at more than half their speed, and no collision ends there.  A tool that leaves the
                cut at speed looks the same.

Breakage after the idea of Altintas, Prediction of cutting forces and tool breakage in milling from feed drive current
measurements, ASME J. Eng. Ind. 114, 1992: the force goes, the feed does not.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

RISE, DROP, MEAN = 10e-3, 20e-3, 50e-3  # s
OVER, LEFT, GOING = 0.8, 0.3, 0.5
APART = 0.1  # s between two events of a kind
MOST = 1000  # events kept one by one


@dataclass
class Event:
    """One event: when, and how much."""

    kind: str
    start: float  # s
    end: float  # s
    peak: float  # N; of a collision the change from before
    force: list[float]  # f at the peak, N in W
    before: float | None = None  # N, of a breakage: the mean before

    def to_json(self) -> dict[str, Any]:
        return {k: v for k, v in asdict(self).items() if v is not None}


class Events:
    """Looks at forces f (N, 3) at times t, chunk after chunk."""

    def __init__(self, period: float, alarm: float | None, collision: float | None, breakage: float | None):
        self.period, self.alarm, self.collision, self.breakage = period, alarm, collision, breakage
        self.rise, self.drop, self.mean = (max(1, round(span / period)) for span in (RISE, DROP, MEAN))
        self.found: list[Event] = []
        self.counts = {"alarm": 0, "collision": 0, "breakage": 0}
        self.open: Event | None = None
        self.last_alarm: Event | None = None
        self.last = {"breakage": -np.inf}
        self.blow: Event | None = None  # the collision that lasts
        self.base, self.last_jump = np.zeros(3), -np.inf
        self.settling, self.calm, self.least = False, 0, np.inf
        self.ends: list[float] = []  # of collisions, the last ones
        self.tail: tuple[np.ndarray, ...] = (np.zeros(0), np.zeros((0, 3)), np.zeros(0))

    def restart(self) -> None:
        """What comes does not follow what came."""
        self._close()
        self.blow, self.settling = None, False
        self.tail = (np.zeros(0), np.zeros((0, 3)), np.zeros(0))

    def look(self, t, f, speed) -> list[Event]:
        """The events that begin in these samples; `speed` (N,) m/s of the joints."""
        known = len(self.found)
        old = len(self.tail[0])
        t, f, speed = (np.concatenate([a, b]) for a, b in zip(self.tail, (t, f, speed), strict=True))
        size = np.linalg.norm(f, axis=1)
        if self.alarm is not None:
            self._alarms(t[old:], f[old:], size[old:])
        if self.collision is not None and len(t) > self.rise:
            self._collisions(t, f, old)
        if self.breakage is not None:
            self._breakages(t, f, size, speed, old)
        keep = self.drop + self.mean + self.rise
        self.tail = t[-keep:], f[-keep:], speed[-keep:]
        return self.found[known:]

    def finish(self) -> None:
        """Nothing more comes."""
        self._close()

    def _alarms(self, t, f, size):
        high, low = size >= self.alarm, size < OVER * self.alarm
        at = 0
        while at < len(t):
            if self.open is None:
                begins = np.flatnonzero(high[at:])
                if not len(begins):
                    return
                at += int(begins[0])
                self.open = self._opened(float(t[at]))
            ends = np.flatnonzero(low[at:])
            stop = at + int(ends[0]) if len(ends) else len(t)
            if stop > at:
                top = at + int(np.argmax(size[at:stop]))
                if size[top] > self.open.peak:
                    self.open.peak, self.open.force = float(size[top]), f[top].tolist()
                self.open.end = float(t[stop - 1])
            if len(ends):
                self._close()
            at = stop

    def _opened(self, t: float) -> Event:
        """A new alarm, or the last one again if that has just ended."""
        if self.last_alarm is not None and t - self.last_alarm.end <= APART:
            self.counts["alarm"] -= 1
            if self.found and self.found[-1] is self.last_alarm:
                self.found.pop()
            return self.last_alarm
        return Event("alarm", t, t, 0.0, [0.0] * 3)

    def _close(self):
        if self.open is not None:
            self._add(self.open)
            self.last_alarm, self.open = self.open, None

    def _collisions(self, t, f, old):
        jump = np.zeros(len(t))
        jump[self.rise :] = np.linalg.norm(f[self.rise :] - f[: -self.rise], axis=1)
        jumps = jump >= self.collision
        at = old
        while at < len(t):
            if self.settling:
                at = self._settle(t, f, jumps, at)
                continue
            if self.blow is None:
                rows = np.flatnonzero(jumps[at:])
                if not len(rows):
                    return
                at += int(rows[0])
                self.base = f[at - self.rise]
                self._blow(t, f, at)
                at += 1
                continue
            away = np.linalg.norm(f[at:] - self.base, axis=1)
            most = np.maximum(np.maximum.accumulate(away), self.blow.peak)
            back = np.flatnonzero(away < np.maximum(self.collision / 2, LEFT * most))
            stop = at + int(back[0]) if len(back) else len(t)
            self._during(t, f, jumps, away, at, stop)
            if len(back):
                self.ends = [end for end in self.ends if end > t[0] - APART] + [float(t[stop])]
                self.blow, self.settling, self.calm, self.least = None, True, 0, np.inf
            at = stop + 1

    def _settle(self, t, f, jumps, at) -> int:
        """The jump back goes on in rows at ...; the row from which a jump is one of its own.

        A jump looks 10 ms back, so it is over when there was none for as long: one row below `collision` is noise.  A
        force that has come back, and goes away again by `collision`, is another one all the same.
        """
        while at < len(t):
            self.calm = 0 if jumps[at] else self.calm + 1
            away = float(np.linalg.norm(f[at] - self.base))
            self.least = min(self.least, away)
            if away - self.least >= self.collision:
                self.settling = False
                self._blow(t, f, at)
                return at + 1
            at += 1
            if self.calm >= self.rise:
                self.settling = False
                return at
        return at

    def _during(self, t, f, jumps, away, at, stop):
        """A collision goes on in rows at ... stop - 1: its end, its peak, and others on top of it."""
        if stop <= at:
            return
        top = at + int(np.argmax(away[: stop - at]))
        if away[top - at] > self.blow.peak:
            self.blow.peak, self.blow.force = float(away[top - at]), f[top].tolist()
        self.blow.end = float(t[stop - 1])
        for row in at + np.flatnonzero(jumps[at:stop]):
            farther = away[row - at] > np.linalg.norm(f[row - self.rise] - self.base)
            if farther and t[row] - self.last_jump > APART:
                self._blow(t, f, row)
            self.last_jump = float(t[row])

    def _blow(self, t, f, row):
        peak = float(np.linalg.norm(f[row] - self.base))
        self.blow = Event("collision", float(t[row]), float(t[row]), peak, f[row].tolist())
        self.last_jump = float(t[row])
        self._add(self.blow)

    def _once(self, kind, rows, t, f, value, before):
        """One event for rows that come closely behind one another."""
        for row in rows:
            if t[row] - self.last[kind] > APART:
                told = float(before[row])
                self._add(Event(kind, float(t[row]), float(t[row]), float(value[row]), f[row].tolist(), told))
            self.last[kind] = t[row]

    def _breakages(self, t, f, size, speed, old):
        n, d, m = len(t), self.drop, self.mean
        if n <= d + m:
            return
        total = np.concatenate([[0], np.cumsum(size)])
        moved = np.concatenate([[0], np.cumsum(speed)])
        before, went = np.zeros(n), np.zeros(n)
        rows = np.arange(d + m, n)
        before[rows] = (total[rows - d] - total[rows - d - m]) / m
        went[rows] = (moved[rows - d] - moved[rows - d - m]) / m
        broken = (before >= self.breakage) & (size < LEFT * before) & (speed > GOING * went) & (went > 0)
        for end in self.ends:
            broken &= np.abs(t - end) > APART
        rows = np.flatnonzero(broken)
        self._once("breakage", rows[rows >= old], t, f, size, before)

    def _add(self, event: Event):
        self.counts[event.kind] += 1
        if len(self.found) < MOST:
            self.found.append(event)
