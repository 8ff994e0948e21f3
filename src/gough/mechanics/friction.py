"""Friction of a joint as a force against its speed, with or without memory.

Common to both laws, with v the joint speed:

    g(v) = F_c + (F_s - F_c) exp(-(v / v_s)^2)         Coulomb level with the Stribeck rise                         (1)

Smooth  (`Stribeck`)     F = g(v) tanh(v / v_0) + f_v v                                                             (2)
Memory  (`LuGre`)        z' = v - s0 |v| / g(v) z                                                                   (3)
                         F  = s0 z + s1 z' + f_v v                                                                  (4)

(2) is the usual regularisation of Coulomb friction; it creeps at v_0 F / F_c under a constant force and is stable in
an explicit step h only for h < 2.7 m v_0 / F_s.  (3), (4): Canudas de Wit, Olsson, Astrom, Lischinsky, IEEE TAC 40(3),
1995; s1 constant.  The memory is integrated apart from the mechanics (Strang splitting): over h with v held, (3) is
linear in z and solved exactly,

    z+ = z exp(-k h) + v h phi(k h),    k = s0 |v| / g(v),    phi(x) = (1 - exp(-x)) / x                            (5)

which stays within |z| <= F_s / s0 however long the step, and sticks without creep.

Laws whose numbers scale with a normal force are in load_friction.py; `load` is that force, and these two know none.
"""

from __future__ import annotations

from typing import ClassVar, Literal

import casadi as ca
import numpy as np
from pydantic import model_validator

from ..declare import Array, Part, quantity
from ..errors import InputError, SheetError


class Friction(Part):
    """What both laws share.  Each number may be one for all joints or one a joint."""

    input_error = SheetError

    coulomb: float | Array = quantity("N", "Coulomb friction F_c", at_least=0, shape=(-1,))
    static: float | Array | None = quantity(
        "N", "breakaway friction F_s, at least F_c", default=None, at_least=0, shape=(-1,)
    )
    stribeck: float | None = quantity("m/s", "Stribeck speed v_s", default=None, above=0)
    viscous: float | Array = quantity("N s/m", "viscous friction f_v", default=0.0, at_least=0, shape=(-1,))

    @model_validator(mode="after")
    def _ordered(self):
        if (self.static is None) != (self.stribeck is None):
            raise InputError("static and stribeck belong together", cure="give both or neither")
        if self.static is not None and np.any(np.less(self.static, self.coulomb)):
            raise InputError(
                "static friction must be at least the Coulomb friction",
                value=f"{self.static} N against {self.coulomb} N",
                cure="change friction.static by as much",
            )
        return self

    loaded: ClassVar[bool] = False  # whether a normal force scales it
    # the numbers that friction is in proportion to
    levels: ClassVar[tuple[str, ...]] = ("coulomb", "static", "viscous")

    @property
    def peak(self):
        """The largest level, N, per joint.  (n,)."""
        return self.coulomb if self.static is None else self.static

    @property
    def unloaded(self):
        """Coulomb N and viscous N s/m friction that no load scales: what a regressor is linear in."""
        return self.coulomb, self.viscous


def level(p, v):
    """g(v) of eq. (1) for a friction `p` or its view.  (n,) N."""
    if p.static is None:
        return p.coulomb
    return p.coulomb + (p.static - p.coulomb) * ca.exp(-((v / p.stribeck) ** 2))


class Stribeck(Friction):
    """Coulomb, Stribeck and viscous friction without memory, eq. (2)."""

    kind: Literal["stribeck"] = "stribeck"
    smoothing: float = quantity("m/s", "speed v_0 below which friction fades", default=1e-3, above=0)

    memory_per_joint: ClassVar[int] = 0

    @staticmethod
    def force(p, v, z, load=None):
        """Friction force against the speed v (n,) m/s, eq. (2).  (n,) N."""
        return level(p, v) * ca.tanh(v / p.smoothing) + p.viscous * v

    @staticmethod
    def memory_rate(p, v, z, load=None):
        """No memory."""
        return z

    @staticmethod
    def advance(p, v, z, h, load=None):
        """No memory to advance."""
        return z


class LuGre(Friction):
    """Friction with bristles, eqs. (3)-(5)."""

    kind: Literal["lugre"] = "lugre"
    stiffness: float = quantity("N/m", "bristle stiffness s0", above=0)
    damping: float = quantity("N s/m", "bristle damping s1", at_least=0)

    @model_validator(mode="after")
    def _positive(self):
        if np.any(np.less_equal(self.coulomb, 0)):
            raise InputError("coulomb friction must be above 0 N under LuGre", cure="leave [friction] out for none")
        return self

    memory_per_joint: ClassVar[int] = 1

    @staticmethod
    def memory_rate(p, v, z, load=None):
        """z' of eq. (3).  (n,) m/s."""
        return v - p.stiffness * ca.fabs(v) / level(p, v) * z

    @staticmethod
    def force(p, v, z, load=None):
        """Friction force with the memory z (n,) m held, eqs. (3), (4).  (n,) N."""
        zd = LuGre.memory_rate(p, v, z)
        return p.stiffness * z + p.damping * zd + p.viscous * v

    @staticmethod
    def advance(p, v, z, h, load=None):
        """The memory after h seconds with the speed v held, eq. (5).  (n,) m."""
        x = p.stiffness * ca.fabs(v) / level(p, v) * h
        small = x < 1e-8  # phi by its series there: the next term, x^2 / 6, is below rounding
        phi = ca.if_else(small, 1 - x / 2, -ca.expm1(-x) / ca.if_else(small, 1, x))
        return z * ca.exp(-x) + v * h * phi
