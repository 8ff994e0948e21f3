"""Cartesian direct adaptive control with fuzzy friction compensation (FCDAC): friction learned without a model.

On sliding.py, eqs. (1)-(11), with one Takagi-Sugeno system of rules for every joint i: the speed x = q'_i belongs to
rule k by a Gaussian, and what rule k says is linear in z,

    m_k = exp(-((x - c_k) / w_k)^2),    zeta = m / sum(m)                                                         (14)
    z = [1, x / x_0, sgn x, V_r'[0] / a_0, ...]                                                                   (15)
    friction_i = z' A_i zeta                                                                                      (16)
    A_i' = G z zeta' s_i,    s = J sigma                                                                          (17)

each entry of A_i held within +-`strength`.  x is taken within the outermost centres, where their rules go on unchanged:
no speed is without a rule.  sgn is smoothed as in robust_adaptive.py; x_0 = 0.1 m/s and a_0, the machine's feed
acceleration, give all entries of A the unit N.  G is a stiffness: learned friction holds against the integral of s.

Source: Garagic and Srinivasan, ACC 2004, eqs. (22)-(32).  Deviations: (31) of the paper lacks the error that (35) has;
since friction acts in each joint, that error is s_i, of that joint, and not sigma.  The paper's z lacks the sixth
acceleration; `accelerations` says how many are used, in the order of the twist (the paper's load dependence; none
unless asked for), and they are those of the reference: A_s holds the measured speed.  Projection is per entry.
"""

from __future__ import annotations

from typing import Any, ClassVar, Literal, NamedTuple

import casadi as ca
import numpy as np
from pydantic import Field, model_validator

from ..declare import Array, quantity
from ..errors import ExperimentError, InputError
from ..mechanics.linear import clip
from ..observe import forward
from .sliding import Known, SlidingLaw

SPEED = 0.1  # m/s, x_0
EMPTY = 1e-3  # least sum of memberships between the outermost centres


class State(NamedTuple):
    """What the law remembers."""

    observer: forward.Pose
    parameters: Any  # factors on what is learned, (k,)
    weights: Any  # A of all joints: (len(z) rules, n) N, an A_i by columns
    started: Any  # force at rest that the model did not know, on the twist


class FuzzyFriction(SlidingLaw):
    """FCDAC, eqs. (1)-(11), (14)-(17)."""

    states: ClassVar = {
        "observer.pose": ("coordinate", "m, 1", "estimated pose: position and quaternion of the tool in W"),
        "parameters": ("learned", "1", "estimated inertial and drive parameters over the believed"),
        "weights": ("weight", "N", "consequents of the rules, joint by joint, rule by rule"),
        "started": ("twist", "N, N m", "force at rest that the model did not know"),
    }
    state_type: ClassVar = State

    kind: Literal["fuzzy_friction"] = "fuzzy_friction"
    centers: Array = quantity(
        "m/s", "c: joint speeds at which rules are at home, rising", default=[-0.05, -0.005, 0.0, 0.005, 0.05],
        shape=(-1,),
    )  # fmt: skip
    widths: Array = quantity("m/s", "w: of each rule", default=[0.02, 0.003, 0.002, 0.003, 0.02], above=0, shape=(-1,))
    friction_rate: float | Array | None = quantity(
        "N/m", "G: newtons learned a metre of error; k^2 / (4 m) of each joint if left out",
        default=None, at_least=0, shape=(-1,),
    )  # fmt: skip
    acceleration_rate: float = quantity("1", "the same for accelerations, as a share of G", default=0.01, at_least=0)
    accelerations: int = Field(0, ge=0, description="how many reference accelerations the rules know, in twist order")
    strength: float = quantity("N", "greatest size of an entry of A", default=800.0, above=0)

    @model_validator(mode="after")
    def _covers(self):
        c, w = np.atleast_1d(self.centers), np.atleast_1d(self.widths)
        if not c.size:
            raise InputError(
                "the fuzzy partition is empty: there is no rule", key="centers", cure="give one centre at least"
            )
        if np.any(np.diff(c) <= 0):
            raise InputError("centres must rise", key="centers", value=str(c.tolist()))
        if c.shape != w.shape:
            raise InputError("every centre needs a width", key="widths", value=f"{len(w)} for {len(c)} centres")
        x = np.linspace(c[0], c[-1], 2001)
        total = np.exp(-(((x[:, None] - c) / w) ** 2)).sum(1)
        worst = int(total.argmin())
        if total[worst] < EMPTY:
            raise InputError(
                "the fuzzy partition is empty: at some speed no rule holds", key="widths",
                value=f"memberships add up to {total[worst]:.2g} at {x[worst]:.3g} m/s", limit=f"{EMPTY:g}",
                cure="widen the rules on both sides, or put one between them",
            )  # fmt: skip
        return self

    def on(self, machine, period):
        law = super().on(machine, period)
        d = len(law.machine.velocities)
        if law.accelerations > d:
            raise ExperimentError(f"the machine has {d}", key="accelerations", value=str(law.accelerations))
        n = law.machine.joints_count
        if np.ndim(law.friction_rate) and len(law.friction_rate) != n:
            raise ExperimentError(
                f"must be one value or {n}", key="friction_rate", value=f"{len(law.friction_rate)} values"
            )
        return law if law.friction_rate is not None else law.replace(friction_rate=law._critical_rate())

    def _critical_rate(self) -> np.ndarray:
        """k^2 / (4 m) of each joint, the others free: a double pole of m s'' + k s' + G s = 0, (8) and (17)."""
        J, M = self.machine.jacobian(self.machine.home), self.machine.mass_matrix(self.machine.home)
        m, k = (1 / np.diag(J @ np.linalg.solve(A, J.T)) for A in (M, self.K_D))
        return k**2 / (4 * m)

    def friction_start(self):
        rows = 3 + self.accelerations
        return (np.zeros(rows * np.size(self.centers) * self.machine.joints_count),)

    def friction(self, state, known: Known):
        p, r = known.view, known.r
        rules, rows = np.size(self.centers), 3 + self.accelerations
        turns = self.turns[: self.accelerations]
        feed = p.machine.feed
        scale = [feed.angular_acceleration if turning else feed.acceleration for turning in turns]
        shared = [r.xdd[k] / a_0 for k, a_0 in enumerate(scale)]
        share = ca.vertcat(ca.DM.ones(3, 1), ca.repmat(p.acceleration_rate, rows - 3, 1))
        lost, after = [], []
        for i, A in enumerate(ca.vertsplit(ca.SX(state.weights), rows * rules)):
            A = ca.reshape(A, rows, rules)
            x = clip(known.qd[i], p.centers[0], p.centers[rules - 1])
            m_k = ca.exp(-(((x - p.centers) / p.widths) ** 2))
            zeta = m_k / ca.sum1(m_k)
            z = ca.vertcat(1, x / SPEED, ca.tanh(known.qd[i] / p.friction_smoothing), *shared)
            lost.append(z.T @ A @ zeta)
            G = p.friction_rate[i] if np.ndim(self.friction_rate) else p.friction_rate
            moved = A + known.step * known.s[i] * G * (share * z) @ zeta.T
            after.append(clip(ca.vec(moved), -p.strength, p.strength))
        return ca.vertcat(*lost), (ca.vertcat(*after),)
