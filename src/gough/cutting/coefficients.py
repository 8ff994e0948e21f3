"""What a material asks of a cutting edge: specific forces of the chip, and forces of rubbing along the edge.

An element of edge of height dz that cuts a chip of thickness h > 0 feels, against its motion, towards the tool's axis,
and along that axis towards the spindle,

    dF_t = (K_tc h + K_te) dz,   dF_r = (K_rc h + K_re) dz,   dF_a = (K_ac h + K_ae) dz                             (1)

after Altintas, Manufacturing Automation, 2nd ed. 2012, ch. 2.
"""

from __future__ import annotations

from pydantic import Field

from ..declare import Part, quantity


class Coefficients(Part):
    """The six numbers of eq. (1), and where they are from."""

    tangential: float = quantity("N/m2", "K_tc, against the motion of the edge, of a chip", above=0)
    radial: float = quantity("N/m2", "K_rc, towards the axis, of a chip", at_least=0)
    axial: float = quantity("N/m2", "K_ac, towards the spindle, of a chip", default=0.0)
    tangential_edge: float = quantity("N/m", "K_te, of the edge", default=0.0, at_least=0)
    radial_edge: float = quantity("N/m", "K_re, of the edge", default=0.0, at_least=0)
    axial_edge: float = quantity("N/m", "K_ae, of the edge", default=0.0)
    source: str = Field("not said", description="where the numbers are from")


_TABLE = "Milling force model for aviation aluminum alloy, Chin. J. Mech. Eng. 34 (2021), table 5"

AL6082 = Coefficients(
    tangential=631e6, radial=99e6, axial=273e6, tangential_edge=13e3, radial_edge=10e3, axial_edge=2.8e3,
    source=f"{_TABLE}, its ref. 189: Al6082-T6, cemented carbide, dry",
)  # fmt: skip
AL6061 = Coefficients(
    tangential=243.77e6, radial=113.5e6, tangential_edge=7.53e3, radial_edge=7.83e3,
    source=f"{_TABLE}, its ref. 160: Al6061-T6, cemented carbide, dry",
)  # fmt: skip
AL7075 = Coefficients(
    tangential=600.46e6, radial=180.96e6, tangential_edge=17.9e3, radial_edge=20.42e3,
    source=f"{_TABLE}, its ref. 160: Al7075-T6, cemented carbide, dry",
)  # fmt: skip

_SCALE = 1.28
A5052 = Coefficients(
    tangential=_SCALE * AL6061.tangential, radial=_SCALE * AL6061.radial, axial=_SCALE * 105e6,
    tangential_edge=_SCALE * AL6061.tangential_edge, radial_edge=_SCALE * AL6061.radial_edge,
    source="calibrated: Al6061-T6 of the same table times 1.28, so that the mean normal forces at radial depths of "
    "0.3, 0.6, 0.9 mm come near the 37, 63, 91 N of Okuda et al. 2006, table 3; K_ac in the ratio to K_tc of Al6082-T6",
)  # fmt: skip

SETS = {"Al6082-T6": AL6082, "Al6061-T6": AL6061, "Al7075-T6": AL7075, "A5052": A5052}
