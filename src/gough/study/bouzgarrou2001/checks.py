"""What the paper says without a simulation: its C_S as printed and repaired, and what its gains are."""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca
import numpy as np

from ...kernel.building import BUILDING
from ...machine.workspace import random_poses
from ...mechanics import constrained
from ...simulate import tick
from ..study import Tick
from .setup import PRINTED, Gains, machine

POSES, SPEED = 300, 1.5  # random states of the workspace, slides at so many m/s (standard deviation)


class Elimination(NamedTuple):
    """C_S s' against the machine's own centrifugal and Coriolis forces, N, over POSES states."""

    repaired: float  # largest difference
    printed: float
    largest: float  # of the forces


def elimination(tick_: Tick | None) -> Elimination:
    """Eq. (6) of the paper by its blocks, M and C of the six coordinates by Christoffel's symbols."""
    m, rng = machine(), np.random.default_rng(21)
    with BUILDING:
        f = _blocks(m)
    worst = np.zeros(3)
    for z in m.coordinates(random_poses(m, POSES, rng)):
        own, repaired, printed = (np.array(part).ravel() for part in f(m.theta, z, rng.normal(size=3) * SPEED))
        worst = np.maximum(worst, [np.abs(a).max() for a in (repaired - own, printed - own, own)])
    return Elimination(*(float(value) for value in worst))


def _blocks(m) -> ca.Function:
    """(theta, z, s') -> the machine's own h(s') - h(0), and C_S s' repaired and printed."""
    p, theta, z, v, _ = tick.symbols_of(m)
    pi = {key: value for key, (value, _) in m.inertial(p).items()}
    rest = ca.SX(3, 1)
    own = m.inverse_force(p, pi, z, v, rest) - m.inverse_force(p, pi, z, rest, rest)
    M, _, phi_x, _ = m.whole_dynamics(p, pi, z, rest)
    c = constrained.closure(m.closure_of(p, z), z, 3)
    A = -constrained.dependent(c)  # Phi_phi^-1 Phi_s
    zd = ca.vertcat(v, -A @ v)
    C = _christoffel(M, z, zd)
    D = ca.reshape(ca.jtimes(ca.vec(phi_x), z, zd), 3, 6)
    rate = D[:, :3] - D[:, 3:] @ A
    inverse = ca.inv(c.phi_b)
    out = []
    for factor in (inverse, ca.SX.eye(3)):
        inner = M[3:, 3:] @ factor @ rate - C[3:, :3] + C[3:, 3:] @ A
        out.append((C[:3, :3] - M[:3, 3:] @ inverse @ rate - C[:3, 3:] @ A + A.T @ inner) @ v)
    return ca.Function("blocks", [theta, z, v], [own, *out])


def _christoffel(M, z, zd):
    """C (n, n) of a mass matrix M(z) at rates zd: C_kj = sum over i of (M_kj,i + M_ki,j - M_ij,k) zd_i / 2."""
    n = M.shape[0]
    slope = [[ca.jacobian(M[k, j], z) for j in range(n)] for k in range(n)]
    C = ca.SX(n, n)
    for k in range(n):
        for j in range(n):
            C[k, j] = sum((slope[k][j][i] + slope[k][i][j] - slope[i][j][k]) * zd[i] / 2 for i in range(n))
    return C


def damping(gains: Gains = PRINTED) -> float:
    """The least damping ratio of the poles of three gains: 1 where none swings."""
    return float((-gains.roots.real / np.abs(gains.roots)).min())


def cascade_share(gains: Gains = PRINTED) -> float:
    """k_p^2 / (4 k_d k_i): a cascade of P and PI has the poles of three gains where it is at least 1."""
    return gains.k_p**2 / (4 * gains.k_d * gains.k_i)
