"""A hexaglide in MJCF: six carriages on slides, each with a leg on a universal joint that ends at the platform.

The slide's coordinate is the carriage's place q on its rail.  The leg's frame S stands as at home, by (1) of
mjcf_hexapod.py, its third axis from carriage to platform joint; a is any axis across the leg, for a slender leg has no
inertia about its own.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np

from . import mjcf_shapes
from .mjcf_frames import hexaglide_positions, leg_frame
from .mjcf_parts import Kind, hinge, number, placed, point_mass, rod, slide


def _legs(base, machine) -> None:
    q = machine.inverse_kinematics(machine.home)
    mjcf_shapes.rails(base, machine)
    lengths = np.broadcast_to(machine.legs.length, 6)
    for i in range(6):
        frame, e = leg_frame(machine, i), machine.rails.direction[i]
        carriage = ET.SubElement(base, "body", name=f"carriage {i + 1}", pos=number(frame.p_WA))
        slide(carriage, "carriage", e, q[i], machine, i, 0.0, machine.limits.travel)
        point_mass(carriage, machine.carriage.mass)
        leg = ET.SubElement(carriage, "body", name=f"leg {i + 1}", **placed(np.zeros(3), frame.R_WS))
        hinge(leg, f"fork {i + 1}", frame.axis_S)
        hinge(leg, f"cross {i + 1}", [0, 1, 0])
        rod(leg, lengths[i], machine.legs.mass)
        ET.SubElement(leg, "site", name=f"leg {i + 1} B", pos=number([0, 0, lengths[i]]))
        mjcf_shapes.carriage(carriage, leg, lengths[i])


KIND = Kind(
    _legs, hexaglide_positions, "leg {} B", "platform B{}", "carriage", "place", "the carriage's place on its rail"
)
