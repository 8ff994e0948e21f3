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

from typing import ClassVar, Literal

import casadi as ca
import numpy as np
from pydantic import Field, model_validator

from .. import frames
from ..declare import Array, quantity
from ..mechanics import bodies
from ..mechanics.load_friction import FrictionLaw
from . import strut_bodies
from .base import Feed
from .drives import Screw, reflected_mass
from .hexapod_parts import Joints, Strut, Tool
from .joint_forces import JointForces
from .platform import columns, outline
from .strut import StrutLoad
from .strut_limits import StrutLimits, check_guides, check_home, check_joints, check_sizes, check_spin, possible_lengths
from .strut_motion import StrutMotion, point_motion


class Hexapod(JointForces):
    """Six-strut parallel machine tool.  Fields are the tables of its data sheet."""

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

    elastic_places: ClassVar = {"drive": "axial", "strut": "axial", "base joint": "full", "platform joint": "full"}

    kind: Literal["hexapod"] = "hexapod"
    name: str = Field(default="hexapod", max_length=64, pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$")
    gravity: Array = quantity("m/s2", "gravity, in W", default=[0.0, 0.0, -9.81], shape=(3,))
    platform: bodies.Body
    joints: Joints
    tool: Tool | None = None
    strut: Strut | None = None
    drive: Screw
    friction: FrictionLaw | None = None
    limits: StrutLimits
    feed: Feed = Feed()
    home: Array = quantity("m, m, m, rad, rad, rad", "pose at rest, x y z a b c of T in W", shape=(6,))
    source: dict[str, str] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _sound(self):
        check_joints(self.joints.base, self.joints.platform)
        check_sizes(self)
        self._check_friction()
        check_spin(self)
        check_guides(self)
        R_home = frames.rotation_of_abc_np(self.home[3:])
        check_home(self, self.home[:3] + self.platform_joints_np() @ R_home.T)
        return self

    # -- kinematics -----------------------------------------------------------------------------------------------

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
        return ca.horzcat(n.T, columns(ca.cross, b, n).T)

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
        out = self.platform_inertial(p)
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

    def carried_by(self, place, p, z):
        """A strut is a two-force member: n at the base joint, in W, and at the platform joint, in T.  (3, 6), None."""
        n = self.struts(p, z)[3]
        return (n if place == "base joint" else frames.rotation_of_quaternion(z[3:]).T @ n), None

    @staticmethod
    def motor_load(p, pi):
        """The reflected mass of screw and motor; no weight.  (6,) kg, (6,) N, pi without it."""
        rest = {key: value for key, value in pi.items() if key != "drive.m"}
        return ca.repmat(ca.SX(pi.get("drive.m", 0)), 6), ca.SX(6, 1), rest

    @property
    def slender(self) -> bool:
        """Whether eq. (5) says all of the struts: slender parts, and a cross without inertia."""
        parts = () if self.strut is None else (self.strut.moving, self.strut.fixed)
        return self.joints.cross is None and not any(part.general for part in parts)

    @staticmethod
    def axis_of(p, i):
        """The axis of base joint i that is fixed in the base, in W; None where the sheet has none.  (3,)."""
        return None if p.joints.base_axis is None else p.joints.base_axis[i, :].T

    # -- limits ---------------------------------------------------------------------------------------------------

    def margins(self, p, z):
        """Names and values of all that must be >= 0: stroke, joint cones, distance from a singularity."""
        home = self.coordinates_of(p, p.home)
        _, _, l, n = self.struts(p, z)
        _, _, _, n_home = self.struts(p, home)
        names = [f"{joint}: {what}" for what in ("too short", "too long") for joint in self.joint_names]
        values = [l.T - p.limits.length[0], p.limits.length[1] - l.T]
        for more, found in (
            self.cone_margins(p, self.joint_names, ("base", "platform"), z, home, n, n_home),
            self.singular_margin(p, z),
        ):
            names += more
            values += found
        return tuple(names), ca.vertcat(*values)

    def limit_told(self, index, margin):
        if index >= 12:
            return super().limit_told(index, margin)
        bound = self.limits.length[0 if index < 6 else 1]
        length = bound + margin if index < 6 else bound - margin
        return self.limit_names[index], f"{length:.8g} m", f"{bound:g} m"

    def possible(self, q):
        return possible_lengths(self, q)

    @staticmethod
    def stride_of(p):
        return 0.25 * ca.sqrt(ca.mmax(ca.sum2((ca.SX(p.joints.base) - ca.SX(p.joints.platform)) ** 2)))

    def drawing(self, x):
        """The machine as polylines in W at the pose x.  List of {"name", "points"}."""
        A, T = self.joints.base, frames.rotation_of_abc_np(np.asarray(x, float)[3:])
        B = np.asarray(x)[:3] + self.platform_joints_np() @ T.T
        tip = np.asarray(x)[:3]
        middle = B.mean(0)
        lines = [{"name": "base", "points": outline(A)}]
        lines += [{"name": name, "points": [A[i].tolist(), B[i].tolist()]} for i, name in enumerate(self.joint_names)]
        lines.append({"name": "platform", "points": outline(B)})
        lines.append({"name": "tool", "points": [middle.tolist(), tip.tolist()]})
        return lines


def _massless(pi) -> bool:
    """Whether struts and drives have no inertia."""
    return not any(key.startswith(("strut", "drive", "joints")) for key in pi)
