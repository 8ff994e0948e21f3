"""Squares with sharp corners: what a machine makes of a change of direction by 90 degrees."""

from __future__ import annotations

from typing import Literal

import numpy as np

from ...declare import Array, quantity
from ...errors import ExperimentError
from ..base import Program
from ..blocks import Block, Line, Rest
from ..path import Path
from . import options


class SquareCorners(Program):
    """Squares about `center`, each from the middle of its side at +x on, so that all four corners are alike.

    Several sides: one square behind the other, with a rapid from one to the next.
    """

    side: Array | float = quantity(
        "m", "side of the square, or a list of sides", default=0.1, above=0, at_most=100, shape=(-1,)
    )
    feed: float = options.feed()
    center: Array = options.center("centre of the squares")
    plane: Array = options.plane()
    pause: float = quantity("s", "rest in each corner", default=0.0, at_least=0, at_most=3600)
    direction: Literal["both", "ccw", "cw"] = options.both_directions()
    abc: Array = options.abc()

    def model_post_init(self, context) -> None:
        if not np.size(self.side):
            raise ExperimentError("is empty", key="side", cure="give one side or more")

    def path(self) -> Path:
        abc, out = tuple(self.abc.tolist()), []

        def line(a, b, rapid=False):
            out.append(Block(Line(a, b), abc, abc, self.feed, rapid))

        here = None
        for side in np.atleast_1d(self.side):
            ccw = np.array([[1, 0], [1, 1], [-1, 1], [-1, -1], [1, -1], [1, 0]]) * side / 2
            for corners in {"both": (ccw, ccw[::-1]), "ccw": (ccw,), "cw": (ccw[::-1],)}[self.direction]:
                points = [tuple(row) for row in options.in_plane(self, corners).tolist()]
                if here not in (None, points[0]):
                    line(here, points[0], rapid=True)
                for here, there in zip(points[:-1], points[1:], strict=True):
                    line(here, there)
                    if self.pause and there != points[-1]:
                        out.append(Block(Rest(there), abc, abc, dwell=self.pause))
                here = points[-1]
        return Path(out)
