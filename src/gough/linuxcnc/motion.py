r"""A recorded motion as the reference of a simulation: what LinuxCNC commands its joints, and nothing smoothed.

LinuxCNC hands its joints a cubic spline through waypoints q_k = inverse(pose_k), one each servo period T, and two
periods later; what it commands at the knots is

    q = (q_{k-1} + 4 q_k + q_{k+1}) / 6,   q' = (q_{k+1} - q_{k-1}) / 2T,                                          (1)
    q'' = (q_{k+1} - 2 q_k + q_{k-1}) / T^2

and was recorded; between the knots q'' is linear.  So joints, speeds and accelerations are those of the planner at any
period, without a difference quotient.  The tool follows from them,

    x = forward(q),   v = J^-1 q',   v' = J^-1 (q'' - J' v)                                                        (2)

and its contour error holds all that the planner did: blending, its own arcs, its samples, and the spline.
"""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np

from ..declare import Shape
from ..errors import KinematicsError
from ..frames import rotation_of_abc_np
from ..kernel.building import BUILDING
from ..kernel.rows import compile_rows
from ..mechanics.linear import solve_square
from ..program.blocks import REST
from ..program.course import Course
from ..program.reference import WINDOW_LENGTH, WINDOW_TIME, Book, Motion, Reference
from ..program.segments import norm
from .follow import follow

LATE = 2  # periods by which commands of the joints are behind those of the axes
_MOVING = 1e-9  # m/s; below it the tip has no direction of its own


class Timing:
    """What a Motion asks of its feed: how long it takes."""

    def __init__(self, duration: float):
        self.duration = duration


class RecordedMotion(Motion):
    """Motion of a Recording along `path`, the programmed path placed in W."""

    def __init__(self, path, recording, machine, settle: float):
        super().__init__(path, Course(path, path), Timing(recording.duration), machine, settle)
        self.recording, self._period = recording, recording.period
        self._knots = recording.joint, recording.joint_rate, recording.joint_acceleration
        late = np.maximum(np.arange(len(recording.axis)) - LATE, 0)
        self._pose = self._in_W(recording.axis[late])
        self._line = recording.line[late]
        x, xd, xdd = self._tool(*self._knots, self._pose)
        v = xd[:, :3]
        speed = norm(v)
        self._speed = speed
        travelled = np.cumsum((speed[1:] + speed[:-1]) / 2 * self._period)
        self._travelled = np.concatenate([[0.0], travelled])
        self._direction = _held(v, speed)
        places = follow(path, x[:, :3], recording.axis[late][:, 3:] if x.shape[1] > 3 else np.zeros((len(x), 3)),
                        speed, self._line)  # fmt: skip
        self._block, self._u, self._s = places
        self._samples = x, xd, xdd

    def _in_W(self, pose):
        """Recorded poses (N, d) of the program's frame as task coordinates in W; near is enough."""
        p = self.path.p_WO + pose[:, :3] @ self.path.R_WO.T
        return np.concatenate([p, self.path.pose_angles(pose[:, 3:])], 1) if pose.shape[1] == 6 else p

    def _tool(self, q, qd, qdd, near):
        """Eq. (2): task coordinates and their rates, (N, d) each."""
        machine = self.machine
        x, status = machine.forward_kinematics(q, near=near, on_fail="nan")
        bad = np.flatnonzero(status)
        if len(bad):
            raise KinematicsError(
                "LinuxCNC commanded joints that no pose inside the machine's limits has",
                value=str(np.round(q[bad[0]], 6).tolist()) + " m",
                cure="check the program against the limits with gough check",
            )
        if x.shape[1] == 6:  # as many turns as the program
            x[:, 3:] += 2 * np.pi * np.round((near[:, 3:] - x[:, 3:]) / (2 * np.pi))
        xd, xdd = _rates(Shape(machine))(machine.theta, machine.coordinates(x), qd, qdd)
        return x, xd, xdd

    def sample(self, k0: int, k1: int, Ts: float) -> Reference:
        """Samples k0 ... k1 - 1 at the period Ts s; behind the recording the machine stands."""
        t = np.arange(k0, k1) * Ts / self._period
        last = len(self._pose) - 1
        i = np.minimum(np.floor(t + 1e-9).astype(int), last)
        tau = np.where(i < last, np.maximum(t - i, 0.0), 0.0)
        j = np.minimum(i + 1, last)
        if (np.abs(tau) < 1e-9).all():
            q, qd, qdd = (knots[i] for knots in self._knots)
            x, xd, xdd = (column[i] for column in self._samples)
        else:
            q, qd, qdd = self._between(i, j, tau[:, None])
            x, xd, xdd = self._tool(q, qd, qdd, self._samples[0][i])
        v, a = xd[:, :3], xdd[:, :3]
        speed = norm(v)
        tangent = np.where((speed > _MOVING)[:, None], v / np.maximum(speed, _MOVING)[:, None], self._direction[i])
        across = a - (a * tangent).sum(1)[:, None] * tangent
        curvature = np.where(speed > 1e-3, norm(across) / np.maximum(speed, 1e-3) ** 2, 0.0)
        normal = np.where((curvature > 0)[:, None], across / np.maximum(norm(across), 1e-300)[:, None], 0.0)
        s = self._travelled[i] + tau * (self._travelled[j] - self._travelled[i])
        pose = x if x.shape[1] == 6 else self.machine.tool_pose(x)
        axis = rotation_of_abc_np(pose[:, 3:])[..., 2]
        return Reference(x, xd, xdd, q, qd, qdd, s[:, None], speed[:, None], tangent, normal, curvature[:, None], axis)

    def _between(self, i, j, tau):
        """The spline of eq. (1) at the share tau of the way from knot i to knot j."""
        (q, qd, qdd), T = self._knots, self._period
        h, change = tau * T, qdd[j] - qdd[i]
        return (
            q[i] + h * qd[i] + h**2 / 2 * qdd[i] + h**2 * tau / 6 * change,
            qd[i] + h * qdd[i] + h * tau / 2 * change,
            qdd[i] + tau * change,
        )

    def book(self, k0: int, k1: int, Ts: float) -> Book:
        """What the samples belong to: by the place of the recorded tip on the programmed path."""
        t = np.arange(k0, k1) * Ts
        i = np.minimum(np.round(t / self._period).astype(int), len(self._block) - 1)
        path, block = self.path, self._block[i]
        on = t < self.recording.duration
        counted = on & ~path.rapid[block] & ((path.kind[block] != REST) | path.turning_at_rest[block])
        line = np.where(on, path.line[block], 0).astype(np.int32)
        window = WINDOW_LENGTH + WINDOW_TIME * self._speed[i]
        return Book(line, self._s[i], counted, block.astype(np.int32), self._u[i], window)


def _held(v, speed):
    """Direction of the tip, where it rests that of the move before; (N, 3)."""
    moving = speed > _MOVING
    if not moving.any():
        return np.tile([1.0, 0.0, 0.0], (len(v), 1))
    last = np.maximum.accumulate(np.where(moving, np.arange(len(v)), -1))
    at = np.where(last < 0, int(np.argmax(moving)), last)
    return v[at] / speed[at][:, None]


@lru_cache(maxsize=16)
def _rates(shape: Shape):
    """(theta, z, q', q'') -> task rate and its rate, eq. (2), on rows."""
    m = shape.part
    with BUILDING:
        p, theta = m.symbols
        z = ca.SX.sym("z", m.coordinate_count)
        qd, qdd = (ca.SX.sym(name, m.joints_count) for name in ("qd", "qdd"))
        J = m.jacobian_of(p, z)
        v = solve_square(J, qd)
        vd = solve_square(J, qdd - m.joint_acceleration(p, z, v, ca.SX(*v.shape)))
        out = [m.task_rate_of(p, z, v), m.task_acceleration_of(p, z, v, vd)]
        return compile_rows(ca.Function("recorded_rates", [theta, z, qd, qdd], out))
