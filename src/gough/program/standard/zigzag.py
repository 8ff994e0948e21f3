"""Corners of several angles behind one another: lines that turn to the left and to the right in turn."""

from __future__ import annotations

import numpy as np
from pydantic import Field

from ...declare import Array, quantity
from ...errors import ExperimentError
from ..base import Program
from ..blocks import Block, Line, Rest
from ..path import Path
from . import options


class Zigzag(Program):
    """Lines of one length; the direction changes by the first angle to the left, by the second to the right, and so on.

    The first line runs along x of the plane; the middle of the path's extent along x and y stands at `center`.
    """

    side: float = quantity("m", "length of each line", default=0.03, above=0, at_most=100)
    angles: Array | float = quantity(
        "rad", "changes of direction at the corners", default=np.radians([30, 60, 90, 120, 150]).tolist(), shape=(-1,),
        above=0, below=np.pi,
    )  # fmt: skip
    back: bool = Field(False, description="come back along the same corners")
    feed: float = options.feed()
    center: Array = options.center("middle of the path")
    plane: Array = options.plane()
    pause: float = quantity("s", "rest in each corner", default=0.0, at_least=0, at_most=3600)
    abc: Array = options.abc()

    def model_post_init(self, context) -> None:
        if not np.size(self.angles):
            raise ExperimentError("is empty", key="angles", cure="give one angle or more")

    def path(self) -> Path:
        angles = np.atleast_1d(self.angles)
        turns = angles * (-1.0) ** np.arange(len(angles))
        heading = np.concatenate([[0.0], np.cumsum(turns)])
        steps = self.side * np.column_stack([np.cos(heading), np.sin(heading)])
        corners = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, 0)])
        corners -= (corners.min(0) + corners.max(0)) / 2
        points = [tuple(row) for row in options.in_plane(self, corners).tolist()]
        if self.back:
            points += points[-2::-1]
        abc, out = tuple(self.abc.tolist()), []
        for k, (a, b) in enumerate(zip(points[:-1], points[1:], strict=True)):
            if k and self.pause:
                out.append(Block(Rest(a), abc, abc, dwell=self.pause))
            out.append(Block(Line(a, b), abc, abc, self.feed))
        return Path(out)
