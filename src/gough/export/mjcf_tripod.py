"""A 3-PRS in MJCF: three sliders, each with a hinged link of constant length that ends at the platform.

Slide i has S_i as its coordinate, hinge i the link's angle theta_i, both as in machine/tripod.py.  A link's frame S at
home: z_S = l along the link, y_S = h its hinge, x_S = h x l.  Three `connect` at the spherical joints T_i, nine rows,
leave three of the twelve freedoms.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np

from ..machine.drives import reflected_mass
from . import mjcf_shapes
from .mjcf_frames import link_frame, tripod_positions
from .mjcf_parts import Kind, hinge, number, placed, point_mass, rod, slide


def _legs(base, machine) -> None:
    S, theta = np.split(machine.standing(machine.home), 2)
    mjcf_shapes.rails(base, machine)
    L = machine.link.length
    for i in range(3):
        frame = link_frame(machine, i)
        slider = ET.SubElement(base, "body", name=f"slider {i + 1}", pos=number(frame.p_WA))
        d, mass = machine.rails.direction[i], reflected_mass(machine.drive)
        slide(slider, "slider", d, S[i], machine, i, mass, machine.limits.travel)
        point_mass(slider, machine.slider.mass)
        link = ET.SubElement(slider, "body", name=f"link {i + 1}", **placed(np.zeros(3), frame.R_WS))
        hinge(link, f"link {i + 1}", frame.axis_S, ref=number(theta[i]), range=number(machine.limits.angle))
        rod(link, L, machine.link.mass)
        ET.SubElement(link, "site", name=f"link {i + 1} T", pos=number([0, 0, L]))
        mjcf_shapes.carriage(slider, link, L)


KIND = Kind(_legs, tripod_positions, "link {} T", "platform T{}", "slider", "place", "the slider's place on its rail")
