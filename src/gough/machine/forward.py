"""Forward kinematics on arrays: Newton's method on SO(3), and no answer that is not checked.

    r = q - q(z),   J d = r,   z <- p + d_v, exp(d_w) R                                                             (1)

The step d is a twist increment; adding its rotation to roll, pitch and yaw instead is what makes the usual hexapod
kinematics diverge beyond 55 degrees.  Far from the answer the step is shortened to 0.3 rad and a quarter of a strut,
so that a start from home does not jump over a singularity into another assembly mode; if it still ends in one, det J
has changed its sign, or the pose lies outside limits or workspace, and the answer is refused.
"""

from __future__ import annotations

import numpy as np

from ..errors import ExperimentError, KinematicsError
from ..frames import abc_of_rotation_np, quaternion_of_abc_np, rotation_of_quaternion_np
from . import workspace
from .arrays import column

RESIDUAL = 1e-10  # m; a tenth of what the pose is promised to, times the least gain of J
ITERATIONS = 60
STATUS = ("ok", "impossible joint coordinates", "no convergence", "another assembly mode", "outside the limits")


def forward_kinematics(machine, q, near=None, on_fail="raise"):
    """See `Machine.forward_kinematics`."""
    if on_fail not in ("raise", "nan"):
        raise ExperimentError('on_fail must be "raise" or "nan"', value=repr(on_fail))
    q = np.asarray(q, float)
    n, d = machine.joints_count, len(machine.task)
    if q.ndim == 0 or q.shape[-1] != n:
        raise ExperimentError(f"joint coordinates must have shape (..., {n})", value=str(q.shape))
    start = np.broadcast_to(column(machine.home if near is None else near, d, "near"), q.shape[:-1] + (d,))
    rows, x0 = q.reshape(-1, n), start.reshape(-1, d)
    possible, why = impossible(machine, rows)
    z, residual, steps = newton(machine, rows, x0, possible)
    x = np.concatenate([z[:, :3], abc_of_rotation_np(rotation_of_quaternion_np(z[:, 3:]))], -1)
    status = np.where(possible, 0, 1)
    status[(status == 0) & ~(residual <= RESIDUAL)] = 2
    good = status == 0
    margins = np.full((len(rows), len(workspace.margin_names(machine))), np.nan)
    if good.any():
        margins[good] = workspace.margins(machine, z[good])
    status[good & ~(margins[:, -1] > -machine.limits.determinant)] = 3  # the last margin is det J / home's - least
    status[(status == 0) & ~(margins >= 0).all(-1)] = 4
    bad = np.flatnonzero(status)
    if on_fail == "nan":
        x[bad] = np.nan
        return x.reshape(q.shape[:-1] + (d,)), status.reshape(q.shape[:-1])
    if len(bad):
        _refuse(machine, q.shape[:-1], int(bad[0]), status[bad[0]], why, residual, steps, margins, x)
    return x.reshape(q.shape[:-1] + (d,))


def impossible(machine, q):
    """Rows (N,) of joint coordinates that some pose may have, and why the others cannot: {row: reason}."""
    reasons = {}
    finite = np.isfinite(q).all(-1)
    positive = finite & (np.where(np.isfinite(q), q, 1) > 0).all(-1)
    # two struts and the chords between their joints close a quadrangle: |l_i - l_j| <= |A_i A_j| + |B_i B_j|
    A, B = machine.joints.base, machine.joints.platform
    reach = np.linalg.norm(A[:, None] - A, axis=-1) + np.linalg.norm(B[:, None] - B, axis=-1)
    l = np.where(positive[:, None], q, 0)
    gap = np.abs(l[:, :, None] - l[:, None, :]) - reach
    fits = positive & ~(gap > 0).any((1, 2))
    for row in np.flatnonzero(~fits)[:1]:
        if not finite[row]:
            reasons[row] = ("must be finite", machine.joint_names[int(np.flatnonzero(~np.isfinite(q[row]))[0])], row)
        elif not positive[row]:
            reasons[row] = ("must be above 0 m", machine.joint_names[int(np.flatnonzero(q[row] <= 0)[0])], row)
        else:
            i, j = np.argwhere(gap[row] > 0)[0]
            pair = f"{machine.joint_names[i]} and {machine.joint_names[j]}"
            reasons[row] = (f"lengths differ by more than their joints allow ({reach[i, j]:.4g} m)", pair, row)
    return fits, reasons


def newton(machine, q, x0, run):
    """Eq. (1) on the rows where `run`.  (N, n), (N, d) -> z (N, 7), residual (N,) m, iterations (N,)."""
    z = np.concatenate([x0[:, :3], quaternion_of_abc_np(x0[:, 3:])], -1)
    residual, steps = np.full(len(q), np.inf), np.zeros(len(q), int)
    active = np.flatnonzero(run)
    reach = 0.25 * np.linalg.norm(machine.joints.base - machine.joints.platform, axis=-1).max()
    for _ in range(ITERATIONS):
        if not len(active):
            break
        l, J = machine.arrays.run("newton", z[active])
        r = q[active] - l
        d = solve_rows(J.reshape(-1, 6, 6), r)
        d[~np.isfinite(d).all(-1)] = 0  # J is singular there: the search ends where it stands
        residual[active] = np.abs(r).max(-1)
        steps[active] += 1
        size = np.maximum(np.linalg.norm(d[:, :3], axis=-1) / reach, np.linalg.norm(d[:, 3:], axis=-1) / 0.3)
        d /= np.maximum(size, 1)[:, None]
        z[active] = stepped(z[active], d)
        # a step below 1e-13 moved the last digits only
        active = active[np.abs(d).max(-1) > 1e-13 * max(1.0, reach)]
    finite = np.isfinite(z).all(-1) & run
    if finite.any():
        l, _ = machine.arrays.run("newton", z[finite])
        residual[finite] = np.abs(q[finite] - l).max(-1)
    residual[~finite] = np.inf
    return z, residual, steps


def solve_rows(J, r):
    """x with J x = r row by row; NaN where J is exactly singular.  (N, 6, 6), (N, 6) -> (N, 6)."""
    try:
        return np.linalg.solve(J, r[..., None])[..., 0]
    except np.linalg.LinAlgError:
        singular = np.linalg.det(J) == 0
        x = np.full(r.shape, np.nan)
        x[~singular] = np.linalg.solve(J[~singular], r[~singular][..., None])[..., 0]
        return x


def stepped(z, d):
    """z (N, 7) moved by twist increments d (N, 6): a step on SO(3)."""
    angle = np.linalg.norm(d[:, 3:], axis=-1, keepdims=True)
    w, u = np.cos(angle / 2), np.sinc(angle / (2 * np.pi)) / 2 * d[:, 3:]
    s, t = z[:, 3:4], z[:, 4:]
    quat = np.concatenate([w * s - (u * t).sum(-1, keepdims=True), w * t + s * u + np.cross(u, t)], -1)
    return np.concatenate([z[:, :3] + d[:, :3], quat / np.linalg.norm(quat, axis=-1, keepdims=True)], -1)


def _refuse(machine, lead, row, status, why, residual, steps, margins, x):
    place = f"index {list(map(int, np.unravel_index(row, lead)))}" if lead else None
    if status == 1:
        rule, joint, _ = why[row]
        raise KinematicsError(f"{joint} {rule}", where=place, cure="check unit and order of the joint coordinates")
    if status == 2:
        raise KinematicsError(
            "forward kinematics found no pose",
            where=place,
            value=f"residual {residual[row]:.3g} m after {steps[row]} iterations, "
            f"nearest pose {np.round(x[row], 6).tolist()}",
            limit=f"{RESIDUAL:g} m",
            cure="give a start nearer to the pose (near=...)",
        )
    if status == 3:
        raise KinematicsError(
            "forward kinematics ended in another assembly mode",
            where=place,
            value=f"det J = {margins[row, -1] + machine.limits.determinant:.3g} of home's",
            cure="give a start nearer to the pose (near=...)",
        )
    worst = int(np.argmin(margins[row]))
    declared = 4 if machine.limits.workspace else 0
    if worst < declared:
        raise workspace.outside_workspace(machine, worst, margins[row, worst], place)
    raise workspace.beyond(machine, worst - declared, margins[row, worst], place)
