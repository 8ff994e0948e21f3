"""Machines of bodies in closed loops: coordinates z = (a, b) with a closure phi(z) = 0, velocities v = a'.

The actuated joints are a.  A kind states its closure, its bodies and the motion of its tool, all as expressions linear
in z' where they are velocities; rate, projection, M, h, the multipliers and the way from the tool's task rate to v and
back follow here from mechanics/constrained.py.  The task is the place of the tool tip: as many coordinates as joints.
"""

from __future__ import annotations

from typing import Any, ClassVar, NamedTuple

import casadi as ca
import numpy as np

from .. import frames
from ..mechanics import constrained
from ..mechanics.linear import solve_square
from .base import Machine


class ToolMotion(NamedTuple):
    """T as it moves with coordinates z and rates z'."""

    position: Any  # (3,) m in W
    rotation: Any  # R_WT (3, 3)
    twist: Any  # [v; w] (6,) in W, linear in z'


class _Moved(NamedTuple):
    """All that is known of a mechanism at z and v."""

    zd: Any
    B: Any
    closure: constrained.Closure
    bodies: list  # (Moving, J on v (6, n), twist (6,), drift of the acceleration at v' = 0 (6,))
    tool: Any  # J on v (6, n)
    tool_drift: Any  # (6,)


class ConstrainedMachine(Machine):
    """A mechanism with dependent coordinates.  A kind states closure_of, bodies_of, tool_motion_of and joint_mass."""

    task: ClassVar = (("x", "m"), ("y", "m"), ("z", "m"))
    pose_is_state: ClassVar = False

    # -- what a kind states ---------------------------------------------------------------------------------------
    #   dependent_names            names of b; coordinates a are the joints (and more: independent_count)
    #   closure_of(p, z)           phi (len(b),) m
    #   bodies_of(p, pi, z, zd)    list of constrained.Moving
    #   joint_mass(pi)             mass that turning parts add to every joint, kg
    #   tool_motion_of(p, z, zd)   ToolMotion

    @property
    def independent_count(self) -> int:
        """How many coordinates a there are: the joints, and behind them what gives way, where anything does."""
        return self.joints_count

    @property
    def coordinate_count(self) -> int:
        """How many coordinates, dependent ones included."""
        return self.independent_count + len(self.dependent_names)

    @property
    def program_zero(self) -> np.ndarray:
        """The place of home, with the axes of W."""
        return np.concatenate([self.home, np.zeros(3)])

    @staticmethod
    def task_motion(x, xd, xdd):
        return x[..., :3], xd[..., :3], xdd[..., :3]

    def standing(self, x) -> np.ndarray:
        """z of tool tips; NaN where the machine has none.  (..., 3) -> (..., len(z))."""
        return self.arrays.run("coordinates", np.asarray(x, float), checked=False)[0]

    def tool_pose(self, x) -> np.ndarray:
        """x y z a b c of T in W: the tilt follows from the place.  (..., 3) -> (..., 6)."""
        x = super().tool_pose(x)
        return self.arrays.run("tool_pose", x)[0]

    # -- coordinates ----------------------------------------------------------------------------------------------

    def joints_of(self, p, z):
        """a, of z.  (n,)."""
        return z[: self.joints_count]

    def jacobian_of(self, p, z):
        """q' = v, the first of them where more are independent.  (joints, n)."""
        n = self.joints_count
        return ca.horzcat(ca.SX.eye(n), ca.SX(n, self.independent_count - n))

    def joint_acceleration(self, p, z, v, vd):
        """q'' = v'.  (n,)."""
        return vd

    def _symbols(self):
        n = self.coordinate_count
        return ca.SX.sym("z", n), ca.SX.sym("zd", n)

    def closed(self, p, z, zd=None) -> constrained.Closure:
        """phi and its derivatives at coordinates z, and at rates zd."""
        z_, zd_ = self._symbols()
        found = constrained.closure(self.closure_of(p, z_), z_, self.independent_count, None if zd is None else zd_)
        symbols, values = ([z_], [_dense(z)]) if zd is None else ([z_, zd_], [_dense(z), _dense(zd)])
        known = [piece for piece in found if piece is not None]
        return constrained.Closure(*ca.substitute(known, symbols, values), *[None] * (4 - len(known)))

    def rate(self, p, z, v):
        """z' = (v, B v)."""
        return ca.vertcat(v, constrained.dependent(self.closed(p, z)) @ v)

    def normalised(self, p, z):
        """z with b one Newton step nearer to phi = 0: from RK4's error of a sub-step, on it to rounding."""
        n = self.independent_count
        return ca.vertcat(z[:n], constrained.projected(self.closed(p, z), z[n:]))

    @staticmethod
    def stepped(z, d):
        """z + d."""
        return z + d

    def between(self, z_before, z):
        """The mean v that leads from z_before to z in a second."""
        n = self.independent_count
        return z[:n] - z_before[:n]

    def newton_step(self, p, z, q):
        """d of a Newton step on a = q, phi(a, b) = 0."""
        n, c = self.independent_count, self.closed(p, z)
        da = q - z[:n]
        return ca.vertcat(da, -solve_square(c.phi_b, c.phi + c.phi_a @ da))

    def target(self, p, r, z):
        """Error q_r - q, q_r' and q_r''."""
        return r.q - z[: self.joints_count], r.qd, r.qdd

    # -- tool -----------------------------------------------------------------------------------------------------

    def tool_pose_of(self, p, z):
        """Position and quaternion of T in W.  (3,), (4,)."""
        tool = self.tool_motion_of(p, z, ca.SX(self.coordinate_count, 1))
        return tool.position, frames.quaternion_of_rotation(tool.rotation)

    def task_of(self, p, z):
        """x y z of the tool tip.  (3,)."""
        return self.tool_motion_of(p, z, ca.SX(self.coordinate_count, 1)).position

    def home_rotation(self, p):
        """R_WT at home.  (3, 3)."""
        z = self.coordinates_of(p, p.home)
        return self.tool_motion_of(p, z, ca.SX(self.coordinate_count, 1)).rotation

    def tool_jacobian(self, p, z):
        """[v; w] of T by v.  (6, n)."""
        z_, zd_ = self._symbols()
        J = ca.jacobian(self.tool_motion_of(p, z_, zd_).twist, zd_)
        B = constrained.dependent(self.closed(p, z))
        J = ca.substitute([J], [z_], [_dense(z)])[0]
        n = self.independent_count
        return J[:, :n] + J[:, n:] @ B

    def task_velocities_of(self, p, z):
        """v by the task rate: the inverse of the tip's Jacobian.  (n, 3)."""
        return solve_square(self.tool_jacobian(p, z)[:3, :], ca.SX.eye(3))

    def task_jacobian_of(self, p, z):
        return self.task_velocities_of(p, z)

    def velocity_of(self, p, z, xd):
        return solve_square(self.tool_jacobian(p, z)[:3, :], xd)

    def acceleration_of(self, p, z, v, xdd):
        moved = self.moved(p, None, z, v)
        return solve_square(moved.tool[:3, :], xdd - moved.tool_drift[:3])

    def task_rate_of(self, p, z, v):
        return self.tool_jacobian(p, z)[:3, :] @ v

    def task_acceleration_of(self, p, z, v, vd):
        moved = self.moved(p, None, z, v)
        return moved.tool[:3, :] @ vd + moved.tool_drift[:3]

    def wrench_of(self, p, z, w):
        return self.tool_jacobian(p, z).T @ w

    # -- dynamics -------------------------------------------------------------------------------------------------

    def moved(self, p, pi, z, v) -> _Moved:
        """The mechanism at z and v; the bodies only where their numbers pi are given."""
        n = self.independent_count
        z_, zd_ = self._symbols()
        B = constrained.dependent(self.closed(p, z))
        zd = ca.vertcat(v, B @ v)
        c = self.closed(p, z, zd)
        tool = self.tool_motion_of(p, z_, zd_)
        bodies = [] if pi is None else self.bodies_of(p, pi, z_, zd_)
        twists = [body.twist for body in bodies] + [tool.twist]
        rates = [constrained.rates(constrained.Moving(0, 0, 0, twist), z_, zd_) for twist in twists]
        flat = [piece for rate in rates for piece in rate]
        flat += [piece for body in bodies for piece in (ca.SX(body.m), ca.SX(body.mc), ca.SX(body.I))]
        flat = ca.substitute(flat, [z_, zd_], [_dense(z), _dense(zd)])
        bd = constrained.dependent_acceleration(c, B, ca.SX(n, 1))  # b'' at v' = 0
        found = []
        for k in range(len(twists)):
            J, drift = flat[2 * k], flat[2 * k + 1]
            J_a = J[:, :n] + J[:, n:] @ B
            found.append((J_a, J_a @ v, drift + J[:, n:] @ bd, J))
        tool_J, _, tool_drift, _ = found.pop()
        numbers = flat[2 * len(twists) :]
        out = []
        for k, (J, twist, drift, whole) in enumerate(found):
            m, mc, I = numbers[3 * k : 3 * k + 3]
            out.append((constrained.Moving(m, mc, I, twist), J, drift, whole))
        return _Moved(zd, B, c, out, tool_J, tool_drift)

    def inverse_force(self, p, pi, z, v, vd):
        """M v' + h, eq. (4) of mechanics/constrained.py.  (n,) N."""
        total = self.joint_mass(pi) * vd
        for body, J, drift, _ in self.moved(p, pi, z, v).bodies:
            total += J.T @ constrained.needed(body, body.twist, J @ vd + drift, p.gravity)
        return total

    def mass_and_bias(self, p, pi, z, v):
        """M (n, n) and h (n,) of M v' + h."""
        n = self.independent_count
        M, h = self.joint_mass(pi) * ca.SX.eye(n), ca.SX(n, 1)
        for body, J, drift, _ in self.moved(p, pi, z, v).bodies:
            M += J.T @ constrained.spatial_inertia(body) @ J
            h += J.T @ constrained.needed(body, body.twist, drift, p.gravity)
        return M, h

    def whole_force(self, p, pi, z, v, vd):
        """F of eq. (3) of mechanics/constrained.py, on all coordinates, and the closure.  (n + m,), Closure."""
        moved = self.moved(p, pi, z, v)
        F = ca.vertcat(self.joint_mass(pi) * vd, ca.SX(len(self.dependent_names), 1))
        for body, J, drift, whole in moved.bodies:
            F += whole.T @ constrained.needed(body, body.twist, J @ vd + drift, p.gravity)
        return F, moved.closure

    def whole_dynamics(self, p, pi, z, v):
        """M (n + m, n + m), q, phi_x and g of M x'' + q + phi_x' l = tau on all coordinates, before any elimination.

        What Chen and Tsai 2008 start from; (4) is cheaper and the same.
        """
        n, count, moved = self.independent_count, self.coordinate_count, self.moved(p, pi, z, v)
        M, q = ca.diag(ca.vertcat(ca.repmat(ca.SX(self.joint_mass(pi)), n), ca.SX(count - n, 1))), ca.SX(count, 1)
        c = moved.closure
        bd = constrained.dependent_acceleration(c, moved.B, ca.SX(n, 1))
        for body, _, drift, whole in moved.bodies:
            M += whole.T @ constrained.spatial_inertia(body) @ whole
            q += whole.T @ constrained.needed(body, body.twist, drift - whole[:, n:] @ bd, p.gravity)
        return M, q, ca.horzcat(c.phi_a, c.phi_b), c.g

    def multipliers_of(self, p, z, v, vd, w):
        """l of eq. (5) of mechanics/constrained.py, N, under a wrench w on the tool.  (m,)."""
        n, (z_, zd_) = self.independent_count, self._symbols()
        pi = {key: value for key, (value, _) in self.inertial(p).items()}
        F, c = self.whole_force(p, pi, z, v, vd)
        J = ca.substitute([ca.jacobian(self.tool_motion_of(p, z_, zd_).twist, zd_)], [z_], [_dense(z)])[0]
        return constrained.multipliers(c, (J.T @ w - F)[n:])


def _dense(value):
    """As SX with every entry there: what substitute asks for."""
    return ca.densify(ca.SX(value))
