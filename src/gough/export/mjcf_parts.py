"""What the models of all kinds have in common: numbers, bodies, the platform with the tool, a rod, a slide.

All numbers are written so that reading gives the same binary number.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from .. import frames
from . import mjcf_shapes

THIN = 1e-12  # kg m2; stands for the axial inertia of a body without one: MuJoCo refuses 0, and against the 0.1 kg m2
# and more across a strut it is below rounding.
LIGHT = 1e-9  # kg; stands for the mass of a body that only passes on forces, for the same reason


class Kind(NamedTuple):
    """How machines of one kind are written."""

    legs: Callable  # (base element, machine): what stands on the base and carries the platform
    positions: Callable  # (machine, task coordinates): qpos
    leg_end: str  # name of the site at the end of a leg, with a place for its number
    platform_end: str  # the same on the platform; "" for a machine without one
    joint: str  # name of the driven joints
    reading: str  # name of their sensors
    said: str  # what that joint is, in the file
    names: tuple[str, ...] = ()  # of the driven joints, where they are not numbered
    pairs: tuple[tuple[str, str, str], ...] = ()  # name and both sites of a loop, where there is no platform

    def driven(self, machine) -> list[str]:
        """The names of the driven joints, in gough's order."""
        return list(self.names) or [f"{self.joint} {i}" for i in range(1, machine.joints_count + 1)]

    def loops(self, machine) -> list[tuple[str, str, str]]:
        """Name and both sites of every `connect`."""
        if not self.platform_end:
            return list(self.pairs)
        numbers = range(1, machine.joints_count + 1)
        return [(f"joint {i}", self.leg_end.format(i), self.platform_end.format(i)) for i in numbers]


def number(value) -> str:
    """Numbers as text that reads back as the same numbers."""
    return " ".join(repr(float(v)) for v in np.atleast_1d(np.asarray(value, float)).ravel())


def inertial(body, mass, center, inertia) -> None:
    """Mass, its centre and the inertia (3, 3) about it, in the body's frame."""
    inertia = np.asarray(inertia)
    if np.array_equal(inertia, np.diag(np.diag(inertia))):
        how = {"diaginertia": number(np.diag(inertia))}
    else:
        how = {"fullinertia": number(inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]])}
    ET.SubElement(body, "inertial", pos=number(center), mass=number(mass), **how)


def rod(body, length: float, mass: float | None) -> None:
    """An even, slender rod from the body's origin along its third axis; next to nothing where it has no mass."""
    if mass is None:
        inertial(body, LIGHT, np.zeros(3), THIN * np.eye(3))
        return
    across = mass * length**2 / 12
    inertial(body, mass, [0, 0, length / 2], np.diag([across, across, THIN]))


def point_mass(body, mass: float) -> None:
    """What only slides: its inertia does not matter."""
    inertial(body, mass, np.zeros(3), THIN * np.eye(3))


def placed(p_WA, R_WS) -> dict[str, str]:
    """Place and turn of a body."""
    return {"pos": number(p_WA), "quat": number(frames.quaternion_of_rotation_np(R_WS))}


def slide(body, name: str, axis, at: float, machine, i: int, mass: float, travel) -> None:
    """The driven joint of leg i: at home it reads `at`; reflected mass, viscous friction, ends."""
    damping = {} if machine.friction is None else {"damping": number(viscous(machine)[i])}
    ET.SubElement(
        body, "joint", name=f"{name} {i + 1}", type="slide", axis=number(axis), ref=number(at), range=number(travel),
        armature=number(mass), **damping,
    )  # fmt: skip


def hinge(body, name: str, axis, **more: str) -> None:
    """A hinge; free all round where no range is given."""
    ET.SubElement(body, "joint", name=name, type="hinge", axis=number(axis), **(more or {"limited": "false"}))


def platform_joints(machine) -> np.ndarray:
    """Where the legs hold the platform, in T.  (n, 3)."""
    return machine.platform_joints_np() if hasattr(machine, "platform_joints_np") else machine.joints.platform


def platform(base, machine, end: str) -> None:
    """The platform with the tool; frame T, free in W; sites `end` where the legs hold it."""
    home, angles = machine.home, machine.tool_pose(machine.home)[3:]
    turn, R_WT = frames.quaternion_of_abc_np(angles), frames.rotation_of_abc_np(angles)
    body = ET.SubElement(base, "body", name="platform", pos=number(home[:3]), quat=number(turn))
    for i, axis in enumerate("xyz"):  # an axis is read in the frame of its body: x of W is a row of R_WT in T
        ET.SubElement(
            body, "joint", name=f"tool {axis}", type="slide", axis=number(R_WT[i]), ref=number(home[i]),
            limited="false",
        )  # fmt: skip
    ET.SubElement(body, "joint", name="tool turn", type="ball", limited="false")
    center, inertia, tool = machine.platform.center, machine.platform.inertia, getattr(machine, "tool", None)
    if tool is not None:  # from P to T
        R_TP = frames.rotation_of_abc_np(tool.angles).T
        center, inertia = R_TP @ (center - tool.position), R_TP @ inertia @ R_TP.T
    inertial(body, machine.platform.mass, center, inertia)
    ET.SubElement(body, "site", name="tool", pos="0 0 0")
    joints = platform_joints(machine)
    for i, place in enumerate(joints, 1):
        ET.SubElement(body, "site", name=end.format(i), pos=number(place))
    mjcf_shapes.platform(body, joints)


def viscous(machine) -> np.ndarray:
    """Viscous friction of the driven joints that does not depend on the load.  (n,) N s/m."""
    friction = machine.friction
    if friction is None:
        return np.zeros(machine.joints_count)
    constant = friction.viscous_offset if hasattr(friction, "viscous_offset") else friction.viscous
    return np.broadcast_to(constant, machine.joints_count)
