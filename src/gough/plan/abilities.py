"""What a machine can do at a pose: dexterity, feed, acceleration, force; closed forms, as row functions.

With J of q' = J x', rotations in rad times the length L of the platform, and its singular values s:

    dexterity     max s / min s                                                                                     (2)

At rest at a pose the drives hold u_0; a motion x', x'' and a wrench f on the tool ask for

    q' = J x',   q''_i = J_i x'' + x'' H_i x',   u = u_0 + G x'' + C(x', x') - K f                                  (3)

(x'H_i x' and C_i(x', x') quadratic in x').  Friction is left out.  Of all tips that move by r in ANY direction, along a
straight line, the tool's direction kept, no joint exceeds its speed S, its acceleration A or its force F up to

    feed           r = min over i of  S / |J_i|,  sqrt(A / max |eig H_i|),
                       sqrt((F - u_0i) / max eig C_i),  sqrt((F + u_0i) / -min eig C_i)                              (4)
    acceleration   r = min over i of  A / |J_i|,  (F - |u_0i|) / |G_i|                    from rest                  (5)
    force          r = min over i of  (F - |u_0i|) / |K_i|                                at rest                    (6)

because the greatest of a . d over all unit d is |a|, and of d'H d an eigenvalue: each is attained, so (4)-(6) are the
largest r there are, not bounds of them.  A platform that turns has (4) and (5) for turns about the tip as well, the tip
at rest.  docs/theory/maps.md.
"""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np

from ..declare import Shape
from ..kernel.building import BUILDING
from ..kernel.rows import Rows, compile_rows
from ..machine.drives import force_limit
from ..machine.workspace import workspace_of
from ..mechanics.linear import solve_square_transposed
from ..mechanics.singular_values import extremes, singular_values


def platform_length(machine) -> float:
    """L of eq. (2), m: the rms distance of the platform's joints from their middle; 1 where no tool turns freely.

    It is the length of limits.condition.  Another length gives another number (Merlet, Jacobian, manipulability,
    condition number, and accuracy of parallel robots, J. Mech. Design 128, 2006): compare machines by the same one.
    """
    if len(machine.task) < 6:
        return 1.0
    B = machine.joints.platform
    return float(np.sqrt(((B - B.mean(0)) ** 2).sum(-1).mean()))


def rows_of(name: str, machine) -> Rows:
    """The row function `name` of a machine: "bounds", "dexterity", "feed", "acceleration" or "force"; see `_WRITTEN`.

    It takes theta, poses (N, d), L of eq. (2) and a wrench (6,) on the tool.
    """
    return _compiled(name, Shape(machine))


@lru_cache(maxsize=256)
def _compiled(name: str, shape: Shape) -> Rows:
    with BUILDING:
        m = shape.part
        p, theta = m.symbols
        x, L, w = ca.SX.sym("x", len(m.task)), ca.SX.sym("L"), ca.SX.sym("w", 6)
        out = _WRITTEN[name](m, p, x, L, w)
        return compile_rows(ca.Function(name, [theta, x, L, w], [ca.densify(y) for y in out]))


class Evaluated:
    """A row function of one machine, called with poses (N, d) and a wrench."""

    def __init__(self, name: str, machine, wrench=None):
        self._rows, self._theta = rows_of(name, machine), machine.theta
        self._length = np.array([platform_length(machine)])
        self._wrench = np.zeros(6) if wrench is None else wrench

    def __call__(self, x) -> list[np.ndarray]:
        """The outputs, (N, k) each."""
        short = -len(x) % self._rows.lanes  # what does not fill the lanes would be a call of its own
        full = np.concatenate([x, np.broadcast_to(x[-1:], (short, x.shape[1]))]) if short else x
        return [y[: len(x)] for y in self._rows(self._theta, full, self._length, self._wrench)]


def singular_values_of(m, p, z, L):
    """Singular values of the homogenised J, eq. (2).  (d,)."""
    J = m.task_jacobian_of(p, z)
    if len(m.task) == 6:
        J = ca.horzcat(J[:, :3], J[:, 3:] / L)
    return singular_values(J)


def _bounds(m, p, x, L, w):
    """`machine.margins` and, of more than one coordinate, min s / max s of eq. (2) against its limit; those of the
    declared workspace; the drives' forces at rest under a wrench w (n,)."""
    z = m.coordinates_of(p, x)
    limits = [m.margins(p, z)[1]]
    if len(m.task) > 1:
        s = singular_values_of(m, p, z, L)
        limits.append(ca.mmin(s) / ca.mmax(s) - 1 / p.limits.condition)
    _, J, h = held(m, p, z)
    return [ca.vertcat(*limits), workspace_of(m, p, z), solve_square_transposed(J, h - m.wrench_of(p, z, w))]


def _dexterity(m, p, x, L, w):
    """Least and greatest singular value."""
    s = singular_values_of(m, p, m.coordinates_of(p, x), L)
    return [ca.vertcat(ca.mmin(s), ca.mmax(s))]


def _blocks(m) -> list[range]:
    """The coordinates that are one sort: places, and where a tool turns freely turns."""
    d = len(m.task)
    return [range(d)] if d < 6 else [range(3), range(3, 6)]


def held(m, p, z):
    """J on the velocities v, and h: what J' u must balance at rest."""
    pi = {key: value for key, (value, _) in m.inertial(p).items()}
    return pi, m.jacobian_of(p, z), m.inverse_force(p, pi, z, *[ca.SX(len(m.velocities), 1)] * 2)


def _feed(m, p, x, L, w):
    """By sort and joint of eq. (4): the feed by speed 1, by acceleration 1, and what forces need: u_0, eig C."""
    z, d = m.coordinates_of(p, x), len(m.task)
    pi, J, h = held(m, p, z)
    rows, needed = m.task_jacobian_of(p, z), [h]
    out = []

    def motion(xd):
        v = m.velocity_of(p, z, xd)
        vd = m.acceleration_of(p, z, v, ca.SX(d, 1))
        return m.joint_acceleration(p, z, v, vd), m.inverse_force(p, pi, z, v, vd) - h

    bent = []  # of each sort: {(j, k): q'' and force of the pair's motion}
    for block in _blocks(m):
        pairs = {}
        for j in block:
            for k in block:
                if j <= k:
                    xd = ca.SX(d, 1)
                    xd[j] += 1
                    xd[k] += float(j != k)
                    pairs[j, k] = motion(ca.densify(xd))
        bent.append(pairs)
    needed += [pair[1] for pairs in bent for pair in pairs.values()]
    u = solve_square_transposed(J, ca.horzcat(*needed))
    column = 1
    for block, pairs in zip(_blocks(m), bent, strict=True):
        columns = {}
        for pair in pairs:
            columns[pair], column = u[:, column], column + 1
        for i in range(m.joints_count):
            H = _quadratic(block, {pair: found[0][i] for pair, found in pairs.items()})
            C = _quadratic(block, {pair: found[i] for pair, found in columns.items()})
            low, high = _ends(H)
            out.append(ca.vertcat(ca.norm_2(rows[i, list(block)].T), ca.fmax(high, -low), u[i, 0], *_ends(C)))
    return [ca.vertcat(*out)]


def _quadratic(block, values):
    """The symmetric matrix of a quadratic form by its values at e_j and e_j + e_k."""
    first, k = block[0], len(block)
    Q = ca.SX(k, k)
    for (a, b), value in values.items():
        if a == b:
            Q[a - first, a - first] = value
        else:
            half = (value - values[a, a] - values[b, b]) / 2
            Q[a - first, b - first] = Q[b - first, a - first] = half
    return Q


def _ends(Q):
    """Least and greatest eigenvalue."""
    return (Q[0, 0], Q[0, 0]) if Q.shape[0] == 1 else extremes(Q)


def _acceleration(m, p, x, L, w):
    """By sort and joint of eq. (5): |J_i|, u_0 and |G_i|."""
    z, d = m.coordinates_of(p, x), len(m.task)
    pi, J, h = held(m, p, z)
    M, _ = m.mass_and_bias(p, pi, z, ca.SX(len(m.velocities), 1))
    xd = ca.SX.sym("xd", d)
    T = ca.jacobian(m.velocity_of(p, z, xd), xd)  # v by the task rate
    u = solve_square_transposed(J, ca.horzcat(h, M @ T))
    rows, out = m.task_jacobian_of(p, z), []
    for block in _blocks(m):
        for i in range(m.joints_count):
            G = u[i, [1 + j for j in block]]
            out.append(ca.vertcat(ca.norm_2(rows[i, list(block)].T), u[i, 0], ca.norm_2(G.T)))
    return [ca.vertcat(*out)]


def _force(m, p, x, L, w):
    """By joint of eq. (6): u_0 and |K_i|."""
    z = m.coordinates_of(p, x)
    _, J, h = held(m, p, z)
    pushed = ca.jacobian(m.wrench_of(p, z, w), w)[:, :3]
    u = solve_square_transposed(J, ca.horzcat(h, pushed))
    return [ca.vertcat(*[ca.vertcat(u[i, 0], ca.norm_2(u[i, 1:].T)) for i in range(m.joints_count)])]


_WRITTEN = {
    "bounds": _bounds, "dexterity": _dexterity, "feed": _feed, "acceleration": _acceleration, "force": _force,
}  # fmt: skip


# -- numbers ---------------------------------------------------------------------------------------------------------


def feeds(machine, x) -> tuple[np.ndarray, np.ndarray]:
    """r of eq. (4) at poses x (N, d): by sort, by what limits (speed, acceleration, force), by joint.

    (N, sorts, 3, n) m/s or rad/s, inf where a machine has no such limit; u_0 (N, n) N.
    """
    found = Evaluated("feed", machine)(x)[0]
    n = machine.joints_count
    gain, bend, u, low, high = np.moveaxis(found.reshape(len(found), -1, n, 5), -1, 0)
    S, A, F = limits_of(machine)
    with np.errstate(divide="ignore", invalid="ignore"):
        by_force = np.minimum(_root(F - u, high), _root(F + u, -low))
        by_force = np.where(np.abs(u) > F, 0.0, by_force)
        r = np.stack([S / gain, _root(A, bend), by_force], 2)
    return np.where(np.isnan(found).any(-1)[:, None, None, None], np.nan, r), u[:, 0]


def _root(room, rate):
    """sqrt(room / rate); inf where the rate is not above 0."""
    return np.sqrt(np.maximum(room, 0) / np.where(rate > 0, rate, 0.0))


def accelerations(machine, x) -> np.ndarray:
    """r of eq. (5) at poses x (N, d), as `feeds`, by what limits (acceleration, force): (N, sorts, 2, n)."""
    found = Evaluated("acceleration", machine)(x)[0]
    gain, u, G = np.moveaxis(found.reshape(len(found), -1, machine.joints_count, 3), -1, 0)
    _, A, F = limits_of(machine)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.stack([A / gain, np.maximum(F - np.abs(u), 0) / G], 2)


def forces(machine, x) -> tuple[np.ndarray, np.ndarray]:
    """u_0 (N, n) N and r of eq. (6) by joint (N, n) N at poses x (N, d)."""
    found = Evaluated("force", machine)(x)[0]
    u, K = np.moveaxis(found.reshape(len(found), machine.joints_count, 2), -1, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return u, np.maximum(limits_of(machine)[2] - np.abs(u), 0) / K


def limits_of(machine) -> tuple[float, float, float]:
    """Greatest speed, acceleration and force of a joint: m/s, m/s2, N; inf where the sheet says none."""
    force = force_limit(machine.drive)
    found = (machine.limits.speed, machine.limits.acceleration, force)
    return tuple(np.inf if one is None else float(one) for one in found)
