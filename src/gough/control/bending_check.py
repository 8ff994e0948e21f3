"""Whether a flexible machine can put its tool where a motion wants it, and whether a law knows how: before a run."""

from __future__ import annotations

import numpy as np

from .. import frames
from ..errors import ExperimentError, KinematicsError, WorkspaceError
from ..machine.base import Machine
from .bending import Bends, shift_at
from .elastic_map import ElasticMap

PLACES = 40  # of a motion, compared with the exact statics: some 20 ms each


def target_shift(machine: Machine, target) -> np.ndarray:
    """d at one target x (len(task),), by the exact statics.  (len(task),) m, rotation vector in W.

    Raises
    ------
    ExperimentError
        as many numbers as the task has not.
    KinematicsError
        no convergence, with what is left.
    WorkspaceError, SingularityError
        the target is unreachable under gravity.
    """
    x = np.asarray(target, float)
    if x.shape != (len(machine.task),):
        names = " ".join(name for name, _ in machine.task)
        raise ExperimentError(
            "must have as many numbers as the task of the machine", key="target", value=str(len(x)),
            limit=f"{len(machine.task)}: {names}",
        )  # fmt: skip
    q = machine.flexible().targets(x)
    return away(machine.forward_kinematics(q, near=x), x)


def away(x_c: np.ndarray, x: np.ndarray) -> np.ndarray:
    """d from x to x_c: of six coordinates the last three a rotation vector in W.  (len(x),)."""
    if len(x) != 6:
        return x_c - x
    R_c, R = (frames.rotation_of_abc_np(one[3:]) for one in (x_c, x))
    return np.concatenate([x_c[:3] - x[:3], frames.rotation_vector_np(R_c @ R.T)])


def check_places(machine: Machine, bends: Bends, motion, period: float, tolerance: float) -> float:
    """Compare d along a motion with the exact statics; the greatest distance, m.

    Raises
    ------
    WorkspaceError, SingularityError
        the target is unreachable under gravity; a place outside of what the polynomials were fitted to.
    KinematicsError
        no convergence, of the statics or of d to them, with what is left.
    """
    count = motion.count(period)
    rows = np.unique(np.linspace(0, count - 1, PLACES).astype(int))
    x = np.concatenate([motion.sample(k, k + 1, period).x for k in rows])
    if isinstance(bends, ElasticMap) and not bends.inside(x).all():
        k = int(np.argmin(bends.inside(x)))
        at = " ".join(f"{1e3 * v:.4g}" for v in x[k, :3])
        raise WorkspaceError(
            "outside of the places for which gravity is known", where=f"t = {rows[k] * period:.4g} s", value=f"{at} mm",
            cure="make limits.workspace of the machine larger",
        )  # fmt: skip
    said, flexible, worst = shift_at(machine, bends, x), machine.flexible(), 0.0
    for k, place, d in zip(rows, x, said, strict=True):
        exact = away(machine.forward_kinematics(flexible.targets(place), near=place), place)
        left = float(np.linalg.norm((exact - d)[:3]))
        worst = max(worst, left)
        if not left <= tolerance:
            raise KinematicsError(
                "no convergence to the exact statics", where=f"t = {k * period:.4g} s", value=f"{left:.3g} m left",
                limit=f"tolerance {tolerance:g} m", cure="give a larger degree, or tolerance",
            )  # fmt: skip
    return worst
