"""Gough-Stewart machine, 6-UPS: six struts of variable length carry a platform with the tool.

            B_i            frames  W   fixed in the base           points  A_i  base joint (universal), fixed in W
       ____/_\\____  T             T   tool: origin at the tip,             B_i  platform joint (spherical), fixed in T
          /   \\                       third axis from tip to spindle      n_i  from A_i to B_i, unit, in W
     ____A_____A__   W

Coordinates z = [p_WT (3), quaternion of R_WT (4)], velocities V = V_WT = [v; w], both in W.

    s = p_WT + b - p_WA,   b = R_WT p_TB,   l = |s|,   n = s / l                                                 (1)
    l' = n . v_B,   v_B = v + w x b      ->  row of J:  [n', (b x n)']                                          (2)
    nu = n' = (v_B - l' n) / l                                                                                  (3)
    l'' = n . a_B + l |nu|^2,   a_B = v' + w' x b + w x (w x b)                                                 (4)

One strut, seen from the platform joint.  Its moving part (mass m, first moment k = m c measured from B towards A,
transverse inertia I about B), its fixed part (k_f = m_f c_f measured from A, I_f about A), the turning parts
(reflected mass m_r) and the axial inertia I_a of both, need the force on B, with P = 1 - n n' and g gravity,

    F = n [ m n.(a_B - g) + k |nu|^2 + m_r l'' ]
      + P (m - k/l) (a_B - g) + ((I + I_f)/l - k) P nu' - (k_f/l) P g
      + I_a [ sigma (nu x n)/l + G sigma' ]                                                                     (5)
    P nu' = (P a_B - 2 l' nu) / l

The universal joint turns about a, fixed in W, and about a x n; so the strut spins about itself at

    sigma = k_a tau / (1 - k_a^2),   k_a = a . n,   tau = a . (n x nu),    G = d sigma / d v_B                   (6)

The platform is one rigid body (`mechanics.bodies.rigid_wrench`).  Then M V' + h = J' (u - friction) + w: Newton-Euler
for the platform plus the six forces F at the points B; (5) is linear in the masses, moments and inertias.
(5) is that of slender parts; parts with centres of mass off the axis or full inertias, and crosses with inertia, are in
strut_bodies.py.  Forces in the joints and the friction they make: reactions.py, joint_forces.py.
Left out: the screw's gyroscopic moment (it turns about n), compliance.
Derivation: docs/theory/hexapod.md.  Sources: Merlet, Parallel Robots, 2nd ed. 2006, ch. 3, 5, 10 for (1), (2);
(5), (6) by virtual work, checked against Lagrange in tests/oracle/lagrange.py.
"""

from __future__ import annotations

from typing import Any, ClassVar, Literal

import casadi as ca
import numpy as np
from pydantic import Field, model_validator

from .. import frames
from ..declare import Array, quantity
from ..errors import InputError
from ..mechanics import bodies
from ..mechanics.linear import determinant_6
from ..mechanics.load_friction import FrictionLaw
from . import strut_bodies
from .base import Drive, Feed, reflected_mass
from .hexapod_parts import Joints, Strut, Tool
from .joint_forces import JointForces
from .limits import Limits, check_guides, check_home, check_joints, check_sizes, check_spin
from .strut import StrutLoad
from .strut_motion import StrutMotion, point_motion


class Hexapod(JointForces):
    """Six-strut parallel machine tool.  Fields are the tables of its data sheet."""

    task: ClassVar = (("x", "m"), ("y", "m"), ("z", "m"), ("a", "rad"), ("b", "rad"), ("c", "rad"))
    velocities: ClassVar = tuple(f"{name}_WT" for name in ("vx", "vy", "vz", "wx", "wy", "wz"))
    joint_names: ClassVar = tuple(f"strut {i}" for i in range(1, 7))
    # Garagic and Srinivasan, ACC 2004, eq. (3); of a load-free friction the viscous part is V_a
    adaptable: ClassVar = (
        "drive.inertia",
        "friction.viscous_offset",
        "platform.mass",
        "strut.moving.mass",
        "strut.fixed.mass",
        "strut.moving.transverse + strut.fixed.transverse",
        "platform.inertia[0,0]",
        "platform.inertia[1,1]",
        "platform.inertia[2,2]",
    )

    kind: Literal["hexapod"] = "hexapod"
    name: str = Field(default="hexapod", max_length=64, pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$")
    gravity: Array = quantity("m/s2", "gravity, in W", default=[0.0, 0.0, -9.81], shape=(3,))
    platform: bodies.Body
    joints: Joints
    tool: Tool | None = None
    strut: Strut | None = None
    drive: Drive
    friction: FrictionLaw | None = None
    limits: Limits
    feed: Feed = Feed()
    home: Array = quantity("m, m, m, rad, rad, rad", "pose at rest, x y z a b c of T in W", shape=(6,))
    source: dict[str, str] = Field(default_factory=dict)

    @model_validator(mode="before")
    @classmethod
    def _home_table(cls, data: Any) -> Any:
        """A sheet writes the pose at rest as a table, [home] pose = [...]."""
        if isinstance(data, dict) and isinstance(data.get("home"), dict):
            if set(data["home"]) != {"pose"}:
                raise InputError("[home] has one key, pose", key="home", value=", ".join(map(str, data["home"])))
            data = {**data, "home": data["home"]["pose"]}
        return data

    @model_validator(mode="after")
    def _sound(self):
        check_joints(self.joints.base, self.joints.platform)
        check_sizes(self)
        for key in () if self.friction is None else self.friction.specs():
            numbers = getattr(self.friction, key)
            if np.ndim(numbers) and len(numbers) != 6:
                raise InputError("friction needs one value or six", key=f"friction.{key}", value=str(len(numbers)))
        check_spin(self)
        check_guides(self)
        R_home = frames.rotation_of_abc_np(self.home[3:])
        check_home(self, self.home[:3] + self.platform_joints_np() @ R_home.T)
        return self

    # -- coordinates ----------------------------------------------------------------------------------------------

    @staticmethod
    def coordinates_of(x):
        """z of a pose x y z a b c.  (6,) -> (7,)."""
        return ca.vertcat(x[:3], frames.quaternion_of_abc(x[3:]))

    @staticmethod
    def tool_pose_of(z):
        """Position and quaternion of T in W.  (7,) -> (3,), (4,)."""
        return z[:3], z[3:]

    @staticmethod
    def rate(p, z, v):
        """z' of coordinates (7,) and twist (6,).  (7,)."""
        return ca.vertcat(v[:3], frames.quaternion_rate(z[3:], v[3:]))

    @staticmethod
    def normalised(z):
        """z with its quaternion of unit length again.  (7,)."""
        return ca.vertcat(z[:3], z[3:] / ca.norm_2(z[3:]))

    @staticmethod
    def stepped(z, d):
        """z moved by a small twist d = [dp; rotation vector in W]: a step on SO(3), not on angles.  (7,)."""
        return ca.vertcat(z[:3] + d[:3], frames.quaternion_product(frames.quaternion_of_rotation_vector(d[3:]), z[3:]))

    @staticmethod
    def bracket(v, w):
        """[v, w] of twists in axes of W: translations commute, turnings do not.  (6,)."""
        return ca.vertcat(ca.SX(3, 1), ca.cross(w[3:], v[3:]))

    # -- kinematics -----------------------------------------------------------------------------------------------

    @staticmethod
    def platform_joints(p):
        """p_TB, in T.  (3, 6)."""
        if p.tool is None:
            return p.joints.platform.T
        R_TP = frames.rotation_of_abc(p.tool.angles).T
        return R_TP @ (p.joints.platform.T - ca.repmat(p.tool.position, 1, 6))

    def platform_joints_np(self) -> np.ndarray:
        """p_TB as numbers.  (6, 3)."""
        return self.joints.platform if self.tool is None else np.array(ca.DM(self.platform_joints(self))).T

    def struts(self, p, z):
        """(b, s, l, n) of eq. (1): (3, 6), (3, 6), (1, 6), (3, 6), all in W."""
        b = frames.rotation_of_quaternion(z[3:]) @ self.platform_joints(p)
        s = ca.repmat(z[:3], 1, 6) + b - p.joints.base.T
        l = ca.sqrt(ca.sum1(s * s))
        return b, s, l, s / ca.repmat(l, 3, 1)

    def joints_of(self, p, z):
        """Strut lengths, eq. (1).  (6,) m."""
        return self.struts(p, z)[2].T

    def jacobian_of(self, p, z):
        """J of eq. (2): q' = J [v; w].  (6, 6)."""
        b, _, _, n = self.struts(p, z)
        return ca.horzcat(n.T, _columns(ca.cross, b, n).T)

    def joint_acceleration(self, p, z, v, vd):
        """l'' of eq. (4).  (6,) m/s2."""
        b, _, l, n = self.struts(p, z)
        out = []
        for i in range(6):
            v_B, a_B = point_motion(b[:, i], v, vd)
            ld = ca.dot(n[:, i], v_B)
            out.append(ca.dot(n[:, i], a_B) + (ca.dot(v_B, v_B) - ld * ld) / l[i])
        return ca.vertcat(*out)

    # -- dynamics -------------------------------------------------------------------------------------------------

    def inertial(self, p):
        """The parameters the dynamics are linear in: {name: (SX, unit)}.

        Per body m, m c and I about the origin of its frame: platform in T, moving part at B, fixed part at A; then
        the reflected mass of the drives.
        """
        m, mc, I = bodies.first_moments(p.platform)
        if p.tool is not None:  # from P to T
            R_TP = frames.rotation_of_abc(p.tool.angles).T
            shifted = mc - m * p.tool.position
            S, Sc = bodies.skew(p.tool.position), bodies.skew(mc)
            I = R_TP @ (I + Sc @ S + S @ Sc - m * S @ S) @ R_TP.T
            mc = R_TP @ shifted
        out = {"platform.m": (m, "kg")}
        out |= {f"platform.m c{axis}": (mc[i], "kg m") for i, axis in enumerate("xyz")}
        for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)):
            out[f"platform.I{'xyz'[i]}{'xyz'[j]}"] = (I[i, j], "kg m2")
        if p.strut is not None:
            out |= strut_bodies.inertial(p.strut)
        if p.joints.cross is not None:
            out["joints.cross"] = (p.joints.cross, "kg m2")
        if p.drive.inertia is not None:
            out["drive.m"] = (reflected_mass(p.drive), "kg")
        return out

    def inverse_force(self, p, pi, z, v, vd):
        """M v' + h, on the twist, eqs. (3)-(6).  pi as `inertial` names it.  (6,) [N; N m]."""
        R = frames.rotation_of_quaternion(z[3:])
        m, mc_W, I_W = self._platform_in_W(pi, R)
        total = bodies.rigid_wrench(m, mc_W, I_W, v[3:], vd[:3] - p.gravity, vd[3:])
        if _massless(pi):
            return total
        b, _, l, n = self.struts(p, z)
        general, slender = strut_bodies.StrutBodies(pi), StrutLoad(pi)
        for i in range(6):
            if self.slender:
                F = slender.force(p, i, l[i], n[:, i], *point_motion(b[:, i], v, vd))
            else:
                motion = StrutMotion(self.axis_of(p, i), b[:, i], l[i], n[:, i], v, vd)
                F = general.force(motion, p.gravity)
                if "joints.cross" in pi:
                    F += strut_bodies.cross_force(pi["joints.cross"], motion)
            total += ca.vertcat(F, ca.cross(b[:, i], F))
        return total

    def mass_and_bias(self, p, pi, z, v):
        """M (6, 6) and h (6,) of M v' + h.  M from the mass seen at each platform joint, h at v' = 0."""
        R = frames.rotation_of_quaternion(z[3:])
        m, mc_W, I_W = self._platform_in_W(pi, R)
        S = frames.skew(mc_W)
        corner, cross, turn = m * ca.SX.eye(3), -S, I_W
        if not _massless(pi):
            b, _, l, n = self.struts(p, z)
            general, slender = strut_bodies.StrutBodies(pi), StrutLoad(pi)
            for i in range(6):
                a = self.axis_of(p, i)
                M_B = slender.mass(p, i, l[i], n[:, i]) if self.slender else general.mass(a, l[i], n[:, i])
                if "joints.cross" in pi:
                    M_B += strut_bodies.cross_mass(pi["joints.cross"], a, l[i], n[:, i])
                B = frames.skew(b[:, i])
                corner, cross, turn = corner + M_B, cross - M_B @ B, turn - B @ M_B @ B
        M = ca.vertcat(ca.horzcat(corner, cross), ca.horzcat(cross.T, turn))
        return M, self.inverse_force(p, pi, z, v, ca.SX(6, 1))

    @property
    def slender(self) -> bool:
        """Whether eq. (5) says all of the struts: slender parts, and a cross without inertia."""
        parts = () if self.strut is None else (self.strut.moving, self.strut.fixed)
        return self.joints.cross is None and not any(part.general for part in parts)

    @staticmethod
    def axis_of(p, i):
        """The axis of base joint i that is fixed in the base, in W; None where the sheet has none.  (3,)."""
        return None if p.joints.base_axis is None else p.joints.base_axis[i, :].T

    @staticmethod
    def _platform_in_W(pi, R):
        def of(key):
            return pi[f"platform.{key}"]

        mc = ca.vertcat(*[of(f"m c{axis}") for axis in "xyz"])
        I = ca.vertcat(
            ca.horzcat(of("Ixx"), of("Ixy"), of("Ixz")),
            ca.horzcat(of("Ixy"), of("Iyy"), of("Iyz")),
            ca.horzcat(of("Ixz"), of("Iyz"), of("Izz")),
        )
        return of("m"), R @ mc, R @ I @ R.T

    # -- limits ---------------------------------------------------------------------------------------------------

    def margins(self, p, z):
        """Names and values of all that must be >= 0: stroke, joint cones, distance from a singularity."""
        home = self.coordinates_of(p.home)
        _, _, l, n = self.struts(p, z)
        _, _, _, n_home = self.struts(p, home)
        R, R_home = (frames.rotation_of_quaternion(y[3:]) for y in (z, home))
        names = [f"{joint}: {what}" for what in ("too short", "too long") for joint in self.joint_names]
        values = [l.T - p.limits.length[0], p.limits.length[1] - l.T]
        if p.limits.cone is not None:
            least = ca.cos(p.limits.cone)
            names += [
                f"{joint}: {end} joint beyond its cone" for end in ("base", "platform") for joint in self.joint_names
            ]
            values += [ca.sum1(n * n_home).T - least, ca.sum1((R.T @ n) * (R_home.T @ n_home)).T - least]
        names.append("near a singularity: det J against home")
        values.append(self.determinant_of(p, z) - p.limits.determinant)
        return tuple(names), ca.vertcat(*values)

    def determinant_of(self, p, z):
        """det J as a fraction of home's; 0 at a singular pose, negative in another assembly mode."""
        home = self.coordinates_of(p.home)
        return determinant_6(self.jacobian_of(p, z)) / determinant_6(self.jacobian_of(p, home))

    def drawing(self, x):
        """The machine as polylines in W at the pose x.  List of {"name", "points"}."""
        A, T = self.joints.base, frames.rotation_of_abc_np(np.asarray(x, float)[3:])
        B = np.asarray(x)[:3] + self.platform_joints_np() @ T.T
        tip = np.asarray(x)[:3]
        middle = B.mean(0)
        lines = [{"name": "base", "points": _outline(A)}]
        lines += [{"name": name, "points": [A[i].tolist(), B[i].tolist()]} for i, name in enumerate(self.joint_names)]
        lines.append({"name": "platform", "points": _outline(B)})
        lines.append({"name": "tool", "points": [middle.tolist(), tip.tolist()]})
        return lines


def _massless(pi) -> bool:
    """Whether struts and drives have no inertia."""
    return not any(key.startswith(("strut", "drive", "joints")) for key in pi)


def _outline(points):
    """A closed polyline through points (6, 3), in their order around the middle."""
    d = points - points.mean(0)
    _, _, axes = np.linalg.svd(d)  # the first two span the plane of the points
    order = np.argsort(np.arctan2(d @ axes[1], d @ axes[0]))
    return points[[*order, order[0]]].tolist()


def _columns(function, A, B):
    return ca.horzcat(*[function(A[:, i], B[:, i]) for i in range(A.shape[1])])
