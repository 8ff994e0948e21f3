"""What a motion that is only planned would show: one row of the regressor and of the limits, as functions of a pose.

A row is what one moment of a Fourier motion makes of

    w = [p, p', p'', abc, abc', abc'']      (18), in the program's frame, whose zero is the machine's home
    X = Y_base S                            (joints r): the base columns of the regressor, times the parameters' sizes
    g                                       >= 0 within every limit, each as a share of what it may be

Coulomb friction is tanh(q' / v_0) here, so that it has a derivative.
"""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca
import numpy as np

from .. import frames
from ..errors import ExperimentError
from ..kernel.building import BUILDING
from ..machine.arrays import row_function
from ..machine.base import Machine
from ..machine.drives import force_limit
from ..machine.workspace import random_poses, workspace_of
from . import joint_torque
from .base import base_parameters, sizes
from .rows import Rows, friction_columns, loaded_kinds, normal_forces, rows_of_motion

SMOOTH = 0.02  # of a joint's greatest speed
_POSES = 150  # of the structural regressor: 900 forces for some 30 columns


class Design(NamedTuple):
    """The row function of a machine, and which columns it has."""

    row: ca.Function  # w -> X (n, r), g (m,)
    limits: tuple[str, ...]  # what g is about
    kept: np.ndarray  # (r,) columns of the regressor with friction
    size: np.ndarray  # (p,)
    names: tuple[str, ...]  # (p,)


def speed_of(machine: Machine) -> float:
    """The greatest speed of a joint that a motion may use: limits.speed, else that of rapids.  m/s."""
    return machine.limits.speed or machine.feed.rapid


def acceleration_of(machine: Machine) -> float:
    """The same of acceleration: limits.acceleration, else along the path.  m/s2."""
    return machine.limits.acceleration or machine.feed.acceleration


def random_rows(machine: Machine, friction=("coulomb", "viscous"), seed: int = 0) -> Rows:
    """Rows of random states in the workspace: what any motion could show.  Forces are 0."""
    rng = np.random.default_rng(seed)
    d, n = len(machine.task), machine.joints_count
    if machine.limits.workspace is None:
        x = np.asarray(machine.home, float) + rng.uniform(-0.05, 0.05, (_POSES, d))  # 50 mm, 3 deg
    else:
        x = random_poses(machine, _POSES, rng)[:, :d]
    # the tip as fast as the joints may be; turning at what does the same 0.3 m away
    scale = np.where([unit == "rad" for _, unit in machine.task], 3.0, 1.0)
    xd = speed_of(machine) / 2 * scale * rng.standard_normal((_POSES, d))
    xdd = acceleration_of(machine) / 2 * scale * rng.standard_normal((_POSES, d))
    return rows_of_motion(machine, x, xd, xdd, np.zeros((_POSES, n)), friction)


def structural(machine: Machine, friction=("coulomb", "viscous")):
    """(BaseParameters, sizes (p,), Rows) of all that any motion of the machine can show."""
    rows = random_rows(machine, friction)
    size = sizes(rows.names, rows.units, rows.values, np.ones(len(rows.names)))
    force = rows.Y[..., : len(machine.parameters.names)] @ machine.parameters.values
    level = np.sqrt(np.mean(force**2)) or 1.0
    columns = np.sqrt(np.mean(rows.Y**2, axis=(0, 1)))
    fallback = np.where(columns > 0, 0.1 * level / np.where(columns > 0, columns, 1.0), 1.0)
    size = sizes(rows.names, rows.units, rows.values, fallback)
    return base_parameters(rows.Y.reshape(-1, len(size)) * size, rows.names, rows.units, size, noise=False), size, rows


def design_of(
    machine: Machine,
    sought: np.ndarray | None = None,
    friction=("coulomb", "viscous"),
    tool_speed: float | None = None,
) -> Design:
    """The row function of a machine for the base columns of what is `sought` (p,) bool (default: all).

    `tool_speed` m/s is the greatest speed of the tool's tip; else the machine's feed.rapid.
    """
    with BUILDING:
        return _design(machine, sought, friction, tool_speed or machine.feed.rapid)


def _design(machine, sought, friction, tool_speed: float) -> Design:
    if joint_torque.KIND in friction:
        raise ExperimentError("no motion is designed for torques of base joints", key="friction")
    found, size, rows = structural(machine, friction)
    if sought is not None:
        flat = rows.Y.reshape(-1, len(size)) * np.where(sought, size, 0.0)
        found = base_parameters(flat, rows.names, rows.units, size, noise=False)
    w = ca.SX.sym("w", 18)
    x, xd, xdd = _motion(machine, w)
    regressor = row_function("regressor", machine)
    flat, _, qd = regressor(machine.theta, x, xd, xdd)
    n, own = machine.joints_count, len(machine.parameters.names)
    sign = ca.tanh(qd / (SMOOTH * speed_of(machine)))
    loads = normal_forces(machine, machine, x, xd, xdd) if loaded_kinds(machine, friction) else None
    Y = [ca.reshape(flat, own, n).T]
    for value, one in friction_columns(machine, friction, sign, qd, loads):
        value = ca.SX.ones(n) if value is None else value
        Y.append(value if one else ca.diag(value))
    Y = ca.horzcat(*Y)
    X = Y[:, found.kept.tolist()] @ ca.diag(ca.DM(size[found.kept]))
    force = Y @ ca.DM(rows.values)
    names, g = _limits(machine, x, xd, xdd, qd, force)
    names, g = (*names, "tool: speed"), ca.vertcat(g, 1 - ca.sumsqr(w[3:6]) / tool_speed**2)
    row = ca.Function("row", [w], [ca.densify(X), ca.densify(g)], ["w"], ["X", "g"])
    return Design(row, names, found.kept, size, rows.names)


def _motion(machine, w):
    """x, xd, xdd (d,) of a moment w of a motion about home; eq. (1) of program/tool_motion.py."""
    d = len(machine.task)
    pose = np.asarray(machine.tool_pose(np.asarray(machine.home, float)), float)
    R = frames.rotation_of_abc_np(pose[3:])
    p, pd, pdd, abc, rate, acc = ca.vertsplit(w, 3)
    E = _rates(abc)
    Ed = ca.jacobian(ca.vec(E), abc) @ rate
    spin, spin_d = E @ rate, E @ acc + ca.reshape(Ed, 3, 3) @ rate
    R = ca.DM(R)
    angles = abc if np.array_equal(np.array(R), np.eye(3)) else frames.abc_of_rotation(R @ frames.rotation_of_abc(abc))
    x = ca.vertcat(ca.DM(pose[:3]) + R @ p, angles)
    return x[:d], ca.vertcat(R @ pd, R @ spin)[:d], ca.vertcat(R @ pdd, R @ spin_d)[:d]


def _rates(abc):
    """E of w = E [a' b' c'], as frames.abc_rate_matrix_np.  (3, 3)."""
    cb, sb, cc, sc = ca.cos(abc[1]), ca.sin(abc[1]), ca.cos(abc[2]), ca.sin(abc[2])
    return ca.horzcat(ca.vertcat(cc * cb, sc * cb, -sb), ca.vertcat(-sc, cc, 0), ca.vertcat(0, 0, 1))


def _limits(machine, x, xd, xdd, qd, force):
    """Names and values (m,) of all that must be >= 0, as shares of what each may be."""
    p, z = machine, machine.coordinates_of(machine, x)
    z_home = machine.coordinates_of(machine, ca.DM(np.asarray(machine.home, float)))
    names, parts = [], []
    space = workspace_of(machine, p, z)
    if space.numel():
        bound = np.array(ca.evalf(ca.SX(workspace_of(machine, p, z_home)))).ravel()
        names += [f"workspace {i + 1}" for i in range(len(bound))]
        parts.append(space / ca.DM(np.where(bound > 1e-6, bound, 1.0)))
    told, margin = machine.margins(p, z)
    bound = np.array(ca.evalf(ca.SX(machine.margins(p, z_home)[1]))).ravel()
    names += told
    parts.append(margin / ca.DM(np.where(bound > 1e-9, bound, 1.0)))
    speed, acceleration = speed_of(machine), acceleration_of(machine)
    qdd = machine.joint_acceleration(p, z, xd, xdd)
    for what, value, most in (
        ("speed", qd, speed),
        ("acceleration", qdd, acceleration),
        ("force", force, _most(machine)),
    ):
        if most is not None:
            names += [f"{joint}: {what}" for joint in machine.joint_names]
            parts.append(1 - (value / most) ** 2)
    return tuple(names), ca.vertcat(*map(ca.SX, parts))


def _most(machine) -> float | None:
    """The greatest force of a drive.  N."""
    limit = force_limit(machine.drive)
    return None if limit is None else float(limit)
