"""An ellipse, or a part of one, or several turns."""

from __future__ import annotations

from typing import Literal

import numpy as np

from ...declare import Array, quantity
from ...frames import rotation_of_abc_np
from .. import blocks
from ..base import Program
from ..path import Path
from . import options


class Ellipse(Program):
    """An ellipse about `center` with the half axes `first` along x and `second` along y of its plane."""

    first: float = quantity("m", "half axis along x", above=0)
    second: float = quantity("m", "half axis along y", above=0)
    feed: float = options.feed()
    center: Array = options.center()
    start: float = quantity("rad", "parameter phi of the first point", default=0.0)
    turns: float = quantity("", "turns", default=1.0, above=0, at_most=1000)
    direction: Literal["ccw", "cw"] = options.direction()
    plane: Array = options.plane()
    abc: Array = options.abc()

    def path(self) -> Path:
        R = rotation_of_abc_np(self.plane)
        back = 1 if self.direction == "ccw" else -1
        curve = blocks.Ellipse(
            tuple(self.center),
            tuple(self.first * R[:, 0]),
            tuple(back * self.second * R[:, 1]),
            back * self.start,
            2 * np.pi * self.turns,
        )
        return Path([blocks.Block(curve, tuple(self.abc), tuple(self.abc), self.feed)])
