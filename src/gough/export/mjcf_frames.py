"""Where the legs of an exported model stand: their frames at home, and its coordinates at any pose.

The frames S are eq. (1) of mjcf_hexapod.py; n = Rot(a, fork) Rot(y_S, cross) n_home gives the two angles of a universal
joint.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .. import frames


class Frame(NamedTuple):
    """Where a leg stands at home, in W."""

    p_WA: np.ndarray  # (3,) m
    p_WB: np.ndarray  # (3,) m
    length: float  # m
    R_WS: np.ndarray  # (3, 3), eq. (1)
    axis_S: np.ndarray  # (3,), the first joint's axis (a, or the hinge of a link), in S


def _frame(A, B, a=None) -> Frame:
    """Eq. (1) for a leg from A to B (3,) m with the axis a of its universal joint.

    Without an axis the leg has no axial inertia and its spin does not matter: any axis across it serves.
    """
    length = float(np.linalg.norm(B - A))
    n = (B - A) / length
    if a is None:
        a = np.cross(n, np.eye(3)[np.argmin(np.abs(n))])
    a = a / np.linalg.norm(a)
    y = np.cross(n, a)
    y /= np.linalg.norm(y)
    R_WS = np.stack([np.cross(y, n), y, n], 1)
    return Frame(A, B, length, R_WS, R_WS.T @ a)


def strut_frame(machine, i: int) -> Frame:
    """Where strut i of a hexapod stands at home, eq. (1)."""
    B = machine.home[:3] + frames.rotation_of_abc_np(machine.home[3:]) @ machine.platform_joints_np()[i]
    a = None if machine.joints.base_axis is None else machine.joints.base_axis[i]
    return _frame(machine.joints.base[i], B, a)


def leg_frame(machine, i: int) -> Frame:
    """Where leg i of a hexaglide stands at home, from its carriage."""
    q, rails = machine.inverse_kinematics(machine.home)[i], machine.rails
    B = machine.home[:3] + frames.rotation_of_abc_np(machine.home[3:]) @ machine.platform_joints_np()[i]
    return _frame(rails.point[i] + q * rails.direction[i], B)


def link_frame(machine, i: int) -> Frame:
    """Where link i of a 3-PRS stands at home, from its slider: y_S along the hinge."""
    z, rails = machine.standing(machine.home), machine.rails
    d, c = rails.direction[i], rails.across[i]
    h, l = np.cross(c, d), np.cos(z[3 + i]) * c + np.sin(z[3 + i]) * d
    A = rails.point[i] + z[i] * d
    return Frame(A, A + machine.link.length * l, machine.link.length, np.stack([np.cross(h, l), h, l], 1), np.eye(3)[1])


def _turned(machine, poses):
    """The platform's coordinates at poses (..., 6), [(..., 3), (..., 4)], and R_WT (..., 3, 3)."""
    R_home = frames.rotation_of_abc_np(machine.tool_pose(machine.home)[3:])
    R_WT = frames.rotation_of_abc_np(poses[..., 3:])
    return [poses[..., :3], frames.quaternion_of_rotation_np(R_home.T @ R_WT)], R_WT


def _universal(frame: Frame, s):
    """fork and cross of a leg along s (..., 3), from its universal joint.  (...,) each."""
    # with the axes U = [a, y, a x y] of home, n = Rot(a, fork) Rot(y, cross) n_home
    a = frame.R_WS @ frame.axis_S
    U = np.stack([a, frame.R_WS[:, 1], np.cross(a, frame.R_WS[:, 1])], 1)
    d, d_home = s @ U, (frame.p_WB - frame.p_WA) @ U
    fork = np.arctan2(-d[..., 1], d[..., 2])
    return fork, np.arctan2(d[..., 0], np.hypot(d[..., 1], d[..., 2])) - np.arctan2(d_home[0], d_home[2])


def hexapod_positions(machine, poses) -> np.ndarray:
    """x y z, quaternion from home, and fork, cross, length of every strut.  (..., 6) -> (..., 25)."""
    out, R_WT = _turned(machine, poses)
    joints = machine.platform_joints_np()
    for i in range(6):
        frame = strut_frame(machine, i)
        s = poses[..., :3] + R_WT @ joints[i] - frame.p_WA
        out.append(np.stack([*_universal(frame, s), np.linalg.norm(s, axis=-1)], -1))
    return np.concatenate(out, -1)


def hexaglide_positions(machine, poses) -> np.ndarray:
    """x y z, quaternion from home, and place, fork, cross of every leg.  (..., 6) -> (..., 25)."""
    out, R_WT = _turned(machine, poses)
    q, joints = machine.inverse_kinematics(poses), machine.platform_joints_np()
    for i in range(6):
        S = machine.rails.point[i] + q[..., i, None] * machine.rails.direction[i]
        s = poses[..., :3] + R_WT @ joints[i] - S
        out.append(np.stack([q[..., i], *_universal(leg_frame(machine, i), s)], -1))
    return np.concatenate(out, -1)


def tripod_positions(machine, x) -> np.ndarray:
    """x y z, quaternion from home, and S_i, theta_i of every link, at tips x.  (..., 3) -> (..., 13)."""
    z, (_, quat) = machine.standing(x), _turned(machine, machine.tool_pose(x))[0]
    return np.concatenate([x, quat, *[np.stack([z[..., i], z[..., 3 + i]], -1) for i in range(3)]], -1)
