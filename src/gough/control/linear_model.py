"""Joint forces of a motion as Psi p, with p all parameters of `machine.parameters_of(friction=True)`.

    Psi p = J^-T (M V' + h) + f_c sgn q' + f_v q'                                                                 (2)
    M_q   = J^-T M J^-1                                                                                           (3)

for every machine whose equations of motion are linear in p; the place and the geometry are those of a reference.
sgn is smoothed, tanh(q' / v_0).  What a learning law wants to know besides: which parameters a name means, how large a
parameter is, and how strongly a motion shows it,

    E_j = mean over a motion of |M_q^-1 Psi_j s_j|^2,    s_j the size of p_j                                       (7)

Source: Honegger 1998, eqs. (7), (8), (19), (20); docs/theory/desired_torque.md.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from ..errors import ExperimentError, did_you_mean
from ..machine.workspace import random_poses
from ..mechanics.linear import solve_square, solve_square_transposed

POSES = 300  # that the mean of eq. (7) is taken over, where no motion is given; its own error is then some 10 %


def split(machine, p):
    """(pi of `machine.inverse_force`, f_c (n,), f_v (n,)) of all parameters p, a column."""
    n, names = machine.joints_count, list(machine.inertial(machine))
    k = len(names)
    return {name: p[i] for i, name in enumerate(names)}, p[k : k + n], p[k + n : k + 2 * n]


def friction(f_c, f_v, qd, smoothing):
    """The last two terms of eq. (2).  (n,) N."""
    return f_c * ca.tanh(qd / smoothing) + f_v * qd


def force_and_mass(machine, view, p, r, smoothing):
    """Psi p (n,) N and M_q (n, n) kg of eqs. (2), (3) on the reference r; `view` is that of `machine`."""
    pi, f_c, f_v = split(machine, p)
    z = machine.coordinates_of(view, r.x)
    v = machine.velocity_of(view, z, r.xd)
    J, (M, h) = machine.jacobian_of(view, z), machine.mass_and_bias(view, pi, z, v)
    columns = solve_square_transposed(J, ca.horzcat(M @ machine.acceleration_of(view, z, v, r.xdd) + h, M))
    M_q = solve_square_transposed(J, columns[:, 1:].T)
    return columns[:, 0] + friction(f_c, f_v, r.qd, smoothing), (M_q + M_q.T) / 2


def shown(machine, view, count: int, r, w, smoothing):
    """Psi' w on the reference r, for w (n,): what each of the `count` parameters has to do with it.  (count,)."""
    p = ca.SX.sym("p", count)
    pi, f_c, f_v = split(machine, p)
    z = machine.coordinates_of(view, r.x)
    v = machine.velocity_of(view, z, r.xd)
    vd = machine.acceleration_of(view, z, v, r.xdd)
    moved = solve_square(machine.jacobian_of(view, z), w)
    power = ca.dot(moved, machine.inverse_force(view, pi, z, v, vd))
    return ca.gradient(power + ca.dot(w, friction(f_c, f_v, r.qd, smoothing)), p)


def at_rest(machine, x, p) -> tuple[np.ndarray, np.ndarray]:
    """Psi p (n,) N and M_q (n, n) kg at rest at the pose x, as numbers."""
    d = len(x)
    turns = np.vstack([np.zeros(d), np.linalg.inv(machine.jacobian(x)).T])  # none, then 1 m/s2 of each joint
    forces = machine.regressor(x, np.zeros(d), turns, friction=True) @ p
    M_q = (forces[1:] - forces[0]).T
    return forces[0], (M_q + M_q.T) / 2


def indices(machine, wanted: list[str] | None, key: str = "learn") -> list[int]:
    """Which parameters the names in `wanted` mean, in the order of the machine; None: all.

    "friction.coulomb" means all of "friction.coulomb[0]" ...

    Raises
    ------
    ExperimentError
        a name that no parameter has.
    """
    names = machine.parameters_of(friction=True).names
    if wanted is None:
        return list(range(len(names)))
    found = set()
    for i, name in enumerate(wanted):
        meant = {j for j, known in enumerate(names) if known == name or known.startswith(f"{name}[")}
        if not meant:
            raise ExperimentError(
                f"{machine.name} has no such parameter", key=f"{key}.{i}", value=name, cure=did_you_mean(name, names)
            )
        found |= meant
    return sorted(found)


def sizes(machine) -> np.ndarray:
    """s_j of eq. (7): what is believed of a parameter; where that is nothing, of the largest of its unit, or 1."""
    _, values, units = machine.parameters_of(friction=True)
    largest = {unit: max(abs(v) for v, u in zip(values, units, strict=True) if u == unit) for unit in set(units)}
    return np.array([abs(v) or largest[u] or 1.0 for v, u in zip(values, units, strict=True)])


def excitation(machine, x, xd, xdd) -> np.ndarray:
    """E_j of eq. (7), one a parameter, for the rows of a motion: pose, twist and twist rate (k, d).  (p,) m2/s4."""
    Y = machine.regressor(x, xd, xdd, friction=True)
    J, M = machine.jacobian(x), machine.mass_matrix(x)
    accelerations = J @ np.linalg.solve(M, np.swapaxes(J, -1, -2) @ Y)  # M_q^-1 = J M^-1 J'
    return np.mean(np.sum(accelerations**2, axis=-2), axis=0) * sizes(machine) ** 2


def usual_excitation(machine) -> np.ndarray:
    """E_j of a machine at work: over its workspace, uniform in all directions within what its [feed] allows.

    Half of rapid and angular rate, the whole of both accelerations.  (p,) m2/s4.
    """
    rng, d = np.random.default_rng(0), len(machine.task)
    inside = machine.limits.workspace is not None
    x = random_poses(machine, POSES, rng) if inside else np.tile(machine.home, (POSES, 1))
    feed = machine.feed
    speed = np.array([feed.rapid / 2] * 3 + [feed.angular_rate / 2] * 3)[:d]
    rate = np.array([feed.acceleration] * 3 + [feed.angular_acceleration] * 3)[:d]
    return excitation(machine, x, *(rng.uniform(-1, 1, (2, POSES, d)) * np.stack([speed, rate])[:, None]))
