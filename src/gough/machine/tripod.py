r"""Three-PRS head: three sliders on rails carry a platform with the tool, each by a hinged link of constant length.

      A_i | rail, q_i = S_i      frames  W   fixed in the base             points  A_i  hinge at S_i = 0
          o B_i  slider                  T   tool: origin at the tip,              B_i  hinge of link i on its slider
     h_i /   \                               third axis from tip to spindle        T_i  spherical joint, at t_i in T
        /theta_i  link, L                W   hinge axis h_i = c_i x d_i, the rail along d_i, c_i across it
    T_i o------ platform ---- tool

Coordinates z = (a, b) = (S_1 S_2 S_3, theta_1 theta_2 theta_3), velocities v = S'.

    T_i = A_i + S_i d_i + L l_i,   l_i = cos(theta_i) c_i + sin(theta_i) d_i,   l_i' = theta_i' h_i x l_i           (1)
    phi_k = (|T_i - T_j|^2 - |t_i - t_j|^2) / (2 |t_i - t_j|),   (i, j) = (1, 2), (2, 3), (3, 1)                    (2)
    R_WT = E(T) E(t)',   E the frame of a triangle: first side, normal; p_WT = mean T - R mean t                    (3)
    w = R (sum over i of |s_i|^2 1 - s_i s_i')^-1 sum of s_i x R' T_i',   s_i = t_i - mean t;                       (4)
    v_T = mean T' - w x R mean t

(4) is the turning that fits the speeds of the three joints best, and theirs exactly where phi_x z' = 0: bodies need a
meaning off the closure too.  The tool tip at x asks for

    h_i . (x + R t_i - A_i) = 0,  i = 1, 2, 3           Newton's method on R from 1, `NEWTON` steps                  (5)
    cos theta_i = c_i . (T_i - A_i) / L,   S_i = d_i . (T_i - A_i) - L sin theta_i,   T_i = x + R t_i               (6)

so tilt and turn of the platform, its parasitic motion, follow from the place of the tip.  Sliders (mass m_s, reflected
mass m_r of screw and motor), even slender links and the platform with its tool are the bodies of
machine/constrained.py, which gives M, h and the multipliers.  docs/theory/tripod.md derives (2)-(6).

Source: Chen and Tsai, Contouring control of a parallel mechanism based on equivalent errors, 2008, section III: their
x = (S, theta) and eq. (3); geometry and masses are not in the paper.  r tan(rho) of their eq. (3) is lead / 2 pi:
theirs are torques, here are forces of the sliders, and J' of theirs is m_r lead / 2 pi.
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
from ..mechanics.constrained import Moving
from ..mechanics.linear import solve_square
from ..mechanics.load_friction import FrictionLaw
from .arrays import check_determinant
from .base import Feed
from .constrained import ConstrainedMachine, ToolMotion
from .drives import Screw, reflected_mass
from .tripod_limits import check_home, margins_of, told
from .tripod_parts import SIDES, Link, Slider, TripodJoints, TripodLimits, TripodRails, stands
from .tripod_reactions import ClosedReactions, reactions_of

NEWTON = 8  # from R = 1; quadratic: a tilt of 45 deg is there after 6

_ACROSS = "it carries forces across its drive, which a spring along the drive knows nothing of"


class Tripod(ConstrainedMachine):
    """Three sliders, three links of constant length, a platform.  Fields are the tables of its data sheet."""

    joint_names: ClassVar = ("slider 1", "slider 2", "slider 3")
    dependent_names: ClassVar = ("theta1", "theta2", "theta3")
    velocities: ClassVar = ("S1'", "S2'", "S3'")
    adaptable: ClassVar = ("platform.mass", "slider.mass")

    elastic_places: ClassVar = {"drive": "axial"}
    rigid_places: ClassVar = dict.fromkeys(("hinge", "link", "slider", "platform joint"), _ACROSS)

    kind: Literal["tripod"] = "tripod"
    name: str = Field(default="tripod", max_length=64, pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$")
    gravity: Array = quantity("m/s2", "gravity, in W", default=[0.0, 0.0, -9.81], shape=(3,))
    platform: bodies.Body
    joints: TripodJoints
    rails: TripodRails
    slider: Slider
    link: Link
    drive: Screw
    friction: FrictionLaw | None = None
    limits: TripodLimits
    feed: Feed = Feed()
    home: Array = quantity("m", "place of the tool tip at rest, x y z of T in W", shape=(3,))
    source: dict[str, str] = Field(default_factory=dict)

    @model_validator(mode="before")
    @classmethod
    def _home_table(cls, data):
        """A sheet writes the place at rest as a table, [home] tip = [...]."""
        if isinstance(data, dict) and isinstance(data.get("home"), dict) and set(data["home"]) != {"unit", "value"}:
            if set(data["home"]) != {"tip"}:
                raise InputError("[home] has one key, tip", key="home", value=", ".join(map(str, data["home"])))
            data = {**data, "home": data["home"]["tip"]}
        return data

    @model_validator(mode="after")
    def _sound(self):
        for key in () if self.friction is None else self.friction.specs():
            numbers = getattr(self.friction, key)
            if np.ndim(numbers) and len(numbers) != 3:
                raise InputError("friction needs one value or three", key=f"friction.{key}", value=str(len(numbers)))
        if self.friction is not None and self.friction.loaded:
            raise InputError(
                f"{self.friction.kind} scales with forces between the tubes of a strut", key="friction.kind",
                cure="a slider has stribeck or lugre",
            )  # fmt: skip
        check_home(self)
        return self

    # -- kinematics -----------------------------------------------------------------------------------------------

    @staticmethod
    def _axes(p):
        """d, c, h of every rail.  (3, 3) each, columns."""
        d, c = ca.SX(p.rails.direction).T, ca.SX(p.rails.across).T
        return d, c, ca.horzcat(*[ca.cross(c[:, i], d[:, i]) for i in range(3)])

    def links(self, p, z):
        """l_i of eq. (1).  (3, 3), columns, in W."""
        d, c, _ = self._axes(p)
        return ca.horzcat(*[ca.cos(z[3 + i]) * c[:, i] + ca.sin(z[3 + i]) * d[:, i] for i in range(3)])

    def joints_in_W(self, p, z):
        """T_i of eq. (1).  (3, 3), columns."""
        d, l = self._axes(p)[0], self.links(p, z)
        along = d * ca.repmat(z[:3].T, 3, 1)
        return ca.SX(p.rails.point).T + along + p.link.length * l

    def joint_speeds(self, p, z, zd):
        """T_i'.  (3, 3), columns, linear in zd."""
        d, _, h = self._axes(p)
        l = self.links(p, z)
        turned = ca.horzcat(*[ca.cross(h[:, i], l[:, i]) * zd[3 + i] for i in range(3)])
        return d * ca.repmat(zd[:3].T, 3, 1) + p.link.length * turned

    def closure_of(self, p, z):
        """phi of eq. (2).  (3,) m."""
        return self.sides_of(p, self.joints_in_W(p, z))

    @staticmethod
    def sides_of(p, T):
        """phi of eq. (2) by the joints T (3, 3), columns, in W.  (3,) m."""
        t, out = ca.SX(p.joints.platform).T, []
        for i, j in SIDES:
            side, true = T[:, i] - T[:, j], t[:, i] - t[:, j]
            out.append((ca.dot(side, side) - ca.dot(true, true)) / (2 * ca.norm_2(true)))
        return ca.vertcat(*out)

    @staticmethod
    def _frame(P):
        """E of eq. (3) of a triangle P (3, 3), columns."""
        first = P[:, 1] - P[:, 0]
        first = first / ca.norm_2(first)
        normal = ca.cross(first, P[:, 2] - P[:, 0])
        normal = normal / ca.norm_2(normal)
        return ca.horzcat(first, ca.cross(normal, first), normal)

    def tool_motion_of(self, p, z, zd):
        """Eqs. (3), (4)."""
        T = self.joints_in_W(p, z)
        R = self.rotation_of(p, T)
        arm = R @ (ca.sum2(ca.SX(p.joints.platform).T) / 3)
        return ToolMotion(ca.sum2(T) / 3 - arm, R, self.twist_of(p, R, self.joint_speeds(p, z, zd)))

    def rotation_of(self, p, T):
        """R_WT of eq. (3) by the joints T (3, 3), columns, in W."""
        return self._frame(T) @ self._frame(ca.SX(p.joints.platform).T).T

    @staticmethod
    def twist_of(p, R, speeds):
        """[v_T; w] of eq. (4) by R_WT and the speeds of the joints (3, 3), columns, in W."""
        t = ca.SX(p.joints.platform).T
        middle = ca.sum2(t) / 3
        s = t - ca.repmat(middle, 1, 3)
        spread, lever = ca.SX(3, 3), ca.SX(3, 1)
        for i in range(3):
            spread += ca.dot(s[:, i], s[:, i]) * ca.SX.eye(3) - s[:, i] @ s[:, i].T
            lever += ca.cross(s[:, i], R.T @ speeds[:, i])
        w = R @ solve_square(spread, lever)
        return ca.vertcat(ca.sum2(speeds) / 3 - ca.cross(w, R @ middle), w)

    def coordinates_of(self, p, x):
        """z of a tool tip, eqs. (5), (6); NaN where a link does not reach.  (3,) -> (6,)."""
        d, c, h = self._axes(p)
        A, t, x = ca.SX(p.rails.point).T, ca.SX(p.joints.platform).T, ca.SX(x)
        quat = ca.SX([1, 0, 0, 0])
        for _ in range(NEWTON):
            r = frames.rotation_of_quaternion(quat) @ t
            miss = ca.sum1((ca.repmat(x, 1, 3) + r - A) * h).T
            K = ca.horzcat(*[ca.cross(r[:, i], h[:, i]) for i in range(3)]).T
            turn = frames.quaternion_of_rotation_vector(-solve_square(K, miss))
            quat = frames.quaternion_product(turn, quat)
            quat = quat / ca.norm_2(quat)
        from_A = ca.repmat(x, 1, 3) + frames.rotation_of_quaternion(quat) @ t - A
        cosine = ca.sum1(from_A * c).T / p.link.length
        sine = ca.sqrt(1 - cosine * cosine)
        return ca.vertcat(ca.sum1(from_A * d).T - p.link.length * sine, ca.atan2(sine, cosine))

    # -- dynamics -------------------------------------------------------------------------------------------------

    def inertial(self, p):
        """The parameters the dynamics are linear in: {name: (SX, unit)}."""
        out = bodies.named("platform", *bodies.first_moments(p.platform)) | {"slider.m": (p.slider.mass, "kg")}
        if p.link.mass is not None:
            out["link.m"] = (p.link.mass, "kg")
        if p.drive.inertia is not None:
            out["drive.m"] = (reflected_mass(p.drive), "kg")
        return out

    @staticmethod
    def joint_mass(pi):
        """m_r of screw and motor, kg."""
        return pi.get("drive.m", 0)

    def bodies_of(self, p, pi, z, zd):
        """Platform, three sliders, three links (about their hinges: m L / 2 along l, m L^2 / 3 across it)."""
        tool = self.tool_motion_of(p, z, zd)
        out = [Moving(*bodies.turned("platform", pi, tool.rotation), tool.twist)]
        d, _, h = self._axes(p)
        l, L, m_l = self.links(p, z), p.link.length, pi.get("link.m")
        for i in range(3):
            along = d[:, i] * zd[i]
            out.append(Moving(pi["slider.m"], ca.SX(3, 1), ca.SX(3, 3), ca.vertcat(along, ca.SX(3, 1))))
            if m_l is not None:
                I = m_l * L * L / 3 * (ca.SX.eye(3) - l[:, i] @ l[:, i].T)
                out.append(Moving(m_l, m_l * L / 2 * l[:, i], I, ca.vertcat(along, h[:, i] * zd[3 + i])))
        return out

    @staticmethod
    def motor_load(p, pi):
        """The reflected mass of screw and motor; the sliders are behind the spring.  (3,) kg, (3,) N, pi without it."""
        rest = {key: value for key, value in pi.items() if key != "drive.m"}
        return ca.repmat(ca.SX(pi.get("drive.m", 0)), 3), ca.SX(3, 1), rest

    # -- forces in the joints -------------------------------------------------------------------------------------

    reaction_fields: ClassVar = ("platform_joint", "base_joint", "multiplier")

    def reactions_of(self, p, z, v, vd, net, loads=None, w=None):
        """`tripod_reactions.reactions_of`; the drives' forces `net` follow from v' and are not asked."""
        return reactions_of(self, p, z, v, vd, ca.SX(6, 1) if w is None else w)

    def reactions(self, x, xd, xdd, wrench=None) -> ClosedReactions:
        """Forces in the joints on a motion.

        x, xd, xdd (..., 3) each, `wrench` (..., 6) on the tool at its tip, in W.  `platform_joint` of the platform on
        each link, `base_joint` of each slider on its link (..., 3, 3) N in W; `multiplier` (..., 3) N of the closure.

        Raises
        ------
        SingularityError
            where det J has fallen below limits.determinant of home's.
        """
        flat, ratio = self.arrays.run("reactions", *self._columns(x, xd, xdd), self._wrench(wrench))
        check_determinant(ratio, self.limits.determinant)
        vectors = [flat[..., k : k + 9].reshape(*flat.shape[:-1], 3, 3) for k in (0, 9)]
        return ClosedReactions(*vectors, multiplier=flat[..., 18:])

    # -- limits ---------------------------------------------------------------------------------------------------

    def determinant_of(self, p, z):
        """det J (q' = J x') as a fraction of home's; 0 where sliders at rest do not hold the platform."""
        home = self.coordinates_of(p, p.home)
        return self._determinant(p, home) / self._determinant(p, z)

    def _determinant(self, p, z):
        D = self.tool_jacobian(p, z)[:3, :]
        return ca.dot(D[:, 0], ca.cross(D[:, 1], D[:, 2]))

    def margins(self, p, z):
        """Names and values of all that must be >= 0: ends of the rails, angles of the links, cones, phi_b, det J."""
        return margins_of(self, p, z)

    def limit_told(self, index, margin):
        return told(self, index, margin)

    @staticmethod
    def stride_of(p):
        """A quarter of a link, m."""
        return 0.25 * p.link.length

    def possible(self, q):
        """Rows (N,) of places of the sliders q (N, 3) m that some pose may have, and `why(row)` for another."""
        B = self.rails.point + self.rails.direction * q[..., None]
        i, j = (np.array(side) for side in zip(*SIDES, strict=True))
        t, L = self.joints.platform, self.link.length
        reach = 2 * L + np.linalg.norm(t[i] - t[j], axis=-1)
        apart = np.linalg.norm(B[:, i] - B[:, j], axis=-1)

        def why(row):
            k = int(np.flatnonzero(apart[row] > reach)[0])
            rule = f"are {apart[row, k]:.4g} m apart, farther than links and platform reach ({reach[k]:.4g} m)"
            return rule, f"sliders {i[k] + 1} and {j[k] + 1}"

        return (apart <= reach).all(-1), why

    def unreachable(self, x):
        _, miss, along = stands(self, x)
        L = self.link.length
        for row in np.flatnonzero((np.abs(miss) > 1e-9).any(1) | (np.abs(along) > L).any(1)):
            if np.abs(miss[row]).max() > 1e-9:
                return int(row), WorkspaceError(
                    "no tilt of the platform brings its joints into the planes of the links",
                    value=f"tip at {np.round(np.atleast_2d(x)[row], 6).tolist()} m",
                    limit=f"{np.abs(miss[row]).max():.3g} m missed",
                    cure="check the place: position, units",
                )
            i = int(np.argmax(np.abs(along[row])))
            return int(row), WorkspaceError(
                f"link {i + 1}: cannot reach: misses by {1e3 * (abs(along[row, i]) - L):.4g} mm",
                value=f"{abs(along[row, i]):.6g} m from joint to rail", limit=f"{L:g} m",
                cure="check the place: position, units",
            )  # fmt: skip
        return None

    def drawing(self, x):
        """The machine as polylines in W with its tool tip at x (3,).  List of {"name", "points"}."""
        x = np.asarray(x, float)[:3]
        R, _, _ = stands(self, x)
        T, q = x + self.joints.platform @ R[0].T, self.inverse_kinematics(x)
        e, point = self.rails.direction, self.rails.point
        B, half = point + e * q[:, None], e * 0.05  # a slider of 0.1 m, to be seen
        lines = [
            {"name": f"rail {i + 1}", "points": [(point[i] + s * e[i]).tolist() for s in self.limits.travel]}
            for i in range(3)
        ]
        lines += [
            {"name": name, "points": [(B[i] - half[i]).tolist(), (B[i] + half[i]).tolist()]}
            for i, name in enumerate(self.joint_names)
        ]
        lines += [{"name": f"link {i + 1}", "points": [B[i].tolist(), T[i].tolist()]} for i in range(3)]
        lines.append({"name": "platform", "points": T[[0, 1, 2, 0]].tolist()})
        lines.append({"name": "tool", "points": [T.mean(0).tolist(), x.tolist()]})
        return lines
