"""How an exported machine looks in MuJoCo's viewer: shapes without mass that touch nothing."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np

_STEEL, _CAST, _TUBE, _TOOL = "0.55 0.58 0.62 1", "0.30 0.36 0.42 1", "0.75 0.77 0.80 1", "0.85 0.55 0.20 1"


def _geom(parent, kind: str, size, colour: str, **more):
    """A shape that is only seen: no mass, no contact."""
    text = {key: " ".join(f"{v:.6g}" for v in np.ravel(value)) for key, value in {"size": size, **more}.items()}
    ET.SubElement(parent, "geom", type=kind, rgba=colour, contype="0", conaffinity="0", mass="0", group="1", **text)


def visual(root) -> None:
    """Light, floor of the picture, and how far the camera stands."""
    ET.SubElement(root, "statistic", meansize="0.3")
    seen = ET.SubElement(root, "visual")
    ET.SubElement(seen, "headlight", ambient="0.4 0.4 0.4", diffuse="0.6 0.6 0.6", specular="0.1 0.1 0.1")
    asset = ET.SubElement(root, "asset")
    ET.SubElement(
        asset, "texture", type="skybox", builtin="gradient", rgb1="0.9 0.93 0.96", rgb2="0.6 0.66 0.72",
        width="64", height="256",
    )  # fmt: skip


def base(world, machine) -> None:
    """The frame: bars from base joint to base joint, in their order around the middle, and a ball at each."""
    points = machine.joints.base
    order = _around(points)
    for i, j in zip(order, [*order[1:], order[0]], strict=True):
        _geom(world, "capsule", [0.025], _CAST, fromto=[*points[i], *points[j]])
    for point in points:
        _geom(world, "sphere", [0.05], _CAST, pos=point)


def platform(body, joints) -> None:
    """Spokes to the platform joints, the spindle, and the tool down to the tip; all in T."""
    middle = joints.mean(0)
    for point in joints:
        _geom(body, "capsule", [0.03], _STEEL, fromto=[*middle, *point])
        _geom(body, "sphere", [0.035], _STEEL, pos=point)
    if np.linalg.norm(middle) > 0.05:  # the tip is below the plate
        collar = 0.25 * middle
        _geom(body, "cylinder", [0.06], _STEEL, fromto=[*middle, *collar])
        _geom(body, "cylinder", [0.012], _TOOL, fromto=[*collar, 0, 0, 0])
    else:
        _geom(body, "cylinder", [0.06], _STEEL, fromto=[0, 0, 0.3, 0, 0, 0.02])
        _geom(body, "cylinder", [0.012], _TOOL, fromto=[0, 0, 0.02, 0, 0, 0])


def strut(sleeve, tube, limits) -> None:
    """The sleeve along its own z from A, the tube back from B; the longest strut still has the one in the other."""
    shortest, longest = float(np.min(limits)), float(np.max(limits))
    _geom(sleeve, "cylinder", [0.045], _CAST, fromto=[0, 0, 0, 0, 0, 0.6 * shortest])
    _geom(tube, "cylinder", [0.03], _TUBE, fromto=[0, 0, 0, 0, 0, 0.5 * shortest - longest])


def rails(world, machine) -> None:
    """A bar a rail, from end to end of the travel; carriages that share a rail share its bar."""
    ends = {}
    for point, e in zip(machine.rails.point, machine.rails.direction, strict=True):
        first, last = (point + q * e for q in machine.limits.travel)
        ends[tuple(np.round([*first, *last], 6))] = None
    for fromto in ends:
        _geom(world, "capsule", [0.02], _CAST, fromto=fromto)


def rail(body, ends) -> None:
    """A bar between two points (2, 3)."""
    _geom(body, "capsule", [0.02], _CAST, fromto=np.ravel(ends))


def block(body) -> None:
    """A carriage."""
    _geom(body, "box", [0.06, 0.06, 0.06], _STEEL)


def carriage(body, leg, length: float) -> None:
    """A block on its rail, and the bar of `length` from it."""
    _geom(body, "box", [0.05, 0.05, 0.05], _CAST)
    _geom(leg, "cylinder", [0.02], _TUBE, fromto=[0, 0, 0, 0, 0, length])


def _around(points) -> list[int]:
    d = points - points.mean(0)
    _, _, axes = np.linalg.svd(d)  # the first two span the plane of the points
    return np.argsort(np.arctan2(d @ axes[1], d @ axes[0])).tolist()
