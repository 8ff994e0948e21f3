"""Where the struts of an exported model stand: their frames at home, and its coordinates at any pose.

The frames S are eq. (1) of mjcf.py; n = Rot(a, fork) Rot(y_S, cross) n_home gives the two angles of a universal joint.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .. import frames


class Frame(NamedTuple):
    """Where a strut stands at home, in W."""

    p_WA: np.ndarray  # (3,) m
    p_WB: np.ndarray  # (3,) m
    length: float  # m
    R_WS: np.ndarray  # (3, 3), eq. (1)
    axis_S: np.ndarray  # (3,), the base joint's own axis a, in S


def strut_frame(machine, i: int) -> Frame:
    """Where strut i stands at home, eq. (1).

    Without a base axis the struts have no axial inertia and their spin does not matter: any axis across the strut
    serves.
    """
    R_WT = frames.rotation_of_abc_np(machine.home[3:])
    A = machine.joints.base[i]
    B = machine.home[:3] + R_WT @ machine.platform_joints_np()[i]
    length = float(np.linalg.norm(B - A))
    n = (B - A) / length
    if machine.joints.base_axis is None:
        a = np.cross(n, np.eye(3)[np.argmin(np.abs(n))])
    else:
        a = machine.joints.base_axis[i]
    a = a / np.linalg.norm(a)
    y = np.cross(n, a)
    y /= np.linalg.norm(y)
    R_WS = np.stack([np.cross(y, n), y, n], 1)
    return Frame(A, B, length, R_WS, R_WS.T @ a)


def positions(machine, poses) -> np.ndarray:
    """`qpos` of the exported model at poses x y z a b c of T: loops closed to rounding.  (..., 6) -> (..., 25).

    Pinocchio writes the quaternion, entries 3 to 6, with w last.
    """
    poses = np.asarray(poses, float)
    R_home = frames.rotation_of_abc_np(machine.home[3:])
    R_WT = frames.rotation_of_abc_np(poses[..., 3:])
    out = [poses[..., :3], frames.quaternion_of_rotation_np(R_home.T @ R_WT)]
    joints = machine.platform_joints_np()
    for i in range(6):
        frame = strut_frame(machine, i)
        s = poses[..., :3] + R_WT @ joints[i] - frame.p_WA
        # with the axes U = [a, y, a x y] of home, n = Rot(a, fork) Rot(y, cross) n_home
        a = frame.R_WS @ frame.axis_S
        U = np.stack([a, frame.R_WS[:, 1], np.cross(a, frame.R_WS[:, 1])], 1)
        d, d_home = s @ U, (frame.p_WB - frame.p_WA) @ U
        fork = np.arctan2(-d[..., 1], d[..., 2])
        cross = np.arctan2(d[..., 0], np.hypot(d[..., 1], d[..., 2])) - np.arctan2(d_home[0], d_home[2])
        out.append(np.stack([fork, cross, np.linalg.norm(s, axis=-1)], -1))
    return np.concatenate(out, -1)
