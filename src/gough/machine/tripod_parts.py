"""What the data sheet of a 3-PRS says of its rails, sliders and links, and where it stands with its tool at a place."""

from __future__ import annotations

import numpy as np
from pydantic import model_validator

from ..declare import Array, Part, quantity
from ..errors import InputError, SheetError
from .limits import Limits

SIDES = ((0, 1), (1, 2), (2, 0))  # joints of the platform's triangle, side by side
_UNIT = 1e-6  # how far from 1 the length of a direction may be, and from 0 the cosine of a right angle


class TripodJoints(Part):
    """Where the links hold the platform."""

    input_error = SheetError

    platform: Array = quantity("m", "centres of the spherical joints p_TB, in T", shape=(3, 3))


class TripodRails(Part):
    """The line on which the hinge of each slider runs, and the plane in which its link swings."""

    input_error = SheetError

    point: Array = quantity("m", "p_WA, where the slider's hinge is at q = 0, in W", shape=(3, 3))
    direction: Array = quantity("1", "the way in which q grows, in W, of length 1", shape=(3, 3))
    across: Array = quantity(
        "1", "the way of a link at angle 0, square to its rail, in W, of length 1; its hinge is square to both",
        shape=(3, 3),
    )  # fmt: skip

    @model_validator(mode="after")
    def _sound(self):
        for key in ("direction", "across"):
            off = np.abs(np.linalg.norm(getattr(self, key), axis=1) - 1)
            if off.max() > _UNIT:
                i = int(off.argmax())
                value = f"{np.linalg.norm(getattr(self, key)[i]):.9g} for slider {i + 1}"
                raise InputError("a direction must have length 1", key=key, value=value, cure="divide it by its length")
        dot = np.abs((self.direction * self.across).sum(1))
        if dot.max() > _UNIT:
            i = int(dot.argmax())
            value = f"{np.degrees(np.arccos(min(dot[i], 1))):.6g} deg for slider {i + 1}"
            raise InputError(
                "must be square to direction", key="across", value=value, cure="take off its part along it"
            )
        return self


class Slider(Part):
    """What runs on a rail."""

    input_error = SheetError

    mass: float = quantity("kg", "mass of a slider with its nut", above=0)


class Link(Part):
    """The bar of constant length between a slider's hinge and the platform."""

    input_error = SheetError

    length: float = quantity("m", "from hinge to spherical joint", above=0, at_most=50)
    mass: float | None = quantity(
        "kg", "mass of a link, spread evenly along it; leave out to neglect it", default=None, above=0
    )


class TripodLimits(Limits):
    """What may not be exceeded by a 3-PRS."""

    travel: Array = quantity("m", "both ends of the rails: least and greatest q", shape=(2,))
    angle: Array = quantity("rad", "least and greatest angle of a link from `across`", shape=(2,))

    @model_validator(mode="after")
    def _ordered(self):
        for key, unit in (("travel", "m"), ("angle", "rad")):
            ends = getattr(self, key)
            if ends[0] >= ends[1]:
                raise InputError("the first end must be below the second", key=key, value=f"{ends.tolist()} {unit}")
        return self


def stands(machine, x):
    """Where the links end with the tool tip at x (N, 3), in NumPy, apart from the equations of the kernel.

    R (N, 3, 3), planes (N, 3) m by which spherical joints miss the planes of their links, and along (N, 3) m, how far
    each is from its rail along `across`.
    """
    from ..frames import rotation_of_vector_np

    x = np.atleast_2d(x)
    t, A, c = machine.joints.platform, machine.rails.point, machine.rails.across
    h = np.cross(c, machine.rails.direction)
    R = np.broadcast_to(np.eye(3), (len(x), 3, 3)).copy()
    for _ in range(50):
        r = t @ np.swapaxes(R, -1, -2)
        miss = ((x[:, None] + r - A) * h).sum(-1)
        K = np.cross(r, h)
        good = np.abs(np.linalg.det(K)) > 1e-12 * np.linalg.norm(t) ** 3
        d = np.zeros_like(x)
        d[good] = -np.linalg.solve(K[good], miss[good][..., None])[..., 0]
        size = np.linalg.norm(d, axis=-1, keepdims=True)
        R = rotation_of_vector_np(d / np.maximum(size / 0.3, 1)) @ R
    r = t @ np.swapaxes(R, -1, -2)
    miss = ((x[:, None] + r - A) * h).sum(-1)
    return R, miss, ((x[:, None] + r - A) * c).sum(-1)
