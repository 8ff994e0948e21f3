"""What the paper says without a simulation: the lemma, the rank of G, and what the linear estimate leaves."""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca
import numpy as np

from ...kernel.building import BUILDING
from ...machine.workspace import random_poses
from ...mechanics import constrained
from ...simulate import tick as plant
from ..study import Tick
from .setup import CIRCLE, law, machine, program

POSES = 500
RANK = 1e-9  # of the largest singular value; the fourth is rounding


class Lemma(NamedTuple):
    """Over POSES of the workspace, with random speeds."""

    residual: float  # largest |G_1 phi_x'| over |G_1|
    ranks: tuple[int, int]  # least and greatest rank of G_1
    condition: float  # greatest condition number of G
    same: float  # largest |G u + f - a''| over |a''|, a'' by the machine's own equations
    operations: int  # of W and G, eq. (7) of control/equivalent_error.py


def lemma(tick: Tick | None) -> Lemma:
    """N(G_1) = Col(phi_x') and the rank of G, eqs. (13)-(16) of the paper; f and G against the machine's equations."""
    m, rng = machine(), np.random.default_rng(0)
    with BUILDING:
        function, operations = _functions(m)
    residual, ranks, conditions, same = [], [], [], []
    for x in random_poses(m, POSES, rng):
        u, speed = rng.normal(size=3) * 500, rng.normal(size=3) * 0.3
        phi_x_, f_, G_1_, M_, h_ = (np.array(part) for part in function(m.theta, m.coordinates(x), speed))
        residual.append(np.abs(G_1_ @ phi_x_.T).max() / np.abs(G_1_).max())
        s = np.linalg.svd(G_1_, compute_uv=False)
        ranks.append(int((s > RANK * s[0]).sum()))
        conditions.append(np.linalg.cond(G_1_[:, :3]))
        wanted = np.linalg.solve(M_, u - h_.ravel())
        same.append(np.abs(f_[:3, 0] + G_1_[:3, :3] @ u - wanted).max() / np.abs(wanted).max())
    return Lemma(max(residual), (min(ranks), max(ranks)), max(conditions), max(same), operations)


def _functions(m) -> tuple[ca.Function, int]:
    """(theta, z, v) -> phi_x, f, G_1, M, h; and how many operations W and G have."""
    p, theta, z, v, _ = plant.symbols_of(m)
    pi = {key: value for key, (value, _) in m.inertial(p).items()}
    M, q, phi_x, g = m.whole_dynamics(p, pi, z, v)
    f, G_1, _ = constrained.eliminated(M, q, phi_x, g)
    function = ca.Function("whole", [theta, z, v], [phi_x, f, G_1, *m.mass_and_bias(p, pi, z, v)])
    control = law(CIRCLE).on(m, 1e-3)
    row = program(CIRCLE).sample(1e-3, m)
    return function, control.error_dynamics(type(row)(*(column[0] for column in row))).n_instructions()


def order() -> float:
    """By how much the error of eq. (20) falls when the tool is half as far from the reference: 1 mm and 0.5 mm."""
    m, rng = machine(), np.random.default_rng(1)
    x_r, way = random_poses(m, 100, rng), rng.normal(size=(100, 3))
    way *= 1e-3 / np.linalg.norm(way, axis=1)[:, None]
    return linear_estimate(x_r + way, x_r) / linear_estimate(x_r + way / 2, x_r)


def linear_estimate(x, x_r) -> float:
    """The largest error of b by eq. (20) of the paper at tool tips x beside the reference x_r, (n, 3) m.  rad."""
    m = machine()
    with BUILDING:
        p, theta = m.symbols
        z, q = ca.SX.sym("z", m.coordinate_count), ca.SX.sym("q", 3)
        step = ca.Function("step", [theta, z, q], [m.stepped(z, m.newton_step(p, z, q))])
    exact, reference = m.coordinates(x), m.coordinates(x_r)
    found = np.array(step.map(len(x))(m.theta, reference.T, exact[:, :3].T)).T
    return float(np.abs(found[:, 3:] - exact[:, 3:]).max())
