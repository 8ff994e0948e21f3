"""Straight lines from point to point."""

from __future__ import annotations

import numpy as np
from pydantic import Field

from ...declare import Array
from ...errors import InputError
from ...quantities import Quantity
from ..base import Program
from ..blocks import Block, Line
from ..path import Path
from . import options


class _Points(Quantity):
    """A list of at least two points: a quantity of shape (n, 3)."""

    def check(self, raw, from_file):
        value = np.array(self._si(raw, from_file), float)
        if value.ndim != 2 or value.shape[1] != 3 or len(value) < 2:
            shape = " x ".join(map(str, value.shape)) or "one number"
            raise InputError("must be two or more points of x y z", value=shape)
        if not np.isfinite(value).all():
            raise InputError("must be finite")
        value.setflags(write=False)
        return value


class Polyline(Program):
    """Straight lines from point to point, with the corners that `corner` says."""

    points: Array = Field(
        description="the points",
        json_schema_extra={"quantity": _Points("m", "two or more points"), "theta": False},
    )
    feed: float = options.feed()
    abc: Array = options.abc()

    def path(self) -> Path:
        points, abc = [tuple(row) for row in self.points.tolist()], tuple(self.abc.tolist())
        return Path([Block(Line(a, b), abc, abc, self.feed) for a, b in zip(points[:-1], points[1:], strict=True)])
