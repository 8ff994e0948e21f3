"""What the data sheet of a hybrid machine says of its base, arms and motors, and where it stands with its tool."""

from __future__ import annotations

import numpy as np
from pydantic import model_validator

from ..declare import Array, Part, quantity
from ..errors import InputError, SheetError
from .limits import COINCIDENT, Limits


class HybridBase(Part):
    """Where the arms turn, and how far the tool is from their plane."""

    input_error = SheetError

    half_width: float = quantity(
        "m", "b: half the distance between the pivots; below 0 where arm 1 stands on the positive side",
        at_least=-50, at_most=50,
    )  # fmt: skip
    overhang: float = quantity(
        "m", "z0: from the plane of the slides to the tool tip with the ram at 0", at_least=-50, at_most=50
    )

    @model_validator(mode="after")
    def _apart(self):
        if abs(self.half_width) < COINCIDENT:
            raise InputError("the pivots stand in one place", key="half_width", value=f"{self.half_width:g} m")
        return self


class Arm(Part):
    """An arm that turns about its pivot; it knows no other motion, so no other number matters."""

    input_error = SheetError

    mass: float = quantity("kg", "mass of an arm", above=0)
    center: float = quantity("m", "centre of mass, from the pivot along the arm")
    inertia: float = quantity("kg m2", "about its centre of mass and the axis of the pivot", above=0)


class MotorSide(Part):
    """What a linear motor carries along its arm before the link does."""

    input_error = SheetError

    mass: float = quantity("kg", "mass of the motor's moving part", above=0)
    inertia: float = quantity("kg m2", "about the slide's point and the axis of the pivots", above=0)


class HybridLimits(Limits):
    """What may not be exceeded by a hybrid machine."""

    travel: Array = quantity("m", "least and greatest s21, s65 and s32, a row each", shape=(3, 2))
    passive: Array = quantity("m", "least and greatest s54 of the passive slide", shape=(2,))
    angle: Array = quantity("rad", "least and greatest angle of the arms", shape=(2,))

    @model_validator(mode="after")
    def _ordered(self):
        for key, unit in (("travel", "m"), ("passive", "m"), ("angle", "rad")):
            ends = np.atleast_2d(getattr(self, key))
            if (ends[:, 0] >= ends[:, 1]).any():
                row = ends[int(np.argmax(ends[:, 0] >= ends[:, 1]))]
                raise InputError("the first end must be below the second", key=key, value=f"{row.tolist()} {unit}")
        if self.travel[0, 0] <= 0:
            raise InputError(
                "slide 1 may not reach its pivot: there it does not move the tool", key="travel",
                value=f"least s21 of {self.travel[0, 0]:g} m", cure="give a least s21 above 0",
            )  # fmt: skip
        return self


def stands(machine, x) -> np.ndarray:
    """z (N, 6) with the tool tip at x (N, 3), in NumPy, apart from the equations of the kernel; NaN where there is
    none."""
    x, b = np.atleast_2d(np.asarray(x, float)), machine.base.half_width
    with np.errstate(invalid="ignore"):
        s21 = np.sqrt((x[:, 0] + b) ** 2 + x[:, 1] ** 2 - b**2)
    phi = np.arctan2(x[:, 1], x[:, 0] + b) - np.arctan2(s21, b)
    return np.stack([s21, s21 + 2 * b * np.sin(phi), x[:, 2], 2 * b * np.cos(phi), phi, phi], -1)
