"""Cartesian direct robust adaptive control (CDAC): the sliding law that also learns load-dependent friction.

On sliding.py, eqs. (1)-(11), with N_i the normal force of strut i on the reference motion, from the estimates of the
sample before (theta and so N know nothing of this sample), and sgn smoothed, tanh(q' / w):

    friction_i = (F_0 + mu_c N_i) c_i sgn q'_i + mu_v N_i d_i q'_i                                                (12)
    c' by adaptation.py, (1), with y_i = (F_0 + mu_c N_i) sgn(q'_i) s_i;  d' with y_i = mu_v N_i q'_i s_i         (13)
    s = J sigma

with the leakage and projection of adaptation.py, c and d each with a norm of its own.  F_0, mu_c and mu_v are the
believed machine's; c_i, d_i, one a strut, are learned and start at 1.  Where the believed friction does not scale with
a load, N = 1, F_0 = 0 and mu_c, mu_v are its N and N s/m.  Viscous friction of the drives that no load scales is part
of f, (7).

Source: Garagic and Srinivasan, ACC 2004, eqs. (5), (9), (11)-(16).  Deviations: q' is the speed of the reference unless
`friction_speed` is "measured".  At a reversal the strut sticks for tens of milliseconds behind its reference; a
compensation that waits for the measured speed to turn holds it where it is stuck, and the glitch grows.  Stribeck and
spherical joints' friction stay unmodelled, as in the paper: they are left to u_sl.
"""

from __future__ import annotations

from typing import Any, ClassVar, Literal, NamedTuple

import casadi as ca
import numpy as np
from pydantic import model_validator

from ..declare import Array, quantity
from ..errors import ExperimentError
from ..observe import forward
from .adaptation import check_bounds, leak, learned
from .sliding import Known, SlidingLaw


class State(NamedTuple):
    """What the law remembers."""

    observer: forward.Pose
    parameters: Any  # factors on what is learned, (k,)
    coulomb: Any  # factors c, (n,)
    viscous: Any  # factors d, (n,)
    started: Any  # force at rest that the model did not know, on the twist


class RobustAdaptive(SlidingLaw):
    """CDAC, eqs. (1)-(13)."""

    states: ClassVar = {
        "observer.pose": ("coordinate", "m, 1", "estimated pose: position and quaternion of the tool in W"),
        "parameters": ("learned", "1", "estimated inertial and drive parameters over the believed"),
        "coulomb": ("joint", "1", "estimated Coulomb coefficients over the believed"),
        "viscous": ("joint", "1", "estimated viscous coefficients over the believed"),
        "started": ("twist", "N, N m", "force at rest that the model did not know"),
    }
    state_type: ClassVar = State

    kind: Literal["robust_adaptive"] = "robust_adaptive"
    coulomb_rate: float = quantity("1/J", "how fast Coulomb friction is learned", default=10.0, at_least=0)
    viscous_rate: float = quantity("1/J", "how fast viscous friction is learned", default=0.1, at_least=0)
    friction_bounds: Array = quantity(
        "1", "least and greatest factor on friction", default=[0.0, 2.0], shape=(2,), at_least=0
    )

    @model_validator(mode="after")
    def _bounded(self):
        check_bounds(self.friction_bounds, "friction_bounds")
        return self

    def on(self, machine, period):
        law = super().on(machine, period)
        if law.machine.friction is None:
            raise ExperimentError(
                "the believed machine has no friction to learn factors of", key="machine.friction",
                cure='give it one, or use kind = "fuzzy_friction", which needs no model',
            )  # fmt: skip
        return law

    def friction_start(self):
        n = self.machine.joints_count
        return np.ones(n), np.ones(n)

    def friction(self, state, known: Known):
        p, m, r = known.view, self.machine, known.r
        N = m.friction_load(known.machine, known.pi, known.z, ca.SX(r.xd), ca.SX(r.xdd))
        law = known.machine.friction
        sign = ca.tanh(known.qd / p.friction_smoothing)
        offset, load = (0, 1) if N is None else (law.coulomb_offset, N)
        per_c, per_v = (offset + load * law.coulomb) * sign, load * law.viscous * known.qd
        low, high = p.friction_bounds[0], p.friction_bounds[1]
        norm = p.leakage_norm * np.sqrt(m.joints_count)

        def after(estimates, per, rate):
            s_leak = leak(estimates, norm, p.leakage)
            return learned(estimates, per * known.s, rate, low, high, known.step, s_leak)

        c, d = after(state.coulomb, per_c, p.coulomb_rate), after(state.viscous, per_v, p.viscous_rate)
        return per_c * state.coulomb + per_v * state.viscous, (c, d)
