"""One axis in MJCF: a carriage on a slide, and no loop."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np

from ..machine.drives import Screw, reflected_mass
from . import mjcf_shapes
from .mjcf_parts import Kind, number, point_mass, slide


def _carriage(base, machine) -> None:
    d, home = machine.rail.direction, float(machine.home[0])
    mjcf_shapes.rail(base, machine.limits.travel[:, None] * d)
    turning = reflected_mass(machine.drive) if isinstance(machine.drive, Screw) else 0.0
    body = ET.SubElement(base, "body", name="carriage", pos=number(home * d))
    slide(body, "carriage", d, home, machine, 0, turning, machine.limits.travel)
    point_mass(body, machine.carriage.mass)
    ET.SubElement(body, "site", name="tool", pos="0 0 0")
    mjcf_shapes.block(body)


def _positions(machine, x) -> np.ndarray:
    """The place of the carriage.  (..., 1) -> (..., 1)."""
    return np.array(x, float)


KIND = Kind(_carriage, _positions, "", "", "carriage", "place", "the carriage's place on its rail")
