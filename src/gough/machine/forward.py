"""Forward kinematics on arrays: Newton's method on SO(3), and no answer that is not checked.

    r = q - q(z),   J d = r,   z <- p + d_v, exp(d_w) R                                                             (1)

The step d is a twist increment; adding its rotation to roll, pitch and yaw instead is what makes the usual hexapod
kinematics diverge beyond 55 degrees.  A machine may give another system with the same answer, which has a step where
q(z) has none (`Machine.newton_system`).  Far from the answer the step is shortened to 0.3 rad and `Machine.stride_of`,
a quarter of a leg or so, so that a start from home does not jump over a singularity into another assembly mode; if it
still ends in one, det J has changed its sign, or the pose lies outside limits or workspace, and the answer is refused.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from ..errors import ExperimentError, KinematicsError
from . import workspace
from .arrays import column

RESIDUAL = 1e-10  # m; a tenth of what the pose is promised to, times the least gain of J
ITERATIONS = 60
BLOCK = 8192  # rows at a time: what is between the steps stays in the cache, and the memory is that of the answers
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
    x, status = np.empty((len(rows), d)), np.empty(len(rows), int)
    for k in range(0, len(rows), BLOCK):
        part = slice(k, k + BLOCK)
        x[part], status[part] = _block(machine, rows[part], x0[part])[:2]
    bad = np.flatnonzero(status)
    if on_fail == "nan":
        x[bad] = np.nan
        return x.reshape(q.shape[:-1] + (d,)), status.reshape(q.shape[:-1])
    if len(bad):
        row = int(bad[0])
        _refuse(machine, q.shape[:-1], row, *_block(machine, rows[row : row + 1], x0[row : row + 1]))
    return x.reshape(q.shape[:-1] + (d,))


def _block(machine, q, x0):
    """Some rows: pose (N, d), status (N,), and why, residual, steps, margins of each for the message."""
    possible, why = impossible(machine, q)
    z, steps = newton(machine, q, x0, possible)
    x, residual, margins = machine.arrays.run("landing", z, q)
    residual = np.where(np.isfinite(residual[:, 0]), residual[:, 0], np.inf)
    inside = margins >= 0
    status = np.where(possible, 0, 1)
    status[possible & ~(residual <= RESIDUAL)] = 2
    good = status == 0
    status[good & ~(margins[:, -1] > -machine.limits.determinant)] = 3  # the last margin is det J / home's - least
    status[(status == 0) & ~inside.all(-1)] = 4
    return x, status, why, residual, steps, margins


def impossible(machine, q):
    """Rows (N,) of joint coordinates that some pose may have, and why the others cannot: {row: reason}."""
    finite = np.isfinite(q).all(-1)
    fits, why = machine.possible(np.where(np.isfinite(q), q, 1.0))
    fits = fits & finite
    reasons = {}
    for row in np.flatnonzero(~fits)[:1]:
        if finite[row]:
            reasons[row] = why(row)
        else:
            reasons[row] = "must be finite", machine.joint_names[int(np.flatnonzero(~np.isfinite(q[row]))[0])]
    return fits, reasons


def newton(machine, q, x0, run):
    """Eq. (1) on the rows where `run`.  (N, n), (N, d) -> z (N, len(z)), iterations (N,)."""
    (z,) = machine.arrays.run("coordinates", x0, checked=False)
    nowhere = ~np.isfinite(z).all(-1)  # no start at all: where dependent coordinates have none, home is as good
    if nowhere.any():
        z[nowhere] = machine.coordinates(machine.home)
    steps = np.zeros(len(q), int)
    reach = float(ca.evalf(ca.SX(machine.stride_of(machine))))
    active = np.flatnonzero(run)
    at, goal = z[active], q[active]
    for _ in range(ITERATIONS):
        if not len(active):
            break
        at, size = machine.arrays.run("newton", at, goal)
        steps[active] += 1
        # a step below 1e-13 moved the last digits only; where J is singular no step was taken
        going = size[:, 0] > 1e-13 * max(1.0, reach)
        if not going.all():
            z[active[~going]] = at[~going]
            active, at, goal = active[going], at[going], goal[going]
    z[active] = at
    return z, steps


def _refuse(machine, lead, index, x, status, why, residual, steps, margins):
    """Raise for row `index`, of which the rest tells, each (1, ...)."""
    row, status = 0, int(status[0])
    place = f"index {list(map(int, np.unravel_index(index, lead)))}" if lead else None
    if status == 1:
        rule, joint = why[row]
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
    declared = len(workspace.space_names(machine))
    if worst < declared:
        raise workspace.outside_workspace(machine, worst, margins[row, worst], place)
    raise workspace.beyond(machine, worst - declared, margins[row, worst], place)
