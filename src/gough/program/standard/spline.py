"""A smooth curve through points."""

from __future__ import annotations

import numpy as np
from pydantic import Field

from ...declare import Array
from ...errors import ExperimentError, InputError
from ...quantities import Quantity
from ..base import Program
from ..blocks import CURVE, Blocks
from ..path import Path
from ..segments import norm
from ..spline import through
from . import options


class _Rows(Quantity):
    """A list of at least two times three numbers: a quantity of shape (n, 3)."""

    def check(self, raw, from_file):
        value = np.array(self._si(raw, from_file), float)
        if value.ndim != 2 or value.shape[1] != 3 or len(value) < 2:
            shape = " x ".join(map(str, value.shape)) or "one number"
            raise InputError(f"must be {self.meaning}", value=shape)
        if not np.isfinite(value).all():
            raise InputError("must be finite")
        value.setflags(write=False)
        return value


class Spline(Program):
    """A smooth curve through points, by arc length: its direction and curvature have no jump.

    The angles a b c of the tool may be given at every point; they change as smoothly along the curve.
    """

    points: Array = Field(
        description="the points",
        json_schema_extra={"quantity": _Rows("m", "two or more points of x y z"), "theta": False},
    )
    feed: float = options.feed()
    angles: Array | None = Field(
        None,
        description="angles a b c of the tool at the points; zero where left out",
        json_schema_extra={"quantity": _Rows("rad", "two or more times a b c"), "theta": False},
    )
    closed: bool = Field(False, description="run on from the last point to the first, without a corner there")

    def model_post_init(self, context) -> None:
        n = len(self.points)
        if self.angles is not None and len(self.angles) != n:
            raise ExperimentError(
                "there must be as many angles as points", key="angles", value=str(len(self.angles)), limit=str(n)
            )
        if self.closed and n < 3:
            raise ExperimentError("a closed curve has three points at least", key="points", value=str(n))
        steps = norm(np.diff(self.points, axis=0, append=self.points[:1]))[: n if self.closed else n - 1]
        same = np.flatnonzero(steps < 1e-9)
        if len(same):
            k = int(same[0]) + 1
            raise ExperimentError(
                "points that follow each other must differ",
                key="points",
                value=f"points {k} and {k % n + 1} are the same",
                cure="leave one of them out",
            )

    def path(self) -> Path:
        curves, angles = through(self.points, self.angles, self.closed)
        m = len(curves.length)
        none, zero = np.zeros((m, 3)), np.zeros(m)
        columns = {
            "kind": np.full(m, CURVE, np.int8), "index": np.arange(m), "rapid": np.zeros(m, bool),
            "line": np.zeros(m, np.int32), "feed": np.full(m, self.feed), "dwell": zero, "tolerance": zero,
            "spindle": zero, "tool": none, "abc0": none, "abc1": none,
        }  # fmt: skip
        if angles is not None:
            columns |= {"abc0": angles[:, 0], "abc1": angles.sum(1)}
        bent = None if angles is None else (np.arange(m), angles)
        return Path.of(columns, [*Blocks().batches(), curves], bent)
