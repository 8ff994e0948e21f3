"""Where a pose stands within the limits: stroke, cones, singularity, and the declared workspace."""

from __future__ import annotations

import casadi as ca
import numpy as np

from .. import frames
from ..errors import SingularityError, WorkspaceError
from ..frames import abc_of_rotation_np, quaternion_of_abc_np, rotation_of_quaternion_np, rotation_of_vector_np


def space_names(machine) -> tuple[str, ...]:
    """What each column of `workspace_margins` says when it is negative."""
    space = machine.limits.workspace
    if space is None:
        return ()
    across = ("radius",) if space.size is None else ("length", "width")
    return (
        *(f"beyond the {name} of the workspace" for name in (*across, "height")),
        "tilted beyond the workspace",
        "turned beyond the workspace",
    )


def margin_names(machine) -> tuple[str, ...]:
    """What each column of `margins` says when it is negative; det J is the last."""
    return space_names(machine) + machine.limit_names


def margins(machine, z) -> np.ndarray:
    """All limits of coordinates z (N, 7); inside where >= 0.  (N, m), columns as `margin_names`."""
    z = np.atleast_2d(z)
    return np.concatenate([workspace_margins(machine, z), machine.arrays.run("margins", z)[0]], -1)


def workspace_margins(machine, z) -> np.ndarray:
    """The declared workspace at coordinates z (N, 7), in m and rad; inside where >= 0.

    (N, k), columns as `space_names`: radius (of a box length and width), height, tilt, turn; (N, 0) without one.
    """
    if machine.limits.workspace is None:
        return np.zeros((len(z), 0))
    return machine.arrays.run("workspace", z)[0]


def workspace_of(machine, p, z):
    """The same of the view `p` of `machine`, symbolic.  (len(z),) -> (k,)."""
    space, home = p.limits.workspace, ca.SX(p.home)
    if space is None:
        return ca.SX(0, 1)
    position, quat = machine.tool_pose_of(p, z)
    R_home, R = machine.home_rotation(p), frames.rotation_of_quaternion(quat)
    home_c = home[5] if home.shape[0] == 6 else frames.abc_of_rotation(R_home)[2]
    turn = frames.abc_of_rotation(R)[2] - home_c
    turn = ca.fabs(turn - 2 * np.pi * ca.floor((turn + np.pi) / (2 * np.pi)))
    # the angle by atan2 of sine and cosine: arccos alone loses half the digits near zero
    sine = ca.norm_2(ca.cross(R[:, 2], R_home[:, 2]))
    tilt = ca.atan2(sine, ca.dot(R[:, 2], R_home[:, 2]))
    offset = position - home[:3]
    if machine.limits.workspace.middle is not None:
        offset -= space.middle
    across = space.radius - ca.norm_2(offset[:2]) if space.size is None else space.size / 2 - ca.fabs(offset[:2])
    inside = ca.vertcat(across, space.height / 2 - ca.fabs(offset[2]), space.tilt - tilt, space.c - turn)
    return inside + 1e-9  # a pose on the very edge is inside, whatever the last digits say


def outside_workspace(machine, index: int, margin: float, place: str | None) -> WorkspaceError:
    """The error that the declared workspace is exceeded by -margin in `index` of `workspace_margins`."""
    space = machine.limits.workspace
    across = [space.radius] if space.size is None else list(space.size / 2)
    bound = (*across, space.height / 2, space.tilt, space.c)[index]
    shown = [f"{v:.6g} m" if index <= len(across) else f"{np.degrees(v):.4g} deg" for v in (bound - margin, bound)]
    cure = "move the work (origin), or declare a larger limits.workspace"
    return WorkspaceError(space_names(machine)[index], where=place, value=shown[0], limit=shown[1], cure=cure)


def check_poses(machine, x, place=lambda row: f"index {row}", thin: int = 1) -> tuple[int, float]:
    """Refuse poses (N, d) outside the limits or near a singularity; the workspace is not asked.

    The row with the largest condition number of J that was looked at, and that number.

    `place(row)` names a row for the message: an NC line and a time.  The condition number, which costs ten times the
    rest together, is taken of one row in `thin`: along a path it changes slowly.

    Raises
    ------
    WorkspaceError, SingularityError
        for the first such row, with the joint and by how much.
    """
    x = np.atleast_2d(x)
    found = machine.arrays.run("margins", machine.standing(x))[0]
    outside = ~(found >= 0)
    beyond_limits = np.flatnonzero(outside.any(-1))
    sample = np.arange(0, len(x), thin)
    unreachable = machine.unreachable(x) if len(beyond_limits) else None
    if unreachable is not None:  # J stops at the first pose without joint coordinates
        sample = sample[sample < beyond_limits[0]]
    number = condition(machine, machine.jacobian(x[sample]))
    singular = np.flatnonzero(~(number <= machine.limits.condition))
    if len(singular) and not (len(beyond_limits) and beyond_limits[0] <= sample[singular[0]]):
        raise SingularityError(
            "near a singularity: condition number of J",
            where=place(int(sample[singular[0]])),
            value=f"{number[singular[0]]:.3g}",
            limit=f"{machine.limits.condition:g}",
            cure=_CURE,
        )
    if len(beyond_limits):
        row = int(beyond_limits[0])
        worst = int(np.argmax(outside[row]))
        if unreachable is not None and unreachable[0] == row and np.isnan(found[row, worst]):
            raise unreachable[1].at(where=place(row))
        raise beyond(machine, worst, found[row, worst], place(row))
    largest = int(np.argmax(number))
    return int(sample[largest]), float(number[largest])


_CURE = "move the work (origin), or change the limits of the machine"


def beyond(machine, index: int, margin: float, place: str | None, time: float | None = None):
    """The error that the limit `index` of `Machine.margins` is exceeded by -margin."""
    rule, value, limit = machine.limit_told(index, margin)
    kind = SingularityError if machine.limit_names[index].startswith("near a singularity") else WorkspaceError
    return kind(rule, where=place, value=value, limit=limit, time=time, cure=_CURE)


def condition(machine, J) -> np.ndarray:
    """Condition number of J (..., n, d), its rotation columns divided by the platform's radius (rms).  (...)."""
    if J.shape[-1] in (1, 3):
        return np.linalg.cond(J)
    B = machine.joints.platform
    radius = np.sqrt(((B - B.mean(0)) ** 2).sum(-1).mean())
    return np.linalg.cond(J / np.r_[1, 1, 1, radius, radius, radius])


def random_poses(machine, count: int, rng: np.random.Generator) -> np.ndarray:
    """Poses uniform in the declared workspace, kept where stroke, cones and det J allow.  (count, d).

    Raises
    ------
    WorkspaceError
        no workspace is declared, or less than a thousandth of it is within the other limits.
    """
    space, home = machine.limits.workspace, machine.home
    if space is None:
        raise WorkspaceError("the machine declares no workspace", cure="give limits.workspace")
    kept, turns = np.zeros((0, len(home))), len(home) == 6  # else tilt and turn follow from the place
    R_home = rotation_of_quaternion_np(quaternion_of_abc_np(home[3:] if turns else np.zeros(3)))
    tried = 0
    while len(kept) < count:
        n = 2 * count + 1000
        if tried > 1000 * (len(kept) + 1):
            raise WorkspaceError(
                "hardly a pose of the declared workspace is within the other limits", where="limits.workspace",
                value=f"{len(kept)} of {tried} poses", cure="make the workspace smaller, or length and cone wider",
            )  # fmt: skip
        tried += n
        if space.size is None:
            r, phi = space.radius * np.sqrt(rng.random(n)), rng.uniform(0, 2 * np.pi, n)
            across = [r * np.cos(phi), r * np.sin(phi)]
        else:
            across = list(rng.uniform(-0.5, 0.5, (2, n)) * space.size[:, None])
        tilt, about = space.tilt * np.sqrt(rng.random(n)), rng.uniform(0, 2 * np.pi, n)
        zero = np.zeros(n)
        lean = rotation_of_vector_np(np.stack([tilt * np.cos(about), tilt * np.sin(about), zero], -1))
        spin = rotation_of_vector_np(np.stack([zero, zero, rng.uniform(-space.c, space.c, n)], -1))
        abc = abc_of_rotation_np(lean @ R_home @ spin)
        height = rng.uniform(-0.5, 0.5, n) * space.height
        middle = home[:3] if space.middle is None else home[:3] + space.middle
        x = np.concatenate([middle + np.stack([*across, height], -1), abc], -1)[:, : len(home)]
        kept = np.concatenate([kept, x[(margins(machine, machine.standing(x)) >= 0).all(-1)]])
    return kept[:count]
