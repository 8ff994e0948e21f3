"""How much a machine with elastic joints gives way at its tool, as polynomials of the place: quick, smooth, exportable.

Bent by gravity and by its own motion the tool is not where the joints, were nothing elastic, would put it.  With x the
place of the tool and x + d the place that the joints stand for,

    d = s(x) + B(x) x'' + sum of c_jk(x) x'_j x'_k,   j <= k                                                        (1)

s by the exact statics (machine/equilibrium.py); B and c of first order about them: with A = [K J'; J 0] of
machine/vibration.py, (1), at that rest, and f = M v' + h(v) - h(0) the forces of a motion in which no spring moves
(mean of there and back: dampers are left out),

    displacement of the tool = -W' [1 0] A^-1 [f; 0]                                                                (2)

Each entry of s, B, c is a sum of products of Chebyshev polynomials of the coordinates of x, of total degree `degree`,
over the box of the declared workspace (5 % wider than the rests that it is fitted to),

    s_i(x) = sum of S_im T_a(y_1) T_b(y_2) ...,   y = (x - center) / half,   a + b + ... <= degree                  (3)

fitted to rests at random places of it.  docs/theory/flexible_control.md, section 2.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import product
from typing import Any

import casadi as ca
import numpy as np

from ..declare import Array, Part, Shape, quantity
from ..errors import ExperimentError
from ..kernel.building import BUILDING
from ..machine.equilibrium import pose_of
from ..machine.vibration import small_motions
from ..machine.workspace import random_poses

POINTS = 3  # rests a coefficient; the fit hardly gains by more
LEAST = 1e-9  # m, half a side of a box that has none
EDGE = 1.05  # sides of the box over the spread of the rests: random places do not reach the edges


class ElasticMap(Part):
    """Eqs. (1), (3) of one machine whose task is the place of its tool; made by `fitted`."""

    degree: int
    center: Array = quantity("m", "middle of the box", shape=(-1,))
    half: Array = quantity("m", "half its sides", shape=(-1,))
    sag: Array = quantity("m", "S of eq. (3), a row each coordinate", shape=(-1, -1))
    motion: Array | None = quantity(
        "1", "the same of B (s2), then c_jk (s2/m) in the order 11 12 13 22 ..., by rows, SI", default=None,
        shape=(-1, -1),
    )  # fmt: skip

    def sag_of(self, p, x):
        """s (d,) m of eq. (1), of the view p at the place x (d,), symbolic."""
        return p.sag @ self._basis(p, x)

    def motion_of(self, p, x, xd, xdd):
        """What eq. (1) adds to s in motion.  (d,) m, symbolic."""
        d = x.shape[0]
        found = ca.reshape(p.motion @ self._basis(p, x), -1, d).T  # row i: B_i1 ... c_i11 ...
        return found @ ca.vertcat(xdd, *[xd[j] * xd[k] for j, k in pairs(d)])

    def _basis(self, p, x):
        y = (x - p.center) / p.half
        return ca.vertcat(*products([y[i] for i in range(y.numel())], self.degree))

    def basis(self, x: np.ndarray) -> np.ndarray:
        """The products of eq. (3) at places x (N, d).  (N, m)."""
        y = (x - self.center) / self.half
        found = products(list(y.T), self.degree)
        return np.stack([np.broadcast_to(one, (len(x),)) for one in found], -1)

    def sag_at(self, x) -> np.ndarray:
        """s of eq. (1) at places x (N, d).  (N, d) m."""
        return self.basis(np.atleast_2d(x)) @ self.sag.T

    def inside(self, x) -> np.ndarray:
        """Which of the places x (N, d) are in the box.  (N,)."""
        return (np.abs(np.atleast_2d(x) - self.center) <= self.half * (1 + 1e-9)).all(-1)


def pairs(d: int) -> list[tuple[int, int]]:
    """(j, k), j <= k, in the order of the coefficients."""
    return [(j, k) for j in range(d) for k in range(j, d)]


def exponents(d: int, degree: int) -> list[tuple[int, ...]]:
    """Of the products of eq. (3)."""
    return [e for e in product(range(degree + 1), repeat=d) if sum(e) <= degree]


def products(y: list, degree: int) -> list[Any]:
    """T_a(y_1) T_b(y_2) ... of eq. (3), of symbols or of columns."""
    table = []
    for one in y:
        T = [1.0, one]
        for _ in range(degree - 1):
            T.append(2 * one * T[-1] - T[-2])
        table.append(T)
    out = []
    for e in exponents(len(y), degree):
        term = 1.0
        for T, k in zip(table, e, strict=True):
            term = term * T[k] if k else term
        out.append(term)
    return out


@lru_cache(maxsize=16)
def fitted(flexible, degree: int, moving: bool) -> ElasticMap:
    """The map of a flexible machine over its declared workspace; with `moving` the parts of a motion too.

    Raises
    ------
    ExperimentError
        no workspace is declared.
    KinematicsError, WorkspaceError
        a place of it that the machine cannot hold under gravity.
    """
    rigid = flexible.rigid
    if rigid.limits.workspace is None:
        raise ExperimentError(
            "needs to know where it may be asked", key="machine", value=f"{rigid.name} declares no workspace",
            cure="give limits.workspace",
        )  # fmt: skip
    d = len(rigid.task)
    count = POINTS * len(exponents(d, degree))
    asked = random_poses(rigid, count, np.random.default_rng(0))
    places, motion = np.zeros((count, d)), []
    for i, x in enumerate(asked):
        one = small_motions(flexible, x)
        places[i] = pose_of(flexible, one.z)[:d]
        if moving:
            motion.append(given_way(flexible, one, x).ravel())
    low, high = places.min(0), places.max(0)
    box = ElasticMap(
        degree=degree,
        center=(low + high) / 2,
        half=np.maximum(EDGE * (high - low) / 2, LEAST),
        sag=np.zeros((d, 1)),
    )
    basis = box.basis(places)
    return box.replace(sag=_solved(basis, asked - places), motion=_solved(basis, np.array(motion)) if moving else None)


def _solved(basis, values) -> np.ndarray:
    return np.linalg.lstsq(basis, values, rcond=None)[0].T.copy()


def given_way(flexible, one, x) -> np.ndarray:
    """B and c_jk of eq. (1) at the rest `one`, by eq. (2).  (d, d + d (d + 1) / 2) s2, s2/m."""
    d, m, n = len(x), len(one.M), len(one.J)
    unit, none = np.eye(d), np.zeros((d, d))
    both = np.array([unit[j] + unit[k] for j, k in pairs(d)])
    xd = np.concatenate([none, unit, both, none[:1]])
    xdd = np.concatenate([unit, none, np.zeros_like(both), none[:1]])
    forces = _forces(Shape(flexible)).map(2 * len(xd))
    x = np.broadcast_to(x, (2 * len(xd), d))
    v, vd = _unbent(flexible, x, np.concatenate([xd, -xd]), np.concatenate([xdd, xdd]))
    f = np.array(forces(flexible.theta, one.z, v.T, vd.T))
    f = (f[:, : len(xd)] + f[:, len(xd) :]) / 2  # without dampers that a bent loop moves
    f = f - f[:, -1:]
    size = np.abs(one.K).max()  # so that both sorts of rows count alike
    A = np.block([[one.K, size * one.J.T], [size * one.J, np.zeros((n, n))]])
    bent = np.linalg.solve(A, np.concatenate([f, np.zeros((n, f.shape[1]))]))[:m]
    gives = (one.W.T @ bent)[:d]
    squares = gives[:, d : 2 * d]
    mixed = []
    for i, (j, k) in enumerate(pairs(d)):  # f is quadratic in v: of e_j + e_k both squares and what is mixed
        whole = gives[:, 2 * d + i]
        mixed.append(squares[:, j] if j == k else whole - squares[:, j] - squares[:, k])
    return np.concatenate([gives[:, :d], np.stack(mixed, -1)], 1)


def _unbent(flexible, x, xd, xdd):
    """v and v' of motions of the flexible machine in which no spring moves.  (N, m) each."""
    _, qd, qdd = flexible.rigid.joint_motion(x, xd, xdd)
    rest = np.zeros((len(qd), len(flexible.velocities) - qd.shape[1]))
    return np.concatenate([qd, rest], 1), np.concatenate([qdd, rest], 1)


@lru_cache(maxsize=16)
def _forces(shape: Shape) -> ca.Function:
    """(theta, z, v, v') -> M v' + h on v."""
    m = shape.part
    with BUILDING:
        p, theta = m.symbols
        z = ca.SX.sym("z", m.coordinate_count)
        v, vd = (ca.SX.sym(name, len(m.velocities)) for name in ("v", "vd"))
        pi = {key: value for key, (value, _) in m.inertial(p).items()}
        return ca.Function("forces", [theta, z, v, vd], [m.inverse_force(p, pi, z, v, vd)])
