"""Contouring by equivalent errors with integral sliding mode: contour errors and the tangential error as coordinates.

    E = (e_1, e_2, e_3, r),   e_1, e_2 of path_equations.py, (1)-(3)
    e_3 = g.d,   d = p - p_r,   g = t, or p_r' (`tangential` = "power")                                            (4)
    e_3'' = g.d'' + 2 g'.d' + g''.d;   t' = k s' n,   t'' = k s'' n - k^2 s'^2 t                                   (5)
    r = log(R R_r'),   r'' = w' - w_r'               where the tool turns freely: three more, small                (6)
    E'' = W + G u,   G = E_x x'' by u,  W all that is not the drives'                                               (7)
    s = E' + b E + c i,   i' = E                                                                                   (8)
    E'' = -b E' - c E - K sat(s / delta)            is asked of (7):  u = G^-1 (-W - b E' - c E - K sat(s / delta)) (9)

so that s' = -K sat(s / delta), and the contour errors know nothing of the tangential one.  (9) is solved without the
inverse of the mass matrix: x'' from E_x x'' = ..., then u by inverse dynamics; `error_dynamics` gives W and G.

Coordinates from the measured joints are exact ("newton", observe.forward), or one Newton step from those of the
reference, which is what is left of the path's place when phi is linearised there ("linear"):

    b^ = b_r - phi_b^-1 phi_a (a - a_r),   b^' = -phi_b^-1 phi_a a'                                                (10)

Speeds of the joints are differences of what the encoders say, over two samples or three:

    q' = (q - q_) / Ts,   or   (3 q - 4 q_ + q__) / 2 Ts: right for a constant acceleration, and 1.8 times as noisy (11)

docs/theory/equivalent_error.md.  Source: Chen and Tsai, Contouring control of a parallel mechanism based on equivalent
errors, 2008, eqs. (17)-(21) and
section V; K = (mu_1 + mu_2) / (1 - k).  Deviations: W has a minus in (9), printed is a plus, with which the error
dynamics would not be linear; s has c i, printed is c E a second time.  Beyond the paper: (3), (6), and the force at
rest that the model does not know, taken over at the start (`bumpless`).
"""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import casadi as ca
import numpy as np

from .. import frames
from ..declare import Array, one_of, quantity
from ..errors import ExperimentError
from ..kernel.pack import flatten, symbols, unflatten
from ..mechanics.linear import clip, solve_spd, solve_square, solve_square_transposed
from ..observe import forward
from .base import Command, Controller, saturated, unknown_force
from .path_check import check_equations
from .path_equations import Frame, PathEquations, carried, frame_at, local, second_order
from .sliding import FASTEST


class State(NamedTuple):
    """What the law remembers."""

    observer: forward.Pose  # of the measured joints, or of those of the reference
    joints: Any  # of the last sample, (n,) m
    before: Any  # of the one before
    frame: Frame
    integral: Any  # i of eq. (8), (d,)
    change: Any  # x_r'' of the last sample, (3,)
    started: Any  # forces at rest that the model does not know, on v


class Errors(NamedTuple):
    """E at a state: value, rate, E'' = gradient x'' + drift."""

    value: Any
    rate: Any
    drift: Any
    gradient: Any


class EquivalentError(Controller):
    """Eqs. (4)-(11)."""

    states: ClassVar = {
        "observer.pose": ("coordinate", "m, rad, 1", "estimated coordinates of the machine"),
        "joints": ("joint", "m", "joint coordinates of the last sample"),
        "before": ("joint", "m", "joint coordinates of the sample before that"),
        "frame": ("frame_axis", "1", "tangent of the path and two axes across it, in W"),
        "integral": ("error", "m s, rad s", "integrals of contour errors, tangential error, rotation"),
        "change": ("axis", "m/s2", "acceleration of the reference of the last sample"),
        "started": ("velocity", "N, N m", "force at rest that the model did not know"),
    }
    tuned: ClassVar = ("damping", "stiffness", "strength")
    adapted: ClassVar = ()

    kind: Literal["equivalent_error"] = "equivalent_error"
    damping: float = quantity("1/s", "b, damping of every error", default=40.0, above=0)
    stiffness: float = quantity("1/s2", "c, stiffness of every error", default=400.0, above=0)
    strength: float | Array = quantity(
        "1", "K, in the unit of each error / s2: of both contour errors, the tangential one, and rotations",
        default=260.0, at_least=0, shape=(-1,),
    )  # fmt: skip
    boundary: float | Array = quantity(
        "1", "delta, in the unit of each error / s: half-width of the boundary layer", default=1.0, above=0, shape=(-1,)
    )
    path: Annotated[PathEquations | None, one_of(conic="gough.control.path_equations:Conic")] = None
    tangential: Literal["distance", "power"] = "distance"
    coordinates: Literal["newton", "linear"] = "newton"
    speed: Literal["two_samples", "three_samples"] = "three_samples"
    bumpless: bool = True

    # -- construction ---------------------------------------------------------------------------------------------

    def on(self, machine, period):
        law = super().on(machine, period)
        d = len(law.machine.task)
        if d < 3:
            raise ExperimentError(
                "contour errors are across a path in space", key="controller", value=f"{law.machine.name}, of {d} axis",
                cure='write kind = "pid", or another machine',
            )  # fmt: skip
        for key in ("strength", "boundary"):
            if np.ndim(getattr(law, key)) and len(getattr(law, key)) != d:
                raise ExperimentError(f"must be one value or {d}", key=key, value=f"{len(getattr(law, key))} values")
        steepest = law.damping + float(np.max(np.asarray(law.strength) / np.asarray(law.boundary)))
        limit = FASTEST[int(law.machine.drive.delay)]
        if steepest * law.period >= limit:
            product = f"times {law.period * 1e3:g} ms = {steepest * law.period:.3g}"
            raise ExperimentError(
                "the sample time is too long for the boundary layer", key="boundary",
                value=f"b + K / delta = {steepest:.4g} 1/s, {product}",
                limit=f"{limit:.3g}", cure=f"a period below {limit / steepest * 1e3:.3g} ms, or a wider boundary layer",
            )  # fmt: skip
        return law

    def standing(self) -> EquivalentError:
        """The law without equations of a path that home is not on: its linear gains b, c, K / delta are the same."""
        return self.replace(path=None, tangential="distance")

    def check_motion(self, motion, period: float) -> None:
        """Refuse a motion on which the equations of the path do not hold, or have no gradient.

        Raises
        ------
        ExperimentError
            with time and NC line of the first sample found.
        """
        check_equations(self, motion, period)

    # -- equations ------------------------------------------------------------------------------------------------

    def errors(self, p, r, position, quat, xd, frame: Frame, change) -> Errors:
        """E of a tool at `position` (3,) with `quat` (4,) that moves with xd (d,).  Eqs. (4)-(6)."""
        tip = ca.SX.sym("tip", 3)
        p_r, v_r, a_r = (ca.SX(column)[:3] for column in (r.x, r.xd, r.xdd))
        bend = ca.SX(r.normal) * r.curvature
        F = local(tip, frame, p_r, bend) if self.path is None else self.path.equations(p.path, tip)
        contour = second_order(F, tip, position, xd[:3])
        if self.tangential == "power":
            g, gd, gdd = v_r, a_r, (a_r - change) / p.period
        else:
            g, s_dd = frame.tangent, ca.dot(frame.tangent, a_r)
            gd, gdd = bend * r.sd, bend * s_dd - (r.curvature * r.sd) ** 2 * g
        d, dd = position - p_r, xd[:3] - v_r
        value = ca.vertcat(contour.value, ca.dot(g, d))
        rate = ca.vertcat(contour.rate, ca.dot(gd, d) + ca.dot(g, dd))
        drift = ca.vertcat(contour.drift, ca.dot(gdd, d) + 2 * ca.dot(gd, dd) - ca.dot(g, a_r))
        gradient = ca.vertcat(contour.gradient, g.T)
        if xd.numel() == 6:
            turn = frames.quaternion_product(quat, frames.conjugate(frames.quaternion_of_abc(r.x[3:])))
            value = ca.vertcat(value, frames.rotation_vector_of_quaternion(turn))
            rate, drift = ca.vertcat(rate, xd[3:] - r.xd[3:]), ca.vertcat(drift, -ca.SX(r.xdd[3:]))
            gradient = ca.diagcat(gradient, ca.SX.eye(3))
        return Errors(value, rate, drift, gradient)

    def asked(self, p, E: Errors, integral):
        """E'' of eq. (9).  (d,)."""
        s = E.rate + p.damping * E.value + p.stiffness * integral
        held = clip(s / p.boundary, -1, 1)
        return -p.damping * E.rate - p.stiffness * E.value - p.strength * held

    @staticmethod
    def acceleration(E: Errors, wanted):
        """x'' with E'' as wanted: by Cramer's rule, a rotation's own.  (d,)."""
        G, y = E.gradient, wanted - E.drift
        across = ca.cross(G[1, :3].T, G[2, :3].T), ca.cross(G[2, :3].T, G[0, :3].T), ca.cross(G[0, :3].T, G[1, :3].T)
        tip = (across[0] * y[0] + across[1] * y[1] + across[2] * y[2]) / ca.dot(G[0, :3].T, across[0])
        return ca.vertcat(tip, y[3:])

    def init(self, r0, u0) -> State:
        """The state from which the first step gives u0 at r0 (where `bumpless`)."""
        m, q = self.machine, np.ravel(r0.q)
        missing = unknown_force(m, r0, u0)
        return State(
            forward.Pose(m.coordinates(np.ravel(r0.x))), q, q, frame_at(r0.tangent), np.zeros(len(m.task)),
            np.ravel(r0.xdd)[:3], missing if self.bumpless else 0 * missing,
        )  # fmt: skip

    def step(self, state: State, r, y, theta):
        p, m = self.at(theta), self.machine
        z, observer = self._coordinates(p, state, r, y.q)
        qd = (y.q - state.joints) / p.period
        if self.speed == "three_samples":
            qd = (3 * y.q - 4 * state.joints + state.before) / (2 * p.period)
        J = m.jacobian_of(p.machine, z)
        v = solve_square(J, qd)
        frame = carried(state.frame, r.tangent)
        E = self.errors(p, r, *m.tool_pose_of(p.machine, z), m.task_rate_of(p.machine, z, v), frame, state.change)
        u = self.command(p, z, v, J, E, state)
        held = saturated(m, p.machine, y.u)
        go_on = 1 if held is None else 1 - ca.mmax(held)
        integral = state.integral + go_on * p.period * E.value
        after = State(observer, y.q, state.joints, frame, integral, ca.SX(r.xdd)[:3], state.started)
        return Command(u), after

    def command(self, p, z, v, J, E: Errors, state: State):
        """u of eq. (9).  (n,)."""
        return self.force(p, z, v, J, E, self.asked(p, E, state.integral), state.started)

    def force(self, p, z, v, J, E: Errors, wanted, started):
        """u with E'' as wanted, by inverse dynamics.  (n,)."""
        m = self.machine
        pi = {key: value for key, (value, _) in m.inertial(p.machine).items()}
        vd = m.acceleration_of(p.machine, z, v, self.acceleration(E, wanted))
        return solve_square_transposed(J, m.inverse_force(p.machine, pi, z, v, vd) + started)

    def _coordinates(self, p, state, r, q):
        m = self.machine
        if self.coordinates == "newton":
            z, _, observer = forward.estimate(m, p.machine, state.observer, q, p.period)
            return z, observer
        z_r, _, observer = forward.estimate(m, p.machine, state.observer, r.q, p.period)
        return m.stepped(z_r, m.newton_step(p.machine, z_r, q)), observer

    def error_dynamics(self, r0) -> ca.Function:
        """(theta, z, v, reference, frame, x_r'' before) -> W and G of eq. (7), and E, E'.  `r0` any row."""
        m, theta, r = self.machine, ca.SX.sym("theta", len(self.theta)), symbols(r0)
        p = self.at(theta)
        z, v, u = ca.SX.sym("z", m.coordinate_count), ca.SX.sym("v", len(m.velocities)), ca.SX.sym("u", m.joints_count)
        turning, change = symbols(frame_at(np.zeros(3))), ca.SX.sym("change", 3)
        E = self.errors(p, r, *m.tool_pose_of(p.machine, z), m.task_rate_of(p.machine, z, v), turning, change)
        pi = {key: value for key, (value, _) in m.inertial(p.machine).items()}
        M, h = m.mass_and_bias(p.machine, pi, z, v)
        J = m.jacobian_of(p.machine, z)
        xdd = m.task_acceleration_of(p.machine, z, v, solve_spd(M, J.T @ u - h))
        Edd = E.gradient @ xdd + E.drift
        W, G = ca.substitute([Edd], [u], [ca.SX.zeros(u.shape)])[0], ca.jacobian(Edd, u)
        columns = [theta, z, v, flatten(r), flatten(turning), change]
        return ca.Function("error_dynamics", columns, [W, G, E.value, E.rate])


def frame_of(flat) -> Frame:
    """The frame of 9 numbers."""
    return unflatten(frame_at(np.zeros(3)), flat)
