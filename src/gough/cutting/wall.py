"""The wall that is cut: how deep the tool goes into it along the path, how high it is, and on which side it stands.

The finished wall is where the program's path says it is: the tool's side runs along it.  What is to be cut off stands
in front of it, `radial` deep, from place to place along the path (metres of the course).  Between the first place and
the last there is stock, before and behind them air.

    stairs    radial[i] from places[i] to places[i + 1]: one depth fewer than places
    linear    radial[i] at places[i], straight in between: as many depths as places

A tool that turns clockwise and has the wall on its right cuts down (climbs), on its left up.  A step of the stairs is
there for the whole tool at once, when its axis passes; a real one is met over sqrt(2 R a_e) of the way, some
millimetres.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field, model_validator

from ..declare import Array, Part, quantity
from ..errors import InputError
from .numeric import ARRAYS

MOST = 256  # places; each is looked at in every sample


class Wall(Part):
    """Stock in front of a wall along the path."""

    axial_depth: float = quantity("m", "height of the wall, from the tool's tip up", above=0)
    places: Array = quantity("m", "where along the path the depth changes, rising", shape=(-1,))
    radial: Array = quantity("m", "radial depths", at_least=0, shape=(-1,))
    form: Literal["stairs", "linear"] = "stairs"
    milling: Literal["down", "up"] = Field("down", description="down: the wall on the right of the feed; up: left")

    @model_validator(mode="after")
    def _fits(self):
        places, wanted = self.places, len(self.places) - (self.form == "stairs")
        if not 2 <= len(places) <= MOST:
            raise InputError(f"needs 2 to {MOST} places", key="places", value=str(len(places)))
        if not (np.diff(places) > 0).all():
            i = int(np.argmin(np.diff(places)))
            raise InputError(
                "places must rise along the path", key="places", value=f"{places[i]:g} m, then {places[i + 1]:g} m"
            )
        if len(self.radial) != wanted:
            raise InputError(
                f"{self.form} with {len(places)} places have {wanted} depths", key="radial",
                value=str(len(self.radial)),
            )  # fmt: skip
        if not self.radial.max() > 0:
            raise InputError(
                "no radial depth is above 0: there is no chip", key="radial", value="0 m everywhere",
                cure="give a depth, or leave the cut out",
            )  # fmt: skip
        return self

    def depth_of(self, p, s, xp):
        """Radial depth at the path length s, m, of the wall seen as `p`."""
        out = 0.0 * s
        for i in range(len(self.places) - 1):
            a, b = p.places[i], p.places[i + 1]
            if self.form == "stairs":
                depth = p.radial[i]
            else:
                depth = p.radial[i] + (p.radial[i + 1] - p.radial[i]) * (s - a) / (b - a)
            out = xp.if_else(s >= a, depth, out)
        return xp.if_else(s < p.places[len(self.places) - 1], out, 0.0)

    def depth(self, s) -> np.ndarray:
        """Radial depth at path lengths s (...) m.  (...) m."""
        return self.depth_of(self, np.asarray(s, float), ARRAYS)

    @property
    def side(self) -> float:
        """Where the wall stands: -1 on the right of the feed (down), +1 on the left (up)."""
        return -1.0 if self.milling == "down" else 1.0
