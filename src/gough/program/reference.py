"""Reference: what the tool and the joints should do at every sample.  Motion makes it, chunk by chunk.

With the tip at p(s), the angles at abc = abc_0 + k u (u the extent travelled in the block, u = s - s_0 on a move):

    v = p' s',  v' = p' s'' + p'' s'^2;    abc' = k u',  abc'' = k u'';    w = E abc',  w' = E abc'' + E' abc'      (1)

w and w' are turned by R_WO from the program's frame into W.  Every row depends on its own time alone, so a motion
sampled in chunks is the motion sampled whole.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..frames import abc_rate_matrix_dot_np, abc_rate_matrix_np
from .blocks import REST
from .feed import Feed
from .path import Path
from .segments import norm, rotated

WINDOW_LENGTH, WINDOW_TIME = 5e-3, 0.1  # m, s of feed: where the point closest to the tool is sought


class Reference(NamedTuple):
    """Rows of n samples.  Joint columns are as many as the machine has joints."""

    x: Any  # pose of T in W: x y z a b c, m and rad
    xd: Any  # twist V_WT = [v; w], m/s and rad/s
    xdd: Any  # its rate
    q: Any  # joints, m
    qd: Any
    qdd: Any
    s: Any  # path length, m
    sd: Any  # its rate, m/s
    tangent: Any  # unit vector along the path
    normal: Any  # unit vector towards the centre of curvature; zero where the path is straight
    curvature: Any  # 1/m
    axis: Any  # tool axis, third column of R_WT


class Book(NamedTuple):
    """What the samples belong to.  (n,) each."""

    line: np.ndarray  # NC line, 0: none
    s: np.ndarray  # path length, m
    counted: np.ndarray  # whether on a feed move: not a rapid, a dwell, the lead-in or after the end
    block: np.ndarray  # number of the block
    window: np.ndarray  # m, how far along the path the point closest to the tool is sought


class Motion:
    """A path placed in W with its feed, on a machine.  `duration` s, `path`, `feed`.

    The tool rests for `lead_in` s before the path and for `settle` s behind it.
    """

    def __init__(self, path: Path, feed: Feed, machine, settle: float = 0.25, lead_in: float = 0.0):
        self.path, self.feed, self.machine = path, feed, machine
        self.settle, self.lead_in = settle, lead_in
        self.duration = lead_in + feed.duration + settle

    def count(self, Ts: float) -> int:
        """Samples at the period Ts from the start to the end of the motion."""
        return int(np.ceil(self.duration / Ts - 1e-9)) + 1

    def _at(self, k0, k1, Ts):
        t = np.arange(k0, k1) * Ts - self.lead_in
        return t, self.feed.at(t)

    def sample(self, k0: int, k1: int, Ts: float) -> Reference:
        """Samples k0 ... k1 - 1 at the period Ts s."""
        _, (i, u, ud, udd) = self._at(k0, k1, Ts)
        path = self.path
        moving = path.kind[i] != REST
        length, sd, sdd = (np.where(moving, a, 0.0) for a in (u, ud, udd))
        position, tangent, bend = path.point(i, length), path.tangent(i, length), path.bend(i, length)
        v = tangent * sd[:, None]
        vd = tangent * sdd[:, None] + bend * (sd * sd)[:, None]
        abc = path.angles(i, u)
        rate, acc = path.turn[i] * ud[:, None], path.turn[i] * udd[:, None]
        E, Ed = abc_rate_matrix_np(abc), abc_rate_matrix_dot_np(abc, rate)
        w = rotated(path.R_WO, rotated(E, rate))
        wd = rotated(path.R_WO, rotated(E, acc) + rotated(Ed, rate))
        x = np.concatenate([position, path.pose_angles(abc)], 1)
        xd, xdd = np.concatenate([v, w], 1), np.concatenate([vd, wd], 1)
        curvature = norm(bend)
        normal = bend / np.where(curvature > 0, curvature, 1.0)[:, None]
        axis = path.rotation(abc)[..., 2]
        q, qd, qdd = self.machine.joint_motion(x, xd, xdd)
        s = path.s0[i] + length
        return Reference(x, xd, xdd, q, qd, qdd, s[:, None], sd[:, None], tangent, normal, curvature[:, None], axis)

    def book(self, k0: int, k1: int, Ts: float) -> Book:
        """What the samples k0 ... k1 - 1 belong to."""
        t, (i, u, _, _) = self._at(k0, k1, Ts)
        path = self.path
        on = (t >= 0) & (t < self.feed.duration)
        counted = on & ~path.rapid[i] & ((path.kind[i] != REST) | path.turning_at_rest[i])
        s = path.s0[i] + np.where(path.kind[i] != REST, u, 0.0)
        # a turn at rest is measured in rad/s; its tip does not run ahead of anything
        speed = np.where(path.turning_at_rest[i], 0.0, self.feed.speed[i])
        line = np.where(on, path.line[i], 0).astype(np.int32)
        return Book(line, s, counted, i.astype(np.int32), WINDOW_LENGTH + WINDOW_TIME * speed)
