"""Velocity reversals of the struts and the glitch that friction leaves in the contour error.

A reversal is a sample at which the reference velocity of a strut has the other sign than when the strut last moved;
slower than 1 um/s is at rest.  Its glitch is a peak of the contour error after it, above what was there before:

    CONTRACT   largest error in the 0.2 s after            - median of the 0.2 s before
    STUDIES    largest error from 20 ms before to 100 ms after - largest error from 250 to 50 ms before

Only samples that count (feed moves) are looked at, and only reversals with such samples on both sides are told.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

AT_REST = 1e-6  # m/s


class Glitch(NamedTuple):
    """How a glitch is taken: seconds before the reversal, seconds after it, and what stands for the time before."""

    before: tuple[float, float]  # from, to; before the reversal
    after: tuple[float, float]  # from, to; behind it
    level: str  # "median" or "max"


CONTRACT = Glitch((0.2, 0.0), (0.0, 0.2), "median")
STUDIES = Glitch((0.25, 0.05), (-0.02, 0.1), "max")


class Reversal(NamedTuple):
    """One reversal: time s, number of the joint from 0, glitch m."""

    time: float
    joint: int
    glitch: float

    def to_json(self) -> dict:
        return self._asdict()


class ReversalMeter:
    """Finds reversals in samples that come in chunks of any size.  `found` holds those whose time after has passed.

    `count` says how many, `largest` the largest glitch (NaN if one was); without `keep` that is all that is kept.
    """

    def __init__(self, period: float, glitch: Glitch = CONTRACT, keep: bool = True):
        self.period, self.found, self.keep = period, [], keep
        self.count, self.largest = 0, None
        self._level = glitch.level
        self._before = tuple(round(t / period) for t in glitch.before)
        self._after = tuple(round(t / period) for t in glitch.after)
        self._sign = self._last = None
        self._first = self._count = 0  # number of the first sample kept, and of the next to come
        self._error, self._counted = np.zeros(0), np.zeros(0, bool)
        self._pending: list[tuple[int, int, float]] = []

    def update(self, qd_r, contour_error, counted) -> None:
        """The next n samples: reference velocities (n, joints) m/s, contour error (n,) m, whether counted (n,)."""
        qd_r = np.asarray(qd_r, float)
        if not len(qd_r):
            return
        if self._sign is None:
            self._sign, self._last = np.zeros(qd_r.shape[1]), qd_r[0]
        self._error = np.concatenate([self._error, np.asarray(contour_error, float)])
        self._counted = np.concatenate([self._counted, np.asarray(counted, bool)])
        sign = np.where(np.abs(qd_r) > AT_REST, np.sign(qd_r), 0.0)
        sign = carried(np.concatenate([self._sign[None], sign]))
        previous = np.concatenate([self._last[None], qd_r[:-1]])
        for row, joint in zip(*np.nonzero(sign[1:] * sign[:-1] < 0), strict=True):
            now, then = qd_r[row, joint], previous[row, joint]
            share = now / (now - then) if now * then < 0 else 0.0  # where between the samples it was zero
            self._pending.append((self._count + int(row), int(joint), float(share)))
        self._sign, self._last = sign[-1].copy(), qd_r[-1].copy()  # a view would keep the chunk
        self._count += len(qd_r)
        self._settle(self._count)

    def close(self) -> list[Reversal]:
        """No more samples: the reversals of all of them, in order of time."""
        self._settle(self._count + self._after[1] + 1)
        return self.found

    def _settle(self, until):
        ready = [entry for entry in self._pending if entry[0] + self._after[1] < until]
        self._pending = [entry for entry in self._pending if entry[0] + self._after[1] >= until]
        for k, joint, share in ready:
            before = self._window(k - self._before[0], k - self._before[1])
            after = self._window(k + self._after[0], k + self._after[1] + 1)
            if not len(before) or not len(after) or not self._counted[k - self._first]:
                continue
            level = np.median(before) if self._level == "median" else np.max(before)
            size = float(np.max(after) - level)
            self.count += 1
            self.largest = size if self.largest is None else float(np.maximum(self.largest, size))
            if self.keep:
                self.found.append(Reversal((k - share) * self.period, joint, size))
        keep = min([self._count] + [entry[0] for entry in self._pending]) - self._before[0]
        drop = max(0, keep - self._first)
        self._error, self._counted = self._error[drop:].copy(), self._counted[drop:].copy()
        self._first += drop

    def _window(self, start, stop):
        part = slice(max(0, start - self._first), max(0, stop - self._first))
        return self._error[part][self._counted[part]]


def reversals(period: float, qd_r, contour_error, counted, glitch: Glitch = CONTRACT) -> list[Reversal]:
    """The reversals of a whole run, `period` s a sample: reference velocities (n, joints), contour error, counted (n,).

    `glitch=STUDIES` takes the glitch as the published experiments judge it.
    """
    meter = ReversalMeter(period, glitch)
    meter.update(qd_r, contour_error, counted)
    return meter.close()


def carried(sign):
    """Zeros replaced by the last sign before them.  (n, joints)."""
    rows = np.where(sign != 0, np.arange(len(sign))[:, None], 0)
    np.maximum.accumulate(rows, axis=0, out=rows)
    return np.take_along_axis(sign, rows, 0)
