"""A cone frustum milled with the flank of the tool, after the five-axis test piece of NAS 979.

The frustum's axis leans over by `tilt` from z, the tool's axis by `half_angle` more or less from that of the frustum:
its surface line at the angle phi about the axis m has the direction
    n(phi) = cos(half_angle) m - sin(half_angle) e(phi),                                                           (1)
e(phi) from the axis to the tip.  Over a turn the tool's axis runs round a cone itself, between half_angle + tilt and
|half_angle - tilt| from z.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from ...declare import Array, quantity
from ...errors import ExperimentError
from ..base import Program
from ..path import Path
from . import options
from .flank import Flank


class ConeFrustum(Program):
    """The frustum's lower circle, run once by the tip of a tool that lies along the surface."""

    radius: float = quantity("m", "radius of the lower circle", default=0.08, above=0, at_most=100)
    height: float = quantity("m", "height along the surface", default=0.02, above=0, at_most=100)
    half_angle: float = quantity(
        "rad", "angle between axis and surface", default=math.radians(15), at_least=0, below=math.pi / 2
    )
    tilt: float = quantity(
        "rad", "angle between the frustum's axis and z", default=math.radians(10), at_least=0, below=math.pi / 2
    )
    toward: float = quantity("rad", "where the axis leans to, from x towards y", default=0.0)
    center: Array = options.center("centre of the lower circle", (0.05, 0.0, -0.04))
    start: float = quantity("rad", "angle of the first point, from the lowest on", default=0.0)
    direction: Literal["ccw", "cw"] = options.direction("from above")
    feed: float = options.feed()
    chord: float = quantity("m", "how far the short lines may leave the surface", default=5e-6, above=0)
    approach: float = quantity(
        "m", "length of the tangents at the start and the end", default=0.01, above=0, at_most=100
    )
    clearance: float = quantity("m", "length of the rapids along the tool", default=0.05, above=0, at_most=100)

    def model_post_init(self, context) -> None:
        if self.half_angle + self.tilt > math.radians(80):
            raise ExperimentError(
                "half_angle and tilt together lean the tool over by more than 80 deg",
                key="tilt",
                value=f"{math.degrees(self.tilt):g} deg",
                cure=f"at most {80 - math.degrees(self.half_angle):.4g} deg for this half_angle",
            )
        tip = self.radius / math.sin(self.half_angle) if self.half_angle else math.inf
        if self.height > tip:
            raise ExperimentError(
                "the frustum ends in its tip",
                key="height",
                value=f"{self.height:g} m",
                cure=f"at most {tip:.4g} m for this radius and half_angle",
            )

    def path(self) -> Path:
        return self.flank().path(self.chord, self.feed, self.tolerance, self.approach, self.clearance)

    def flank(self) -> Flank:
        """The surface the tool follows."""
        st, ct, sw, cw = math.sin(self.tilt), math.cos(self.tilt), math.sin(self.toward), math.cos(self.toward)
        m = np.array([st * cw, st * sw, ct])
        e1, e2 = np.array([ct * cw, ct * sw, -st]), np.array([-sw, cw, 0.0])
        way = 1 if self.direction == "ccw" else -1

        def outward(u):
            phi = self.start + way * 2 * math.pi * u[:, None]
            return np.cos(phi) * e1 + np.sin(phi) * e2

        return Flank(
            lambda u: self.center + self.radius * outward(u),
            lambda u: math.cos(self.half_angle) * m - math.sin(self.half_angle) * outward(u),
            self.height,
        )
