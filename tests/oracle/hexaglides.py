"""Hexaglides to test with: the library's, the same with legs that have mass, and one on which no term vanishes."""

from __future__ import annotations

import numpy as np

from gough.machine.hexapod_parts import Tool
from gough.machine.sheet import load_machine
from gough.mechanics.bodies import Body

from .machines import elementary


def library():
    return load_machine("eth-hexaglide")


def with_legs():
    return library().replace(name="hexaglide-with-legs", **{"legs.mass": 8.0})


def general():
    """Six rails of their own in oblique directions, legs of different lengths with mass, a tool frame set off and
    turned, a full inertia with its centre off every axis, and oblique gravity."""
    m, rng = library(), np.random.default_rng(6)
    position, angles = np.array([0.03, -0.05, -0.12]), np.array([0.2, -0.3, 0.4])
    R_PT = elementary(2, angles[2]) @ elementary(1, angles[1]) @ elementary(0, angles[0])
    direction = m.rails.direction + rng.uniform(-0.2, 0.2, (6, 3))
    direction = direction / np.linalg.norm(direction, axis=1)[:, None]
    body = Body(mass=118.7, center=[0.04, -0.03, 0.1], inertia=[[3.6, 0.3, -0.2], [0.3, 3.9, 0.25], [-0.2, 0.25, 2.9]])
    return m.replace(
        name="general-hexaglide", gravity=[1.5, -2.5, -9.0], platform=body, tool=Tool(position=position, angles=angles),
        **{
            "joints.platform": position + m.joints.platform @ R_PT.T, "rails.direction": direction,
            "rails.point": m.rails.point + rng.uniform(-0.05, 0.05, (6, 3)), "rails.rail": np.arange(6.0),
            "legs.length": 1 + rng.uniform(-0.05, 0.1, 6), "legs.mass": 8.0, "limits.gap": 0.0,
            "limits.workspace.size": [0.3, 0.3],
        },
    )  # fmt: skip


HEXAGLIDES = {"eth-hexaglide": library, "hexaglide-with-legs": with_legs, "general-hexaglide": general}
