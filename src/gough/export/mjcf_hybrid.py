"""A hybrid machine in MJCF: arm 1 with slide 1 and link 2, which has the ram and the passive slide; arm 6 with slide 6.

Joints and their coordinates are those of machine/hybrid.py: `arm 1` phi10, `slide 1` s21, `ram` s32, `passive` s54,
`arm 6` phi60, `slide 6` s65.  Links 2 and 5 are bodies without joints on the motors' sides.  Link 5 may not turn on
link 2 either, so the loop is closed by `connect` at two points across the passive slide: six rows of rank three, which
leave three of the six freedoms.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np

from .. import frames
from . import mjcf_shapes
from .mjcf_parts import LIGHT, THIN, Kind, hinge, inertial, number, viscous

ACROSS = 0.25  # m, from the passive slide to either point: as far as links are wide


def _arms(base, machine) -> None:
    s21, s65, s32, s54, phi10, phi60 = machine.standing(machine.home)
    b, overhang = machine.base.half_width, machine.base.overhang
    limits = machine.limits
    mjcf_shapes.rail(base, [[-b, 0, -overhang], [b, 0, -overhang]])
    slide_1 = _arm(base, machine, 1, -b, phi10, s21, 0)
    link_2 = ET.SubElement(slide_1, "body", name="link 2")
    _inertial(link_2, machine.link2)
    ram = ET.SubElement(link_2, "body", name="ram", pos=number([b, 0, overhang + s32]))
    _driven(ram, machine, "ram", 2, [0, 0, 1], s32)
    _inertial(ram, machine.ram)
    ET.SubElement(ram, "site", name="tool", pos="0 0 0")
    mjcf_shapes.rail(ram, [[0, 0, -overhang], [0, 0, 0]])
    passive = ET.SubElement(link_2, "body", name="passive", pos=number([s54, 0, 0]))
    ET.SubElement(
        passive, "joint", name="passive", type="slide", axis="1 0 0", ref=number(s54), range=number(limits.passive)
    )
    inertial(passive, LIGHT, np.zeros(3), THIN * np.eye(3))
    slide_6 = _arm(base, machine, 6, b, phi60, s65, 1)
    link_5 = ET.SubElement(slide_6, "body", name="link 5")
    _inertial(link_5, machine.link5)
    for body, name in ((passive, "link 2"), (link_5, "link 5")):
        for side, y in (("a", ACROSS), ("b", -ACROSS)):
            ET.SubElement(body, "site", name=f"{name} {side}", pos=number([0, y, 0]))
    mjcf_shapes.rail(link_2, [[0, 0, 0], [2 * b, 0, 0]])


def _arm(base, machine, number_: int, x: float, angle: float, place: float, i: int):
    """An arm on its pivot, and the motor's side of its slide, which is returned."""
    arm, pivot = machine.arm, [x, 0, -machine.base.overhang]
    turn = frames.quaternion_of_abc_np(np.array([0, 0, angle]))
    body = ET.SubElement(base, "body", name=f"arm {number_}", pos=number(pivot), quat=number(turn))
    hinge(body, f"arm {number_}", [0, 0, 1], ref=number(angle), range=number(machine.limits.angle))
    # it turns about one axis only: alike about all is a body that may be
    inertial(body, arm.mass, [0, arm.center, 0], arm.inertia * np.eye(3))
    mjcf_shapes.rail(body, [[0, 0, 0], [0, machine.limits.travel[i, 1], 0]])
    motor = ET.SubElement(body, "body", name=f"slide {number_}", pos=number([0, place, 0]))
    _driven(motor, machine, f"slide {number_}", i, [0, 1, 0], place)
    inertial(motor, machine.slide.mass, np.zeros(3), machine.slide.inertia * np.eye(3))
    mjcf_shapes.block(motor)
    return motor


def _driven(body, machine, name: str, i: int, axis, at: float) -> None:
    """The slide of a linear motor: nothing turns with it."""
    damping = {} if machine.friction is None else {"damping": number(viscous(machine)[i])}
    ET.SubElement(
        body, "joint", name=name, type="slide", axis=number(axis), ref=number(at),
        range=number(machine.limits.travel[i]), **damping,
    )  # fmt: skip


def _inertial(body, given) -> None:
    inertial(body, given.mass, given.center, given.inertia)


def _positions(machine, x) -> np.ndarray:
    """phi10, s21, s32, s54, phi60, s65 at tool tips.  (..., 3) -> (..., 6)."""
    s21, s65, s32, s54, phi10, phi60 = np.moveaxis(machine.standing(x), -1, 0)
    return np.stack([phi10, s21, s32, s54, phi60, s65], -1)


KIND = Kind(
    _arms, _positions, "", "", "slide", "place", "a motor's place on its arm, of the ram its own",
    ("slide 1", "slide 6", "ram"), tuple((f"link 5 {side}", f"link 5 {side}", f"link 2 {side}") for side in "ab"),
)  # fmt: skip
