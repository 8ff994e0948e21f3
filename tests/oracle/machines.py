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


def full(name: str, seed: int):
    """A machine of this name whose struts are any bodies: off their axes, with full inertias, crosses, guides.

    The full inertia is that of a body spread over three random points about the sheet's slender one, so it is one that
    a distribution of mass has.
    """
    m, rng = (general() if name == "general" else load_machine(name)), np.random.default_rng(seed)
    parts = {}
    for key in ("moving", "fixed"):
        part = getattr(m.strut, key)
        points = rng.normal(size=(3, 3)) * 0.2
        points -= points.mean(0)
        spread = sum(part.mass / 3 * (r @ r * np.eye(3) - np.outer(r, r)) for r in points)
        axial = min(part.axial or 0.1, 1.9 * part.transverse)  # more has no body
        inertia = spread + np.diag([part.transverse, part.transverse, axial])
        parts[key] = StrutPart(mass=part.mass, center=part.center, offset=rng.normal(size=2) * 0.05, inertia=inertia)
    longest = m.limits.length[1]
    strut = Strut(**parts, sleeve=0.53 * longest, tube=0.55 * longest)
    return m.replace(name=f"full-{name}", strut=strut, **{"joints.cross": 0.7, "gravity": m.gravity + [0.5, -1.0, 0.3]})


MACHINES = {
    "nist-octahedral": lambda: load_machine("nist-octahedral"),
    "okuma-pm600": lambda: load_machine("okuma-pm600"),
    "general": general,
    "full-nist-octahedral": lambda: full("nist-octahedral", 1),
    "full-okuma-pm600": lambda: full("okuma-pm600", 2),
    "full-general": lambda: full("general", 3),
}
