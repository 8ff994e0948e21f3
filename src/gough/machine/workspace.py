"""Where a pose stands within the limits: stroke, cones, singularity, and the declared workspace."""

from __future__ import annotations

import numpy as np

from ..errors import SingularityError, WorkspaceError
from ..frames import abc_of_rotation_np, quaternion_of_abc_np, rotation_of_quaternion_np, rotation_of_vector_np

_WORKSPACE = (
    "beyond the radius of the workspace",
    "beyond the height of the workspace",
    "tilted beyond the workspace",
    "turned beyond the workspace",
)


def margin_names(machine) -> tuple[str, ...]:
    """What each column of `margins` says when it is negative; det J is the last."""
    return (_WORKSPACE if machine.limits.workspace else ()) + machine.limit_names


def margins(machine, z) -> np.ndarray:
    """All limits of coordinates z (N, 7); inside where >= 0.  (N, m), columns as `margin_names`."""
    z = np.atleast_2d(z)
    found = machine.arrays.run("margins", z)[0]
    space = machine.limits.workspace
    if space is None:
        return found
    home = machine.home
    R_home = rotation_of_quaternion_np(quaternion_of_abc_np(home[3:]))
    R = rotation_of_quaternion_np(z[:, 3:])
    turn = abc_of_rotation_np(R)[:, 2] - home[5]
    turn = np.abs((turn + np.pi) % (2 * np.pi) - np.pi)
    # the angle by atan2 of sine and cosine: arccos alone loses half the digits near zero
    sine = np.linalg.norm(np.cross(R[:, :, 2], R_home[:, 2]), axis=-1)
    tilt = np.arctan2(sine, R[:, :, 2] @ R_home[:, 2])
    offset = z[:, :3] - home[:3]
    slack = 1e-9  # a pose on the very edge is inside, whatever the last digits say
    inside = [
        space.radius - np.hypot(offset[:, 0], offset[:, 1]),
        space.height / 2 - np.abs(offset[:, 2]),
        space.tilt - tilt,
        space.c - turn,
    ]
    return np.concatenate([np.stack(inside, -1) + slack, found], -1)


def check_poses(machine, x, place=lambda row: f"index {row}") -> None:
    """Refuse poses (N, 6) outside the limits or near a singularity; the workspace is not asked.

    `place(row)` names a row for the message: an NC line and a time.

    Raises
    ------
    WorkspaceError, SingularityError
        for the first such row, with the joint and by how much.
    """
    x = np.atleast_2d(x)
    z = np.concatenate([x[:, :3], quaternion_of_abc_np(x[:, 3:])], -1)
    found = machine.arrays.run("margins", z)[0]
    outside = ~(found >= 0)
    bad = np.flatnonzero(outside.any(-1) | ~(condition(machine, machine.jacobian(x)) <= machine.limits.condition))
    if not len(bad):
        return
    row = int(bad[0])
    worst = int(np.argmax(outside[row])) if outside[row].any() else found.shape[1] - 1
    describe(machine, machine.limit_names[worst], worst, x[row], place(row))


def describe(machine, name, index, x, place, time=None):
    """Raise the error that says which limit (`index` of `Machine.margins`) the pose x (6,) violates."""
    n = machine.joints_count
    cure = "move the program (origin) or the work, or change the limits"
    if index < 2 * n:
        q = machine.inverse_kinematics(x)[index % n]
        limit = machine.limits.length[0 if index < n else 1]
        raise WorkspaceError(name, where=place, value=f"{q:.6g} m", limit=f"{limit:g} m", time=time, cure=cure)
    if name.startswith("near a singularity"):
        J, J_home = machine.jacobian(x), machine.jacobian(machine.home)
        value = f"{np.linalg.det(J) / np.linalg.det(J_home):.3g} of it, condition number {condition(machine, J):.3g}"
        limit = f"{machine.limits.determinant:g}, condition {machine.limits.condition:g}"
        raise SingularityError(name, where=place, value=value, limit=limit, time=time, cure=cure)
    raise WorkspaceError(name, where=place, limit=f"{np.degrees(machine.limits.cone):g} deg", time=time, cure=cure)


def condition(machine, J) -> np.ndarray:
    """Condition number of J (..., n, 6), its rotation columns divided by the platform's radius (rms).  (...)."""
    B = machine.joints.platform
    radius = np.sqrt(((B - B.mean(0)) ** 2).sum(-1).mean())
    return np.linalg.cond(J / np.r_[1, 1, 1, radius, radius, radius])


def random_poses(machine, count: int, rng: np.random.Generator) -> np.ndarray:
    """Poses uniform in the declared workspace, kept where stroke, cones and det J allow.  (count, 6).

    Raises
    ------
    WorkspaceError
        no workspace is declared, or less than a thousandth of it is within the other limits.
    """
    space, home = machine.limits.workspace, machine.home
    if space is None:
        raise WorkspaceError("the machine declares no workspace", cure="give limits.workspace")
    kept = np.zeros((0, 6))
    R_home = rotation_of_quaternion_np(quaternion_of_abc_np(home[3:]))
    tried = 0
    while len(kept) < count:
        n = 2 * count + 1000
        if tried > 1000 * (len(kept) + 1):
            raise WorkspaceError(
                "hardly a pose of the declared workspace is within the other limits", where="limits.workspace",
                value=f"{len(kept)} of {tried} poses", cure="make the workspace smaller, or length and cone wider",
            )  # fmt: skip
        tried += n
        r, phi = space.radius * np.sqrt(rng.random(n)), rng.uniform(0, 2 * np.pi, n)
        tilt, about = space.tilt * np.sqrt(rng.random(n)), rng.uniform(0, 2 * np.pi, n)
        zero = np.zeros(n)
        lean = rotation_of_vector_np(np.stack([tilt * np.cos(about), tilt * np.sin(about), zero], -1))
        spin = rotation_of_vector_np(np.stack([zero, zero, rng.uniform(-space.c, space.c, n)], -1))
        abc = abc_of_rotation_np(lean @ R_home @ spin)
        height = rng.uniform(-0.5, 0.5, n) * space.height
        x = np.concatenate([home[:3] + np.stack([r * np.cos(phi), r * np.sin(phi), height], -1), abc], -1)
        z = np.concatenate([x[:, :3], quaternion_of_abc_np(x[:, 3:])], -1)
        kept = np.concatenate([kept, x[(margins(machine, z) >= 0).all(-1)]])
    return kept[:count]
