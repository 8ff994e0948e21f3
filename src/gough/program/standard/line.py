"""A straight line, one way or there and back."""

from __future__ import annotations

import numpy as np
from pydantic import Field

from ...declare import Array, quantity
from ..base import Program
from ..path import Path
from . import options
from .polyline import Polyline


class Line(Program):
    """A straight line, there and, with `back`, back again."""

    to: Array = quantity("m", "last point", shape=(3,))
    begin: Array = quantity("m", "first point", default=(0.0, 0.0, 0.0), shape=(3,))
    back: bool = Field(False, description="come back to the first point")
    feed: float = options.feed()
    abc: Array = options.abc()

    def path(self) -> Path:
        points = [self.begin, self.to, self.begin][: 3 if self.back else 2]
        return Polyline(points=np.array(points), feed=self.feed, abc=self.abc).path()
