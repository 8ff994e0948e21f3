"""Hexaglide, 6-PUS: six carriages on rails carry a platform with the tool, each by a leg of constant length.

      S_i ->   S_j        frames  W   fixed in the base           points  S_i  joint of carriage i, on its rail
     ==o========o===  W           T   tool: origin at the tip,            B_i  platform joint, fixed in T
        \\      /                      third axis from tip to spindle      u_i  from S_i to B_i, unit, in W
       B_\\____/_  T                                                        e_i  along the rail, the way q_i grows

Coordinates z = [p_WT (3), quaternion of R_WT (4)], velocities V = V_WT = [v; w], both in W.

    s = p_WT + b - p_WR,   b = R_WT p_TB,   p_WS = p_WR + q e                                                    (1)
    q = e.s + side sqrt(l^2 - d^2),   d = |s - (e.s) e|,   u = (s - q e) / l,   c = u . e                        (2)
    q' = u . v_B / c,   v_B = v + w x b      ->  row of J:  [u', (b x u)'] / c                                  (3)
    q'' = (u . a_B + |v_B - q' e|^2 / l) / c,   a_B = v' + w' x b + w x (w x b)                                  (4)

The side of each carriage is a number of its data sheet: which of the two places on its rail a leg reaches from.  A leg
whose joint is farther than l from the rail has none (d > l), and q, J, q'' are no numbers then.

A carriage (mass m_S) needs along its rail, and an even, slender leg (mass m_l) needs at its ends,

    f = m_S (q'' - e . g)                                                                                        (5)
    F_S = m_l (a_S / 3 + a_B / 6 - g / 2),   F_B = m_l (a_S / 6 + a_B / 3 - g / 2),   a_S = q'' e                (6)

and with the platform as one rigid body (`mechanics.bodies.rigid_wrench`, its moments about T)

    M V' + h = platform + sum of J_i' (f + e . F_S) + [F_B; b x F_B] = J' (u - friction) + w                     (7)

linear in m_S, m_l and the platform's m, m c, I.  Without leg mass it is the model of Honegger, Nonlinear adaptive
control of a 6 DOF parallel manipulator, 1998, eqs. (3), (5)-(17); (6) is what that paper neglects.
Derivation: docs/theory/hexaglide.md.  Forward kinematics is Newton's on |s - q e| = l (`newton_system`).
"""

from __future__ import annotations

from typing import ClassVar, Literal

import casadi as ca
import numpy as np
from pydantic import Field, model_validator

from .. import frames
from ..declare import Array, quantity
from ..errors import InputError, WorkspaceError
from ..mechanics import bodies
from ..mechanics.load_friction import FrictionLaw
from .base import Feed
from .drives import LinearMotor
from .hexaglide_parts import Carriage, Legs, PlatformJoints, RailLimits, Rails, check_home, legs_np
from .hexapod_parts import Tool
from .limits import check_points, check_weight
from .platform import PlatformMachine, columns, outline
from .rail_limits import possible_places, rail_limit_told, rail_margins
from .strut_motion import point_motion


class Hexaglide(PlatformMachine):
    """Six carriages on rails, six legs of constant length.  Fields are the tables of its data sheet."""

    joint_names: ClassVar = tuple(f"carriage {i}" for i in range(1, 7))
    leg_names: ClassVar = tuple(f"leg {i}" for i in range(1, 7))
    # Honegger 1998, eqs. (9), (10), but for the first moments, which are no numbers of the sheet, and the friction
    adaptable: ClassVar = (
        "carriage.mass",
        "platform.mass",
        "platform.inertia[0,0]",
        "platform.inertia[1,1]",
        "platform.inertia[2,2]",
        "legs.mass",
    )

    elastic_places: ClassVar = {
        "drive": "axial",
        "leg": "axial",
        "guide": "full",
        "carriage joint": "full",
        "platform joint": "full",
    }

    kind: Literal["hexaglide"] = "hexaglide"
    name: str = Field(default="hexaglide", max_length=64, pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$")
    gravity: Array = quantity("m/s2", "gravity, in W", default=[0.0, 0.0, -9.81], shape=(3,))
    platform: bodies.Body
    joints: PlatformJoints
    tool: Tool | None = None
    rails: Rails
    legs: Legs
    carriage: Carriage
    drive: LinearMotor
    friction: FrictionLaw | None = None
    limits: RailLimits
    feed: Feed = Feed()
    home: Array = quantity("m, m, m, rad, rad, rad", "pose at rest, x y z a b c of T in W", shape=(6,))
    source: dict[str, str] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _sound(self):
        check_points("platform", self.joints.platform)
        check_weight(self, [])
        self._check_friction()
        if self.friction is not None and self.friction.loaded:
            raise InputError(
                f"{self.friction.kind} scales with forces between the tubes of a strut", key="friction.kind",
                cure="a carriage has stribeck or lugre",
            )  # fmt: skip
        check_home(self, self._platform_joints_in_W(self.home))
        return self

    def _platform_joints_in_W(self, x) -> np.ndarray:
        """p_WB of poses x (..., 6).  (..., 6, 3) m."""
        R = frames.rotation_of_abc_np(x[..., 3:])
        return x[..., None, :3] + self.platform_joints_np() @ np.swapaxes(R, -1, -2)

    # -- kinematics -----------------------------------------------------------------------------------------------

    @staticmethod
    def lengths(p):
        """l of every leg.  (1, 6) m."""
        l = ca.SX(p.legs.length)
        return ca.repmat(l, 1, 6) if l.numel() == 1 else l.T

    def from_rails(self, p, z):
        """(b, s, e, d2): platform joints from T, s of eq. (1), directions, squared distance to the rail; in W.

        (3, 6), (3, 6), (3, 6), (1, 6).
        """
        b = frames.rotation_of_quaternion(z[3:]) @ self.platform_joints(p)
        e = ca.SX(p.rails.direction).T
        s = ca.repmat(z[:3], 1, 6) + b - ca.SX(p.rails.point).T
        across = s - e * ca.repmat(self._along(e, s), 3, 1)
        return b, s, e, ca.sum1(across * across)

    @staticmethod
    def _along(e, s):
        """q of the point of the rail that is nearest to s: (e . s) / (e . e), exact for a direction a digit off 1."""
        return ca.sum1(e * s) / ca.sum1(e * e)

    def reach(self, p, z):
        """(b, e, q, u, c) of eq. (2): (3, 6), (3, 6), (1, 6), (3, 6), (1, 6), in W; q, u, c NaN out of reach."""
        b, s, e, d2 = self.from_rails(p, z)
        l = self.lengths(p)
        q = self._along(e, s) + ca.SX(self.rails.side).T * ca.sqrt((l * l - d2) / ca.sum1(e * e))
        u = (s - e * ca.repmat(q, 3, 1)) / ca.repmat(l, 3, 1)
        return b, e, q, u, ca.sum1(u * e)

    def joints_of(self, p, z):
        """Places of the carriages, eq. (2).  (6,) m."""
        return self.reach(p, z)[2].T

    def jacobian_of(self, p, z):
        """J of eq. (3): q' = J [v; w].  (6, 6)."""
        return self._rows(*self.reach(p, z))

    @staticmethod
    def _rows(b, e, q, u, c):
        u = u / ca.repmat(c, 3, 1)
        return ca.horzcat(u.T, columns(ca.cross, b, u).T)

    def newton_system(self, p, z, q):
        """K d = r of |p_WB - p_WS(q)| = l, linearised in z: defined for every pose, also where no carriage reaches."""
        b, s, e, _ = self.from_rails(p, z)
        s = s - e * ca.repmat(ca.SX(q).T, 3, 1)
        length = ca.sqrt(ca.sum1(s * s))
        n = s / ca.repmat(length, 3, 1)
        return ca.horzcat(n.T, columns(ca.cross, b, n).T), (self.lengths(p) - length).T

    def joint_acceleration(self, p, z, v, vd):
        """q'' of eq. (4).  (6,) m/s2."""
        return ca.vertcat(*[qdd for _, _, qdd, _ in self._motions(p, *self.reach(p, z), v, vd)])

    def _motions(self, p, b, e, q, u, c, v, vd):
        """(e, b, q'', a_B) of every leg, eqs. (3), (4)."""
        l, out = self.lengths(p), []
        for i in range(6):
            v_B, a_B = point_motion(b[:, i], v, vd)
            turned = v_B - e[:, i] * (ca.dot(u[:, i], v_B) / c[i])
            out.append((e[:, i], b[:, i], (ca.dot(u[:, i], a_B) + ca.dot(turned, turned) / l[i]) / c[i], a_B))
        return out

    # -- dynamics -------------------------------------------------------------------------------------------------

    def inertial(self, p):
        """The parameters the dynamics are linear in: {name: (SX, unit)}.

        Platform m, m c and I about the origin of T; carriage; leg, where it has mass.
        """
        out = self.platform_inertial(p) | {"carriage.m": (p.carriage.mass, "kg")}
        if p.legs.mass is not None:
            out["leg.m"] = (p.legs.mass, "kg")
        return out

    def inverse_force(self, p, pi, z, v, vd):
        """M v' + h, on the twist, eqs. (5)-(7).  pi as `inertial` names it.  (6,) [N; N m]."""
        m, mc_W, I_W = self._platform_in_W(pi, frames.rotation_of_quaternion(z[3:]))
        total = bodies.rigid_wrench(m, mc_W, I_W, v[3:], vd[:3] - p.gravity, vd[3:])
        reach, m_S, m_l = self.reach(p, z), pi["carriage.m"], pi.get("leg.m")
        along = []
        for e, b, qdd, a_B in self._motions(p, *reach, v, vd):
            f = m_S * (qdd * ca.dot(e, e) - ca.dot(e, p.gravity))
            if m_l is not None:
                a_S = qdd * e
                F_B = m_l * (a_S / 6 + a_B / 3 - p.gravity / 2)
                f += m_l * ca.dot(e, a_S / 3 + a_B / 6 - p.gravity / 2)
                total += ca.vertcat(F_B, ca.cross(b, F_B))
            along.append(f)
        return total + self._rows(*reach).T @ ca.vertcat(*along)

    def mass_and_bias(self, p, pi, z, v):
        """M (6, 6) and h (6,) of M v' + h.  M from the kinetic energy of (5)-(7), h at v' = 0."""
        m, mc_W, I_W = self._platform_in_W(pi, frames.rotation_of_quaternion(z[3:]))
        S, reach = frames.skew(mc_W), self.reach(p, z)
        M = ca.vertcat(ca.horzcat(m * ca.SX.eye(3), -S), ca.horzcat(S, I_W))
        b, e, _, _, _ = reach
        J, m_l = self._rows(*reach), pi.get("leg.m")
        m_q = (pi["carriage.m"] + (0 if m_l is None else m_l / 3)) * ca.sum1(e * e)
        M += J.T @ (ca.repmat(m_q.T, 1, 6) * J)
        if m_l is not None:
            for i in range(6):
                J_B = ca.horzcat(ca.SX.eye(3), -frames.skew(b[:, i]))
                mixed = J[i, :].T @ (e[:, i].T @ J_B)
                M += m_l * (J_B.T @ J_B / 3 + (mixed + mixed.T) / 6)
        return M, self.inverse_force(p, pi, z, v, ca.SX(6, 1))

    # -- what gives way -------------------------------------------------------------------------------------------

    def leg_ratio(self, p, z):
        """Force along each leg per newton of its drive, 1 / c.  (6,)."""
        return 1 / self.reach(p, z)[4].T

    def carried_by(self, place, p, z):
        """u / c at the joints of a leg (W; T at the platform); a guide carries it less e, which its drive takes."""
        _, e, _, u, c = self.reach(p, z)
        force = u / ca.repmat(c, 3, 1)
        if place == "platform joint":
            return frames.rotation_of_quaternion(z[3:]).T @ force, None
        return force, e if place == "guide" else None

    @staticmethod
    def motor_load(p, pi):
        """The carriages, with the parts of their weight along the rails.  (6,) kg, (6,) N, pi without them."""
        e, m = ca.SX(p.rails.direction), pi["carriage.m"]
        return m * ca.sum2(e * e), m * (e @ p.gravity), pi | {"carriage.m": 0}

    # -- limits ---------------------------------------------------------------------------------------------------

    def margins(self, p, z):
        """Names and values of all that must be >= 0: reach, rail ends, carriages apart, cones, no singularity."""
        return rail_margins(self, p, z)

    def limit_told(self, index, margin):
        return rail_limit_told(self, index, margin) or super().limit_told(index, margin)

    def possible(self, q):
        return possible_places(self, q)

    @staticmethod
    def stride_of(p):
        """A quarter of the longest leg, m."""
        return 0.25 * ca.mmax(ca.SX(p.legs.length))

    def unreachable(self, x):
        l = np.broadcast_to(self.legs.length, 6)
        misses = legs_np(self, self._platform_joints_in_W(np.asarray(x, float)))[0] - l
        bad = np.argwhere(misses > 0)
        if not len(bad):
            return None
        row, leg = (int(i) for i in bad[0])
        rule, value, limit = self.limit_told(leg, -misses[row, leg])
        return row, WorkspaceError(rule, value=value, limit=limit, cure="check the pose: position, angles, units")

    def drawing(self, x):
        """The machine as polylines in W at the pose x.  List of {"name", "points"}."""
        x = np.asarray(x, float)
        B = self._platform_joints_in_W(x)
        e, point = self.rails.direction, self.rails.point
        S = point + e * legs_np(self, B)[1][:, None]
        lines = []
        for number in np.unique(self.rails.rail):
            i = int(np.flatnonzero(self.rails.rail == number)[0])
            ends = [(point[i] + q * e[i]).tolist() for q in self.limits.travel]
            lines.append({"name": f"rail {number:g}", "points": ends})
        half = e * max(self.limits.gap, 0.1) / 2  # a carriage as long as the gap, or 0.1 m, to be seen
        lines += [
            {"name": name, "points": [(S[i] - half[i]).tolist(), (S[i] + half[i]).tolist()]}
            for i, name in enumerate(self.joint_names)
        ]
        lines += [{"name": name, "points": [S[i].tolist(), B[i].tolist()]} for i, name in enumerate(self.leg_names)]
        lines.append({"name": "platform", "points": outline(B)})
        lines.append({"name": "tool", "points": [B.mean(0).tolist(), x[:3].tolist()]})
        return lines
