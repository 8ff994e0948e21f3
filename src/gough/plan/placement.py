"""Where to clamp the work: the place of program zero that leaves the least margin over all limits greatest.

The feed along a path knows nothing of joints (preflight.py, "cartesian"), so it is the same at every place.  The motion
is sampled once, in the frame O of the program; a place p_WO, turned about the third axis of W by c, makes of it

    p_W = p_WO + Rz(c) R_O p,    R_WT = Rz(c) R_O R(abc),    v_W, w_W and their rates likewise                       (1)

and what is maximised is the least of m_i = 1 - use over samples and limits (demand.py): by differential evolution over
places x, many at once, then by linear programs for a step d of the place,

    greatest t with  m_i(x) + grad m_i . d >= t  for all i near the least,   |d_k| <= reach                         (2)

whose answer is judged whole; samples that were missed join, and again.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..errors import ExperimentError, WorkspaceError
from ..frames import abc_of_rotation_np, rotation_of_abc_np
from ..program.segments import rotated
from .course import rows, state, stretches
from .demand import POSE, Demand
from .judge import judge
from .preflight import CARTESIAN, Preflight, planned

if TYPE_CHECKING:
    from ..simulate.plant import Plant

_KEPT = 300  # samples that places are judged by at first
_ROUNDS = 8
_SURE = 1e-5  # of a margin: what the samples may have missed
_BATCH = 20_000  # rows asked at once
_WIDEST = 1.0  # m, to each side of home where no workspace is declared
_REACH, _FINEST = 10e-3, 1e-7  # m and rad, of a step of (2): the first, and the last
_STEP = 1e-6  # m and rad, of differences: err by 1e-12 of a margin's bend, and rounding by 1e-10
_BAND = 0.2  # of margins that a step of (2) may make the least
_CLIMBS = 60
_BEYOND = -10.0  # margin of a place where the machine cannot stand: finite, so that places can be compared


class Placement(NamedTuple):
    """Where program zero belongs: `origin` (6,), x y z a b c in W, m and rad.  Margins are least ones, 0 at a limit."""

    origin: np.ndarray
    margin: float
    before: float  # of the place that the program has now
    joint: str  # what limits most at this place
    what: str
    line: int
    preflight: Preflight

    @property
    def table(self) -> str:
        """The line of [program] in an experiment file."""
        shown = [f"{1e3 * v:.3f} mm" for v in self.origin[:3]] + [
            f"{np.degrees(v) + 0.0:.4f} deg" for v in self.origin[3:]
        ]
        return "origin = [" + ", ".join(f'"{text}"' for text in shown) + "]"

    def words(self, machine) -> str | None:
        """G10 L2 that sets G54 so, for a controller whose machine zero is the home of `machine`; None where a turned
        zero would have to turn A, B and C too, which no G10 does."""
        home = np.asarray(machine.program_zero, float)
        R = rotation_of_abc_np(home[3:])
        x, y, z = 1e3 * (R.T @ (self.origin[:3] - home[:3]))
        turn = abc_of_rotation_np(R.T @ rotation_of_abc_np(self.origin[3:]))
        if np.abs(turn[:2]).max() > 1e-9:
            return None
        angle = float(np.degrees(turn[2]))
        program = self.preflight.motion.path
        if abs(angle) > 1e-9 and (program.abc0.any() or program.turn.any()):
            return None
        return f"G10 L2 P1 X{x:.3f} Y{y:.3f} Z{z:.3f} R{angle + 0.0:.4f}"


def place(
    machine, program, turn: bool = False, poses_only: bool = False, seed: int = 0, plant: Plant | None = None
) -> Placement:
    """The place of program zero with the greatest least margin, and with `turn` its best angle about the third axis.

    `poses_only`: the drives do not count; for a program whose feeds are fitted afterwards (feeds.py).  With `plant`
    what it asks of the drives counts (preflight.py).

    Raises
    ------
    WorkspaceError
        no place keeps all limits: which limit binds at the best one, on which line and by how much.
    """
    machine = machine.rigid
    search = _Search(machine, program, turn, poses_only, plant)
    before = best = search.judged(search.start)
    x = search.optimum(seed)
    for _ in range(_ROUNDS):
        found = search.judged(x)
        best = max(best, found, key=search.least)
        if search.least(found) >= search.margins(x[None])[0] - _SURE:
            break
        search.join(found)
        x = search.climbed(x)
    worst = [one for one in best.findings if one.kind == POSE or not poses_only]
    if worst:
        raise WorkspaceError(
            f"no place in the workspace keeps the program within the limits; at the best one {worst[0].joint}: "
            f"{worst[0].what}", file=best.name, line=worst[0].line or None, value=worst[0].value, limit=worst[0].limit,
            cure=worst[0].advice if worst[0].kind != POSE else "make the part smaller, or split the program",
        )  # fmt: skip
    origin = np.concatenate([best.motion.path.p_WO, abc_of_rotation_np(best.motion.path.R_WO)]).round(7) + 0.0
    peak = next(one for one in best.peaks if one.kind == POSE or not poses_only)
    return Placement(origin, search.least(best), search.least(before), peak.joint, peak.what, peak.line, best)


class _Search:
    """Margins of places of one program on one machine."""

    def __init__(self, machine, program, turn: bool, poses_only: bool, plant: Plant | None):
        self.machine, self.program, self.demand = machine, program, Demand(machine, plant=plant)
        self.columns = slice(0, self.demand.pose_count if poses_only else len(self.demand))
        motion = planned(machine, program, CARTESIAN)
        self.p0, self.R0 = motion.path.p_WO, motion.path.R_WO
        self.axis = machine.rail.direction if len(machine.task) == 1 else None
        self.turn = turn and self.axis is None
        if turn and self.axis is not None:
            raise ExperimentError("one axis cannot be turned", key="--turn", cure="leave it out")
        self.whole = self._sampled(motion)
        self._bounds(motion)
        self.start = np.zeros(len(self.low))
        self.kept = self._choice()

    def _sampled(self, motion):
        """Poses, twists and their rates of T in the frame of program zero: p, R, v, w, v', w'."""
        self.free = _Six(motion)
        parts = []
        whole = stretches(motion)
        for share in (0.0, 0.5, 1.0):
            here = rows(self.free, whole, share)
            parts.append(np.concatenate([here.x, here.xd, here.xdd], 1))
        for share in (0.0, 1.0):
            path = motion.course.path
            block, still = np.arange(len(path)), np.zeros(len(path))
            here = state(self.free, block, share * path.extent, still, still)
            parts.append(np.concatenate([here.x, here.xd, here.xdd], 1))
        return self._own(np.concatenate(parts))

    def _own(self, rows_):
        p, abc, v, w, vd, wd = (rows_[:, 3 * k : 3 * k + 3] for k in range(6))
        R = rotation_of_abc_np(abc)
        back = self.R0.T
        turned = np.stack([rotated(back, R[..., :, k]) for k in range(3)], -1)
        return [rotated(back, p - self.p0), turned, *(rotated(back, a) for a in (v, w, vd, wd))]

    def _bounds(self, motion):
        """Bounds of what is searched, from where the program is now: m, and rad."""
        machine = self.machine
        if self.axis is not None:
            half = np.ptp(machine.limits.travel)
            self.low, self.high = np.array([-half]), np.array([half])
            return
        p = rotated(self.R0, self.whole[0]) + self.p0
        middle = (p.min(0) + p.max(0)) / 2
        space, home = machine.limits.workspace, machine.program_zero[:3]
        half, centre = np.full(3, _WIDEST), home
        if space is not None:
            across = np.full(2, space.radius) if space.size is None else np.asarray(space.size) / 2
            half = np.append(across, space.height / 2)
            centre = home if space.middle is None else home + space.middle
        # the middle of the program comes to lie in the workspace; and where it is now is always among the places
        self.low, self.high = np.minimum(centre - half - middle, 0.0), np.maximum(centre + half - middle, 0.0)
        if self.turn:
            self.low, self.high = np.append(self.low, -np.pi), np.append(self.high, np.pi)

    def _frame(self, x):
        """p_WO (n, 3) and R_WO (n, 3, 3) of places x (n, k)."""
        if self.axis is not None:
            return self.p0 + x * self.axis, np.broadcast_to(self.R0, (len(x), 3, 3))
        c = x[:, 3] if self.turn else np.zeros(len(x))
        zero = np.zeros(len(x))
        Rz = rotation_of_abc_np(np.stack([zero, zero, c], -1))
        return self.p0 + x[:, :3], Rz @ self.R0

    def _uses(self, x, some):
        """Uses of the samples `some` at places x (n, k).  (n, len(some), limits), with inf where none can be stood."""
        p, R, v, w, vd, wd = (column[some] for column in self.whole)
        p_WO, R_WO = self._frame(x)
        n, m = len(x), len(p)
        out = np.empty((n, m, self.columns.stop))
        step = max(1, _BATCH // m)
        for k in range(0, n, step):
            at, turned = p_WO[k : k + step], R_WO[k : k + step]
            vectors = [np.einsum("nij,mj->nmi", turned, a) for a in (p, v, w, vd, wd)]
            abc = abc_of_rotation_np(np.einsum("nij,mjk->nmik", turned, R))
            rows_ = [
                np.concatenate([vectors[0] + at[:, None], abc], -1), np.concatenate(vectors[1:3], -1),
                np.concatenate(vectors[3:], -1),
            ]  # fmt: skip
            own = self.machine.task_motion(*(a.reshape(-1, 6) for a in rows_))
            uses, broken = self.demand.uses(*own)
            uses[broken] = np.inf
            out[k : k + step] = uses[:, self.columns].reshape(len(at), m, -1)
        return out

    def margins(self, x) -> np.ndarray:
        """Least margins of places x (n, k), over the samples that are kept.  (n,)."""
        return np.maximum(1 - self._uses(np.asarray(x, float), self.kept).max((1, 2)), _BEYOND)

    def _choice(self):
        """Samples that places are judged by: evenly along the program, and those that use most of any limit now."""
        n = len(self.whole[0])
        even = np.unique(np.linspace(0, n - 1, min(n, _KEPT)).astype(int))
        return np.union1d(even, self._most(self.start))

    def _most(self, x):
        """The sample that uses most of each limit at the place x (n,)."""
        n = len(self.whole[0])
        parts = np.array_split(np.arange(n), n // 5000 + 1)
        return np.concatenate([self._uses(x[None], part)[0] for part in parts]).argmax(0)

    def join(self, found: Preflight) -> None:
        """Take in the samples that use most of each limit at the place of `found`."""
        block, *rates = found.found.top_place.T
        here = state(self.free, block.astype(int), *rates)
        more = self._own(np.concatenate([here.x, here.xd, here.xdd], 1))
        self.kept = np.append(self.kept, len(self.whole[0]) + np.arange(len(block)))
        self.whole = [np.concatenate(pair) for pair in zip(self.whole, more, strict=True)]

    def least(self, found: Preflight) -> float:
        """The least margin of a whole preflight."""
        return float("-inf") if found.found.unreachable else 1 - float(found.found.top[self.columns].max())

    def optimum(self, seed: int) -> np.ndarray:
        """The place with the greatest least margin."""
        from scipy.optimize import differential_evolution

        def cost(x):  # (k, n) of differential evolution
            return -self.margins(x.T)

        bounds = list(zip(self.low, self.high, strict=True))
        start = np.clip(self.start, self.low, self.high)
        found = differential_evolution(
            cost, bounds, x0=start, seed=seed, vectorized=True, updating="deferred", popsize=12, maxiter=60, tol=1e-4,
            polish=False,
        )  # fmt: skip
        return self.climbed(found.x)

    def climbed(self, x) -> np.ndarray:
        """The top of the least margin near x, by eq. (2) within a box that shrinks where it promises too much."""
        from scipy.optimize import linprog

        k, reach, h = len(x), _REACH, _STEP * np.eye(len(x))
        top = self.margins(x[None])[0]
        for _ in range(_CLIMBS):
            at = 1 - self._uses(np.concatenate([x[None], x + h, x - h]), self.kept).reshape(2 * k + 1, -1)
            near = np.flatnonzero(at[0] < at[0].min() + _BAND)
            if not np.isfinite(at[:, near]).all():
                return x
            slope = (at[1 : k + 1, near] - at[k + 1 :, near]).T / (2 * _STEP)
            box = [*zip(np.maximum(self.low - x, -reach), np.minimum(self.high - x, reach), strict=True), (None, None)]
            rows_ = np.column_stack([-slope, np.ones(len(near))])
            step = linprog(np.append(np.zeros(k), -1.0), rows_, at[0, near], bounds=box, method="highs")
            if step.x is None:
                return x
            new = np.clip(x + step.x[:k], self.low, self.high)
            found = self.margins(new[None])[0]
            if found > top:
                x, top = new, found
            else:
                reach /= 4
                if reach < _FINEST:
                    break
        return x

    def judged(self, x) -> Preflight:
        """The whole preflight at a place."""
        p_WO, R_WO = (a[0] for a in self._frame(np.asarray(x, float)[None]))
        program = self.program.replace(origin=np.concatenate([p_WO, abc_of_rotation_np(R_WO)]))
        motion = planned(self.machine, program, CARTESIAN)
        name = getattr(program, "name", type(program).__name__)
        return Preflight(motion, self.demand, judge(motion, self.demand), name, CARTESIAN)


class _Six:
    """A motion whose rows are the six of T, whatever the task of the machine is."""

    class _Free:
        rigid: object

        @staticmethod
        def task_motion(x, xd, xdd):
            return x, xd, xdd

    def __init__(self, motion):
        self.feed, self.course = motion.feed, motion.course
        self.machine = self._Free()
        self.machine.rigid = self.machine
