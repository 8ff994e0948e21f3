"""What the data sheet of a hexapod says of its joints, tool and struts.

A strut has a frame S: its third axis n runs from base to platform joint, its second lies along n x a, where a is the
axis of the universal joint that is fixed in the base (`joints.base_axis`); so the first is nearest to a.
"""

from __future__ import annotations

from typing import Any, ClassVar

from pydantic import model_validator

from ..declare import Array, Part, quantity
from ..errors import InputError, SheetError
from ..mechanics.bodies import check_inertia


class JointFriction(Part):
    """Friction of the joints at both ends of every strut, mu r |reaction| about the axis they turn on."""

    input_error = SheetError
    levels: ClassVar[tuple[str, ...]] = ("coefficient",)  # the numbers that friction is in proportion to

    coefficient: float = quantity("1", "friction coefficient mu of the joints", at_least=0)
    platform_radius: float = quantity("m", "radius r of the balls of the platform joints", at_least=0, at_most=1)
    base_radius: float = quantity("m", "radius r of the bearings of the base joints", at_least=0, at_most=1)
    smoothing: float = quantity("rad/s", "rate below which joint friction fades", default=1e-3, above=0)


class Joints(Part):
    """Where the struts are held."""

    input_error = SheetError

    base: Array = quantity("m", "base joints p_WA, in W", shape=(6, 3))
    platform: Array = quantity("m", "platform joints p_TB, in T (in P where [tool] is given)", shape=(6, 3))
    base_axis: Array | None = quantity(
        "1",
        "axis of the universal joint fixed in the base, in W; fixes the spin of a strut",
        default=None,
        shape=(6, 3),
    )
    cross: float | None = quantity(
        "kg m2",
        "inertia of the cross of each base joint about base_axis, its centre of mass in the joint",
        default=None,
        at_least=0,
    )
    friction: JointFriction | None = None


class Tool(Part):
    """Where the tool sits on a platform frame P of its own; without it P is T."""

    input_error = SheetError

    position: Array = quantity("m", "tool tip p_PT, in P", shape=(3,))
    angles: Array = quantity("rad", "a b c of R_PT = Rz(c) Ry(b) Rx(a)", default=[0.0, 0.0, 0.0], shape=(3,))


class StrutPart(Part):
    """One of the two bodies of a strut: slender with `transverse` and `axial`, or any with `inertia`."""

    input_error = SheetError

    mass: float = quantity("kg", "mass", above=0)
    center: float = quantity(
        "m", "centre of mass, along the strut: from the platform joint (moving), from the base joint (fixed)"
    )
    offset: Array | None = quantity(
        "m", "centre of mass off the strut's axis, along first and second axis of S", default=None, shape=(2,)
    )
    transverse: float | None = quantity(
        "kg m2", "inertia about the centre of mass, across the strut", default=None, at_least=0
    )
    axial: float | None = quantity(
        "kg m2", "inertia about the strut's axis (through the centre of mass)", default=None, at_least=0
    )
    inertia: Array | None = quantity(
        "kg m2", "inertia about the centre of mass, axes of S; in place of transverse and axial", default=None,
        shape=(3, 3),
    )  # fmt: skip

    @model_validator(mode="after")
    def _one_inertia(self):
        if self.inertia is not None:
            for key in ("transverse", "axial"):
                if getattr(self, key) is not None:
                    raise InputError("inertia already says it", key=key, cure=f"leave {key} or inertia out")
            try:
                check_inertia(self.inertia)
            except InputError as error:
                raise error.at(key="inertia") from None
        elif self.transverse is None:
            raise InputError("is missing", key="transverse", cure="give transverse, or the full inertia")
        return self

    @property
    def general(self) -> bool:
        """Whether the strut's first two axes matter to this body."""
        return self.offset is not None or self.inertia is not None

    @property
    def spins(self) -> Any:
        """Whether the spin of the strut matters to this body."""
        return self.general or self.axial


class Strut(Part):
    """The two bodies of each strut; the same for all six."""

    input_error = SheetError

    moving: StrutPart
    fixed: StrutPart
    sleeve: float | None = quantity(
        "m", "guide: distance of the sleeve's mouth from the base joint", default=None, above=0
    )
    tube: float | None = quantity(
        "m", "guide: distance of the moving tube's end from the platform joint", default=None, above=0
    )
