"""Cutting: a tool, a material and a wall, and what comes of them at a spindle speed."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np
from pydantic import Field, field_validator, model_validator

from ..declare import Part, one_of, quantity
from ..errors import ExperimentError, InputError
from . import force
from .coefficients import SETS, Coefficients
from .deflection import Beam, Leaning
from .numeric import ARRAYS
from .tool import EndMill
from .wall import Wall

Deflection = Annotated[
    Leaning | Beam | None,
    one_of(measured="gough.cutting.deflection:Leaning", beam="gough.cutting.deflection:Beam"),
]


class Cutting(Part):
    """An end mill along a wall: the force on the machine, and how the tool gives way to it."""

    tool: EndMill
    coefficients: Coefficients
    wall: Wall
    spindle_speed: float = quantity("rad/s", "of the spindle, clockwise (M3)", above=0, at_most=2e4)
    start_angle: float = quantity("rad", "angle of tooth 0 at the start of the run", default=0.0)
    regenerative: bool = Field(
        False, description="the chip knows what the tool did a tooth ago; else it knows the programmed feed only"
    )
    deflection: Deflection = Field(None, description="how the tool gives way; rigid where left out")

    @field_validator("coefficients", mode="before")
    @classmethod
    def _by_name(cls, raw):
        """A material by its name."""
        if not isinstance(raw, str):
            return raw
        if raw not in SETS:
            raise InputError("no such material", value=ascii(raw)[:60], cure=f"there is {', '.join(SETS)}; or a table")
        return SETS[raw]

    @model_validator(mode="after")
    def _fits(self):
        tool, wall = self.tool, self.wall
        if wall.radial.max() > tool.diameter:
            raise InputError(
                "deeper than the diameter of the tool", key="wall.radial", value=f"{wall.radial.max():g} m",
                cure=f"give at most {tool.diameter:g} m, which is a full slot",
            )  # fmt: skip
        turned = force.lag(ARRAYS, tool) * wall.axial_depth
        if turned > 2 * math.pi:
            most = 2 * math.pi / force.lag(ARRAYS, tool)
            raise InputError(
                "the flutes wind more than once around the tool within this height", key="wall.axial_depth",
                value=f"{wall.axial_depth:g} m", cure=f"give at most {most:.4g} m",
            )  # fmt: skip
        if tool.extension is not None and wall.axial_depth > tool.extension:
            raise InputError(
                "higher than the tool is long", key="wall.axial_depth", value=f"{wall.axial_depth:g} m",
                cure=f"tool.extension is {tool.extension:g} m",
            )  # fmt: skip
        if isinstance(self.deflection, Beam) and tool.extension is None:
            raise InputError("a beam needs its length", key="tool.extension", cure='write e.g. extension = "75 mm"')
        if self.regenerative and tool.runout is not None:
            raise InputError(
                "a chip that knows the tool's motion knows no runout", key="regenerative", value="true",
                cure="leave out tool.runout, or regenerative",
            )  # fmt: skip
        return self

    @property
    def tooth_period(self) -> float:
        """From tooth to tooth, s."""
        return 2 * math.pi / (self.tool.teeth * self.spindle_speed)

    def feed_per_tooth(self, speed) -> np.ndarray:
        """f of a feed in m/s, m."""
        return np.asarray(speed, float) * self.tooth_period

    def forces(self, speed, depth, angle) -> np.ndarray:
        """F_x, F_y, F_z, M_z in C at feeds m/s, radial depths m and spindle angles rad that broadcast.  (..., 4)."""
        return force.forces(
            self.tool, self.coefficients, self.wall.axial_depth, self.feed_per_tooth(speed), depth, angle,
            self.wall.side,
        )  # fmt: skip

    def mean_forces(self, speed, depth) -> np.ndarray:
        """Their mean over a turn of the spindle at feeds m/s and radial depths m that broadcast.  (..., 4) N, N m."""
        return force.mean_force(
            self.tool, self.coefficients, self.wall.axial_depth, self.feed_per_tooth(speed), depth, self.wall.side
        )

    def check_path(self, length: float, speed: float) -> None:
        """Refuse a wall that the path of `length` m never meets, or a feed (m/s) that makes no chip there.

        Raises
        ------
        ExperimentError
        """
        wall = self.wall
        inside = wall.places[:-1][wall.radial[: len(wall.places) - 1] > 0]
        first = inside.min() if len(inside) else wall.places[-2]
        last = wall.places[1:][wall.radial > 0].max() if wall.form == "stairs" else wall.places[-1]
        if last <= 0:
            raise ExperimentError(
                "the wall ends before the path begins", key="plant.cutting.wall.places", value=f"{last:g} m",
                limit="0 m", cure="places count metres along the path",
            )  # fmt: skip
        if first >= length:
            raise ExperimentError(
                "the wall begins behind the end of the path", key="plant.cutting.wall.places", value=f"{first:g} m",
                limit=f"{length:g} m", cure="places count metres along the path",
            )  # fmt: skip
        if not self.feed_per_tooth(speed) > 1e-9:
            raise ExperimentError(
                "the feed makes no chip at this spindle speed", key="plant.cutting.spindle_speed",
                value=f"{self.feed_per_tooth(speed):g} m a tooth", cure="a faster feed, or a slower spindle",
            )  # fmt: skip
