"""What the adaptive sliding-mode laws share: the pose follows a surface, the inertial parameters are learned.

    e     = [p_r - p; log(R_r R')]                                                                                 (1)
    V_s   = V_r + L e,   A_s = V_r' + L (V_r - V),   sigma = V_s - V                                               (2)

    f(theta) = M v' + C(V) V_s + g + J' F_v J V_s,  with v' = A_s: linear in the factors theta on what is learned  (7)
    force    = f(theta) + K_D sigma + u_sl + f_0                                                                   (8)
    u_sl     = tau_0 W sigma / max(|sigma|_W, eps),   |sigma|_W^2 = sigma' W sigma,   W = diag(1, 1, 1, l^2 ...)   (9)
    u        = J^-T force + friction                                                                              (10)
    theta'   by adaptation.py, (1), with y = d(sigma' f)/d theta                                                  (11)

L is `slope`, K_D = sqrt(D) M(home) sqrt(D) with D = diag(`damping`), or given.  f_0 is what holds the machine at the
start beyond f (its model's error there), so that nothing moves.  (3)-(6), C by two calls of the inverse dynamics, are
in docs/theory/sliding.md with the proof that V = sigma' M sigma / 2 + theta~' g^-1 theta~ / 2 does not rise.

Source: Garagic and Srinivasan, ACC 2004, eqs. (6)-(17), with these deviations:
 - The paper adds K_D sigma, a force on the platform, to motor torques; and its M* is not symmetric.  Its proof needs
   all of (8) in Cartesian space and (10) after it: the motors get K_a J' K_D sigma, in its letters.
 - Orientation is a rotation vector, not a difference of Euler angles; A_s is V_s' but for terms of second order in e.
 - One tau_0 / eps for m/s and rad/s is none for either: W weights them by the length l.
 - The regressor of (11) is taken at the reference motion (V_r, V_r') unless `regressor` is "actual".  The measured
   speed stands in A_s and in sigma; the square of its noise drives the estimates to their bounds (4 kHz, 1 um).  What
   is lost: (11) is then exact only to first order in sigma, and the proof asks for "actual".
 - Everything learned waits while a drive is saturated.
"""

from __future__ import annotations

from abc import abstractmethod
from functools import lru_cache
from typing import Any, ClassVar, Literal, NamedTuple

import casadi as ca
import numpy as np
from pydantic import Field, model_validator

from ..declare import Array, Shape, quantity
from ..errors import ExperimentError, InputError, did_you_mean
from ..mechanics.linear import solve_square_transposed
from ..observe import forward
from .adaptation import check_bounds, leak, learned
from .base import Command, Controller, saturated, unknown_force

# sigma' = -k sigma, held for a sample, its speed the mean of the last one: z^2 - z + k Ts (z + 1) / 2, and with a
# sample of delay z^3 - z^2 + k Ts (z + 1) / 2, leave the unit circle at these k Ts
FASTEST = {0: 2.0, 1: 2 * (np.sqrt(2) - 1)}


class Known(NamedTuple):
    """What friction compensation may look at in one sample."""

    view: Any  # of the law
    machine: Any  # view of the machine with the estimates in it
    pi: Any  # its inertial parameters
    z: Any  # coordinates, (7,)
    J: Any
    s: Any  # J sigma, the error of each joint's speed, (n,) m/s
    qd: Any  # speeds that give friction its sign, (n,) m/s
    r: Any  # the reference
    step: Any  # s, 0 while nothing is to be learned


class SlidingLaw(Controller):
    """Eqs. (1)-(11) without friction; a law adds its own."""

    tuned: ClassVar = ("slope", "damping", "K_D")
    adapted: ClassVar = ("parameters", "coulomb", "viscous", "weights")

    slope: float | Array = quantity("1/s", "L: the error decays so fast on the surface", above=0, shape=(-1,))
    damping: float | Array | None = quantity(
        "1/s", "rate at which the surface is reached, D of K_D = sqrt(D) M(home) sqrt(D)",
        default=None, above=0, shape=(-1,),
    )  # fmt: skip
    K_D: Array | None = quantity(
        "N s/m", "damping matrix, symmetric and positive definite; rows of turnings in N m s", default=None,
        shape=(-1, -1),
    )  # fmt: skip
    sliding: float = quantity("N", "tau_0, bound of the force that holds on the surface", default=0.0, at_least=0)
    boundary: float = quantity("m/s", "eps, half-width of the boundary layer", default=2e-3, above=0)
    length: float | None = quantity("m", "l, how far a turning counts; from M(home) if left out", default=None, above=0)

    adapt: list[str] | None = Field(
        None,
        description='numbers of the sheet to learn, "a + b" by one factor; the machine\'s choice if left out',
    )
    inertia_rate: float = quantity("1/J", "how fast inertial parameters are learned", default=0.3, at_least=0)
    bounds: Array = quantity("1", "least and greatest factor on them", default=[0.5, 1.5], shape=(2,), at_least=0)
    leakage: float = quantity("W", "s_0 of the sigma modification", default=1.0, at_least=0)
    leakage_norm: float = quantity(
        "1", "M_0, root mean square of a group of factors above which it acts", default=1.5, above=0
    )
    regressor: Literal["desired", "actual"] = Field("desired", description="motion at which is learned")

    friction_speed: Literal["reference", "measured"] = Field(
        "reference", description="speed that gives compensated friction its sign"
    )
    friction_smoothing: float = quantity("m/s", "speed below which that sign fades", default=2e-4, above=0)

    # -- construction ---------------------------------------------------------------------------------------------

    @model_validator(mode="after")
    def _sound(self):
        if (self.damping is None) == (self.K_D is None):
            raise InputError("give either damping or K_D", key="damping", cure='write damping = "200 1/s"')
        if self.K_D is not None:
            _check_positive(self.K_D, "K_D")
        check_bounds(self.bounds, "bounds")
        return self

    def on(self, machine, period):
        law = super().on(machine, period)
        machine, d = law.machine, len(law.machine.velocities)
        for key in ("slope", "damping"):
            if np.ndim(getattr(law, key)) and len(getattr(law, key)) != d:
                raise ExperimentError(f"must be one value or {d}", key=key, value=f"{len(getattr(law, key))} values")
        M = machine.velocity_mass(machine.home)
        if law.K_D is None:
            root = np.sqrt(np.broadcast_to(law.damping, d))
            law = law.replace(K_D=root[:, None] * M * root, damping=None)
        elif law.K_D.shape != (d, d):
            raise ExperimentError(f"must be {d} x {d}", key="K_D", value="x".join(map(str, law.K_D.shape)))
        turns = law.turns
        if law.length is None and turns.any():
            law = law.replace(length=float(np.sqrt(np.trace(M[turns][:, turns]) / np.trace(M[~turns][:, ~turns]))))
        if law.adapt is None:
            law = law.replace(adapt=[text for text in machine.adaptable if _names(text) <= set(machine.names)])
        law._check_adapt()
        law._check_period(M)
        return law

    @property
    def turns(self) -> np.ndarray:
        """Which velocities are turnings.  (d,) bool."""
        return np.array([name.startswith("w") for name in self.machine.velocities])

    def _check_adapt(self) -> None:
        known, before = self.machine.names, set()
        for i, text in enumerate(self.adapt):
            for name in sorted(_names(text) - set(known)):
                raise ExperimentError(
                    f"{self.machine.name} has no such number", key=f"adapt.{i}", value=ascii(name),
                    cure=did_you_mean(name, known if name else self.machine.adaptable),
                )  # fmt: skip
            for name in sorted(_names(text) & before):
                raise ExperimentError("a number is learned by one factor", key=f"adapt.{i}", value=f"{name} once more")
            before |= _names(text)
        idle, nonlinear = _unfit(Shape(self))
        if nonlinear:
            raise ExperimentError(
                "the equations of motion are not linear in what is to be learned", key=f"adapt.{nonlinear[0]}",
                value=self.adapt[nonlinear[0]], cure="learn masses and inertias; geometry stays as it is",
            )  # fmt: skip
        if idle:
            raise ExperimentError(
                "no force depends on it, so nothing is to be learned of it", key=f"adapt.{idle[0]}",
                value=self.adapt[idle[0]], cure="learn masses and inertias; friction has factors and rules of its own",
            )  # fmt: skip

    def _check_period(self, M) -> None:
        W = np.diag(self._weights(self))
        fastest = float(
            np.abs(np.linalg.eigvals(np.linalg.solve(M, self.K_D + self.sliding / self.boundary * W))).max()
        )
        limit = FASTEST[int(self.machine.drive.delay)]
        if fastest * self.period >= limit:
            raise ExperimentError(
                "the sample time is too long for damping and boundary layer",
                key="boundary" if self.sliding else "damping",
                value=f"(K_D + tau_0 W / eps) / M = {fastest:.4g} 1/s, times {self.period * 1e3:g} ms = "
                f"{fastest * self.period:.3g}",
                limit=f"{limit:.3g}",
                cure=f"a period below {limit / fastest * 1e3:.3g} ms, less damping or a wider boundary layer",
            )

    # -- equations ------------------------------------------------------------------------------------------------

    def _weights(self, p):
        """The diagonal of W, eq. (9)."""
        return [p.length**2 if turning else 1.0 for turning in self.turns]

    def _believed(self, theta, factors):
        """View of the machine with its learned numbers times their factors."""
        m, names = self.machine, self.names
        start = next(i for i, name in enumerate(names) if name.startswith("machine."))
        numbers = ca.SX(theta[start : start + len(m.theta)])
        for k, text in enumerate(self.adapt):
            for name in _names(text):
                numbers[m.names.index(name)] *= factors[k]
        return m.at(numbers)

    def _force(self, believed, z, J, V, V_s, A_s):
        """f of eq. (7) on the twist."""
        m = self.machine
        pi = {key: value for key, (value, _) in m.inertial(believed).items()}
        return m.passive_force(believed, pi, z, V, V_s, A_s) + J.T @ (m.drag(believed) * (J @ V_s))

    def _force_at(self, believed, z, J, V, A):
        """f of eq. (7) where both velocities are V: the inverse dynamics."""
        m = self.machine
        pi = {key: value for key, (value, _) in m.inertial(believed).items()}
        return m.inverse_force(believed, pi, z, V, A) + J.T @ (m.drag(believed) * (J @ V))

    @abstractmethod
    def friction_start(self) -> Any:
        """The friction's first estimates, a NamedTuple of NumPy."""

    @abstractmethod
    def friction(self, state, known: Known) -> tuple[Any, Any]:
        """(force that friction is expected to take (n,) N, next estimates)."""

    def init(self, r0, u0):
        """The state from which the first step gives u0 at r0."""
        z0, missing = self.machine.coordinates(np.ravel(r0.x)), unknown_force(self.machine, r0, u0)
        return self.state_type(forward.Pose(z0), np.ones(len(self.adapt)), *self.friction_start(), missing)

    state_type: ClassVar[type]

    def step(self, state, r, y, theta):
        p, m = self.at(theta), self.machine
        z, V, observer = forward.estimate(m, p.machine, state.observer, y.q, p.period)
        e, V_r, A_r = m.target(p.machine, r, z)
        V_s, A_s = V_r + p.slope * e, A_r + p.slope * (V_r - V)
        sigma = V_s - V
        held = saturated(m, p.machine, y.u)
        step = p.period * (1 if held is None else 1 - ca.mmax(held))

        factors = ca.SX.sym("factors", len(self.adapt))
        believed, J = self._believed(theta, factors), m.jacobian_of(p.machine, z)
        f = self._force(believed, z, J, V, V_s, A_s)
        taught = f if self.regressor == "actual" else self._force_at(believed, z, J, ca.SX(V_r), ca.SX(A_r))
        power = ca.gradient(ca.dot(sigma, taught), factors) if self.adapt else ca.SX(0, 1)
        f, power = ca.substitute([f, power], [factors], [state.parameters])
        s_leak = leak(state.parameters, p.leakage_norm * np.sqrt(max(len(self.adapt), 1)), p.leakage)
        parameters = learned(state.parameters, power, p.inertia_rate, p.bounds[0], p.bounds[1], step, s_leak)

        W = ca.vertcat(*self._weights(p))
        size = ca.sqrt(ca.dot(W * sigma, sigma))
        slide = p.sliding * W * sigma / ca.if_else(size > p.boundary, size, p.boundary)
        force = f + p.K_D @ sigma + slide + state.started

        now = self._believed(theta, state.parameters)
        pi = {key: value for key, (value, _) in m.inertial(now).items()}
        qd = r.qd if self.friction_speed == "reference" else J @ V
        lost, estimates = self.friction(state, Known(p, now, pi, z, J, J @ sigma, qd, r, step))
        u = solve_square_transposed(J, force) + lost
        return Command(u), self.state_type(observer, parameters, *estimates, state.started)


def _names(text: str) -> set[str]:
    return {name.strip() for name in text.split("+")}


def _check_positive(K, key: str) -> None:
    """P3: symmetric first, for a Cholesky factor of the lower triangle would not notice."""
    if K.shape[0] != K.shape[1] or np.abs(K - K.T).max() > 1e-9 * np.abs(K).max():
        raise InputError(
            "must be symmetric",
            key=key,
            value=f"differs by up to {np.abs(K - K.T).max():.3g}"
            if K.shape[0] == K.shape[1]
            else "x".join(map(str, K.shape)),
        )
    eigenvalues = np.linalg.eigvalsh(K)
    if not eigenvalues.min() > 0:
        raise InputError(
            "must be positive definite", key=key, value="eigenvalues " + ", ".join(f"{x:.4g}" for x in eigenvalues)
        )


@lru_cache(maxsize=64)
def _unfit(shape: Shape) -> tuple[list[int], list[int]]:
    """Of a law of that structure, which groups f does not depend on, and which it is not linear in.

    No number of the law or its machine matters: all are symbols here.
    """
    law = shape.part
    m, d = law.machine, len(law.machine.velocities)
    theta, factors = ca.SX.sym("theta", len(law.theta)), ca.SX.sym("factors", len(law.adapt))
    z = ca.SX.sym("z", m.coordinate_count)
    V, A = ca.SX.sym("V", d), ca.SX.sym("A", d)
    f = law._force_at(law._believed(theta, factors), z, m.jacobian_of(law.at(theta).machine, z), V, A)
    idle = [i for i, used in enumerate(ca.which_depends(f, factors, 1)) if not used]
    return idle, [i for i, curved in enumerate(ca.which_depends(f, factors, 2)) if curved]
