"""Desired computed torque with a velocity observer, and parameters learned while the machine moves.

    u    = Psi p + M_q a + f_0                         Psi, M_q on the reference: linear_model.py, (2), (3)          (1)
    a    = w^2 e + 2 w e'^,    e = q_r - q             e'^ from observe/velocity.py                                  (4)
    p'   = G Psi' M_q^-1 a                                                                                           (5)
    G_jj = k_j s_j^2 / E_j                             k_j is `learning`, E_j and s_j as in linear_model.py, (7)     (6)

Only the joints' places are measured; no pose is sought from them, for all that the model is asked about is the
reference.  So the law runs at three rates: (4) and the observer every sample, Psi p and M_q every `model_period`, (5)
every `adaptation_period`, and what the slower ones found is held.  f_0 are the forces at the start that the first
estimates did not know; they fade with `takeover`, and feedback and learning take their place.

k_j is how fast an error of p_j alone would die on a motion with the excitation E_j.  Where the motion does not show a
parameter, it stays as it is.

Source: Honegger, Nonlinear adaptive control of a 6 dof parallel manipulator, 1998, eqs. (18)-(24), after Craig 1988.
Choices where the paper says nothing, and deviations:
 - M_q is that of the estimates.
 - Psi has every parameter of the machine; `learn` says which are learned (the paper's Table 1 are some of them).
 - G is given by (6), so that one number serves kilograms and newtons.
 - The observer is sampled exactly; `observer` = "euler" gives what (23) is by Euler's method, which at a circle's
   acceleration v^2/r leaves e = Ts v^2/(r w) even where the model is perfect (docs/theory/desired_torque.md).
 - `physical` keeps masses, moments of inertia and friction from falling below 0.  Nothing is learned while a drive is
   saturated.
"""

from __future__ import annotations

from typing import Any, ClassVar, Literal, NamedTuple

import casadi as ca
import numpy as np
from pydantic import Field

from ..declare import Array, quantity
from ..errors import ExperimentError
from ..mechanics.linear import solve_spd
from ..observe import velocity
from . import linear_model
from .base import Command, Controller, Task, saturated


class State(NamedTuple):
    """What the law remembers."""

    observer: velocity.Speed
    parameters: Any  # p, (k,)
    force: Any  # Psi p, (n,) N
    mass: Any  # M_q, (n, n) kg
    feedback: Any  # a, (n,) m/s2
    started: Any  # f_0, (n,) N


class DesiredTorqueAdaptive(Controller):
    """Desired computed torque, eqs. (1)-(6)."""

    states: ClassVar = {
        "observer.position": ("joint", "m", "observed following error, or joint coordinate (euler)"),
        "observer.rate": ("joint", "m/s", "its rate, without innovation"),
        "parameters": ("parameter", "SI", "estimates, in the order of machine.parameters_of(friction=True)"),
        "force": ("joint", "N", "forces of the model, held"),
        "mass": ("joint_pair", "kg", "joint-space mass matrix of the model, held"),
        "feedback": ("joint", "m/s2", "acceleration asked for by the feedback"),
        "started": ("joint", "N", "force at the start that the first estimates did not know, fading"),
    }

    tuned: ClassVar = ("pole", "observer_pole")
    adapted: ClassVar = ("parameters",)

    kind: Literal["desired_torque_adaptive"] = "desired_torque_adaptive"
    pole: float = quantity("1/s", "w, both poles of the following error", above=0)
    observer_pole: float | None = quantity(
        "1/s", "w_0, both poles of the observer; 2.5 w if left out", default=None, above=0
    )
    observer: Literal["exact", "euler"] = Field("exact", description="how the observer is sampled")
    model_period: float | None = quantity(
        "s", "period of Psi p and M_q; the law's if left out", default=None, theta=False, above=0
    )
    adaptation_period: float | None = quantity(
        "s", "period of the learning; ten times the law's if left out", default=None, theta=False, above=0
    )

    learn: list[str] | None = Field(None, description="parameters that are learned; all if left out, none if empty")
    learning: float | Array = quantity(
        "1/s", "k, learning factors: one, or one a learned parameter", default=0.1, above=0, shape=(-1,)
    )
    excitation: Array | None = quantity(
        "m2/s4", "E of the motion to learn from, one a learned parameter; the machine's usual if left out",
        default=None, at_least=0, shape=(-1,),
    )  # fmt: skip
    size: Array | None = quantity(
        "1", "s in SI, one a learned parameter; what is believed of it if left out", default=None, above=0, shape=(-1,)
    )
    estimates: float | Array = quantity(
        "1", "first estimates over what is believed: one factor, or one a parameter", default=1.0, at_least=0,
        shape=(-1,),
    )  # fmt: skip
    physical: bool = Field(False, description="keep masses, moments of inertia and friction at 0 or above")
    friction_smoothing: float = quantity("m/s", "v_0, speed below which friction's sign fades", default=2e-4, above=0)
    takeover: float = quantity("s", "time constant in which f_0 fades", default=1.0, above=0)

    # -- construction ---------------------------------------------------------------------------------------------

    def on(self, machine, period):
        law = super().on(machine, period)
        machine = law.machine
        learned, known = linear_model.indices(machine, law.learn), len(machine.parameters_of(friction=True).names)
        changes: dict[str, Any] = {}
        if law.observer_pole is None:
            changes["observer_pole"] = 2.5 * law.pole
        if law.model_period is None:
            changes["model_period"] = law.period
        if law.adaptation_period is None:
            changes["adaptation_period"] = 10 * law.period
        if law.excitation is None:
            changes["excitation"] = linear_model.usual_excitation(machine)[learned] if learned else np.zeros(0)
        if law.size is None:
            changes["size"] = linear_model.sizes(machine)[learned]
        law = law.replace(**changes)
        for key, count in (*((key, len(learned)) for key in ("learning", "excitation", "size")), ("estimates", known)):
            value = getattr(law, key)
            if np.ndim(value) and len(value) != count:
                ones = "one a learned parameter" if key != "estimates" else "one a parameter"
                raise ExperimentError(f"must be {count} values, {ones}", key=key, value=f"{len(value)} values")
        if law.observer == "euler" and law.observer_pole * law.period >= 2:
            raise ExperimentError(
                "Euler's method is unstable at this sample time", key="observer_pole",
                value=f"w_0 Ts = {law.observer_pole * law.period:.3g}", limit="2",
                cure=f'below {2 / law.period:.4g} 1/s, or observer = "exact"',
            )  # fmt: skip
        return law

    def doubts(self):
        if self.observer_pole >= self.pole:
            return ()
        return (
            f"the observer is slower than the controller: observer_pole {self.observer_pole:g} 1/s is below pole "
            f"{self.pole:g} 1/s, so the loop waits for its speed; give 2.5 times pole, {2.5 * self.pole:g} 1/s",
        )

    @property
    def first_estimates(self) -> np.ndarray:
        """p at the start, SI.  (k,)."""
        return self.machine.parameters_of(friction=True).values * self.estimates

    # -- equations ------------------------------------------------------------------------------------------------

    def init(self, r0, u0) -> State:
        """The state from which the first step gives u0 at r0."""
        p, u0 = self.first_estimates, np.ravel(u0)
        force, mass = linear_model.at_rest(self.machine, np.ravel(r0.x), p)
        start = velocity.start(r0.q, self.observer)
        return State(start, p, force, mass, np.zeros_like(u0), u0 - force)

    def tasks(self):
        model = Task("model", self.model_period, self.model)
        learned = linear_model.indices(self.machine, self.learn)
        return (Task("adaptation", self.adaptation_period, self.adapt), model) if learned else (model,)

    def model(self, state: State, r, y, theta) -> State:
        """Psi p and M_q on the reference of now."""
        p = self.at(theta)
        force, mass = linear_model.force_and_mass(self.machine, p.machine, state.parameters, r, p.friction_smoothing)
        return state._replace(force=force, mass=mass)

    def adapt(self, state: State, r, y, theta) -> State:
        """The estimates after a step of (5), from the feedback of the sample before."""
        p, m = self.at(theta), self.machine
        lag = solve_spd(state.mass, state.feedback)
        taught = linear_model.shown(m, p.machine, state.parameters.shape[0], r, lag, p.friction_smoothing)
        held = saturated(m, p.machine, y.u)
        step = self.adaptation_period * (1 if held is None else 1 - ca.mmax(held))
        names, _, units = m.parameters_of(friction=True)
        after = ca.SX(state.parameters)
        for i, j in enumerate(linear_model.indices(m, self.learn)):
            after[j] += step * self._gain(p, i) * taught[j]
            if self.physical and _never_negative(names[j], units[j]):
                after[j] = ca.if_else(after[j] < 0, 0, after[j])
        return state._replace(parameters=after)

    @staticmethod
    def _gain(p, i: int):
        """G_jj of eq. (6) of learned parameter i; 0 where the motion of E does not show it."""
        k, E = (p.learning if p.learning.numel() == 1 else p.learning[i]), p.excitation[i]
        return ca.if_else(E > 0, k * p.size[i] ** 2 / ca.if_else(E > 0, E, 1), 0)

    def step(self, state: State, r, y, theta):
        p = self.at(theta)
        rate = velocity.speed_error(state.observer, r, y.q, p.observer_pole, p.period, self.observer)
        a = p.pole**2 * (r.q - y.q) + 2 * p.pole * rate
        observer = velocity.advanced(state.observer, r, y.q, a, p.observer_pole, p.period, self.observer)
        u = state.force + state.mass @ a + state.started
        started = state.started * ca.exp(-p.period / p.takeover)
        return Command(u), state._replace(observer=observer, feedback=a, started=started)


def _never_negative(name: str, unit: str) -> bool:
    """Whether a body or a joint cannot have this parameter below 0: a mass, a moment of inertia, friction."""
    product = name[-3:-2] == "I" and name[-2] != name[-1]
    return unit in ("kg", "N", "N s/m") or (unit == "kg m2" and not product)
