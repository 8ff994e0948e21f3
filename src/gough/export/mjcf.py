"""A machine as an MJCF model: the file that MuJoCo opens and Pinocchio reads.

The tree: one body without joints, the base, holds all, for Pinocchio reads one tree only.  On it stands the platform,
its frame T (a tool frame P is folded in), free by three slides x y z, whose coordinates are p_WT, and a ball joint,
whose quaternion q turns it from home: R_WT = R_home R(q); its velocity is w in axes of T.  And the legs, as
mjcf_hexapod.py, mjcf_hexaglide.py and mjcf_tripod.py write them.  The loops are closed by an equality `connect` of the
leg's and the platform's joint, three rows a leg, which leave the freedoms of the machine.  A hybrid machine and an axis
have no such platform: mjcf_hybrid.py, mjcf_axis.py.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from importlib import import_module

import numpy as np

from ..errors import ExperimentError, SheetError, did_you_mean
from ..machine.drives import force_limit
from . import mjcf_parts, mjcf_shapes
from .mjcf_frames import strut_frame
from .mjcf_parts import Kind, number, viscous

__all__ = ["mjcf", "positions", "stiffness", "strut_frame", "viscous"]

KINDS = {
    "hexapod": ".mjcf_hexapod", "hexaglide": ".mjcf_hexaglide", "tripod": ".mjcf_tripod", "hybrid": ".mjcf_hybrid",
    "axis": ".mjcf_axis",
}  # fmt: skip

# MuJoCo holds the loops by springs with dampers: a rate w = 1 / (time constant x damping ratio), and a share d of the
# exact constraint force.  Its own: 20 ms and 0.9 to 0.95.  "stiff": as stiff as a step h bears, critically damped.
LOOPS = ("default", "stiff")
STIFF_RATE = 0.7  # w h; at 1 MuJoCo's Euler step is unstable on nist-octahedral
STIFF_SHARE = 0.9999  # the largest that MuJoCo takes
STEP = {"default": 1e-3, "stiff": 0.25e-3}  # s


def mjcf(machine, loops: str = "default", timestep: float | None = None) -> str:
    """The machine as the text of an MJCF file.

    Parameters
    ----------
    machine
        a machine of a kind of KINDS.  Friction: the viscous part is written as damping of the slides; Coulomb friction,
        bristles and friction that scales with load have no like in MuJoCo and are left out; a comment in the file says
        so.
    loops
        "default": MuJoCo's own soft constraints, under which these machines sag by a millimetre.  "stiff": springs as
        stiff as the step bears, and RK4; the pose is then right to some 0.03 um at 1 ms, a quarter of it at half the
        step.  A model loaded with "stiff" must not be given a larger step.
    timestep
        of MuJoCo's integrator, s; else 1 ms, or 0.25 ms with "stiff".

    Raises
    ------
    SheetError
        a machine of another kind.
    ExperimentError
        no such way to close the loops, or a step that is not a positive number.
    """
    kind = _kind(machine)
    if loops not in LOOPS:
        raise ExperimentError(
            "no such way to close the loops", key="loops", value=ascii(loops), cure=did_you_mean(str(loops), LOOPS)
        )
    step = STEP[loops] if timestep is None else timestep
    if not (np.isfinite(step) and step > 0):
        raise ExperimentError("the step must be a positive number of seconds", key="timestep", value=f"{step}")
    root = ET.Element("mujoco", model=machine.name)
    root.append(ET.Comment(_note(machine, kind, loops)))
    ET.SubElement(root, "compiler", angle="radian", autolimits="true", inertiafromgeom="false")
    rk4 = {"integrator": "RK4"} if loops == "stiff" else {}
    ET.SubElement(root, "option", timestep=number(step), gravity=number(machine.gravity), **rk4)
    mjcf_shapes.visual(root)
    base = ET.SubElement(ET.SubElement(root, "worldbody"), "body", name="base")
    ET.SubElement(base, "inertial", pos="0 0 0", mass="0", diaginertia="0 0 0")  # Pinocchio wants one of every body
    if kind.platform_end:
        mjcf_parts.platform(base, machine, kind.platform_end)
    kind.legs(base, machine)
    equality = ET.SubElement(root, "equality")
    pull = stiffness(step) if loops == "stiff" else {}
    for name, one, other in kind.loops(machine):
        ET.SubElement(equality, "connect", name=name, site1=one, site2=other, **pull)
    _drives(root, machine, kind)
    _home(root, machine, kind)
    ET.indent(root, "  ")
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def positions(machine, x) -> np.ndarray:
    """`qpos` of the exported model at task coordinates x (..., d): poses, or tips of a 3-PRS; loops closed to rounding.

    Pinocchio writes the quaternion, entries 3 to 6, with w last.  (..., d) -> (..., 7 + joints of the legs).

    Raises
    ------
    SheetError
        a machine of a kind that is not written.
    """
    return _kind(machine).positions(machine, np.asarray(x, float))


def _kind(machine) -> Kind:
    kind = str(getattr(machine, "kind", ""))
    if kind not in KINDS or not hasattr(machine, "joints_count"):
        raise SheetError(
            "no machine of this kind can be written as mjcf", key="kind", value=kind, cure=f"{', '.join(KINDS)} can"
        )
    return import_module(KINDS[kind], __package__).KIND


def stiffness(step: float) -> dict[str, str]:
    """solref and solimp of a loop that is as stiff as a step (s) bears."""
    rate = STIFF_RATE / step
    return {"solref": number([-rate * rate, -2 * rate]), "solimp": number([STIFF_SHARE, STIFF_SHARE, 1e-3, 0.5, 2.0])}


def _drives(root, machine, kind: Kind):
    """Motors on the slides, in N, and what a controller reads."""
    limit = force_limit(machine.drive)
    actuator, sensor = ET.SubElement(root, "actuator"), ET.SubElement(root, "sensor")
    for i, joint in enumerate(kind.driven(machine), 1):
        bound = {} if limit is None else {"ctrlrange": number([-limit, limit])}
        ET.SubElement(actuator, "motor", name=f"drive {i}", joint=joint, **bound)
        ET.SubElement(sensor, "jointpos", name=f"{kind.reading} {i}", joint=joint)
    ET.SubElement(sensor, "framepos", name="tool position", objtype="site", objname="tool")
    ET.SubElement(sensor, "framequat", name="tool orientation", objtype="site", objname="tool")


def _home(root, machine, kind: Kind):
    """The key frame `home`: at rest, held by the forces of rest."""
    rest = np.zeros(len(machine.task))
    u = machine.inverse_dynamics(machine.home, rest, rest)
    q = kind.positions(machine, machine.home) + 0.0  # no -0
    ET.SubElement(ET.SubElement(root, "keyframe"), "key", name="home", qpos=number(q), ctrl=number(u))


def _note(machine, kind: Kind, loops: str) -> str:
    from .. import __version__

    left_out = ["joint cones", "delay and resolution of the drives"]
    if machine.compliance:
        left_out.append("compliance: all joints are rigid")
    if machine.friction is not None:
        left_out.append(f"all friction of kind {machine.friction.kind} but its constant viscous part")
    joint = " ".join(f'"{name}"' for name in kind.names) if kind.names else f'"{kind.joint} i"'
    text = f"""
  gough {__version__}: machine {machine.name}, SI units, W fixed in the base.  Loops: {loops}.
  Joint {joint} is {kind.said}, its motor the force along it in N; key frame "home" is at rest.
  Left out: {", ".join(left_out)}.
"""
    return text.replace("--", "- -")  # a comment of XML holds no double hyphen
