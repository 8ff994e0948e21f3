"""What the data sheet of a hexapod says of its joints, tool and struts."""

from __future__ import annotations

from ..declare import Array, Part, quantity
from ..errors import SheetError


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


class Tool(Part):
    """Where the tool sits on a platform frame P of its own; without it P is T."""

    input_error = SheetError

    position: Array = quantity("m", "tool tip p_PT, in P", shape=(3,))
    angles: Array = quantity("rad", "a b c of R_PT = Rz(c) Ry(b) Rx(a)", default=[0.0, 0.0, 0.0], shape=(3,))


class StrutPart(Part):
    """One of the two bodies of a strut, a slender body on the strut's axis."""

    input_error = SheetError

    mass: float = quantity("kg", "mass", above=0)
    center: float = quantity(
        "m", "centre of mass, along the strut: from the platform joint (moving), from the base joint (fixed)"
    )
    transverse: float = quantity("kg m2", "inertia about the centre of mass, across the strut", at_least=0)
    axial: float | None = quantity("kg m2", "inertia about the strut's axis", default=None, at_least=0)


class Strut(Part):
    """The two bodies of each strut; the same for all six."""

    input_error = SheetError

    moving: StrutPart
    fixed: StrutPart
