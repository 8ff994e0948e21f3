"""Machines that are exported to other engines: the library's, and one with every option of the hexapod."""

from __future__ import annotations

import numpy as np

from gough.machine.hexapod_parts import Strut, StrutPart
from gough.machine.sheet import load_machine

from .machines import general


def everything():
    """`general` with nothing symmetric left: full inertias and off-axis masses of the struts, a cross with inertia."""
    strut = Strut(
        moving=StrutPart(
            mass=16.0, center=0.465, offset=[0.03, -0.02],
            inertia=[[2.153, 0.2, -0.1], [0.2, 1.9, 0.3], [-0.1, 0.3, 1.2]],
        ),
        fixed=StrutPart(
            mass=18.0, center=-0.08, offset=[-0.04, 0.05],
            inertia=[[0.5, 0.06, 0.03], [0.06, 0.6, -0.08], [0.03, -0.08, 0.7]],
        ),
    )  # fmt: skip
    return general().replace(name="everything", strut=strut, **{"joints.cross": 0.9})


def without_friction(machine):
    """The machine with frictionless joints."""
    return machine.replace(friction=None, **({} if machine.joints.friction is None else {"joints.friction": None}))


EXPORTED = {
    "nist-octahedral": lambda: without_friction(load_machine("nist-octahedral")),
    "okuma-pm600": lambda: without_friction(load_machine("okuma-pm600")),
    "everything": lambda: without_friction(everything()),
}


def worst(found, right) -> float:
    """Largest difference of an entry, against the largest entry."""
    return float(np.abs(np.asarray(found) - right).max() / np.abs(right).max())
