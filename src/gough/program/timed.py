"""TimedMotion: a motion given as a pose over time, and the path it leaves behind for the measures.

The tip p(t) and the angles a b c(t) are those of the program's frame.  Twist and twist rate follow as eq. (1) of
tool_motion.py, with d/dt in place of the feed:

    v = R_WO p',  w = R_WO E abc',   v' = R_WO p'',  w' = R_WO (E abc'' + E' abc')

The path is a curve through points of the motion, a piece for each step of the table; where the tip turns back, one
curve ends and the next begins.  A motion of the angles alone is a row of turns at rest.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..errors import ProgramError
from ..frames import abc_rate_matrix_dot_np, abc_rate_matrix_np
from .blocks import CURVE, REST, Block, Blocks, Rest
from .curves import Curves
from .path import Path
from .reference import WINDOW_LENGTH, WINDOW_TIME, Book, Motion, Reference
from .segments import dot, norm, rotated
from .spline import through

_STILL = 1e-8  # m; a step of the tip below it is no direction
_SLOW = 1e-3  # of the greatest speed: the tip stands, and its path has no curvature there
_BACK = np.cos(np.radians(30))  # a sharper turn between two steps is a turning back

Poses = Callable[[np.ndarray], tuple[np.ndarray, ...]]


class TimedMotion(Motion):
    """A motion of `duration` s with its rest at both ends.

    `poses(t)` gives p, p', p'', abc, abc', abc'' (n, 3) for times from 0 to the last of `nodes` (m + 1,) s.
    """

    def __init__(self, poses: Poses, nodes: np.ndarray, machine, p_WO, R_WO, settle: float, lead_in: float):
        self.poses, self.machine, self.settle, self.lead_in = poses, machine, settle, lead_in
        made, self.start = path_of(poses, nodes)
        self.path = made.placed(p_WO, R_WO)
        self.end = float(nodes[-1])
        self.duration = lead_in + self.end + settle

    def _places(self, k0: int, k1: int, Ts: float):
        """Times (n,) of the samples within the motion, whether they are, and what `poses` says of them, placed in W."""
        t = np.arange(k0, k1) * Ts - self.lead_in
        on = (t >= 0) & (t <= self.end)
        inside = np.minimum(np.maximum(t, 0.0), self.end)
        p, pd, pdd, abc, rate, acc = self.poses(inside)
        pd, pdd, rate, acc = (np.where(on[:, None], a, 0.0) for a in (pd, pdd, rate, acc))
        R = self.path.R_WO
        return inside, on, self.path.p_WO + rotated(R, p), rotated(R, pd), rotated(R, pdd), abc, rate, acc

    def sample(self, k0: int, k1: int, Ts: float) -> Reference:
        """Samples k0 ... k1 - 1 at the period Ts s."""
        inside, _, p, v, vd, abc, rate, acc = self._places(k0, k1, Ts)
        E, Ed = abc_rate_matrix_np(abc), abc_rate_matrix_dot_np(abc, rate)
        w = rotated(self.path.R_WO, rotated(E, rate))
        wd = rotated(self.path.R_WO, rotated(E, acc) + rotated(Ed, rate))
        x = np.concatenate([p, self.path.pose_angles(abc)], 1)
        d = len(self.machine.task)
        x, xd, xdd = x[:, :d], np.concatenate([v, w], 1)[:, :d], np.concatenate([vd, wd], 1)[:, :d]
        q, qd, qdd = self.machine.joint_motion(x, xd, xdd)
        block, u = self._blocks(inside, p)
        moving = self.path.kind[block] != REST
        s, sd = self.path.s0[block] + np.where(moving, u, 0.0), norm(v)
        _, tangent, bend = self.path.frame(block, np.where(moving, u, 0.0))
        curvature = norm(bend)
        normal = bend / np.where(curvature > 0, curvature, 1.0)[:, None]
        axis = self.path.rotation(abc)[..., 2]
        return Reference(x, xd, xdd, q, qd, qdd, s[:, None], sd[:, None], tangent, normal, curvature[:, None], axis)

    def book(self, k0: int, k1: int, Ts: float) -> Book:
        """What the samples k0 ... k1 - 1 belong to."""
        inside, on, p, v, *_ = self._places(k0, k1, Ts)
        block, u = self._blocks(inside, p)
        s = self.path.s0[block] + np.where(self.path.kind[block] != REST, u, 0.0)
        line = np.zeros(len(inside), np.int32)
        return Book(line, s, on, block.astype(np.int32), u, WINDOW_LENGTH + WINDOW_TIME * norm(v))

    def _blocks(self, t, p):
        """Block of the times t (n,), and the extent travelled in it by the tip at p (n, 3), in W."""
        block = np.minimum(np.searchsorted(self.start, t, "right") - 1, len(self.path) - 1)
        share = (t - self.start[block]) / (self.start[block + 1] - self.start[block])
        extent = self.path.extent[block]
        u = share * extent
        moving = np.flatnonzero(self.path.kind[block] != REST)
        if len(moving):
            i, length = block[moving], extent[moving]
            u[moving] = self.path.closest(i, p[moving], 0.0 * length, length, u[moving])
        return block, u


def path_of(poses: Poses, nodes: np.ndarray) -> tuple[Path, np.ndarray]:
    """The path of a motion through its poses at `nodes` (m + 1,) s, and when each block begins, and the last ends.

    Raises
    ------
    ProgramError
        neither the tip nor the angles move.
    """
    p, _, _, abc, *_ = poses(nodes)
    if np.ptp(p, axis=0).max() < _STILL:
        return _turns(p[0], abc, nodes)
    stops = _stops(poses, nodes)
    nodes = np.union1d(nodes, stops)
    p, _, _, abc, *_ = poses(nodes)
    kept = [0]
    for k in range(1, len(nodes)):  # steps that are too short to have a direction are joined to the next
        if norm(p[k] - p[kept[-1]]) >= _STILL:
            kept.append(k)
    if len(kept) > 1:
        kept[-1] = len(nodes) - 1
    t, p, abc = nodes[kept], p[kept], abc[kept]
    ends = np.searchsorted(t, stops).clip(1, len(t) - 2)
    breaks = np.unique([0, *ends, len(t) - 1])
    runs = [through(p[a : b + 1], abc[a : b + 1]) for a, b in zip(breaks[:-1], breaks[1:], strict=True)]
    curves = Curves.joined([run[0] for run in runs])
    angles = np.concatenate([run[1] for run in runs])
    m = len(curves.length)
    none, zero = np.zeros((m, 3)), np.zeros(m)
    columns = {
        "kind": np.full(m, CURVE, np.int8), "index": np.arange(m), "rapid": np.zeros(m, bool),
        "line": np.zeros(m, np.int32), "feed": curves.length / np.diff(t), "dwell": zero, "tolerance": zero,
        "spindle": zero, "tool": none, "abc0": abc[:-1].copy(), "abc1": abc[1:].copy(),
    }  # fmt: skip
    bent = (np.arange(m), angles) if np.ptp(abc, axis=0).max() > 0 else None
    return Path.of(columns, [*Blocks().batches(), curves], bent), t


def _stops(poses: Poses, nodes: np.ndarray) -> np.ndarray:
    """Times between the ends at which the tip stands still: where it turns back, or has almost no speed.  (k,) s."""
    p, pd, *_ = poses(nodes)
    speed = norm(pd)
    step = np.diff(p, axis=0)
    length = norm(step)
    back = dot(step[1:], step[:-1]) < _BACK * length[1:] * length[:-1]
    lowest = (speed[1:-1] <= speed[:-2]) & (speed[1:-1] <= speed[2:]) & (speed[1:-1] < _SLOW * speed.max())
    out = []
    for k in np.flatnonzero(back | lowest) + 1:
        low, high = nodes[k - 1], nodes[k + 1]
        for _ in range(2):  # a hundredth of a step, then a hundredth of that
            t = np.linspace(low, high, 201)
            best = int(np.argmin(norm(poses(t)[1])))
            low, high = t[max(best - 1, 0)], t[min(best + 1, 200)]
        out.append(t[best])
    out = np.array(out)
    return out[np.diff(out, prepend=-np.inf) > 1e-3 * (nodes[1] - nodes[0])]  # one stop seen from two nodes


def _turns(at, abc, nodes):
    """A path of turns at rest."""
    change = norm(np.diff(abc, axis=0))
    if not change.max(initial=0.0) > 0:
        raise ProgramError("neither the tip nor the angles move", cure="give a coefficient that is not 0")
    kept = np.concatenate([[True], change > 0])
    abc, t = abc[kept], nodes[kept]
    t[-1] = nodes[-1]
    rate = norm(np.diff(abc, axis=0)) / np.diff(t)
    rest = Rest(tuple(at))
    blocks = [Block(rest, tuple(abc[k]), tuple(abc[k + 1]), rate[k]) for k in range(len(rate))]
    return Path(blocks), t
