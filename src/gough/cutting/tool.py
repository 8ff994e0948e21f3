"""The end mill: its teeth, how they stand, and what bends.

The spindle turns clockwise seen from above (M3).  Tooth 0 stands at the angle phi of the spindle, tooth j at
phi + j 2 pi / N at the tip and lags behind by k z at the height z above it, k = 2 tan(helix) / D.  A spindle that is
off the tool's axis by `runout` r carries tooth j on the radius D / 2 + r cos(`runout_angle` - j 2 pi / N).
"""

from __future__ import annotations

import math

from pydantic import Field, model_validator

from ..declare import Part, quantity
from ..errors import InputError


class EndMill(Part):
    """A cylindrical end mill with evenly spaced right-hand flutes."""

    diameter: float = quantity("m", "diameter D", above=0, at_most=1)
    teeth: int = Field(ge=1, le=16, description="number of teeth N")
    helix: float = quantity("rad", "helix angle", default=0.0, at_least=0, at_most=math.radians(75))
    runout: float | None = quantity(
        "m", "how far the tool's axis is off the spindle's; without it all teeth take the same chip", default=None,
        at_least=0,
    )  # fmt: skip
    runout_angle: float = quantity("rad", "where that is, from tooth 0", default=0.0)
    extension: float | None = quantity("m", "free length from the clamping to the tip", default=None, above=0)
    modulus: float = quantity("Pa", "Young's modulus; sintered carbide where left out", default=600e9, above=0)
    core: float = quantity(
        "1", "diameter of the round bar that bends as the fluted tool does, over D", default=0.8, above=0, at_most=1
    )

    @model_validator(mode="after")
    def _turns_true(self):
        if self.runout is not None and self.runout >= self.diameter / 2:
            raise InputError(
                "must be below the radius of the tool", key="runout", value=f"{self.runout:g} m",
                cure=f"give less than {self.diameter / 2:g} m",
            )  # fmt: skip
        return self
