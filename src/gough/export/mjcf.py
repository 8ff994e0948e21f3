"""A hexapod as an MJCF model: the file that MuJoCo opens and Pinocchio reads.

The tree: one body without joints, the base, holds all, for Pinocchio reads one tree only.  On it stands the platform,
its frame T (a tool frame P is folded in), free by three slides x y z, whose coordinates are p_WT, and a ball joint,
whose quaternion q turns it from home: R_WT = R_home R(q); its velocity is w in axes of T.  And six struts: a sleeve
that turns about A on a universal joint, and a tube that slides in it; the slide's coordinate is the strut's length l.
Frames S of a strut stand as at home, with a the axis of the joint that is fixed in W:

    z_S = n,  y_S = n x a / |n x a|,  x_S = y_S x n,                R_WS = [x_S y_S z_S]                          (1)

first the hinge about a, then the hinge about y_S, fixed in the strut: a universal joint.  The tube's frame sits at B.
The loops are closed by an equality `connect` of the tube's and the platform's point B, three rows a strut, so 24
freedoms less 18 rows leave the six of the machine.

The reflected mass J (2 pi / lead)^2 of motor and screw is the slide's `armature`, which adds m_r l' ^2 / 2 to the
energy and nothing else, as in gough.  Rooting the struts in the base, not in the platform, keeps their inertias on
axes through fixed points, and every loop is closed by the mildest of constraints, a common point.

All numbers are written so that reading gives the same binary number.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np

from .. import frames
from ..errors import ExperimentError, SheetError, did_you_mean
from ..machine.drives import force_limit, reflected_mass
from ..machine.hexapod import Hexapod
from . import mjcf_shapes
from .mjcf_frames import Frame, positions, strut_frame

__all__ = ["mjcf", "positions", "stiffness", "strut_frame", "viscous"]

THIN = 1e-12  # kg m2; stands for the axial inertia of a body without one: MuJoCo refuses 0, and against the 0.1 kg m2
# and more across a strut it is below rounding.
LIGHT = 1e-9  # kg; stands for the mass of a body that only passes on forces, for the same reason

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
        a Hexapod.  Friction: the viscous part is written as damping of the slides; Coulomb friction, bristles and
        friction that scales with load have no like in MuJoCo and are left out; a comment in the file says so.
    loops
        "default": MuJoCo's own soft constraints, under which these machines sag by a millimetre.  "stiff": springs as
        stiff as the step bears, and RK4; the pose is then right to some 0.03 um at 1 ms, a quarter of it at half the
        step.  A model loaded with "stiff" must not be given a larger step.
    timestep
        of MuJoCo's integrator, s; else 1 ms, or 0.25 ms with "stiff".

    Raises
    ------
    SheetError
        not a hexapod.
    ExperimentError
        no such way to close the loops, or a step that is not a positive number.
    """
    if not isinstance(machine, Hexapod):
        raise SheetError("only a hexapod can be written as mjcf", key="kind", value=str(getattr(machine, "kind", "")))
    if loops not in LOOPS:
        raise ExperimentError(
            "no such way to close the loops", key="loops", value=ascii(loops), cure=did_you_mean(str(loops), LOOPS)
        )
    step = STEP[loops] if timestep is None else timestep
    if not (np.isfinite(step) and step > 0):
        raise ExperimentError("the step must be a positive number of seconds", key="timestep", value=f"{step}")
    root = ET.Element("mujoco", model=machine.name)
    root.append(ET.Comment(_note(machine, loops)))
    ET.SubElement(root, "compiler", angle="radian", autolimits="true", inertiafromgeom="false")
    rk4 = {"integrator": "RK4"} if loops == "stiff" else {}
    ET.SubElement(root, "option", timestep=_n(step), gravity=_n(machine.gravity), **rk4)
    mjcf_shapes.visual(root)
    world = ET.SubElement(root, "worldbody")
    base = ET.SubElement(world, "body", name="base")
    ET.SubElement(base, "inertial", pos="0 0 0", mass="0", diaginertia="0 0 0")  # Pinocchio wants one of every body
    mjcf_shapes.base(base, machine)
    _platform(base, machine)
    struts = [strut_frame(machine, i) for i in range(6)]
    for i, frame in enumerate(struts):
        _strut(base, machine, i, frame)
    equality = ET.SubElement(root, "equality")
    pull = stiffness(step) if loops == "stiff" else {}
    for i in range(1, 7):
        ET.SubElement(equality, "connect", name=f"joint {i}", site1=f"tube {i} B", site2=f"platform B{i}", **pull)
    _drives(root, machine)
    _home(root, machine, struts)
    ET.indent(root, "  ")
    return '<?xml version="1.0" encoding="utf-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def stiffness(step: float) -> dict[str, str]:
    """solref and solimp of a loop that is as stiff as a step (s) bears."""
    rate = STIFF_RATE / step
    return {"solref": _n([-rate * rate, -2 * rate]), "solimp": _n([STIFF_SHARE, STIFF_SHARE, 1e-3, 0.5, 2.0])}


def _platform(base, machine):
    """The platform with the tool; frame T, free in W."""
    home = machine.home
    body = ET.SubElement(
        base, "body", name="platform", pos=_n(home[:3]), quat=_n(frames.quaternion_of_abc_np(home[3:]))
    )
    for i, axis in enumerate("xyz"):
        ET.SubElement(
            body, "joint", name=f"tool {axis}", type="slide", axis=_n(np.eye(3)[i]), ref=_n(home[i]), limited="false"
        )
    ET.SubElement(body, "joint", name="tool turn", type="ball", limited="false")
    inner, center, inertia = machine.platform, machine.platform.center, machine.platform.inertia
    if machine.tool is not None:  # from P to T
        R_TP = frames.rotation_of_abc_np(machine.tool.angles).T
        center, inertia = R_TP @ (center - machine.tool.position), R_TP @ inertia @ R_TP.T
    _inertial(body, inner.mass, center, inertia)
    ET.SubElement(body, "site", name="tool", pos="0 0 0")
    joints = machine.platform_joints_np()
    for i in range(6):
        ET.SubElement(body, "site", name=f"platform B{i + 1}", pos=_n(joints[i]))
    mjcf_shapes.platform(body, joints)


def _strut(base, machine, i: int, frame: Frame):
    """Sleeve on its universal joint, tube on its slide; a cross between the joint's hinges where it has inertia."""
    number, strut = i + 1, machine.strut
    place = {"pos": _n(frame.p_WA), "quat": _n(frames.quaternion_of_rotation_np(frame.R_WS))}
    fork = {"name": f"fork {number}", "type": "hinge", "axis": _n(frame.axis_S), "limited": "false"}
    if machine.joints.cross is not None:  # turns about a only, so any inertia that is J about a will do
        base = ET.SubElement(base, "body", name=f"cross {number}", **place)
        ET.SubElement(base, "joint", fork)
        _inertial(base, LIGHT, np.zeros(3), (machine.joints.cross or THIN) * np.eye(3))
        place = {"pos": "0 0 0"}
    sleeve = ET.SubElement(base, "body", name=f"sleeve {number}", **place)
    if machine.joints.cross is None:
        ET.SubElement(sleeve, "joint", fork)
    ET.SubElement(sleeve, "joint", name=f"cross {number}", type="hinge", axis="0 1 0", limited="false")
    _part(sleeve, strut and strut.fixed, 1, f"strut.fixed of {machine.name}")
    tube = ET.SubElement(sleeve, "body", name=f"tube {number}", pos=_n([0, 0, frame.length]))
    slide = {"armature": _n(reflected_mass(machine.drive))}
    if machine.friction is not None:
        slide["damping"] = _n(viscous(machine)[i])
    ET.SubElement(
        tube, "joint", name=f"strut {number}", type="slide", axis="0 0 1",
        ref=_n(frame.length), range=_n(machine.limits.length), **slide,
    )  # fmt: skip
    _part(tube, strut and strut.moving, -1, f"strut.moving of {machine.name}")
    ET.SubElement(tube, "site", name=f"tube {number} B", pos="0 0 0")
    mjcf_shapes.strut(sleeve, tube, machine.limits.length)


def _part(body, part, sense: int, key: str):
    """One body of a strut in its frame; `sense` of `center` on z_S.  `part` None: next to nothing."""
    if part is None:
        _inertial(body, LIGHT, np.zeros(3), THIN * np.eye(3))
        return
    x, y = (0.0, 0.0) if part.offset is None else part.offset
    if part.inertia is not None:
        inertia = part.inertia
    else:
        across, axial = part.transverse or THIN, part.axial or THIN
        if axial > 2 * across:
            raise SheetError(
                "MuJoCo takes no body with more inertia about its axis than twice that across it",
                key=key, value=f"{axial:g} against {across:g} kg m2", cure="check axial and transverse",
            )  # fmt: skip
        inertia = np.diag([across, across, axial])
    _inertial(body, part.mass, [x, y, sense * part.center], inertia)


def viscous(machine) -> np.ndarray:
    """Viscous friction of the slides that does not depend on the load.  (6,) N s/m."""
    friction = machine.friction
    if friction is None:
        return np.zeros(6)
    constant = friction.viscous_offset if hasattr(friction, "viscous_offset") else friction.viscous
    return np.broadcast_to(constant, 6)


def _inertial(body, mass, center, inertia):
    inertia = np.asarray(inertia)
    if np.array_equal(inertia, np.diag(np.diag(inertia))):
        how = {"diaginertia": _n(np.diag(inertia))}
    else:
        how = {"fullinertia": _n(inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]])}
    ET.SubElement(body, "inertial", pos=_n(center), mass=_n(mass), **how)


def _drives(root, machine):
    """Motors on the slides, in N of strut force, and what a controller reads."""
    limit = force_limit(machine.drive)
    actuator, sensor = ET.SubElement(root, "actuator"), ET.SubElement(root, "sensor")
    for i in range(1, 7):
        bound = {} if limit is None else {"ctrlrange": _n([-limit, limit])}
        ET.SubElement(actuator, "motor", name=f"drive {i}", joint=f"strut {i}", **bound)
        ET.SubElement(sensor, "jointpos", name=f"length {i}", joint=f"strut {i}")
    ET.SubElement(sensor, "framepos", name="tool position", objtype="site", objname="tool")
    ET.SubElement(sensor, "framequat", name="tool orientation", objtype="site", objname="tool")


def _home(root, machine, struts):
    """The key frame `home`: at rest, held by the forces of rest."""
    home = machine.home
    q = [*home[:3], 1.0, 0.0, 0.0, 0.0]
    for frame in struts:
        q += [0.0, 0.0, frame.length]
    u = machine.inverse_dynamics(home, np.zeros(6), np.zeros(6))
    ET.SubElement(ET.SubElement(root, "keyframe"), "key", name="home", qpos=_n(q), ctrl=_n(u))


def _note(machine, loops: str) -> str:
    from .. import __version__

    left_out = ["joint cones", "delay and resolution of the drives"]
    if machine.friction is not None:
        left_out.append(f"all friction of kind {machine.friction.kind} but its constant viscous part")
    text = f"""
  gough {__version__}: machine {machine.name}, SI units, W fixed in the base.  Loops: {loops}.
  Joint "strut i" is the strut's length, its motor the strut's force in N; key frame "home" is at rest.
  Left out: {", ".join(left_out)}.
"""
    return text.replace("--", "- -")  # a comment of XML holds no double hyphen


def _n(value) -> str:
    """Numbers as text that reads back as the same numbers."""
    return " ".join(repr(float(v)) for v in np.atleast_1d(np.asarray(value, float)).ravel())
