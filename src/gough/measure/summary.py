"""The numbers of a run: gathered chunk by chunk over every sample, and shown as a table.

    contour_error, orientation_error   max, rms, mean, at (time of the max), line (its NC line)    m, rad   feed moves
    lag, tracking                      max, rms of the absolute value; tracking: the worst joint   m        feed moves
    reversals                          count, largest (glitch)                                     m        feed moves
    strut_force, strut_velocity        peak of the absolute value of any joint                     N, m/s   all samples
    overshoot                          max of any joint, past a reference that rests (overshoot.py) m       all samples
    saturated                          share of samples with a drive at its limit                           all samples
    samples, counted                   how many, and how many of feed moves

A number that nothing was measured for, or that is not finite, is None.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .. import units
from .overshoot import OvershootMeter
from .reversal import ReversalMeter
from .tree import columns, nested

_SHOWN = 20  # lines of a batch


class Accumulator:
    """Metrics of one run of period `period` s from chunks of any size.  `update(...)`, then `result()`.

    Without `keep_reversals` they are counted only, and the memory does not grow with the run.
    """

    def __init__(self, period: float, keep_reversals: bool = True):
        self.period = period
        self.samples = self.counted = self._saturated = 0
        self._contour, self._orientation, self._lag = _Worst(), _Worst(), _Worst()
        self._tracking: list[_Worst] = []
        self._force = self._velocity = None
        self._reversals = ReversalMeter(period, keep=keep_reversals)
        self._overshoot = OvershootMeter()
        self._limited = False

    def update(
        self, *, contour_error, orientation_error, lag, counted, line, q_r, qd_r, q, qd=None, u=None, saturated=None
    ) -> None:
        """The next n samples: (n,) rows of errors m, rad, m, of counted and NC line; (n, joints) of the others, SI."""
        counted = np.asarray(counted, bool)
        t = (self.samples + np.arange(len(counted))) * self.period
        self.samples += len(counted)
        self.counted += int(counted.sum())
        rows = np.flatnonzero(counted)
        place = t[rows], np.asarray(line)[rows]
        for worst, values in (
            (self._contour, contour_error),
            (self._orientation, orientation_error),
            (self._lag, np.abs(lag)),
        ):
            worst.add(np.asarray(values, float)[rows], *place)
        error = np.abs(np.asarray(q_r, float) - q)[rows]
        self._tracking = self._tracking or [_Worst() for _ in range(error.shape[1])]
        for worst, column in zip(self._tracking, error.T, strict=True):
            worst.add(column, *place)
        self._force, self._velocity = _peak(self._force, u), _peak(self._velocity, qd)
        if saturated is not None:
            self._limited = True
            self._saturated += int((np.asarray(saturated) != 0).any(1).sum())
        self._overshoot.update(q_r, qd_r, q)
        self._reversals.update(qd_r, contour_error, counted)

    def result(self) -> dict[str, Any]:
        """The metrics, SI.  No more updates afterwards."""
        self._reversals.close()
        tracking = [worst.result() for worst in self._tracking]
        lag = self._lag.result()
        return {
            "contour_error": self._contour.result(),
            "orientation_error": self._orientation.result(),
            "lag": {"max": lag["max"], "rms": lag["rms"]},
            "tracking": {name: _largest([w[name] for w in tracking]) for name in ("max", "rms")},
            "reversals": {"count": self._reversals.count, "largest": _number(self._reversals.largest)},
            "strut_force": {"peak": _number(self._force)},
            "strut_velocity": {"peak": _number(self._velocity)},
            "overshoot": {"max": _number(self._overshoot.largest)},
            "saturated": self._saturated / self.samples if self._limited and self.samples else None,
            "samples": self.samples,
            "counted": self.counted,
        }

    @property
    def reversals(self) -> list[dict[str, Any]]:
        """Every reversal so far whose time after has passed: time s, joint (from 0), glitch m."""
        return [r.to_json() for r in self._reversals.found]


class _Worst:
    """Largest value and where it was, mean and root mean square of non-negative values that come in chunks."""

    def __init__(self):
        self.count, self.sum, self.squares, self.max = 0, 0.0, 0.0, -math.inf
        self.at = self.line = None

    def add(self, values, t, line):
        if not len(values):
            return
        self.count += len(values)
        self.sum += float(values.sum())
        self.squares += float(values @ values)
        k = int(np.argmax(values))  # the first NaN, if there is one
        if not values[k] <= self.max and not math.isnan(self.max):
            self.max, self.at, self.line = float(values[k]), float(t[k]), int(line[k])

    def result(self):
        if not self.count:
            return dict.fromkeys(("max", "rms", "mean", "at", "line"))
        return {
            "max": _number(self.max),
            "rms": _number(math.sqrt(self.squares / self.count)),
            "mean": _number(self.sum / self.count),
            "at": self.at,
            "line": self.line,
        }


def _peak(known, values):
    if values is None or not np.size(values):
        return known
    found = float(np.max(np.abs(values)))
    return found if known is None or not found <= known and not math.isnan(known) else known


def _number(value):
    return None if value is None or not math.isfinite(value) else float(value)


def _largest(values):
    if not values or not all(value is not None and math.isfinite(value) for value in values):
        return None
    return float(max(values))


class Measured:
    """The metrics of a run; prints itself.  `metrics` is the dict, its entries are attributes too.

    `joint` is what the machine calls one of its joints.
    """

    def __init__(self, metrics: dict[str, Any], joint: str = "strut"):
        self.metrics, self.joint = metrics, joint

    def __getattr__(self, name: str) -> Any:
        try:
            return self.__dict__["metrics"][name]
        except KeyError:
            raise AttributeError(f"{name} was not measured") from None

    def __repr__(self) -> str:
        m = self.metrics
        rows = [("", "max", "rms", "mean")]
        for label, name, unit in (
            ("contour error", "contour_error", "m"),
            ("orientation error", "orientation_error", "rad"),
            ("lag", "lag", "m"),
            ("tracking, worst joint", "tracking", "m"),
        ):
            if m.get(name):
                rows.append((label, *(_show(m[name].get(what), unit) for what in ("max", "rms", "mean"))))
        for label, value in (
            (f"{self.joint} force, peak", _show(_get(m, "strut_force", "peak"), "N")),
            (f"{self.joint} velocity, peak", _show(_get(m, "strut_velocity", "peak"), "m/s")),
            ("largest reversal glitch", _show(_get(m, "reversals", "largest"), "m")),
        ):
            if value:
                rows.append((label, value, "", ""))
        widths = [max(len(row[k]) for row in rows) for k in range(4)]
        lines = [
            "  ".join([row[0].ljust(widths[0])] + [row[k].rjust(widths[k]) for k in (1, 2, 3)]).rstrip() for row in rows
        ]
        at = _get(m, "contour_error", "at")
        if at is not None:
            lines.append(f"largest contour error at t = {at:.4g} s, line {_get(m, 'contour_error', 'line')}")
        lines.append(f"{m.get('counted', 0)} of {m.get('samples', 0)} samples on feed moves")
        if m.get("saturated"):
            lines.append(f"a drive at its limit in {100 * m['saturated']:.3g} % of the samples")
        return "\n".join(lines)


class MeasuredRuns(Measured):
    """The metrics of a batch: entries as of one run, each an array (runs,).  Prints a line a run, at most twenty."""

    def __init__(self, metrics: dict[str, Any], labels: list[str], reasons: list[str]):
        super().__init__(metrics)
        self.labels, self.reasons = labels, reasons

    def __repr__(self) -> str:
        m, count = self.metrics, len(self.labels)
        heads = (
            ("contour max", ("contour_error", "max"), "m"), ("rms", ("contour_error", "rms"), "m"),
            ("orientation max", ("orientation_error", "max"), "rad"), ("tracking max", ("tracking", "max"), "m"),
            ("force peak", ("strut_force", "peak"), "N"),
        )  # fmt: skip
        columns = [(head, _get(m, *path), unit) for head, path, unit in heads if _get(m, *path) is not None]
        # of more than fit the worst are shown
        order = np.arange(count)
        if count > _SHOWN and columns:
            order = np.argsort(-np.nan_to_num(columns[0][1], nan=np.inf), kind="stable")[: _SHOWN - 1]
        rows = [("run", *(head for head, _, _ in columns), "")]
        for i in order:
            cells = (_show(None if np.isnan(values[i]) else float(values[i]), unit) for _, values, unit in columns)
            rows.append((self.labels[i], *cells, f"FAILED: {self.reasons[i]}" if self.reasons[i] else ""))
        if len(order) < count:
            middle = (
                _show(float(np.nanmedian(values)) if np.isfinite(values).any() else None, unit)
                for _, values, unit in columns
            )
            rows.append((f"median of {count}", *middle, ""))
        widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
        return "\n".join(
            "  ".join([row[0].ljust(widths[0]), *(c.rjust(w) for c, w in zip(row[1:-1], widths[1:-1], strict=True))])
            + (f"  {row[-1]}" if row[-1] else "")
            for row in rows
        )


def _get(metrics, *names):
    for name in names:
        metrics = (metrics or {}).get(name)
    return metrics


def _show(value, unit):
    return "" if value is None else units.show(value, unit)


def measure(log) -> Measured:
    """The metrics of a log: as the run gathered them over every sample, else from the rows the log has.

    Of a batch each is an array (runs,), NaN where nothing was measured.

    Raises
    ------
    LogError
        the log has neither metrics nor the rows they are made of.
    """
    if log.batch:
        return _measure_runs(log)
    if log.metrics:
        return Measured(log.metrics, log.joint_word)
    t, q, q_r = log["t"], log["q"], log["q_r"]
    period = float(t[1] - t[0]) if len(t) > 1 else 1.0
    line = log["line"]
    rates = (np.gradient(values, t, axis=0) if len(t) > 1 else np.zeros_like(values) for values in (q_r, q))
    qd_r, qd = rates
    gathered = Accumulator(period)
    gathered.update(
        contour_error=log["contour_error"],
        orientation_error=log["orientation_error"],
        lag=log["lag"],
        counted=_row(log, "counted", line > 0),
        line=line,
        q_r=q_r,
        qd_r=qd_r,
        q=q,
        qd=qd,
        u=_row(log, "u"),
        saturated=_row(log, "saturated"),
    )
    return Measured(gathered.result(), log.joint_word)


def _measure_runs(log) -> MeasuredRuns:
    count, told = log.dataset.sizes["run"], log.runs
    metrics = log.metrics or nested(columns([measure(log.run(i)).metrics for i in range(count)]))
    label = [str(told[i].get("label", i)) if i < len(told) else str(i) for i in range(count)]
    return MeasuredRuns(metrics, label, [told[i].get("reason", "") if i < len(told) else "" for i in range(count)])


def _row(log, name, default=None):
    return log[name] if name in log else default  # noqa: SIM401, a Log has no get
