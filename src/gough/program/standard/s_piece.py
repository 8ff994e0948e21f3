"""An S-shaped wall milled with the flank of the tool: the idea of S-shaped five-axis test pieces, a surface of ours.

The wall is ruled between two S-shaped curves.  With th = 2 pi u, u from 0 to 1, its lower curve is
    x = width / 2 sin th,    y = length (u - 1/2) - bow sin 2 th,    z = 0,                                         (1)
and its upper one lies at the height h above, moved aside by
    h tan(lean) (sin(th) / 2, cos th),                                                                             (2)
whose length is at most h tan(lean): so far, `lean`, the tool leans at the ends and in the middle, half as far (its
tangent) at the bends, and always to another side.
"""

from __future__ import annotations

import math

import numpy as np

from ...declare import Array, quantity
from ..base import Program
from ..path import Path
from . import options
from .flank import Flank


class SPiece(Program):
    """An S-shaped wall, its lower curve run once by the tip of a tool that lies along the rulings."""

    length: float = quantity("m", "from the start to the end", default=0.2, above=0, at_most=100)
    width: float = quantity("m", "from bend to bend", default=0.12, above=0, at_most=100)
    bow: float = quantity("m", "how far the bends are pulled over", default=0.02, at_least=0, at_most=100)
    height: float = quantity("m", "height of the wall", default=0.03, above=0, at_most=100)
    lean: float = quantity(
        "rad", "largest angle between the tool and z", default=math.radians(18), at_least=0, at_most=math.radians(80)
    )
    center: Array = options.center("middle of the lower curve", (0.0, 0.0, -0.04))
    feed: float = options.feed()
    chord: float = quantity("m", "how far the short lines may leave the surface", default=5e-6, above=0)
    approach: float = quantity(
        "m", "length of the tangents at the start and the end", default=0.01, above=0, at_most=100
    )
    clearance: float = quantity("m", "length of the rapids along the tool", default=0.05, above=0, at_most=100)

    def path(self) -> Path:
        return self.flank().path(self.chord, self.feed, self.tolerance, self.approach, self.clearance)

    def flank(self) -> Flank:
        """The surface the tool follows."""

        def tip(u):
            th = 2 * math.pi * u
            x = self.width / 2 * np.sin(th)
            y = self.length * (u - 0.5) - self.bow * np.sin(2 * th)
            return self.center + np.column_stack([x, y, np.zeros_like(u)])

        def axis(u):
            th, t = 2 * math.pi * u, math.tan(self.lean)
            n = np.column_stack([t * np.sin(th) / 2, t * np.cos(th), np.ones_like(u)])
            return n / np.linalg.norm(n, axis=1)[:, None]

        return Flank(tip, axis, self.height)
