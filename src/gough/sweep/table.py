"""The lines of a sweep as columns: draw, point, controller, settings, how it ended and every metric; and the index.

    number, draw, point, controller, kind, id, status, reason      one line a draw, point of the grid and controller
    set.NAME                                                       number of a factor in the unit that it is written in
    limit_hit, limit_hit.time                                      the limit that ended the run, and when, s
    spectral_radius                                                of the loop at home, a sample; above 1 it grows
    NAME                                                           metric in SI units; NaN where the run has none

The index is these columns as Parquet.  It is made of the runs' files and can be made again; nothing is read from it.
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..errors import LogError
from ..files import write_atomic
from ..measure.tree import told
from .factors import Factor
from .run import Swept

_WRITTEN = re.compile(r"\s*([+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?)\s*(.*?)\s*")


class Axis(NamedTuple):
    """A factor along its values: numbers in a unit, or words."""

    key: str
    unit: str
    words: tuple[str, ...]  # where values are no numbers: what 0, 1, ... stand for


class Lines(NamedTuple):
    """A sweep as columns, all (n,)."""

    draw: np.ndarray
    point: np.ndarray
    controller: np.ndarray
    ids: list[str]
    status: np.ndarray  # of texts
    reason: list[str]
    axes: list[Axis]
    limit: list[str]  # that ended the run; "" where none did
    limit_time: np.ndarray  # s
    radius: np.ndarray  # spectral, a sample; NaN where the run was not begun
    values: np.ndarray  # (factors, n)
    metrics: dict[str, np.ndarray]

    def metric(self, name: str) -> np.ndarray:
        """A metric of every line; NaN where the run failed or has none."""
        values = self.metrics.get(name, np.full(len(self.ids), np.nan))
        return np.where(self.status == "done", values, np.nan)


def lines_of(swept: Swept) -> Lines:
    """The columns of a sweep."""
    rows, factors = swept.rows, swept.design.factors
    records = [swept.records[row.job.id] for row in rows]
    names = list(dict.fromkeys(name for record in records for name in record["metrics"]))
    metrics = {
        name: np.array([math.nan if (v := r["metrics"].get(name)) is None else v for r in records], float)
        for name in names
    }
    axes, values = [], np.full((len(factors), len(rows)), np.nan)
    grid, machines = swept.design.grid(), swept.design.machines()
    for k, factor in enumerate(factors):
        axis = axis_of(factor)
        axes.append(axis)
        known = machines if factor.distribution is not None else grid
        numbers = [_number(axis, settings[factor.names[0]]) for settings in known]
        at = [row.draw if factor.distribution is not None else row.point for row in rows]
        values[k] = np.array(numbers)[at] if at else []
    hit = [record.get("limit_hit") or {} for record in records]
    return Lines(
        np.array([row.draw for row in rows]), np.array([row.point for row in rows]),
        np.array([row.job.controller for row in rows]), [row.job.id for row in rows],
        np.array([record["status"] for record in records]), [record["reason"] for record in records], axes,
        [one.get("limit", "") for one in hit], np.array([one.get("time", math.nan) for one in hit], float),
        np.array([_known(record.get("spectral_radius")) for record in records], float), values, metrics,
    )  # fmt: skip


def _known(value: float | None) -> float:
    return math.nan if value is None else value


def axis_of(factor: Factor) -> Axis:
    """How the values of a factor lie along an axis."""
    if factor.distribution is not None:
        return Axis(factor.key, factor.distribution.unit, ())
    split = [_split(value) for value in factor.values]
    if all(split) and len({unit for _, unit in split}) == 1:
        return Axis(factor.key, split[0][1], ())
    return Axis(factor.key, "", tuple(str(value) for value in factor.values))


def _split(value: Any) -> tuple[float, str] | None:
    """Number and unit of a value as a file writes it."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        return float(value), ""
    match = _WRITTEN.fullmatch(value) if isinstance(value, str) else None
    return (float(match[1]), match[2]) if match else None


def _number(axis: Axis, value: Any) -> float:
    return float(axis.words.index(str(value))) if axis.words else _split(value)[0]


def write_index(swept: Swept, lines: Lines, path: Path) -> Path:
    """Write the index as Parquet.

    Raises
    ------
    LogError
        pyarrow is not installed.
    StorageError
        the file could not be written.
    """
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        raise LogError("the index needs pyarrow", cure="pip install 'gough[logs]'") from None
    labels = swept.experiment.labels
    columns: list[tuple[str, str, Any]] = [
        ("number", "1", np.arange(len(lines.ids))), ("draw", "1", lines.draw), ("point", "1", lines.point),
        ("controller", "1", lines.controller), ("kind", "", [labels[i] for i in lines.controller]),
        ("id", "", lines.ids), ("status", "", lines.status.tolist()), ("reason", "", lines.reason),
    ]  # fmt: skip
    for axis, values in zip(lines.axes, lines.values, strict=True):
        shown = [axis.words[int(v)] for v in values] if axis.words else values
        columns.append((f"set.{axis.key}", axis.unit or ("" if axis.words else "1"), shown))
    columns += [
        ("limit_hit", "", lines.limit), ("limit_hit.time", "s", lines.limit_time),
        ("spectral_radius", "1", lines.radius),
    ]  # fmt: skip
    columns += [(name, told(name)[0], values) for name, values in lines.metrics.items()]
    arrays = [pa.array(values) for _, _, values in columns]
    fields = [
        pa.field(name, array.type, metadata={"units": unit})
        for (name, unit, _), array in zip(columns, arrays, strict=True)
    ]
    table = pa.table(arrays, schema=pa.schema(fields, metadata={"schema": "gough-sweep-index-1"}))
    return write_atomic(path, lambda temporary: pq.write_table(table, temporary))
