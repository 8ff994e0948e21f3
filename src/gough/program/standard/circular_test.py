"""Circular tests in the manner of ISO 230-4: one circle, both ways, with a run-in and a run-out.

The tool runs `overlap` degrees of the circle before the angle `start`, so that the machine has its feed and its
transients are over when the circle proper begins, then the full circle, then `overlap` degrees more.  The way back runs
from where the way there ended.  Ball-bar tests use half a circle of overlap.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from ...declare import Array, quantity
from ...frames import rotation_of_abc_np
from ..base import Program
from ..blocks import Arc, Block, Rest
from ..path import Path
from . import options


class CircularTest(Program):
    """A circle about `center` in any plane, run counter-clockwise and then clockwise."""

    radius: float = quantity("m", "radius", above=0, at_most=100)
    feed: float = options.feed()
    center: Array = options.center("centre of the circle")
    plane: Array = options.plane()
    start: float = quantity("rad", "angle, from x towards y of the plane, where the circle proper begins", default=0.0)
    overlap: float = quantity(
        "rad", "run-in before the circle and run-out behind it", default=np.pi, at_least=0, at_most=2 * np.pi
    )
    pause: float = quantity("s", "rest between the two ways", default=0.5, at_least=0, at_most=3600)
    direction: Literal["both", "ccw", "cw"] = options.both_directions()
    abc: Array = options.abc()

    def path(self) -> Path:
        R, abc = rotation_of_abc_np(self.plane), tuple(self.abc.tolist())
        sweep = 2 * np.pi + 2 * self.overlap

        def at(angle):
            return tuple(self.center + self.radius * (np.cos(angle) * R[:, 0] + np.sin(angle) * R[:, 1]))

        def run(first, sweep):
            return Block(Arc(at(first), tuple(self.center), tuple(R[:, 2]), sweep), abc, abc, self.feed)

        there, back = run(self.start - self.overlap, sweep), run(self.start + self.overlap, -sweep)
        if self.direction != "both":
            return Path([there if self.direction == "ccw" else back])
        pause = [Block(Rest(at(self.start + self.overlap)), abc, abc, dwell=self.pause)] if self.pause else []
        return Path([there, *pause, back])
