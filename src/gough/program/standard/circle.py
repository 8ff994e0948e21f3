"""A circle, or a part of one, or several turns."""

from __future__ import annotations

from typing import Literal

import numpy as np

from ...declare import Array, quantity
from ...frames import rotation_of_abc_np
from ..base import Program
from ..blocks import Arc, Block
from ..path import Path
from . import options


class Circle(Program):
    """A circle about `center`, from the angle `start` (from x towards y of its plane) on for `turns` turns."""

    radius: float = quantity("m", "radius", above=0)
    feed: float = options.feed()
    center: Array = options.center()
    start: float = quantity("rad", "angle of the first point", default=0.0)
    turns: float = quantity("", "turns, 0.5 is half a circle", default=1.0, above=0, at_most=1000)
    direction: Literal["ccw", "cw"] = options.direction()
    plane: Array = options.plane()
    abc: Array = options.abc()

    def path(self) -> Path:
        R = rotation_of_abc_np(self.plane)
        first = self.center + self.radius * (np.cos(self.start) * R[:, 0] + np.sin(self.start) * R[:, 1])
        sweep = 2 * np.pi * self.turns * (1 if self.direction == "ccw" else -1)
        arc = Arc(tuple(first), tuple(self.center), tuple(R[:, 2]), sweep)
        return Path([Block(arc, tuple(self.abc), tuple(self.abc), self.feed)], circle_from=0.0)
