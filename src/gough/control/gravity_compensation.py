"""Gravity compensation: the reference moved so that the tool of a flexible machine stands where it is wanted.

The joints of a machine that gives way are where they should be, and its tool hangs below.  With d(x) from the place of
the tool to the one that the joints must stand for, at rest (control/bending.py), the inner law is told

    x_c = x + w d(x),   x_c' = x' + (w d)',   x_c'' = x'' + (w d)''                                                 (1)

along the whole path with w = 1 (`where` = "path"); or towards the `target` only, as Bouzgarrou et al. add it,

    w = 1 - S(rho^2 / distance^2),   d = d(target),   rho = |p - p_target|                                          (2)

S the polynomial of wrapping.ramp.  From the start both set in over `takeover`.  In (1) the rates are derivatives of d
along the motion, no differences.

Source: Bouzgarrou, Ray, Gogu, Thuilot 2001, section 3.3 and Fig. 9.  Their algorithm searches the joints of the target
by iteration, study/bouzgarrou2001/statics.py; here d is a closed form or a polynomial of the exact statics, compared
with those before a run (`tolerance`).  docs/theory/flexible_control.md, section 3.
"""

from __future__ import annotations

from typing import ClassVar, Literal

import casadi as ca
from pydantic import Field, model_validator

from ..declare import Array, quantity
from ..errors import ExperimentError
from .bending import Bends, bends_of, shift_along
from .bending_check import check_places, target_shift
from .shifted import shifted
from .wrapping import Wrapping, faded, ramp


class GravityCompensation(Wrapping):
    """Eqs. (1), (2) around an inner law."""

    kind: Literal["gravity_compensation"] = "gravity_compensation"
    where: Literal["path", "target"] = Field("path", description="along the whole path, or near the target only")
    target: Array | None = quantity(
        "m, m, m, rad, rad, rad", "pose of the target, with as many numbers as the machine's task", default=None,
        theta=False, shape=(-1,),
    )  # fmt: skip
    distance: float = quantity("m", "from the target at which it begins to set in", default=0.1, above=0)
    degree: int = Field(6, ge=1, le=10, description="of the polynomials, where the machine needs them")
    tolerance: float = quantity(
        "m", "greatest distance from the exact statics along a motion", default=1e-6, theta=False, above=0
    )
    bends: Bends | None = Field(None, description="made by `on`, from the machine's [[compliance]]")
    aside: Array | None = quantity("1", "d(target), made by `on`, m and rad", default=None, shape=(-1,))

    tuned: ClassVar = ()

    @model_validator(mode="after")
    def _one_way(self):
        if (self.where == "target") != (self.target is not None):
            raise ExperimentError(
                "belong together", key="target", value=f'where = "{self.where}"',
                cure='give target = ["-315 mm", ...] and where = "target", or neither',
            )  # fmt: skip
        return self

    def on(self, machine, period):
        law = super().on(machine, period)
        if law.where == "target":
            return law.replace(aside=target_shift(law.machine, law.target))
        return law.replace(bends=bends_of(law.machine, law.degree, False))

    def check_motion(self, motion, period):
        """Refuse a motion on which d leaves the exact statics, or that the machine cannot hold under gravity."""
        super().check_motion(motion, period)
        if self.where == "path":
            check_places(self.machine, self.bends, motion, period, self.tolerance)

    def moved(self, p, own, r, weight):
        x, xd, xdd = (ca.SX(part) for part in (r.x, r.xd, r.xdd))
        if self.where == "target":
            zero = ca.SX.zeros(len(self.machine.task))
            d = faded(self._near(p, x, xd, xdd), (p.aside, zero, zero))
        else:
            d = shift_along(self.machine, self.bends, p.bends, x, xd, xdd)
        return shifted(self.machine, p.machine, r, *faded(weight, d)), own

    def _near(self, p, x, xd, xdd):
        """w of eq. (2), and its rates."""
        k = min(3, len(self.machine.task))
        gap, v, a = x[:k] - ca.SX(ca.DM(self.target[:k])), xd[:k], xdd[:k]
        square = p.distance**2
        share, rate, bend = ca.dot(gap, gap), 2 * ca.dot(gap, v), 2 * (ca.dot(v, v) + ca.dot(gap, a))
        w, slope, curve = ramp(share / square, 1.0)
        rate, bend = rate / square, bend / square
        return 1 - w, -slope * rate, -(curve * rate * rate + slope * bend)
