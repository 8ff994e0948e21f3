"""What figures and page both need from logs: names, units for the eye, thinned rows, circles, planes."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..errors import LogError
from ..log import Log
from ..units import factor

LIMIT = 4000  # points of a line: two for each pixel of the widest chart


def as_logs(logs: Log | Iterable[Log]) -> list[Log]:
    """One log or several, as a list.

    Raises
    ------
    LogError
        there is none, or one holds a batch of runs.
    """
    out = [logs] if isinstance(logs, Log) else list(logs)
    if not out:
        raise LogError("there is no log to report")
    for log in out:
        if "run" in log.dataset.dims:
            raise LogError("holds a batch of runs", key="run", cure="pick one: log.run(0); log.plot.spread() shows all")
    return out


def labels(logs: Sequence[Log]) -> list[str]:
    """A name for each log: its controller; numbered where two have the same."""
    names = [str(log.info.get("controller_name") or log.info.get("controller_kind") or "log") for log in logs]
    count, seen, out = Counter(names), Counter(), []
    for name in names:
        seen[name] += 1
        out.append(f"{name}_{seen[name]}" if count[name] > 1 else name)
    return out


def human(name: str) -> str:
    """ "computed_torque" -> "computed torque", "pid" -> "PID"."""
    return re.sub(r"\bpid\b", "PID", name.replace("_", " "))


def thin(y: np.ndarray, limit: int = LIMIT) -> np.ndarray:
    """Rows of (n,) to draw, at most `limit` of them, rising: first, last, and of each bin the smallest and the largest.

    The extremes of y are always among them.  A bin with a value that is not finite keeps one such row, so that the
    line has its gap.
    """
    y = np.asarray(y, float)
    n = len(y)
    if n <= limit:
        return np.arange(n)
    width = -(-n // max(1, (limit - 4) // 3))  # up to three rows a bin, four at the ends
    whole = n // width * width
    bins = y[:whole].reshape(-1, width)
    start = np.arange(0, whole, width)
    bad = ~np.isfinite(bins)
    low = start + np.argmin(np.where(bad, np.inf, bins), axis=1)
    high = start + np.argmax(np.where(bad, -np.inf, bins), axis=1)
    gap = (start + np.argmax(bad, axis=1))[bad.any(axis=1)]
    rest = y[whole:]
    tail = [whole + k for k in (np.argmin(rest), np.argmax(rest))] if len(rest) else []
    return np.unique(np.concatenate([[0], low, high, gap, tail, [n - 1]]).astype(int))


class Scale(NamedTuple):
    """A unit for the eye: values times `times` are in `unit`."""

    unit: str
    times: float


_STEPS = {
    "m": (("nm", 1e-9), ("µm", 1e-6), ("mm", 1e-3), ("m", 1.0)),
    "rad": (("nrad", 1e-9), ("µrad", 1e-6), ("mrad", 1e-3), ("rad", 1.0)),
    "N": (("mN", 1e-3), ("N", 1.0), ("kN", 1e3)),
    "m/s": (("µm/s", 1e-6), ("mm/s", 1e-3), ("m/s", 1.0)),
    "s": (("µs", 1e-6), ("ms", 1e-3), ("s", 1.0)),
}


def scale_for(values: Any, si_unit: str) -> Scale:
    """The unit in which the largest of `values` is at least one: one scale for everything shown together."""
    values = np.abs(np.atleast_1d(np.asarray(values, float)))
    values = values[np.isfinite(values)]
    largest = values.max() if values.size else 0.0
    steps = _STEPS.get(si_unit)
    if not steps:
        return Scale(si_unit, 1 / factor(si_unit))
    fitting = [step for step in steps if largest >= 0.9999 * step[1]]
    plain = next(step for step in steps if step[1] == 1.0)
    unit, size = (fitting[-1] if fitting else steps[0]) if largest > 0 else plain
    return Scale(unit, 1 / size)


def counted(log: Log) -> np.ndarray:
    """Whether each row is of a feed move, which the metrics count; all rows of a log that does not say.  (n,) bool."""
    return log["counted"] == 1 if "counted" in log else np.ones(len(log), bool)


def force_range(logs: Iterable[Log]) -> tuple[float, float] | None:
    """Smallest and largest force of all logs, N, for one scale in pictures that are compared; None if there is none."""
    values = [log["u"][np.isfinite(log["u"])] for log in logs if "u" in log]
    values = np.concatenate([v.ravel() for v in values]) if values else np.zeros(0)
    return (float(values.min()), float(values.max())) if values.size else None


def with_margin(span: tuple[float, float]) -> list[float]:
    """The ends of an axis that shows `span` with a little room."""
    room = 0.05 * (span[1] - span[0]) or 0.05 * abs(span[1]) or 1.0
    return [span[0] - room, span[1] + room]


def spans(flags: np.ndarray, t: np.ndarray) -> list[tuple[float, float]]:
    """Times from and to where `flags` (n,) holds."""
    flags = np.concatenate([[False], np.asarray(flags, bool), [False]])
    edges = np.flatnonzero(flags[1:] != flags[:-1]).reshape(-1, 2)
    return [(float(t[a]), float(t[min(b, len(t) - 1)])) for a, b in edges]


class Plane(NamedTuple):
    """The two task axes in which a path extends most, as rows of W."""

    first: int
    second: int
    label: str


def plane_of(points: Iterable[np.ndarray]) -> Plane:
    """The plane to look at paths (n, 3) in; the x y plane unless the path extends more in another."""
    extent = np.zeros(3)
    for p in points:
        finite = p[np.isfinite(p).all(axis=1)]
        if len(finite):
            extent = np.maximum(extent, np.ptp(finite, axis=0))
    flattest = 2 - int(np.argmin(extent[::-1]))  # z of equals
    first, second = (i for i in range(3) if i != flattest)
    return Plane(first, second, f"{'xyz'[first]}{'xyz'[second]}")


def tip(log: Log, name: str = "x") -> np.ndarray:
    """Tool tip in W, (n, 3) m, of machines whose first three task coordinates are x y z; fewer are filled with 0."""
    parts = str(log.dataset[name].attrs.get("components", "")).split(", ") if name in log else []
    out = np.zeros((len(log), 3))
    for i, axis in enumerate("xyz"):
        if axis in parts:
            out[:, i] = log[name][:, parts.index(axis)]
    return out


class Circle(NamedTuple):
    """A circle of a program as driven: angles about its axis and signed radial errors of its rows."""

    number: int
    line: int
    radius: float
    feed: float
    angle: np.ndarray
    error: np.ndarray
    axes: tuple[str, str]  # of W, to the right and up on the paper, nearly

    @property
    def full(self) -> bool:
        """Whether it was driven nearly all round: more than 340 degrees of rows with finite numbers."""
        angle = np.unwrap(self.angle[np.isfinite(self.angle)])
        return bool(len(angle)) and float(np.ptp(angle)) > np.deg2rad(340)


def circles(log: Log) -> list[Circle]:
    """The circles of a log that have rows."""
    if "circle" not in log or "radial_error" not in log:
        return []
    number, p, out = log["circle"], tip(log), []
    for entry in log.info.get("circles") or []:
        rows = np.flatnonzero(number == entry["id"])
        if not len(rows):
            continue
        e1, e2, axes = _axes(np.asarray(entry["normal"], float))
        r = p[rows] - np.asarray(entry["center"], float)
        angle = np.arctan2(r @ e2, r @ e1)
        out.append(
            Circle(
                int(entry["id"]),
                int(entry.get("line") or 0),
                float(entry["radius"]),
                float(entry.get("feed") or 0),
                angle,
                log["radial_error"][rows],
                axes,
            )
        )
    return out


def circle_numbers(logs: Iterable[Log]) -> list[int]:
    """Numbers of the circles worth a picture: the full ones; if there is none, the arcs."""
    found = [circle for log in logs for circle in circles(log)]
    return sorted({c.number for c in found if c.full} or {c.number for c in found})


# right on the paper for a circle seen against the x, y or z axis, so that z is up where it can be
_RIGHT = (((0, 1, 0), ("+y", "+z")), ((-1, 0, 0), ("-x", "+z")), ((1, 0, 0), ("+x", "+y")))


def _axes(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray, tuple[str, str]]:
    """Right and up on the paper, and their names, for a circle seen against the axis its normal is nearest to."""
    main = int(np.argmax(np.abs(normal)))
    normal = normal * np.sign(normal[main]) / np.linalg.norm(normal)
    right, names = _RIGHT[main]
    right = np.asarray(right, float)
    right = right - right @ normal * normal
    right /= np.linalg.norm(right)
    return right, np.cross(normal, right), names


def path_rows(error: np.ndarray) -> np.ndarray:
    """Rows of a path to draw, at most LIMIT: half for its shape, evenly, half for its errors, their extremes kept."""
    even = np.linspace(0, len(error) - 1, min(len(error), LIMIT // 2)).astype(int)
    return np.union1d(even, thin(error, LIMIT // 2))


def magnification(radius: float, errors: Iterable[np.ndarray]) -> float:
    """The 1-2-5 step that draws the largest of the errors as at most 0.3 radii; 1 if there is none."""
    largest = 0.0
    for error in errors:
        finite = np.abs(error[np.isfinite(error)])
        largest = max(largest, float(finite.max()) if finite.size else 0.0)
    if largest <= 0:
        return 1.0
    wanted = 0.3 * radius / largest
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(next(step for step in (5, 2, 1) if step * power <= wanted * (1 + 1e-12)) * power)


def magnified(circle: Circle, times: float) -> tuple[np.ndarray, np.ndarray]:
    """Points of the driven circle with its radial error drawn `times` as large: right and up, (n,) m."""
    radius = circle.radius + times * circle.error
    return radius * np.cos(circle.angle), radius * np.sin(circle.angle)


def reversals(log: Log, largest: int = 2000) -> list[dict[str, Any]]:
    """The velocity reversals of a log in order of time; of more than `largest` those with the largest glitch."""
    found = [entry for entry in log.info.get("reversals") or [] if isinstance(entry.get("time"), int | float)]
    found = sorted(found, key=lambda entry: -(entry.get("glitch") or 0.0))[:largest]
    return sorted(found, key=lambda entry: entry["time"])
