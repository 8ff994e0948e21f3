"""A circle-diamond-square test piece, after the contouring test pieces of ISO 10791-7 and NAS 979.

A square, in it a square turned by 45 degrees (the diamond) that touches the middles of its sides, in that a circle.
Each is milled round once at its own depth; the circle twice, first clockwise and then counter-clockwise, so that its
polar plot shows both directions.  Rapids lead from one to the next, at the height `clearance`.
"""

from __future__ import annotations

import math

from ...declare import quantity
from ...errors import ExperimentError
from ..base import Program
from ..blocks import Arc, Block, Line
from ..path import Path
from ..write import to_gcode


class CircleDiamondSquare(Program):
    """The piece about the program's zero; the square's sides lie along x and y, its top at z = 0."""

    side: float = quantity("m", "side of the square", default=0.16, above=0)
    radius: float = quantity("m", "radius of the circle", default=0.05, above=0)
    depth: float = quantity("m", "depth of one level; the square is at the third", default=2e-3, above=0)
    clearance: float = quantity("m", "height of the rapids", default=10e-3, above=0)
    feed: float = quantity("m/s", "speed along the path", above=0)

    def model_post_init(self, context) -> None:
        touching = self.side / math.sqrt(8)
        if self.radius > touching:
            raise ExperimentError(
                "the circle must fit into the diamond",
                key="radius",
                value=f"{self.radius:g} m",
                cure=f"at most {touching:.4g} m for this side",
            )

    def path(self) -> Path:
        half, r, up = self.side / 2, self.radius, self.clearance
        square = [(-half, -half), (half, -half), (half, half), (-half, half), (-half, -half)]
        diamond = [(0.0, -half), (half, 0.0), (0.0, half), (-half, 0.0), (0.0, -half)]
        out: list[Block] = []
        here = [(0.0, 0.0, 0.0)]

        def line(*to, rapid=False):
            out.append(Block(Line(here[0], to), feed=self.feed, rapid=rapid))
            here[0] = to

        def enter(x, y, level):
            line(*here[0][:2], up, rapid=True)
            if (x, y) != here[0][:2]:
                line(x, y, up, rapid=True)
            line(x, y, -level * self.depth)

        for level, corners in ((3, square), (2, diamond)):
            enter(*corners[0], level)
            for x, y in corners[1:]:
                line(x, y, -level * self.depth)
        enter(r, 0.0, 1)
        for sweep in (-2 * math.pi, 2 * math.pi):
            out.append(Block(Arc(here[0], (0.0, 0.0, -self.depth), (0.0, 0.0, 1.0), sweep), feed=self.feed))
        line(*here[0][:2], up, rapid=True)
        return Path(out)

    def to_gcode(self) -> str:
        """The same path as an NC program in mm."""
        return to_gcode(self.path(), "circle-diamond-square")
