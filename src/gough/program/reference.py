"""Reference: what the tool and the joints should do at every sample.  Motion makes it, chunk by chunk.

tool_motion.py has the equations of the tool.  Every row depends on its own time alone, so a motion sampled in chunks
is the motion sampled whole.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .blocks import REST
from .course import Course
from .feed import Feed
from .path import Path
from .segments import norm
from .tool_motion import tool_motion

WINDOW_LENGTH, WINDOW_TIME = 5e-3, 0.1  # m, s of feed: where the point closest to the tool is sought


class Reference(NamedTuple):
    """Rows of n samples.  Joint columns are as many as the machine has joints."""

    x: Any  # task coordinates of T in W: x y z, and a b c where the machine has them, m and rad
    xd: Any  # twist V_WT = [v; w], m/s and rad/s, or v alone
    xdd: Any  # its rate
    q: Any  # joints, m
    qd: Any
    qdd: Any
    s: Any  # length driven along the course, m
    sd: Any  # its rate, m/s
    tangent: Any  # unit vector along the course
    normal: Any  # unit vector towards the centre of curvature; zero where the course is straight
    curvature: Any  # 1/m
    axis: Any  # tool axis, third column of R_WT


class Book(NamedTuple):
    """What the samples belong to, on the programmed path.  (n,) each."""

    line: np.ndarray  # NC line, 0: none
    s: np.ndarray  # length along the programmed path, m
    counted: np.ndarray  # whether on a feed move: not a rapid, a dwell, the lead-in or after the end
    block: np.ndarray  # number of the block
    u: np.ndarray  # extent travelled in it, m or rad
    window: np.ndarray  # m, how far along the path the point closest to the tool is sought


class Motion:
    """A path placed in W, its course and the feed along that, on a machine.  `duration` s.

    `path` is the programmed path, `course.path` the one that is driven.  The tool rests for `lead_in` s before the
    path and for `settle` s behind it.
    """

    def __init__(self, path: Path, course: Course, feed: Feed, machine, settle: float = 0.25, lead_in: float = 0.0):
        self.path, self.course, self.feed, self.machine = path, course, feed, machine
        self.settle, self.lead_in = settle, lead_in
        self.duration = lead_in + feed.duration + settle

    def count(self, Ts: float) -> int:
        """Samples at the period Ts from the start to the end of the motion."""
        return int(np.ceil(self.duration / Ts - 1e-9)) + 1

    def _at(self, k0, k1, Ts):
        t = np.arange(k0, k1) * Ts - self.lead_in
        return t, self.feed.at(t)[:4]

    def sample(self, k0: int, k1: int, Ts: float) -> Reference:
        """Samples k0 ... k1 - 1 at the period Ts s.

        Joints are NaN where the machine has none for the pose; whoever runs a motion looks with simulate.reach first.
        """
        _, (i, u, ud, udd) = self._at(k0, k1, Ts)
        path = self.course.path
        x, xd, xdd, tangent, bend, R_WT = tool_motion(path, i, u, ud, udd)
        x, xd, xdd = self.machine.task_motion(x, xd, xdd)
        curvature = norm(bend)
        normal = bend / np.where(curvature > 0, curvature, 1.0)[:, None]
        q, qd, qdd = self.machine.joint_motion(x, xd, xdd, on_fail="nan")
        moving = path.kind[i] != REST
        s, sd, axis = path.s0[i] + np.where(moving, u, 0.0), np.where(moving, ud, 0.0), R_WT[..., 2]
        return Reference(x, xd, xdd, q, qd, qdd, s[:, None], sd[:, None], tangent, normal, curvature[:, None], axis)

    def book(self, k0: int, k1: int, Ts: float) -> Book:
        """What the samples k0 ... k1 - 1 belong to."""
        t, (j, u, _, _) = self._at(k0, k1, Ts)
        path = self.path
        block, extent, s = self.course.place(j, u)
        on = (t >= 0) & (t < self.feed.duration)
        counted = on & ~path.rapid[block] & ((path.kind[block] != REST) | path.turning_at_rest[block])
        # a turn at rest is measured in rad/s; its tip does not run ahead of anything
        speed = np.where(path.turning_at_rest[block], 0.0, self.feed.speed[j])
        line = np.where(on, path.line[block], 0).astype(np.int32)
        return Book(line, s, counted, block.astype(np.int32), extent, WINDOW_LENGTH + WINDOW_TIME * speed)
