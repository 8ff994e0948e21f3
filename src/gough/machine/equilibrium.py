"""Rest: where a machine with elastic joints stands under gravity and a wrench on its tool, and what holds it there.

Unknown are the displacement d of the velocities' coordinates and the joint forces u:

    F(z) = J' u + w - h(z, 0) = 0,     q_m(z) = q_r                                                                 (8)
    [F_z S  J'; q_m,z S  0] [d; u+ - u] = -[F; q_m - q_r],     z+ = normalised(z + S d),   z' = S v                 (9)

Newton's method from the unbent machine; q_m is what the encoders read.  A step that does not lower what is left is
halved.  With the tool's place in the place of the readings,

    F(z) = 0,     x(z) = x_d;     the targets of the joints are q_m(z)                                              (10)

is the static compensation of gravity.  The answer is stable where the stiffness with the joints held is positive
definite; an arm that its load turns over is refused.  docs/theory/compliance.md, section 3.
"""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np

from .. import frames
from ..declare import Shape
from ..errors import ExperimentError, KinematicsError, RunError
from ..kernel.building import BUILDING
from .arrays import column
from .workspace import beyond

STEPS = 40
_CURE = "check stiffness, masses and the wrench; a softer machine than this is no machine tool"


def at_rest(machine, x, wrench=None, check: bool = True) -> tuple[np.ndarray, np.ndarray]:
    """z and u (n,) N of eq. (8) with the joints where `machine.rigid` has the pose x (d,), `wrench` (6,) on the tool.

    Raises
    ------
    KinematicsError
        no convergence, with the residual; or no stable rest.
    WorkspaceError, SingularityError
        the machine sags beyond its limits.
    """
    x, w = _given(machine, x, wrench)
    q = machine.rigid.inverse_kinematics(x)
    u0 = machine.rigid.inverse_dynamics(x, *np.zeros((2, len(machine.task))), w)
    z, u = solved(machine, machine.coordinates(x), u0, q, w)
    if check:
        margins = np.array(_functions(Shape(machine))["margins"](machine.theta, z)).ravel()
        worst = int(np.argmin(np.where(np.isfinite(margins), margins, -np.inf)))
        if not margins[worst] >= 0:
            raise beyond(machine, worst, float(margins[worst]), "at rest under gravity and load")
    return z, u


def targets(machine, x, wrench=None) -> np.ndarray:
    """Readings q_m (n,) m of eq. (10): where the joints must be for the tool to be at x (d,), under `wrench` (6,).

    Raises
    ------
    KinematicsError
        as `at_rest`.
    WorkspaceError, SingularityError
        the target is unreachable under gravity: the joints would have to leave their limits.
    """
    x, w = _given(machine, x, wrench)
    u0 = machine.rigid.inverse_dynamics(x, *np.zeros((2, len(x))), w)
    z, _ = solved(machine, machine.coordinates(x), u0, x, w, "target")
    q = np.array(_functions(Shape(machine))["readings"](machine.theta, z)).ravel()
    try:
        at_rest(machine, machine.rigid.forward_kinematics(q, near=x), w)
    except RunError as error:
        told = error.problems[0]
        raise type(error)(
            f"target unreachable under gravity: {told.rule}", where=told.where, value=told.value, limit=told.limit,
            cure="move the work, or make the machine stiffer",
        ) from None  # fmt: skip
    return q


def solved(machine, z, u, q, w, system: str = "system") -> tuple[np.ndarray, np.ndarray]:
    """z and u of eq. (8) for the readings q (n,), from a guess of both; of eq. (10) with system="target", q the task's.

    Raises
    ------
    KinematicsError
        as `at_rest`.
    """
    known = _functions(Shape(machine))
    evaluate, move = known[system], known["move"]
    n, theta = len(q), machine.theta
    F, K, gap, J, J_m, scale = (np.array(one) for one in evaluate(theta, z, u, q, w))
    miss = _size(F, gap, scale)
    for _ in range(STEPS):
        A = np.block([[K, J.T], [J_m, np.zeros((n, n))]])
        try:
            step = np.linalg.solve(A, -np.concatenate([F, gap])[:, 0])
        except np.linalg.LinAlgError:
            break
        for halved in range(8):
            factor = 0.5**halved
            z_new = np.array(move(theta, z, factor * step[:-n])).ravel()
            u_new = u + factor * step[-n:]
            found = [np.array(one) for one in evaluate(theta, z_new, u_new, q, w)]
            miss_new = _size(found[0], found[2], found[5])
            if miss_new < miss or miss_new < 1e-13:
                break
        else:
            break
        small = np.abs(step[:-n]).max() < 1e-13 or miss_new >= miss
        z, u, miss = z_new, u_new, miss_new
        F, K, gap, J, J_m, scale = found
        if small:
            break
    # a place is known to its last digit, and a stiff spring makes a force of it
    rounding = 4e-16 * np.abs(K).max() * max(1.0, np.abs(z).max()) / scale[0, 0]
    if not miss < 1e-9 + rounding:
        raise KinematicsError(
            "no rest found under gravity and load: no convergence", where="elastic joints",
            value=f"{np.abs(F).max():.3g} N or N m and {np.abs(gap).max():.3g} m left", cure=_CURE,
        )  # fmt: skip
    N = _null(J)
    held = N.T @ -K @ N
    least = np.linalg.eigvalsh((held + held.T) / 2)[0]
    if not least > 0:
        raise KinematicsError(
            "no stable rest under gravity and load: the elastic joints give way without end", where="elastic joints",
            value=f"least stiffness {least:.3g} N/m or N m/rad with the joints held", cure=_CURE,
        )  # fmt: skip
    return z, u


def _given(machine, x, wrench) -> tuple[np.ndarray, np.ndarray]:
    """One pose and one wrench as finite numbers.

    Raises
    ------
    ExperimentError
        other shapes, or what is no number.
    """
    x = column(x, len(machine.task), "pose")
    w = np.zeros(6) if wrench is None else column(wrench, 6, "wrench")
    for name, value in (("pose", x), ("wrench", w)):
        if value.ndim != 1:
            raise ExperimentError(f"rest is of one {name} at a time", key=name, value=f"shape {value.shape}")
    return x, w


def pose_of(machine, z) -> np.ndarray:
    """x y z a b c of T in W at coordinates z.  (6,)."""
    found = np.array(_functions(Shape(machine))["pose"](machine.theta, z)).ravel()
    return np.concatenate([found[:3], frames.abc_of_rotation_np(frames.rotation_of_quaternion_np(found[3:]))])


def _size(F, gap, scale) -> float:
    """The largest of what is left, forces by those there are, places in m."""
    left = max(float(np.abs(F).max() / scale[0, 0]), float(np.abs(gap).max()))
    return left if np.isfinite(left) else np.inf


def _null(J: np.ndarray) -> np.ndarray:
    """Columns: velocities that move no joint, J N = 0."""
    _, s, Vt = np.linalg.svd(J)
    return Vt[len(s) :].T


@lru_cache(maxsize=64)
def _functions(shape: Shape) -> dict[str, ca.Function]:
    """What Newton's method asks of a machine: all of (theta, z, ...)."""
    m = shape.part
    with BUILDING:
        p, theta = m.symbols
        z, v = ca.SX.sym("z", m.coordinate_count), ca.SX.sym("v", len(m.velocities))
        u, q, w = ca.SX.sym("u", m.joints_count), ca.SX.sym("q", m.joints_count), ca.SX.sym("w", 6)
        F, terms = static_force(m, p, z, u, w)
        S = ca.jacobian(m.rate(p, z, v), v)  # z' is linear in v
        gap = m.measured_of(p, z) - q
        scale = 1 + sum(ca.norm_1(term) for term in terms)
        J, J_m = m.jacobian_of(p, z), ca.jacobian(gap, z) @ S
        closed = m.normalised(p, z + S @ v)
        x = ca.SX.sym("x", len(m.task))
        asked = m.stiff.coordinates_of(p.stiff, x)
        away, L = _away(m, p, z, x, asked), ca.jacobian(m.task_rate_of(p, z, v), v)
        return {
            "target": ca.Function("target", [theta, z, u, x, w], [F, ca.jacobian(F, z) @ S, away, J, L, scale]),
            "readings": ca.Function("readings", [theta, z], [m.measured_of(p, z)]),
            "system": ca.Function("rest", [theta, z, u, q, w], [F, ca.jacobian(F, z) @ S, gap, J, J_m, scale]),
            "move": ca.Function("move", [theta, z, v], [m.normalised(p, closed)]),
            "margins": ca.Function("margins", [theta, z], [m.margins(p, z)[1]]),
            "pose": ca.Function("pose", [theta, z], [ca.vertcat(*m.tool_pose_of(p, z))]),
        }


def _away(m, p, z, x, asked):
    """Displacement of the tool from x: of its place, and of six coordinates the turn as a rotation vector.  (d,)."""
    if len(m.task) != 6:
        return m.task_of(p, z) - x
    position, quat = m.tool_pose_of(p, z)
    turn = frames.quaternion_product(quat, frames.conjugate(asked[3:]))
    return ca.vertcat(position - x[:3], frames.rotation_vector_of_quaternion(turn))


def static_force(m, p, z, u, w):
    """F of eq. (8), and the terms it is the sum of.  (len(v),), list."""
    pi = {key: value for key, (value, _) in m.inertial(p).items()}
    rest = ca.SX.zeros(len(m.velocities))
    _, h = m.mass_and_bias(p, pi, z, rest)
    terms = [m.jacobian_of(p, z).T @ u, m.wrench_of(p, z, w), -h]
    return sum(terms), terms
