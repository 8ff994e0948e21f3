"""The algorithm of section 3.3 of the paper: joints that put the tool of the machine, bent by gravity, on its target.

    repeat   b with Phi(a, b) = 0                           b = (phi, 3 of delta), a = (s, d), d the 9 of delta     (1)
             l  = Phi_b^-T (-g_b - K_b b)
             d <- K_d^-1 (-g_d - Phi_d' l)
             e  = J_r^-1(s) (x_d - G_f),   s <- s + e       until |e| < e_c

as printed, but for "evaluate phi": the flexible loop closes in space, six equations, and three of delta (the paper's
alpha) follow with phi.  With B = db / dd of the closure one turn multiplies an error of d by

    -K_d^-1 B' K_b B                                                                                                (2)

which is not small: alpha carries its share of the load, and where two slides are alike an eigenvalue is near -1 or
beyond.  So (1) does not converge on this machine.  Repaired, the stiffness that follows with d is counted:

    d <- d - (K_d + B' K_b B)^-1 (g_d + K_d d + B' (g_b + K_b b))                                                   (3)

Then a turn leaves of an error what the sag changes by over it, |d sag / d x|, and as little by gravity's own stiffness
(docs/theory/flexible_control.md, section 3).
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import casadi as ca
import numpy as np

from ...declare import Shape
from ...errors import KinematicsError
from ...kernel.building import BUILDING
from ...machine.hybrid_flexible import FlexibleHybrid

N, A = 12, slice(3, 12)  # a, and d in it
MOST = 50  # turns
CLOSE = 3  # Newton steps of the closure


class Found(NamedTuple):
    """Joints, and how the algorithm came there."""

    s: np.ndarray  # (3,) m
    steps: np.ndarray  # |e| of each turn, m


def algorithm(machine: FlexibleHybrid, x, small: float = 1e-13, printed: bool = False) -> Found:
    """Joints s_d (3,) m for the tool at x (3,), by (1) with (3) until |e| < `small` m; `printed`: with (1) alone.

    Raises
    ------
    KinematicsError
        no convergence, with the residual.
    """
    x = np.asarray(x, float)
    z, steps = machine.coordinates(x), []
    turn, theta = _functions(Shape(machine))[0], machine.theta
    J = machine.rigid.jacobian(x)  # at the target: s is off it by a sag
    while len(steps) < MOST:
        b, alone, repaired, tip = (np.array(part).ravel() for part in turn(theta, z))
        z[N:], z[A] = b, alone if printed else repaired
        e = J @ (x - tip)
        z[:3] += e
        steps.append(float(np.linalg.norm(e)))
        # d lags a turn behind: the first e is that of the unbent machine, 0
        if len(steps) > 2 and steps[-1] < small:
            return Found(z[:3].copy(), np.array(steps))
        if not steps[-1] < 1:
            break
    raise KinematicsError(
        "no convergence of the static compensation", where="section 3.3", value=f"{steps[-1]:.3g} m left",
        limit=f"{small:g} m", cure="repair the algorithm" if printed else "make the machine stiffer",
    )  # fmt: skip


@lru_cache(maxsize=8)
def _functions(shape: Shape) -> tuple[ca.Function, ca.Function]:
    """(theta, z) -> b, d by (1), d by (3), the tool's place before; (theta, z) -> the matrix of (2)."""
    m = shape.part
    with BUILDING:
        p, theta = m.symbols
        z_ = ca.SX.sym("z", m.coordinate_count)
        z = z_
        for _ in range(CLOSE):
            z = m.normalised(p, z)
        pi = {key: value for key, (value, _) in m.inertial(p).items()}
        rest = ca.SX.zeros(N)
        g, _ = m.whole_force(p, pi, z, rest, rest)
        c = m.closed(p, z)
        K = ca.hessian(m.elastic_energy(p, z_), z_)[0]
        K_d, K_b, d = K[A, A], K[N:, N:], z[A]
        stress = g[N:] + K_b @ z[N:]
        B = -ca.solve(c.phi_b, ca.densify(c.phi_a[:, A]))
        alone = ca.solve(K_d, -g[A] - B.T @ stress)  # -Phi_d' l = -B' (g_b + K_b b)
        follows = B.T @ K_b @ B
        repaired = d - ca.solve(K_d + follows, g[A] + K_d @ d + B.T @ stress)
        turn = ca.Function("turn", [theta, z_], [z[N:], alone, repaired, m.task_of(p, z)])
        return turn, ca.Function("gain", [theta, z_], [-ca.solve(K_d, follows)])


def printed_gain(machine: FlexibleHybrid, x) -> float:
    """Largest |eigenvalue| of (2) with the tool at x (3,): by what one turn of the printed algorithm multiplies."""
    found = np.array(_functions(Shape(machine))[1](machine.theta, machine.coordinates(x)))
    return float(np.abs(np.linalg.eigvals(found)).max())


def contraction(machine: FlexibleHybrid, x, step: float = 1e-3) -> float:
    """|d sag / d x| at x (3,), by central differences of the exact statics: what a turn leaves of an error."""
    columns = []
    for direction in np.eye(3):
        ahead, behind = (machine.settled_pose(x + sign * step * direction)[:3] for sign in (1, -1))
        columns.append((ahead - behind) / (2 * step) - direction)
    return float(np.linalg.norm(np.array(columns), 2))
