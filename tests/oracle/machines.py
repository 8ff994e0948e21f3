"""Machines to test with: the library's, and one on which no term vanishes."""

from __future__ import annotations

import numpy as np

from gough.machine.hexapod_parts import Strut, StrutPart, Tool
from gough.machine.sheet import load_machine
from gough.mechanics.bodies import Body


def elementary(axis: int, angle: float) -> np.ndarray:
    """Right-handed turn about one axis, written apart from gough.frames."""
    R = np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R[i, i] = R[j, j] = np.cos(angle)
    R[j, i] = np.sin(angle)
    R[i, j] = -R[j, i]
    return R


def general():
    """okuma-pm600 with nothing left at zero.

    A tool frame set off and turned, a centre of mass off the axis, a full inertia, oblique axes of the base joints,
    oblique gravity, and an axial inertia of the struts large enough for their spin to count.
    """
    m = load_machine("okuma-pm600")
    position, angles = np.array([0.03, -0.05, -0.12]), np.array([0.2, -0.3, 0.4])
    R_PT = elementary(2, angles[2]) @ elementary(1, angles[1]) @ elementary(0, angles[0])
    axis = m.joints.base_axis + np.array([0.1, -0.2, 0.3])
    axis = axis / np.linalg.norm(axis, axis=1)[:, None]
    body = Body(mass=150.0, center=[0.02, -0.03, 0.25], inertia=[[6.0, 0.7, -0.4], [0.7, 7.0, 0.5], [-0.4, 0.5, 9.0]])
    strut = Strut(
        moving=StrutPart(mass=16.0, center=0.465, transverse=2.153, axial=2.4),
        fixed=StrutPart(mass=18.0, center=-0.08, transverse=0.15, axial=1.1),
    )
    return m.replace(
        name="general", gravity=[1.5, -2.5, -9.0], platform=body, strut=strut,
        tool=Tool(position=position, angles=angles),
        **{"joints.platform": position + m.joints.platform @ R_PT.T, "joints.base_axis": axis},
    )  # fmt: skip


MACHINES = {
    "nist-octahedral": lambda: load_machine("nist-octahedral"),
    "okuma-pm600": lambda: load_machine("okuma-pm600"),
    "general": general,
}
