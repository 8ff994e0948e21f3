"""The table of a report: the one place for its labels, units and formats; and its conclusion in one sentence."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from ..log import Log
from .prepare import Scale, as_logs, human, labels, scale_for

NONE = "–"
STABLE = 1 + 1e-6  # largest spectral radius of a stable loop; simulate/stability.py warns above the same
SATURATED = 0.05  # share of samples with a drive at its limit, above which the drive is judged and not the law


class Row(NamedTuple):
    """One line of the table: a label and a text with unit for each log; `best` are the columns with the best value."""

    label: str
    values: tuple[str, ...]
    best: tuple[int, ...] = ()


class _Line(NamedTuple):
    label: str
    path: tuple[str, ...]  # in the metrics, or in the info behind "info"
    unit: str
    better: bool = False  # whether smaller is better, so that the best is marked


LINES = (
    _Line("contour error, max", ("contour_error", "max"), "m", True),
    _Line("contour error, rms", ("contour_error", "rms"), "m", True),
    _Line("contour error, mean", ("contour_error", "mean"), "m", True),
    _Line("orientation error, max", ("orientation_error", "max"), "rad", True),
    _Line("lag, max", ("lag", "max"), "m", True),
    _Line("velocity reversals", ("reversals", "count"), "count"),
    _Line("largest reversal glitch", ("reversals", "largest"), "m", True),
    _Line("{joint} force, peak", ("strut_force", "peak"), "N"),
    _Line("{joint} velocity, peak", ("strut_velocity", "peak"), "m/s"),
    _Line("drives saturated", ("saturated",), "%"),
    _Line("simulated time", ("info", "simulated_time"), "time"),
    _Line("wall time", ("info", "wall_time"), "time"),
)


def report_table(logs: Log | Iterable[Log]) -> list[Row]:
    """Rows of (label, values): one text with its unit for each log, in their order.  What is not known is "–".

    Raises
    ------
    LogError
        there is no log.
    """
    logs = as_logs(logs)
    rows = []
    if any(log.failed for log in logs):
        rows.append(Row("status", tuple(failed_at(log) or "done" for log in logs)))
    for line in LINES:
        values = [number(log, line.path) for log in logs]
        scale = _scale(line.unit, values)
        best = _best(logs, values) if line.better else ()
        rows.append(
            Row(
                line.label.format(joint=logs[0].joint_word),
                tuple(_shown(value, line.unit, scale) for value in values),
                best,
            )
        )
    return rows


def heads(logs: Log | Iterable[Log]) -> list[str]:
    """The head of each column: the controllers, told apart, and until when those ran that failed."""
    logs = as_logs(logs)
    return [f"{name}, {failed_at(log)}" if log.failed else name for name, log in zip(names(logs), logs, strict=True)]


def names(logs: Log | Iterable[Log]) -> list[str]:
    """The controllers, told apart."""
    return [human(label) for label in labels(as_logs(logs))]


def failed_at(log: Log) -> str:
    """ "FAILED at 13.25 s" of a run that failed, without the time if the log does not tell it; else empty."""
    if not log.failed:
        return ""
    end = number(log, ("info", "simulated_time"))
    return "FAILED" if end is None else f"FAILED at {_time(end)}"


def flaws(log: Log) -> list[str]:
    """Why the errors of a log must not be compared with those of others: it failed, is unstable, or saturated."""
    out = []
    if log.failed:
        end = number(log, ("info", "simulated_time"))
        out.append("the run failed" if end is None else f"the run failed at {_time(end)}")
    radius = number(log, ("info", "run", "spectral_radius"))
    if radius is not None and radius > STABLE:
        shown = f"{radius:.3g}" if radius >= 1.01 else f"{radius:.7g}"  # never the 1 that it is above
        out.append(f"the loop is unstable (spectral radius {shown} a sample)")
    share = number(log, ("saturated",))
    if share is not None and share > SATURATED:
        out.append(f"a drive is at its limit in {100 * share:.3g} % of the samples")
    return out


def number(log: Log, path: Sequence[str]) -> float | None:
    """A number of the metrics, or of the info where the path begins with "info"; None if not there or not finite.

    Of a list of numbers it is the largest.
    """
    value: Any = log.info if path[0] == "info" else log.metrics
    for key in path[1:] if path[0] == "info" else path:
        value = value.get(key) if isinstance(value, dict) else None
    if isinstance(value, list):
        value = max((v for v in value if isinstance(v, int | float)), default=None)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return None
    return value


def worst(log: Log) -> tuple[float, int] | None:
    """Time, s, and NC line of the largest contour error; None if the log has no such line."""
    at, line = number(log, ("contour_error", "at")), number(log, ("contour_error", "line"))
    return (at, int(line)) if at is not None and line else None


def where(logs: Log | Iterable[Log]) -> str:
    """Time and NC line of the largest contour errors, one sentence; empty where no log knows its lines."""
    logs = as_logs(logs)
    found = [(name, worst(log)) for name, log in zip(names(logs), logs, strict=True)]
    told = [f"{name} at {place[0]:.3f} s, NC line {place[1]}" for name, place in found if place]
    return f"Largest contour error: {'; '.join(told)}." if told else ""


def verdict(logs: Log | Iterable[Log]) -> str:
    """Who is better and by how much, or how good the only one is.

    Logs with `flaws` are told first, one sentence each, and are not compared with anything.
    """
    logs = as_logs(logs)
    told, sound = [], []
    for name, log in zip(names(logs), logs, strict=True):
        found = flaws(log)
        if found:
            told.append(f"{name}: {_listed(found)}{'; no comparison' if len(logs) > 1 else ''}.")
        else:
            sound.append((name, number(log, ("contour_error", "rms")), number(log, ("contour_error", "max"))))
    rated = sorted(((n, rms, top) for n, rms, top in sound if rms is not None and top is not None), key=lambda r: r[1])
    if rated:
        told.append(_comparison(rated))
    elif not told:
        told.append("The logs hold no contour error of a feed move.")
    return " ".join(sentence[0].upper() + sentence[1:] for sentence in told)


def _comparison(rated: list[tuple[str, float, float]]) -> str:
    name, rms, top = rated[0]
    if len(rated) == 1:
        scale = scale_for([top], "m")
        return f"{name} kept the tool within {_of(top, scale)} of the programmed path, {_of(rms, scale)} rms."
    other, other_rms, other_top = rated[1]
    scale = scale_for([other_rms, rms], "m")
    numbers = f"contour error {_of(rms, scale)} rms against {_of(other_rms, scale)}"
    scale = scale_for([other_top, top], "m")
    numbers += f", {_of(top, scale)} at most against {_of(other_top, scale)}"
    # a difference of 2 % is less than the third digit shown and than a change of seed makes
    if other_rms <= 1.02 * rms:
        out = f"{name} and {other} follow the path equally well: {numbers}"
    elif rms > 0:
        out = f"{name} follows the path {other_rms / rms:.2g} times as closely as {other}: {numbers}"
    else:
        out = f"{name} follows the path without error: {numbers}"
    if other_rms > 1.02 * rms and top > other_top:
        out += "; but its largest error is the larger one"
    if len(rated) > 2:
        out += f"; {_listed([row[0] for row in rated[2:]])} {'is' if len(rated) == 3 else 'are'} behind both"
    return out + "."


def _scale(unit: str, values: list[float | None]) -> Scale:
    return scale_for([v for v in values if v is not None], unit) if unit in ("m", "rad", "N", "m/s") else Scale(unit, 1)


def _shown(value: float | None, unit: str, scale: Scale) -> str:
    if value is None:
        return NONE
    if unit == "count":
        return f"{value:.0f}"
    if unit == "%":
        return f"{100 * value:.2f} %"
    if unit == "time":
        return _time(value)
    return _of(value, scale)


def _time(value: float) -> str:
    return f"{value:.2f} s" if value >= 1 or not value else f"{value:.3f} s"


def _of(value: float, scale: Scale) -> str:
    """Three digits, no powers of ten: one column reads as one."""
    shown = value * scale.times
    digits = 2 - math.floor(math.log10(abs(shown))) if shown else 2
    return f"{shown:.{min(max(digits, 0), 4)}f} {scale.unit}"


def _best(logs: list[Log], values: list[float | None]) -> tuple[int, ...]:
    """Columns with the smallest value of those without flaws; none if there is no comparison or all are equal."""
    known = {i: v for i, v in enumerate(values) if v is not None and not flaws(logs[i])}
    if len(known) < 2 or len(set(known.values())) == 1:
        return ()
    return tuple(i for i, v in known.items() if v == min(known.values()))


def _listed(names: Sequence[str]) -> str:
    return " and ".join(filter(None, [", ".join(names[:-1]), names[-1]]))
