r"""Hybrid machine: two arms turn about pivots of the base and carry an XY stage on three slides, its Z axis on board.

        phi10           phi60        W   in the middle between the pivots, third axis along theirs, towards the tool;
         |               |               the plane of the slides is at -z0
     s21 o A_2 --s54-- A_5 o s65     2   link 2 with the ram 3 (s32), at A_2 on arm 1: axes turned by phi10
         |               |           5   link 5, at A_5 on arm 6: axes turned by phi60
       --o------ W ------o--         T   tip of the ram, axes of link 2; s32 moves it along the third axis
      (-b,0,-z0)      (b,0,-z0)

Coordinates z = (a, b) = (s21 s65 s32, s54 phi10 phi60), velocities v = (s21', s65', s32').  With A_2 and A_5 by the
chains of frames of hybrid_chain.py, which have eqs. (1) and (2), and R_2 of link 2, R_5 of link 5,

    phi = ( -e_y . R_2' (A_5 - A_2),   s54 - e_x . R_2' (A_5 - A_2),   2 b (phi60 - phi10) )                       (3)
        = ( s21 - s65 + 2 b sin phi10, s54 - 2 b cos phi10, 0 )                       where phi60 = phi10
    p_WT = A_2 + R_2 (b, 0, z0 + s32)                                                                               (4)
    s21^2 = (x + b)^2 + y^2 - b^2,   phi10 = atan2(y, x + b) - atan2(s21, b),   s32 = z,                            (5)
    s65 = s21 + 2 b sin phi10,   s54 = 2 b cos phi10,   phi60 = phi10
    det J = 2 b cos phi10 / s21,   J by q' = J x';   |det phi_b| = 4 b^2 |cos phi10|                                (6)

With b < 0 arm 1 stands on the positive side: the mirror image, to which all of this applies.  (5) is the closed form of
the paper's "analytically possible" phi, and all of the inverse kinematics.  Arms, the moving parts of the motors, links
2 and 5 and the ram are the bodies of machine/constrained.py, which gives M, h and the multipliers of its eqs. (4), (5).
docs/theory/hybrid.md derives (3)-(8).

Source: Bouzgarrou, Ray, Gogu, Thuilot, Modeling and control of a HSM machine tool with parallel kinematics, 2001,
section 2: coordinates q = [s21 s65 s32 s54 phi10 phi60]; their Fig. 1, closure and numbers are not in the text, so (3)
is the parallel-armed machine of that list of joints.  The frame of T has the axes of their E(x3, y3, z3).
"""

from __future__ import annotations

from typing import ClassVar, Literal

import casadi as ca
import numpy as np
from pydantic import Field, model_validator

from ..declare import Array, quantity
from ..errors import InputError
from ..mechanics import bodies
from ..mechanics.constrained import Moving
from ..mechanics.load_friction import FrictionLaw
from .arrays import check_determinant
from .base import Feed
from .constrained import ConstrainedMachine, ToolMotion
from .drives import LinearMotor
from .hybrid_chain import chains
from .hybrid_limits import check_home, margins_of, told, unreachable
from .hybrid_parts import Arm, HybridBase, HybridLimits, MotorSide, stands
from .hybrid_reactions import HybridReactions, reactions_of


class Hybrid(ConstrainedMachine):
    """Two arms, three slides in a plane, a ram.  Fields are the tables of its data sheet."""

    joint_names: ClassVar = ("slide 1", "slide 6", "ram")
    dependent_names: ClassVar = ("s54", "phi10", "phi60")
    velocities: ClassVar = ("s21'", "s65'", "s32'")
    adaptable: ClassVar = ("link2.mass", "link5.mass", "ram.mass")

    elastic_places: ClassVar = {"slide": "spring"}
    rigid_places: ClassVar = {"drive": "a linear motor is stiff", "ram": "the compliance of its slide is in slide 1"}

    kind: Literal["hybrid"] = "hybrid"
    name: str = Field(default="hybrid", max_length=64, pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]*$")
    gravity: Array = quantity("m/s2", "gravity, in W", default=[0.0, -9.81, 0.0], shape=(3,))
    base: HybridBase
    arm: Arm
    slide: MotorSide
    link2: bodies.Body
    link5: bodies.Body
    ram: bodies.Body
    drive: LinearMotor
    friction: FrictionLaw | None = None
    limits: HybridLimits
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
                cure="a slide has stribeck or lugre",
            )  # fmt: skip
        check_home(self)
        return self

    # -- kinematics -----------------------------------------------------------------------------------------------

    @staticmethod
    def closure_of(p, z):
        """phi of eq. (3).  (3,) m."""
        at, b = chains(p, z, ca.SX.zeros(6)), p.base.half_width
        gap = at.link_2.R.T @ (at.link_5.p - at.passive.p)
        return ca.vertcat(-gap[1], -gap[0], 2 * b * (z[5] - z[4]))

    @staticmethod
    def tool_motion_of(p, z, zd):
        """Eq. (4)."""
        tool = chains(p, z, zd).tool
        return ToolMotion(tool.p, tool.R, tool.twist)

    @staticmethod
    def coordinates_of(p, x):
        """z of a tool tip, eq. (5); NaN where slide 1 does not reach.  (3,) -> (6,)."""
        b, x = p.base.half_width, ca.SX(x)
        along = x[0] + b
        s21 = ca.sqrt(along * along + x[1] * x[1] - b * b)
        phi = ca.atan2(x[1], along) - ca.atan2(s21, b)
        return ca.vertcat(s21, s21 + 2 * b * ca.sin(phi), x[2], 2 * b * ca.cos(phi), phi, phi)

    # -- dynamics -------------------------------------------------------------------------------------------------

    @staticmethod
    def inertial(p):
        """The parameters the dynamics are linear in: {name: (SX, unit)}.  An arm's mass alone moves nothing."""
        first = p.arm.mass * p.arm.center
        out = {
            "arm.m": (p.arm.mass, "kg"),
            "arm.m c": (first, "kg m"),
            "arm.I": (p.arm.inertia + first * p.arm.center, "kg m2"),
            "slide.m": (p.slide.mass, "kg"),
            "slide.I": (p.slide.inertia, "kg m2"),
        }
        for name in ("link2", "link5", "ram"):
            out |= bodies.named(name, *bodies.first_moments(getattr(p, name)))
        return out

    @staticmethod
    def joint_mass(pi):
        """Nothing turns with a linear motor."""
        return 0

    def bodies_of(self, p, pi, z, zd):
        """Arm 1, its motor, link 2, ram; arm 6, its motor, link 5.  Arms about their pivots."""
        return self.bodies_at(pi, chains(p, z, zd))

    @staticmethod
    def bodies_at(pi, at):
        """The same at frames `at` (Chains)."""
        e_z = ca.SX([0, 0, 1])
        about = e_z @ e_z.T  # arms and motors turn about the third axis only
        out = []
        for arm, slide, links in (
            (at.arm_1, at.slide_1, (("link2", at.link_2), ("ram", at.tool))),
            (at.arm_6, at.slide_6, (("link5", at.link_5),)),
        ):
            out.append(Moving(pi["arm.m"], pi["arm.m c"] * arm.R[:, 1], pi["arm.I"] * about, arm.twist))
            out.append(Moving(pi["slide.m"], ca.SX(3, 1), pi["slide.I"] * about, slide.twist))
            out += [Moving(*bodies.turned(name, pi, frame.R), frame.twist) for name, frame in links]
        return out

    def carrying(self, mass, center):
        """The ram with a point mass (kg) at `center` (3,) m of T."""
        return self.replace(ram=self.ram.joined(mass, np.asarray(center, float)))

    # -- what gives way -------------------------------------------------------------------------------------------

    def elastic_numbers(self, place):
        """Slides 1 and 6, those on the arms."""
        return (1, 6)

    def flexible(self, measured="motor", stiffness=1.0):
        """This machine with slides 1 and 6 elastic in six components each; see Machine.flexible, hybrid_flexible.py."""
        from .hybrid_flexible import flexible_hybrid

        return flexible_hybrid(self, measured, stiffness)

    # -- forces in the joints -------------------------------------------------------------------------------------

    reaction_fields: ClassVar = ("multiplier",)

    def reactions_of(self, p, z, v, vd, net, loads=None, w=None):
        """`hybrid_reactions.reactions_of`; the drives' forces `net` follow from v' and are not asked."""
        return reactions_of(self, p, z, v, vd, ca.SX(6, 1) if w is None else w)

    def reactions(self, x, xd, xdd, wrench=None) -> HybridReactions:
        """Forces in the joints on a motion, in the plane of the slides.

        x, xd, xdd (..., 3) each, `wrench` (..., 6) on the tool at its tip, in W.  `pivot` of the base on arms 1 and 6
        (..., 2, 2) N, x and y in W; `passive` (..., 3) of link 2 on link 5: force x and y in W, N, and moment, N m;
        `multiplier` (..., 3) N of the closure.

        Raises
        ------
        SingularityError
            where det J has fallen below limits.determinant of home's.
        """
        flat, ratio = self.arrays.run("reactions", *self._columns(x, xd, xdd), self._wrench(wrench))
        check_determinant(ratio, self.limits.determinant)
        return HybridReactions(flat[..., :4].reshape(*flat.shape[:-1], 2, 2), flat[..., 4:7], flat[..., 7:])

    # -- limits ---------------------------------------------------------------------------------------------------

    @staticmethod
    def determinant_of(p, z):
        """det J of eq. (6) as a fraction of home's; 0 where slides at rest do not hold the tool."""
        b, x = p.base.half_width, ca.SX(p.home)
        s21 = ca.sqrt((x[0] + b) ** 2 + x[1] ** 2 - b * b)
        at_home = ca.cos(ca.atan2(x[1], x[0] + b) - ca.atan2(s21, b)) / s21
        return ca.cos(z[4]) / z[0] / at_home

    def margins(self, p, z):
        """Names and values of all that must be >= 0: ends of the slides, angles of the arms, det J."""
        return margins_of(self, p, z)

    def limit_told(self, index, margin):
        return told(self, index, margin)

    @staticmethod
    def stride_of(p):
        """Half of |b|, m."""
        return 0.5 * ca.fabs(p.base.half_width)

    def possible(self, q):
        """Rows (N,) of places of the slides q (N, 3) m that some pose may have, and `why(row)` for another."""
        width, apart = 2 * abs(self.base.half_width), np.abs(q[..., 1] - q[..., 0])

        def why(row):
            return f"are {apart[row]:.4g} m apart, more than their pivots ({width:.4g} m)", "slide 1 and slide 6"

        return apart <= width, why

    def unreachable(self, x):
        return unreachable(self, x)

    def drawing(self, x):
        """The machine as polylines in W with its tool tip at x (3,).  List of {"name", "points"}."""
        x = np.asarray(x, float)[:3]
        (s21, s65, _, s54, phi, _), b = stands(self, x)[0], self.base.half_width
        R = np.array([[np.cos(phi), -np.sin(phi), 0], [np.sin(phi), np.cos(phi), 0], [0, 0, 1]])
        pivots = [np.array([side * b, 0.0, -self.base.overhang]) for side in (-1, 1)]
        A_2, A_5 = pivots[0] + R @ [0, s21, 0], pivots[1] + R @ [0, s65, 0]
        foot, half = A_2 + R @ [b, 0, 0], R @ [0, 0.1, 0]  # a slide of 0.2 m, to be seen
        lines = [("base", pivots)]
        for name, pivot, ends in zip(("arm 1", "arm 6"), pivots, self.limits.travel[:2], strict=True):
            lines.append((name, [pivot, pivot + R @ [0, ends[1], 0]]))
        lines += [("slide 1", [A_2 - half, A_2 + half]), ("slide 6", [A_5 - half, A_5 + half])]
        lines += [("link 2", [A_2, A_2 + R @ [s54, 0, 0]]), ("ram", [foot, x])]
        return [{"name": name, "points": [point.tolist() for point in points]} for name, points in lines]
