"""From rows with times to samples at a period: what is missing is put in as missing, what is twice is left out.

With T the period and t the times, row i is k = round((t_i - t_{i-1}) / T) samples behind the one before:

    k = 1   the next sample                k = 0   the same sample again: left out if it says the same, else refused
    k > 1   k - 1 samples are missing      k < 0   time goes backwards: refused

and |t_i - t_{i-1} - k T| > jitter is a sample at the wrong time.  Only differences count, so a clock that runs a little
slow matters to nobody.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...machine.record import Time
from .findings import Finding, Findings
from .table import Block, Source

_FARTHEST = 1e15  # samples between two rows, which may say any time
LONGEST = 50  # missing samples put in; behind more the record begins anew


class Samples(NamedTuple):
    """Rows that follow one another at the period."""

    t: np.ndarray  # (n,) s
    values: np.ndarray  # (n, k), NaN where the sample is missing
    lines: np.ndarray  # (n,) 0 where the sample is missing
    late: np.ndarray  # (n,) whether the row lies at the wrong time
    anew: bool  # whether they do not follow the samples before


class Timeline:
    """Puts blocks of rows on their times."""

    def __init__(self, source: Source, time: Time, findings: Findings):
        self.source, self.time, self.findings = source, time, findings
        self.last: tuple[float, np.ndarray] | None = None  # time and values of the last row
        self.rows = 0

    def place(self, block: Block, width: int) -> list[Samples]:
        """The samples of a block whose first `width` columns are values and whose next one, if any, is time."""
        values, lines = block.values[:, :width], block.lines
        T = self.time.period
        if self.time.column is None:
            t = (self.rows + np.arange(len(values))) * T
            anew, self.rows = self.rows == 0, self.rows + len(values)
            return [Samples(t, values, lines, np.zeros(len(values), bool), anew)]
        t = block.values[:, width] * self.time.scale
        if np.isnan(t).any():
            row = int(np.argmax(np.isnan(t)))
            told = next((text for r, column, text in block.bad if (r, column) == (row, width)), "no number")
            raise self._error(f"{self.time.column}: a row needs its time", lines[row], told)
        if self.last is None:
            self._check_period(t)
            before, known = t[0] - T, np.full(width, np.nan)
        else:
            before, known = self.last
        dt = np.diff(t, prepend=before)
        k = np.rint(np.clip(dt / T, -_FARTHEST, _FARTHEST)).astype(np.int64)
        late = np.abs(dt - k * T) > self.time.allowed
        keep = self._kept(k, values, lines, t, known)
        if not keep.all():
            # what was left out had k = 0, so the others' k and dt still tell their distance
            values, lines, t, k, late = (array[keep] for array in (values, lines, t, k, late))
        if len(t):
            self.last = t[-1], values[-1]
        for row in np.flatnonzero(late):
            text = "a row lies at the wrong time"
            self.findings.add(Finding("jitter", text, int(lines[row]), float(t[row]), float(t[row])), 2 * T)
        first = self.rows == 0
        self.rows += len(t)
        return self._split(t, values, lines, late, k, first)

    def _check_period(self, t: np.ndarray) -> None:
        if len(t) < 3:
            return
        step = float(np.median(np.diff(t)))
        if step > 0 and abs(step / self.time.period - 1) > 0.01:
            raise self.source.error(
                "rows are as far apart as the period says", key="time.period", value=f"{step:g} s",
                limit=f"{self.time.period:g} s",
                cure=f'write period = "{step:.6g} s", or check unit = "{self.time.unit}" of the time',
            )  # fmt: skip

    def _kept(self, k, values, lines, t, known) -> np.ndarray:
        """Which rows are samples of their own."""
        if (k < 0).any():
            row = int(np.argmax(k < 0))
            raise self._error("time goes backwards", lines[row], f"{t[row]:.9g} s")
        keep = k > 0
        for row in np.flatnonzero(~keep):
            former = values[row - 1] if row else known
            if not np.array_equal(values[row], former, equal_nan=True):
                raise self._error("two rows of one time differ", lines[row], f"{t[row]:.9g} s")
            self.findings.add(
                Finding("duplicate", "a row is there twice", int(lines[row]), float(t[row]), float(t[row])),
                2 * self.time.period,
            )
        return keep

    def _split(self, t, values, lines, late, k, first: bool) -> list[Samples]:
        """The rows with missing samples put in, cut where too many are missing."""
        gaps = np.flatnonzero(k > 1)
        if not len(gaps):
            return [Samples(t, values, lines, late, first)] if len(t) else []
        T = self.time.period
        for row in gaps:
            count = int(k[row] - 1)
            text = "samples are missing" if count <= LONGEST else "the record breaks off and begins anew"
            self.findings.add(
                Finding("missing", text, int(lines[row]), float(t[row] - count * T), float(t[row] - T), count)
            )
        cuts = [0, *(int(row) for row in gaps if k[row] > LONGEST + 1), len(t)]
        out = []
        for start, stop in zip(cuts[:-1], cuts[1:], strict=True):
            if stop == start:
                continue
            part = slice(start, stop)
            steps = k[part].copy()
            broken = start > 0 or (len(steps) and steps[0] > LONGEST + 1)
            if broken or first:
                steps[0] = 1
            at = np.cumsum(steps) - 1
            n = int(at[-1]) + 1
            full = np.full((n, values.shape[1]), np.nan)
            full[at] = values[part]
            where, wrong = np.zeros(n, lines.dtype), np.zeros(n, bool)
            where[at], wrong[at] = lines[part], late[part]
            times = np.interp(np.arange(n), at, t[part])
            missing = np.flatnonzero(where[: at[0]] == 0)  # before the first row of the part
            times[missing] = t[start] - (at[0] - missing) * T
            out.append(Samples(times, full, where, wrong, bool(broken or (first and start == 0))))
        return out

    def _error(self, rule: str, line, value: str):
        number = {"line": int(line)} if self.source.row_word == "line" else {"where": f"row {int(line)}"}
        return self.source.error(rule, value=value, **number)
