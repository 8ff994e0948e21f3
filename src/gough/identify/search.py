"""The search for an exciting motion: IPOPT on a working set of limits, within a box that follows how well it goes.

    minimise f(M(c)),   g_j(t_i) >= KEEP for the (j, i) of a working set,   |c - c_0| <= box                       (1)

Of all limits at all times a motion touches some tens, and IPOPT's time goes with their number.  The set begins with
what the start comes near to; after each round every limit is looked at, at many more times, and where one is left, its
lowest points join the set.  A round that leaves a limit by more than all it allows is taken back, and the box made
smaller.  It ends when IPOPT calls (1) solved, no limit is left anywhere and the box does not bind: a solution of the
whole problem.  Theory: docs/theory/identification.md.
"""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca
import numpy as np

from ..errors import RunError
from ..kernel.building import BUILDING
from .design import Design

KEEP = 0.05  # of each limit, kept free: for what lies between the times
_LEFT = 0.2  # of KEEP: below it a limit joins the set
_NEAR = 0.6  # of a limit, to which the start's lowest points are in the set from the beginning
_LITTLE = -0.3  # a round that leaves a limit by no more is followed by a larger box
_FAR = -1.0  # a round that leaves a limit by more is taken back
_ROUNDS, _CAP, _LAST, _PATIENCE = 40, 100, 300, 10  # the last rounds have more iterations than the others
_GROW, _CUT, _WIDEN = 1.5, 0.4, 2.0  # of the box
_CRAMPED = ("Infeasible_Problem_Detected", "Restoration_Failed")
_SOLVED = ("Solve_Succeeded", "Solved_To_Acceptable_Level")
_CURE = "take another seed, a longer period, or fewer harmonics"


class Times(NamedTuple):
    """Moments w = G c (series.py) at the times that are looked at."""

    seen: np.ndarray  # (m, 18, k) for the criterion
    dense: np.ndarray  # (n, 18, k) for the limits
    dt: float  # s between those


def limits_at(design: Design, G, c) -> np.ndarray:
    """g of every limit at the times of G (m, 18, k).  (limits, m)."""
    return np.array(design.row.map(len(G))(w=(G @ c).T)["g"])


def search(design: Design, at: Times, start: np.ndarray, criterion: ca.Function) -> np.ndarray:
    """The free numbers (k,) that make `criterion` least within every limit, from a start within them.

    Raises
    ------
    RunError
        the optimiser gave up, or there are still limits left between the times after many rounds.
    """
    problem = _Problem(design, at, criterion)
    g = limits_at(design, at.dense, start)
    working = _lowest(g, _NEAR)
    c, box = start, 2 * np.abs(start).mean()
    for k in range(_ROUNDS):
        last = k >= _ROUNDS - _PATIENCE
        found, status = problem.solve(working, c, box, _LAST if last else _CAP)
        if status in _CRAMPED:  # the box holds no motion that keeps what joined the set
            box *= _WIDEN
            continue
        if not np.isfinite(found).all() or status not in (*_SOLVED, "Maximum_Iterations_Exceeded"):
            raise RunError(_GAVE_UP, value=f"IPOPT ends with {status}", cure=_CURE)
        g = limits_at(design, at.dense, found)
        bound = np.abs(found - c).max() > 0.98 * box
        if status in _SOLVED and g.min() >= 0 and not bound:
            return found
        working |= _lowest(g, _LEFT * KEEP)
        if g.min() > _FAR:  # not so with NaN, where a joint has no position
            c, box = found, (_GROW if g.min() > _LITTLE else 1.0) * box
        else:
            box *= _CUT
    if not g.min() >= 0:
        i, n = (int(v) for v in np.unravel_index(np.argmin(g), g.shape))
        raise RunError(
            "the motion found leaves a limit between the times it was optimised at", where=design.limits[i],
            time=(n + 0.5) * at.dt, value=f"{-100 * g[i, n]:.3g} % beyond", cure=_CURE,
        )  # fmt: skip
    raise RunError(_GAVE_UP, value=f"IPOPT ends with {status} after {_ROUNDS} rounds", cure=_CURE)


_GAVE_UP = "the optimiser found no exciting motion"


def _lowest(g, below: float) -> set[tuple[int, int]]:
    """(limit, time) of the points below `below` of g (limits, n) that are lower than their neighbours, and NaNs."""
    low = ~(g >= below) & ~(g > np.roll(g, 1, 1)) & ~(g > np.roll(g, -1, 1))
    return {(int(j), int(i)) for j, i in np.argwhere(low)}


class _Problem:
    """Equation (1) for one working set after another."""

    def __init__(self, design: Design, at: Times, criterion: ca.Function):
        self.at, self.criterion = at, criterion
        with BUILDING:
            self.row = ca.SX.sym("w", 18)
            X, self.all = design.row(self.row)
            self.X = ca.Function("X", [self.row], [X.T])
        self.known: dict[tuple[int, ...], tuple[ca.Function, ca.Function]] = {}

    def solve(self, working: set[tuple[int, int]], c0, box: float, most: int) -> tuple[np.ndarray, str]:
        """The free numbers (k,) that IPOPT ends at, and how it says it ended."""
        scale = np.abs(c0).mean()
        with BUILDING:
            solver = self._solver(working, scale, len(c0), most)
        lower, upper = (c0 - box) / scale, (c0 + box) / scale
        answer = solver(x0=c0 / scale, lbx=lower, ubx=upper, lbg=KEEP, ubg=np.inf)
        return np.array(answer["x"]).ravel() * scale, str(solver.stats()["return_status"])

    def _solver(self, working, scale: float, size: int, most: int):
        c, p = ca.MX.sym("c", size), ca.MX.sym("p", 0)
        m = len(self.at.seen)
        stacked = self.X.map(m)(_moments(self.at.seen * scale, c))  # (r, n m)
        limits, jacobian = self._limits(working, scale, c)
        options = {
            "jac_g": ca.Function("jac_g", [c, p], [limits, jacobian]), "print_time": False, "show_eval_warnings": False,
            "ipopt": {
                "print_level": 0, "sb": "yes", "hessian_approximation": "limited-memory", "max_iter": most,
                "tol": 5e-3, "acceptable_tol": 5e-2, "acceptable_obj_change_tol": 1e-3, "acceptable_iter": 5,
            },
        }  # fmt: skip
        cost = self.criterion(stacked @ stacked.T / m)
        return ca.nlpsol("excite", "ipopt", {"x": c, "f": cost, "g": limits, "p": p}, options)

    def _limits(self, working, scale: float, c):
        """The limits of the working set (k,) and their slopes by c; CasADi's own Jacobian would not be by moments."""
        if not working:
            return ca.MX(0, 1), ca.MX(0, c.numel())
        of: dict[int, list[int]] = {}
        for j, i in sorted(working):
            of.setdefault(i, []).append(j)
        kinds = sorted({j for j, _ in working})
        value, slope = self._functions(tuple(kinds))
        G = self.at.dense[list(of)] * scale
        w = _moments(G, c)
        g = ca.horzsplit(value.map(len(G))(w), 1)
        slopes = ca.horzsplit(slope.map(len(G))(w), 18)
        rows = [[kinds.index(j) for j in js] for js in of.values()]
        return (
            ca.vertcat(*[g[i][js] for i, js in enumerate(rows)]),
            ca.vertcat(*[slopes[i][js, :] @ ca.DM(G[i]) for i, js in enumerate(rows)]),
        )

    def _functions(self, kinds: tuple[int, ...]) -> tuple[ca.Function, ca.Function]:
        """w -> the limits `kinds`, and their slopes by w: a working set without forces need not know their slopes."""
        if kinds not in self.known:
            g = self.all[list(kinds)]
            slope = ca.Function("dg", [self.row], [ca.densify(ca.jacobian(g, self.row))])
            self.known[kinds] = ca.Function("g", [self.row], [g]), slope
        return self.known[kinds]


def _moments(G, c):
    """w = G c at the times of G (m, 18, k).  (18, m)."""
    return ca.reshape(ca.DM(G.reshape(len(G) * 18, -1)) @ c, 18, len(G))
