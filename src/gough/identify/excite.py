"""Motions that show the parameters: a finite Fourier series in task coordinates, from rest to rest, by optimisation.

With X the base columns of the regressor at m times of the period, each times its parameter's size, M = X' X / m, and c
the coefficients of the series with K harmonics,

    maximise log det M over c                                                                                      (1)
    subject to g_j(t) >= KEEP at times t, for all limits j                                                         (2)
               sum over k of k sine_k = 0,   sum over k of k^2 cosine_k = 0                                        (3)

with g_j the workspace, strokes, cones, distance from a singularity, speed, acceleration and force of every joint, as
shares.  (1) is the volume of the estimate's ellipsoid (D-optimal), smooth where the condition number is not; the
condition number falls with it.  c is written in a basis of (3).  IPOPT solves it from a start that a seed decides; what
it does not call solved is an error.  What is found is looked at at many more times; where it leaves a limit between
those of (2), such a time is added and it is solved again.
Swevers et al., IEEE Trans. Robotics and Automation 13(5), 1997, for the series; docs/theory/identification.md.
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca
import numpy as np

from ..errors import ExperimentError, RunError, WorkspaceError
from ..machine.base import Machine
from ..program.standard.fourier import Fourier
from ..simulate.reach import check_motion
from .base import BaseParameters, base_parameters
from .design import Design, design_of, structural
from .regress import chosen_of
from .rows import rows_of_motion

_POINTS = 8  # times in the shortest period: the forces have harmonics up to about three times the pose's
_LIMITS = 14  # times in the shortest period at which limits are looked at: a sine is 2.5 % from its peak between them
_CHECKED = 7  # times as many when what was found is looked at
_ITERATIONS = 400
_ROUNDS = 5  # of adding times at which a limit was left
_SHRINK = 0.7
_ROOM = 0.15  # of each limit, left by the start
_KEEP = 0.05  # KEEP of eq. (2): for what lies between the times
_SOLVED = ("Solve_Succeeded", "Solved_To_Acceptable_Level")


def excite(
    machine: Machine,
    period: float = 10.0,
    cycles: int = 1,
    harmonics: int = 5,
    free: Sequence[str] | None = None,
    friction: Sequence[str] = ("coulomb", "viscous"),
    seed: int = 0,
) -> Fourier:
    """A periodic motion of `machine` about its home that shows its parameters best, eqs. (1)-(3).

    `free` names the parameters that matter, as for `identify`; `seed` the start of the search.  The same arguments
    give the same motion.

    Raises
    ------
    ExperimentError
        arguments out of bounds, `free` names nothing.
    RunError
        the optimiser did not converge, or what it found leaves a limit between its times: no motion is given.
    """
    if not (np.isfinite(period) and period > 0 and 2 <= harmonics <= 32):
        raise ExperimentError("period must be above 0 s and harmonics from 2 to 32", value=f"{period}, {harmonics}")
    names = structural(machine, friction)[2].names
    design = design_of(machine, None if free is None else chosen_of(names, free), friction)
    basis = _basis(harmonics)
    seen, held = (_expand(_moments(_times(period, n * harmonics), period, harmonics, basis), len(machine.task))
                  for n in (_POINTS, _LIMITS))  # fmt: skip
    start = _start(design, held, harmonics, seed)
    dense = _expand(
        _moments(_times(period, _CHECKED * _LIMITS * harmonics), period, harmonics, basis), len(machine.task)
    )
    for _ in range(_ROUNDS):
        start = _solved(design, seen, held, start)
        g = _limits_at(design, dense, start)
        worst = np.unique(g.argmin(1)[g.min(1) < 0])
        if not len(worst):
            break
        held = np.concatenate([held, dense[worst]])  # a limit left between the times: look there too
    _check(design, g, period)
    program = _program(start, basis, len(machine.task), period, cycles)
    check_motion(machine, program.plan(machine), period / len(dense))
    return program


def shown(machine: Machine, program, friction: Sequence[str] = ("coulomb", "viscous"), period: float = 0.01):
    """What a planned program shows if only rounding limits it: BaseParameters, with the condition number."""
    motion = program.plan(machine)
    r = motion.sample(0, motion.count(period), period)
    rows = rows_of_motion(machine, r.x, r.xd, r.xdd, np.zeros((len(r.x), machine.joints_count)), friction)
    size = structural(machine, friction)[1]
    found: BaseParameters = base_parameters(
        rows.Y.reshape(-1, len(size)) * size, rows.names, rows.units, size, noise=False
    )
    return found


# -- the series ------------------------------------------------------------------------------------------------------


def _basis(K: int) -> tuple[np.ndarray, np.ndarray]:
    """Orthonormal bases of the sines and the cosines that begin at rest, eq. (3).  (K, K - 1) each."""
    k = np.arange(1.0, K + 1)
    return tuple(np.linalg.svd((k**power)[None])[2][1:].T for power in (1, 2))


def _times(period: float, count: int) -> np.ndarray:
    """Times of a period, none at its ends: distances from home have no derivative there.  (count,) s."""
    return (np.arange(count) + 0.5) * period / count


def _moments(t, period, K, basis) -> np.ndarray:
    """B (m, 3, 2 (K - 1)): value, rate and acceleration of a coordinate at the times, by the series' free numbers."""
    k = np.arange(1.0, K + 1) * 2 * np.pi / period
    phase = np.multiply.outer(t, k)
    sine, cosine = np.sin(phase), np.cos(phase)
    a = np.stack([sine, cosine * k, -sine * k**2], 1) @ basis[0]
    b = np.stack([cosine - 1, -sine * k, -cosine * k**2], 1) @ basis[1]
    return np.concatenate([a, b], -1)


def _expand(B, columns: int) -> np.ndarray:
    """w = G c for every time, w in the order of design.py, c coordinate by coordinate.  (m, 18, columns 2 (K - 1))."""
    m, _, f = B.shape
    G = np.zeros((m, 18, columns * f))
    for j in range(columns):
        first = 9 * (j // 3) + j % 3  # p, p', p'' then abc, abc', abc''
        for order in range(3):
            G[:, first + 3 * order, j * f : (j + 1) * f] = B[:, order]
    return G


def _start(design: Design, G, K: int, seed: int) -> np.ndarray:
    """Random coefficients, made smaller until every limit holds."""
    f = 2 * (K - 1)
    c = 0.1 * np.random.default_rng(seed).standard_normal((G.shape[-1] // f, f)) / np.tile(np.arange(2, K + 1), 2)
    c = c.reshape(-1)
    for _ in range(60):
        g = _limits_at(design, G, c)
        if g.min() > _ROOM:
            return c
        c = c * _SHRINK
    worst = design.limits[int(np.argmin(g.min(1)))]
    raise WorkspaceError(
        "no motion about home is within the limits", where=worst, cure="check home, limits and feed of the machine"
    )


def _limits_at(design: Design, G, c) -> np.ndarray:
    """g of every limit at the times of G (m, 18, k).  (limits, m)."""
    return np.array(design.row.map(len(G))(w=(G @ c).T)["g"])


def _solved(design: Design, seen, held, start) -> np.ndarray:
    """Equations (1) at the times of `seen` and (2) at those of `held`, (m, 18, k) each, by IPOPT.  (k,)."""
    m, r = len(seen), len(design.kept)
    scale = np.abs(start).mean()
    c = ca.MX.sym("c", len(start))

    def moments(G):
        return ca.reshape(ca.DM((G * scale).reshape(len(G) * 18, -1)) @ c, 18, len(G))

    row = ca.SX.sym("w", 18)
    X, g = design.row(row)
    only_X, only_g = ca.Function("X", [row], [X.T]), ca.Function("g", [row], [g])
    slope = ca.Function("dg", [row], [ca.densify(ca.jacobian(g, row))])
    stacked = only_X.map(m)(moments(seen))  # (r, n m)
    M = stacked @ stacked.T / m
    cost = -_log_det(r)(M)
    w = moments(held)
    limits = ca.vec(only_g.map(len(held))(w))
    slopes = ca.horzsplit(slope.map(len(held))(w), 18)
    jacobian = ca.vertcat(*[s @ ca.DM(G * scale) for s, G in zip(slopes, held, strict=True)])
    p = ca.MX.sym("p", 0)
    options = {
        "jac_g": ca.Function("jac_g", [c, p], [limits, jacobian]),
        "print_time": False,
        "ipopt": {
            "print_level": 0, "sb": "yes", "hessian_approximation": "limited-memory", "max_iter": _ITERATIONS,
            "tol": 1e-3, "acceptable_tol": 1e-2, "acceptable_obj_change_tol": 1e-4, "acceptable_iter": 10,
        },
    }  # fmt: skip
    solver = ca.nlpsol("excite", "ipopt", {"x": c, "f": cost, "g": limits, "p": p}, options)
    answer = solver(x0=start / scale, lbg=_KEEP, ubg=np.inf)
    status = str(solver.stats()["return_status"])
    found = np.array(answer["x"]).ravel() * scale
    if status not in _SOLVED or not np.isfinite(found).all():
        raise RunError(
            "the optimiser found no exciting motion", value=f"IPOPT ends with {status}",
            cure="take another seed, a longer period, or fewer harmonics",
        )  # fmt: skip
    return found


def _log_det(r: int) -> ca.Function:
    """log det of a symmetric positive (r, r)."""
    M = ca.SX.sym("M", r, r)
    U = ca.chol(M)
    return ca.Function("log_det", [M], [2 * ca.sum1(ca.log(ca.diag(U)))])


def _program(c, basis, columns, period, cycles) -> Fourier:
    """The program of the free numbers c."""
    K = len(basis[0])
    c = c.reshape(columns, 2 * (K - 1))
    both = [basis[i] @ c[:, i * (K - 1) : (i + 1) * (K - 1)].T for i in range(2)]
    full = [np.pad(rows, ((0, 0), (0, 6 - columns))) for rows in both]
    keys = (("sine", "cosine"), ("turn_sine", "turn_cosine"))
    series = {
        keys[j][i]: full[i][:, 3 * j : 3 * j + 3] for i in range(2) for j in range(2) if full[i][:, 3 * j :].any()
    }
    return Fourier(period=period, cycles=cycles, **series)


def _check(design: Design, g, period: float) -> None:
    """Refuse what leaves a limit between the times that the optimiser looked at; g (limits, m)."""
    if not g.min() >= 0:
        i, k = (int(v) for v in np.unravel_index(np.argmin(g), g.shape))
        raise RunError(
            "the motion found leaves a limit between the times it was optimised at", where=design.limits[i],
            time=(k + 0.5) * period / g.shape[1], value=f"{-100 * g[i, k]:.3g} % beyond",
            cure="take more harmonics, or another seed",
        )  # fmt: skip
