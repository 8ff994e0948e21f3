"""A hexapod in MJCF: six struts, each a sleeve that turns about A on a universal joint, and a tube that slides in it.

The slide's coordinate is the strut's length l.  Frames S of a strut stand as at home, with a the axis of the joint that
is fixed in W:

    z_S = n,  y_S = n x a / |n x a|,  x_S = y_S x n,                R_WS = [x_S y_S z_S]                          (1)

first the hinge about a, then the hinge about y_S, fixed in the strut: a universal joint.  The tube's frame sits at B.
The reflected mass J (2 pi / lead)^2 of motor and screw is the slide's `armature`, which adds m_r l' ^2 / 2 to the
energy and nothing else, as in gough.  Rooting the struts in the base, not in the platform, keeps their inertias on
axes through fixed points, and every loop is closed by the mildest of constraints, a common point.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np

from ..errors import SheetError
from ..machine.drives import reflected_mass
from . import mjcf_shapes
from .mjcf_frames import Frame, hexapod_positions, strut_frame
from .mjcf_parts import LIGHT, THIN, Kind, hinge, inertial, number, placed, slide


def _legs(base, machine) -> None:
    mjcf_shapes.base(base, machine)
    for i in range(6):
        _strut(base, machine, i, strut_frame(machine, i))


def _strut(base, machine, i: int, frame: Frame):
    """Sleeve on its universal joint, tube on its slide; a cross between the joint's hinges where it has inertia."""
    number_, strut = i + 1, machine.strut
    place = placed(frame.p_WA, frame.R_WS)
    if machine.joints.cross is not None:  # turns about a only, so any inertia that is J about a will do
        base = ET.SubElement(base, "body", name=f"cross {number_}", **place)
        hinge(base, f"fork {number_}", frame.axis_S)
        inertial(base, LIGHT, np.zeros(3), (machine.joints.cross or THIN) * np.eye(3))
        place = {"pos": "0 0 0"}
    sleeve = ET.SubElement(base, "body", name=f"sleeve {number_}", **place)
    if machine.joints.cross is None:
        hinge(sleeve, f"fork {number_}", frame.axis_S)
    hinge(sleeve, f"cross {number_}", [0, 1, 0])
    _part(sleeve, strut and strut.fixed, 1, f"strut.fixed of {machine.name}")
    tube = ET.SubElement(sleeve, "body", name=f"tube {number_}", pos=number([0, 0, frame.length]))
    slide(tube, "strut", [0, 0, 1], frame.length, machine, i, reflected_mass(machine.drive), machine.limits.length)
    _part(tube, strut and strut.moving, -1, f"strut.moving of {machine.name}")
    ET.SubElement(tube, "site", name=f"tube {number_} B", pos="0 0 0")
    mjcf_shapes.strut(sleeve, tube, machine.limits.length)


def _part(body, part, sense: int, key: str):
    """One body of a strut in its frame; `sense` of `center` on z_S.  `part` None: next to nothing."""
    if part is None:
        inertial(body, LIGHT, np.zeros(3), THIN * np.eye(3))
        return
    x, y = (0.0, 0.0) if part.offset is None else part.offset
    if part.inertia is not None:
        inertia = part.inertia
    else:
        across, axial = part.transverse or THIN, part.axial or THIN
        if axial > 2 * across:
            raise SheetError(
                "MuJoCo takes no body with more inertia about its axis than twice that across it",
                key=key, value=f"{axial:g} against {across:g} kg m2", cure="check axial and transverse",
            )  # fmt: skip
        inertia = np.diag([across, across, axial])
    inertial(body, part.mass, [x, y, sense * part.center], inertia)


KIND = Kind(_legs, hexapod_positions, "tube {} B", "platform B{}", "strut", "length", "the strut's length")
