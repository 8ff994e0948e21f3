"""Which poses a map is of: some coordinates of the task run over ranges, the others stand still."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..errors import ExperimentError, did_you_mean
from ..quantities import brief, with_unit

MOST = 20_000_000  # poses of a map: 160 MB a variable


class Axis(NamedTuple):
    """A coordinate that runs."""

    name: str
    unit: str
    values: np.ndarray  # (k,) rising


class Grid(NamedTuple):
    """The axes in the order of the map's dimensions, and the pose that holds the other coordinates."""

    axes: tuple[Axis, ...]
    fixed: np.ndarray  # (d,)
    columns: tuple[int, ...]  # of the axes in a pose

    @property
    def shape(self) -> tuple[int, ...]:
        return tuple(len(axis.values) for axis in self.axes)

    @property
    def count(self) -> int:
        return int(np.prod(self.shape))

    def poses(self, start: int, stop: int) -> np.ndarray:
        """Poses start to stop of the map, the last axis running fastest.  (stop - start, d)."""
        x = np.tile(self.fixed, (stop - start, 1))
        for column, axis, index in zip(
            self.columns, self.axes, np.unravel_index(np.arange(start, stop), self.shape), strict=True
        ):
            x[:, column] = axis.values[index]
        return x


def middle_of(machine) -> np.ndarray:
    """The pose in the middle of the declared workspace, turned as home; home where none is declared.  (d,)."""
    x, space = np.array(machine.home, float), machine.limits.workspace
    if space is not None and space.middle is not None and len(x) >= 3:
        x[:3] += space.middle
    return x


def ranges_of(machine) -> dict[str, tuple[float, float]]:
    """Range of each coordinate that the sheet gives: the box around the declared workspace, or an axis' travel."""
    space, middle = machine.limits.workspace, middle_of(machine)
    if len(middle) == 1:
        return {machine.task[0][0]: tuple(map(float, machine.limits.travel))} if space is None else {}
    if space is None:
        return {}
    half = [*([space.radius] * 2 if space.size is None else space.size / 2), space.height / 2]
    half += [space.tilt, space.tilt, space.c][: len(middle) - 3]
    return {name: (float(at - h), float(at + h)) for (name, _), at, h in zip(machine.task, middle, half, strict=True)}


def grid_of(
    machine,
    over: Sequence[str] | Mapping[str, tuple[float, float] | None] | None = None,
    at: Mapping[str, float] | None = None,
    points: int | Sequence[int] = 41,
) -> Grid:
    """The grid of a map.

    Parameters
    ----------
    over : names of the coordinates that run, or {name: (least, greatest) or None}, m and rad; None: x and y (or the
        only one).  Without a range a coordinate runs over the declared workspace.
    at : {name: m or rad} of coordinates that stand still elsewhere than in the middle of the workspace.
    points : of every coordinate that runs, or one number each.

    Raises
    ------
    ExperimentError
        no such coordinate, one that both runs and stands, no range, too many or too few points.
    """
    names = [name for name, _ in machine.task]
    at = dict(at or {})
    if over is None:
        over = [name for name in names[:2] if name not in at] or [name for name in names if name not in at][:1]
    runs = dict(over) if isinstance(over, Mapping) else dict.fromkeys(over)
    for key, given in (("over", runs), ("at", at)):
        for name in given:
            if name not in names:
                told = did_you_mean(str(name), names)
                raise ExperimentError("the machine has no such coordinate", key=key, value=brief(name), cure=told)
    both = [name for name in runs if name in at]
    if both:
        raise ExperimentError("runs already", key="at", value=both[0], cure=f"leave {both[0]} out of over, or of at")
    if not runs:
        raise ExperimentError("a map needs a coordinate that runs", key="over", cure=f"give some of {', '.join(names)}")
    counts = [points] * len(runs) if isinstance(points, int | np.integer) else list(points)
    if len(counts) != len(runs):
        cure = f"give one number, or {len(runs)}"
        raise ExperimentError("one number for each coordinate that runs", key="points", value=brief(points), cure=cure)
    for count in counts:
        if isinstance(count, bool) or not isinstance(count, int | np.integer) or count < 2:
            raise ExperimentError("at least 2 points", key="points", value=brief(count))
    total = math.prod(int(count) for count in counts)
    if total > MOST:
        raise ExperimentError("too many poses", key="points", value=f"{total}", limit=f"{MOST}")
    known, fixed, axes = ranges_of(machine), middle_of(machine), []
    for name, value in at.items():
        fixed[names.index(name)] = _number("at", name, value)
    for (name, span), count in zip(runs.items(), counts, strict=True):
        if span is None and name not in known:
            raise ExperimentError(
                f"the range of {name} is missing: {machine.name} declares no workspace", key="over",
                cure=f'give one, as {name} = (-0.1, 0.1), on the command line "{name}=-0.1 m..0.1 m"',
            )  # fmt: skip
        low, high = (_number("over", name, end) for end in (known[name] if span is None else _pair(name, span)))
        unit = machine.task[names.index(name)][1]
        if not low < high:
            value = f"{with_unit(low, unit)} to {with_unit(high, unit)}"
            empty = "the workspace has no extent here: give a range" if span is None else "the least comes first"
            raise ExperimentError(empty, key=f"over.{name}", value=value)
        axes.append(Axis(name, unit, np.linspace(low, high, count)))
    return Grid(tuple(axes), fixed, tuple(names.index(axis.name) for axis in axes))


def _pair(name: str, span: Any) -> tuple[Any, Any]:
    try:
        low, high = span
    except (TypeError, ValueError):
        raise ExperimentError("a range is two numbers", key=f"over.{name}", value=brief(span)) from None
    return low, high


def _number(key: str, name: str, value: Any) -> float:
    number = float(value) if isinstance(value, int | float | np.number) and not isinstance(value, bool) else np.nan
    if not np.isfinite(number):
        raise ExperimentError("must be a finite number", key=f"{key}.{name}", value=brief(value))
    return number
