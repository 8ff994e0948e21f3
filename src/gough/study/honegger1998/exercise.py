"""The motion to learn from: straight lines between corners of a cube of 0.2 m, there and back without a plan.

Figure 6 of the paper is learned from "a simple translational movement".  Translations without turns show no inertia:
with w = w' = 0 the last three columns of (11) are zero, whatever is driven.  `turn` adds rotations along the lines.
"""

from __future__ import annotations

import numpy as np
from pydantic import Field

from ...declare import quantity
from ...program.base import Program
from ...program.blocks import Block, Line
from ...program.path import Path

CORNERS = 24
HALF, SPREAD = 0.1, 0.02  # m
SEED = 0


class Exercise(Program):
    """CORNERS points near the corners of a cube about program zero, `rounds` times."""

    feed: float = quantity("m/s", "speed along the lines", default=0.4, above=0)
    turn: float = quantity("rad", "the angles a b c at the points are up to so much of either sign", default=0.0)
    rounds: int = Field(1, ge=1, le=10_000, description="how often")

    def points(self) -> tuple[np.ndarray, np.ndarray]:
        """Points m and angles rad of one round, from and to program zero.  (CORNERS, 3) each."""
        rng = np.random.default_rng(SEED)
        points = rng.choice([-HALF, HALF], (CORNERS, 3)) + rng.uniform(-SPREAD, SPREAD, (CORNERS, 3))
        angles = self.turn * rng.uniform(-1, 1, (CORNERS, 3))
        points[0] = angles[0] = 0
        return points, angles

    def path(self) -> Path:
        points, angles = ([tuple(row) for row in part.tolist()] for part in self.points())
        order = [i for _ in range(self.rounds) for i in range(CORNERS)] + [0]
        return Path([
            Block(Line(points[a], points[b]), angles[a], angles[b], self.feed)
            for a, b in zip(order[:-1], order[1:], strict=True)
        ])  # fmt: skip
