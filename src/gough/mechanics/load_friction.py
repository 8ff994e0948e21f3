"""Friction that scales with a normal force N, with or without memory.

With the numbers of friction.py replaced by

    F_c = F_0 + mu_c N,    F_s = F_0 + mu_s N,    f_v = f_0 + mu_v N                                               (1)

the laws are those of friction.py: (1), (2) there for `LoadStribeck`, (1), (3)-(5) for `LoadLuGre`.  F_0 and f_0 remain
without a load (screw, seals, motor).  N is held over a sub-step of the plant, so nothing here is implicit.

The bristles' stiffness s0 and damping s1 are N/m and N s/m, the same at every load.  What scales is where the bristles
end: z settles at g(v, N) sign(v) / s0, so the steady force is the scaled Stribeck curve, and breakaway comes after a
way g / s0 in proportion to the load.  Stiffness in proportion to N would change the energy stored in a bent bristle
with N and hand it to the mechanics; with s0 constant the law takes energy whatever N does (docs/theory/friction.md).
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import model_validator

from ..declare import Array, Part, one_of, quantity
from ..errors import InputError, SheetError
from .friction import LuGre, Stribeck


class LoadFriction(Part):
    """What both laws share.  Coefficients and offsets may be one for all joints or one a joint."""

    input_error = SheetError

    coulomb: float | Array = quantity("1", "Coulomb coefficient mu_c, of the normal force", at_least=0, shape=(-1,))
    static: float | Array | None = quantity(
        "1", "breakaway coefficient mu_s, at least mu_c", default=None, at_least=0, shape=(-1,)
    )
    stribeck: float | None = quantity("m/s", "Stribeck speed v_s", default=None, above=0)
    viscous: float | Array = quantity(
        "s/m", "viscous coefficient mu_v, of the normal force", default=0.0, at_least=0, shape=(-1,)
    )
    coulomb_offset: float | Array = quantity(
        "N", "Coulomb friction F_0 without a load", default=0.0, at_least=0, shape=(-1,)
    )
    viscous_offset: float | Array = quantity(
        "N s/m", "viscous friction f_0 without a load", default=0.0, at_least=0, shape=(-1,)
    )

    loaded: ClassVar[bool] = True
    levels: ClassVar[tuple[str, ...]] = ("coulomb", "static", "viscous", "coulomb_offset", "viscous_offset")

    @model_validator(mode="after")
    def _ordered(self):
        if (self.static is None) != (self.stribeck is None):
            raise InputError("static and stribeck belong together", cure="give both or neither")
        if self.static is not None and np.any(np.less(self.static, self.coulomb)):
            raise InputError(
                "static coefficient must be at least the Coulomb coefficient",
                value=f"{self.static} against {self.coulomb}",
                cure="change friction.static by as much",
            )
        return self

    @property
    def unloaded(self):
        """Coulomb N and viscous N s/m friction that no load scales: what a regressor is linear in."""
        return self.coulomb_offset, self.viscous_offset

    @staticmethod
    def at_load(p, load) -> Any:
        """The numbers of friction.py at normal forces `load` (n,) N, eq. (1); `p` this friction or its view."""
        names = ("stribeck", "smoothing", "stiffness", "damping")
        return SimpleNamespace(
            coulomb=p.coulomb_offset + p.coulomb * load,
            static=None if p.static is None else p.coulomb_offset + p.static * load,
            viscous=p.viscous_offset + p.viscous * load,
            **{name: getattr(p, name) for name in names if hasattr(p, name)},
        )


class LoadStribeck(LoadFriction):
    """Coulomb, Stribeck and viscous friction in proportion to a normal force, without memory."""

    kind: Literal["load_stribeck"] = "load_stribeck"
    smoothing: float = quantity("m/s", "speed v_0 below which friction fades", default=1e-3, above=0)

    memory_per_joint: ClassVar[int] = 0

    @staticmethod
    def force(p, v, z, load):
        """Friction force against the speed v (n,) m/s under the normal forces load (n,) N.  (n,) N."""
        return Stribeck.force(LoadFriction.at_load(p, load), v, z)

    @staticmethod
    def memory_rate(p, v, z, load):
        """No memory."""
        return z

    @staticmethod
    def advance(p, v, z, h, load):
        """No memory to advance."""
        return z


class LoadLuGre(LoadFriction):
    """Friction with bristles whose level is in proportion to a normal force."""

    kind: Literal["load_lugre"] = "load_lugre"
    stiffness: float = quantity("N/m", "bristle stiffness s0, at every load", above=0)
    damping: float = quantity("N s/m", "bristle damping s1, at every load", at_least=0)

    memory_per_joint: ClassVar[int] = 1

    @model_validator(mode="after")
    def _positive(self):
        if np.any(np.less_equal(np.add(self.coulomb, self.coulomb_offset), 0)):
            raise InputError(
                "coulomb or coulomb_offset must be above 0 under LuGre", cure="leave [friction] out for none"
            )
        return self

    @staticmethod
    def memory_rate(p, v, z, load):
        """z' under the normal forces load (n,) N.  (n,) m/s."""
        return LuGre.memory_rate(LoadFriction.at_load(p, load), v, z)

    @staticmethod
    def force(p, v, z, load):
        """Friction force with the memory z (n,) m held, under the normal forces load (n,) N.  (n,) N."""
        return LuGre.force(LoadFriction.at_load(p, load), v, z)

    @staticmethod
    def advance(p, v, z, h, load):
        """The memory after h seconds with speed v and load held.  (n,) m."""
        return LuGre.advance(LoadFriction.at_load(p, load), v, z, h)


_HERE = "gough.mechanics"
FrictionLaw = Annotated[
    Stribeck | LuGre | LoadStribeck | LoadLuGre,
    one_of(
        stribeck=f"{_HERE}.friction:Stribeck",
        lugre=f"{_HERE}.friction:LuGre",
        load_stribeck=f"{_HERE}.load_friction:LoadStribeck",
        load_lugre=f"{_HERE}.load_friction:LoadLuGre",
    ),
]
