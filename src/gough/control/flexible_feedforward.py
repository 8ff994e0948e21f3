"""Flexible feedforward: the reference moved so that the tool of a flexible machine, bent by its motion, is on its path.

The forces that a motion asks for bend the machine as gravity does.  With d(x, x', x'') of both (control/bending.py, for
every motion slow against the first mode: docs/theory/flexible_control.md, section 4), the inner law is told

    x_c = x + w y,   x_c' = x' + (w y)',   x_c'' = x'' + (w y)''                                                    (1)

w fading in over `takeover`.  d' would ask for the jerk, of which a reference says nothing; so y follows d as a filter
of two equal poles b = 2 pi bandwidth whose input runs ahead by its lag,

    i = (d + d_) / 2 + (2 / b) (d - d_) / Ts,   y'' = b^2 (i - y) - 2 b y'                                          (2)

d_ that of the sample before: of a steady d' nothing lags, of d'' 1 / b^2 of it.  (2) is solved exactly from sample to
sample, with i held, which is why i is that of the middle.  A step of the acceleration is a step of d that no joint can
follow: give a bounded jerk.

Bouzgarrou et al. 2001 name inversion with the flexible model as further work; this is its first order.
"""

from __future__ import annotations

from typing import Any, ClassVar, Literal, NamedTuple

import casadi as ca
import numpy as np
from pydantic import Field

from ..declare import quantity
from ..errors import ExperimentError
from .bending import Bends, bends_of, shift, shift_at
from .bending_check import check_places
from .shifted import shifted
from .wrapping import Wrapping, faded


class Filter(NamedTuple):
    """What eq. (2) remembers."""

    y: Any  # (len(task),) m, rad
    rate: Any  # y'
    last: Any  # d_


class FlexibleFeedforward(Wrapping):
    """Eqs. (1), (2) around an inner law."""

    states: ClassVar = {
        "own.y": ("task", "m, rad", "displacement of the reference, from the tool to where the joints must stand"),
        "own.rate": ("task", "m/s, rad/s", "its rate"),
        "own.last": ("task", "m, rad", "what it follows, in the sample before"),
    }

    kind: Literal["flexible_feedforward"] = "flexible_feedforward"
    bandwidth: float = quantity("Hz", "b / 2 pi, of the displacement's filter", default=100.0, above=0)
    degree: int = Field(6, ge=1, le=10, description="of the polynomials, where the machine needs them")
    tolerance: float = quantity(
        "m", "greatest distance from the exact statics along a motion", default=1e-6, theta=False, above=0
    )
    bends: Bends | None = Field(None, description="made by `on`, from the machine's [[compliance]]")

    def on(self, machine, period):
        law = super().on(machine, period)
        if law.bandwidth * law.period >= 0.2:  # e^(-b Ts) below 0.3: the filter is hardly there
            raise ExperimentError(
                "is too fast for the sample time", key="bandwidth", value=f"{law.bandwidth:g} Hz at {law.period:g} s",
                limit=f"{0.2 / law.period:g} Hz",
            )  # fmt: skip
        return law.replace(bends=bends_of(law.machine, law.degree, True))

    def check_motion(self, motion, period):
        """Refuse a motion on which d at rest is not the exact statics', or that the machine cannot hold."""
        super().check_motion(motion, period)
        check_places(self.machine, self.bends, motion, period, self.tolerance)

    def first(self, r0):
        d = shift_at(self.machine, self.bends, np.ravel(r0.x)[None])[0]
        return Filter(d, np.zeros_like(d), d)

    def moved(self, p, own, r, weight):
        y, yd, last = own
        x, xd, xdd = (ca.SX(part) for part in (r.x, r.xd, r.xdd))
        d = shift(self.machine, self.bends, p.bends, x, xd, xdd)
        b, Ts = 2 * np.pi * p.bandwidth, p.period
        ahead = (d + last) / 2 + 2 / b * (d - last) / Ts
        # (2) over the sample that ends now: of e = y - i, e+ = (e (1 + b Ts) + e' Ts) exp(-b Ts); y'' is its mean
        e, fade = y - ahead, ca.exp(-b * Ts)
        y, before = ahead + (e * (1 + b * Ts) + yd * Ts) * fade, yd
        yd = (yd * (1 - b * Ts) - b * b * Ts * e) * fade
        ydd = (yd - before) / Ts
        return shifted(self.machine, p.machine, r, *faded(weight, (y, yd, ydd))), Filter(y, yd, d)
