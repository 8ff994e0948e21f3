"""Limits of a machine's pose, and the checks of its geometry when it is made."""

from __future__ import annotations

import numpy as np
from pydantic import model_validator

from ..declare import Array, Part, quantity
from ..errors import InputError, Problem, SheetError


class Workspace(Part):
    """Where the tool is meant to work: a cylinder about home, with tilt and turn."""

    input_error = SheetError

    radius: float = quantity("m", "greatest distance of the tip from home, across the third axis of W", above=0)
    height: float = quantity("m", "height of the cylinder, half above and half below home", above=0)
    tilt: float = quantity("rad", "greatest angle between the tool axis and its direction at home", at_least=0)
    c: float = quantity("rad", "greatest turn c from home", at_least=0)


class Limits(Part):
    """What may not be exceeded."""

    input_error = SheetError

    length: Array = quantity("m", "shortest and longest strut", shape=(2,), above=0)
    speed: float | None = quantity(
        "m/s", "greatest speed of a joint, for programs with joint_limits", default=None, theta=False, above=0
    )
    acceleration: float | None = quantity(
        "m/s2", "greatest acceleration of a joint, likewise", default=None, theta=False, above=0
    )
    cone: float | None = quantity(
        "rad", "greatest angle of each joint from its direction at home", default=None, above=0, below=np.pi
    )
    condition: float = quantity(
        "1", "greatest condition number of J, lengths divided by the platform's radius", default=100.0, above=1
    )
    condition_warning: float = quantity("1", "condition number of J from which a run warns", default=50.0, above=1)
    determinant: float = quantity("1", "least det J, as a fraction of home's", default=1e-3, above=0, below=1)
    workspace: Workspace | None = None

    @model_validator(mode="after")
    def _ordered(self):
        if self.length[0] >= self.length[1]:
            raise InputError("the shortest must be below the longest", key="length", value=f"{self.length.tolist()} m")
        return self


_COINCIDENT = 1e-6  # m; joints nearer than this are one joint
_SPAN = (1e-3, 50.0)  # m; outside it the unit was most likely wrong


def check_joints(base: np.ndarray, platform: np.ndarray) -> None:
    """Refuse joints (6, 3) m that make no machine.

    Raises
    ------
    InputError
        for two joints in one place on both ends, joints on one line, or a span that looks like millimetres.
    """
    for name, points in (("base", base), ("platform", platform)):
        span = np.ptp(points, axis=0).max()
        if not _SPAN[0] <= span <= _SPAN[1]:
            cure = 'did you mean mm? write { unit = "mm", value = ... }' if span > _SPAN[1] else "did you mean m?"
            raise InputError(
                f"{name} joints span a strange distance", key=f"joints.{name}", value=f"{span:g} m", cure=cure
            )
        singular = np.linalg.svd(points - points.mean(0), compute_uv=False)
        if singular[1] < 1e-9 * singular[0]:
            raise InputError(f"{name} joints lie on one line", key=f"joints.{name}", value=f"span {span:g} m")
    for i in range(6):
        for j in range(i):
            apart = [np.linalg.norm(points[i] - points[j]) for points in (base, platform)]
            if max(apart) < _COINCIDENT:
                raise InputError(
                    f"struts {j + 1} and {i + 1} have the same joints",
                    key="joints",
                    value=f"{apart[0]:g} m and {apart[1]:g} m apart",
                    cure=f"move base or platform joint {i + 1}",
                )


def check_sizes(machine) -> None:
    """Refuse masses that sit where no machine has them: most often a length in another unit.

    Raises
    ------
    InputError
        a problem for each.
    """
    longest, wrong = machine.limits.length[1], []
    B = machine.joints.platform
    span = np.linalg.norm(np.ptp(B, axis=0))
    places = [("platform.center", np.linalg.norm(machine.platform.center - B.mean(0)), 5 * span)]
    if machine.strut is not None:
        places += [
            (f"strut.{part}.center", abs(getattr(machine.strut, part).center), longest) for part in ("moving", "fixed")
        ]
    for key, distance, limit in places:
        if distance > limit:
            wrong.append(Problem(
                "the centre of mass lies far outside the machine", key=key, value=f"{distance:g} m from its joints",
                limit=f"{limit:.3g} m", cure="did you mean mm?",
            ))  # fmt: skip
    if np.linalg.norm(machine.gravity) > _GRAVITY:
        value = f"{np.linalg.norm(machine.gravity):g} m/s2"
        wrong.append(Problem("gravity is no planet's", key="gravity", value=value, limit=f"{_GRAVITY:g} m/s2"))
    if wrong:
        raise InputError(problems=wrong)


def check_spin(machine) -> None:
    """Refuse what needs the spin of the struts without `joints.base_axis`, which fixes it.

    Raises
    ------
    InputError
        a problem for each key that needs it.
    """
    if machine.joints.base_axis is not None:
        return
    strut, joints = machine.strut, machine.joints
    needs = []
    for part in () if strut is None else ("moving", "fixed"):
        body = getattr(strut, part)
        needs += [f"strut.{part}.{key}" for key in ("offset", "inertia") if getattr(body, key) is not None]
        needs += [f"strut.{part}.axial"] if body.axial else []
    needs += [f"joints.{key}" for key in ("cross", "friction") if getattr(joints, key) is not None]
    if needs:
        raise InputError(problems=[Problem(
            "needs joints.base_axis, which fixes the spin of the struts", key=key,
            cure=f"give joints.base_axis or leave {key} out",
        ) for key in needs])  # fmt: skip


def check_guides(machine) -> None:
    """Refuse half a guide.

    Raises
    ------
    InputError
        one of sleeve and tube without the other.
    """
    sleeve, tube = (None, None) if machine.strut is None else (machine.strut.sleeve, machine.strut.tube)
    if (sleeve is None) != (tube is None):
        missing = "strut.sleeve" if sleeve is None else "strut.tube"
        raise InputError("strut.sleeve and strut.tube belong together", key=missing, cure="give both or neither")


OVERLAP = 1e-3  # m of tube that must be left in the sleeve: less is no guide


def check_loads(machine) -> None:
    """Refuse load-dependent friction of struts without a guide, or on a stroke on which the tubes leave their sleeves.

    Kinematics and frictionless dynamics do not ask for it, so a machine may be made without; sheets and runs do.

    Raises
    ------
    InputError
        no guide, or too little overlap at the longest strut of limits.length.
    """
    if machine.friction is None or not machine.friction.loaded:
        return
    if not getattr(machine, "guided", False):
        raise InputError(
            f"{machine.friction.kind} needs the normal force between the tubes", key="friction.kind",
            cure="give strut.sleeve and strut.tube, or take a friction without load",
        )  # fmt: skip
    reach, longest = machine.strut.sleeve + machine.strut.tube, machine.limits.length[1]
    if not reach - longest >= OVERLAP:
        raise InputError(
            "the tube leaves its sleeve within the stroke", key="limits.length",
            value=f"longest strut {longest:g} m", limit=f"sleeve + tube = {reach:g} m",
            cure="shorten the stroke, lengthen strut.sleeve or strut.tube, or take a friction without load",
        )  # fmt: skip


_GRAVITY = 30.0  # m/s2
_LOCKED = 1e-3  # 1 - (a . n)^2 of a joint axis within 1.8 deg of its strut


def check_home(machine, B: np.ndarray) -> None:
    """Refuse a hexapod that cannot stand at home, with its platform joints at B (6, 3) m in W.

    Raises
    ------
    InputError
        for struts beyond their stroke at home, a singular pose, or joint axes that are no unit vectors or lie along
        their struts; a problem for each.
    """
    A, limits, wrong = machine.joints.base, machine.limits, []
    s = B - A
    l = np.linalg.norm(s, axis=1)
    for i in np.flatnonzero(~((l >= limits.length[0]) & (l <= limits.length[1]))):
        wrong.append(Problem(
            f"strut {i + 1} is too {'short' if l[i] < limits.length[0] else 'long'} at home", key="home",
            value=f"{l[i]:.6g} m", limit=f"{limits.length[0]:g} to {limits.length[1]:g} m",
            cure="change home, the joints or limits.length",
        ))  # fmt: skip
    if l.min() > 0:
        n = s / l[:, None]
        r = B - B.mean(0)
        J = np.concatenate([n, np.cross(r, n) / np.sqrt((r * r).sum(1).mean())], 1)
        condition = np.linalg.cond(J)
        if not condition <= limits.condition:
            wrong.append(Problem(
                "home is a singular pose, or near one", key="home", value=f"condition number {condition:.3g}",
                limit=f"{limits.condition:g}",
                cure="change home or the joints (similar hexagons one above the other do not hold)",
            ))  # fmt: skip
        axis = machine.joints.base_axis
        if axis is not None:
            off = np.abs(np.linalg.norm(axis, axis=1) - 1)
            if off.max() > 1e-6:
                i = int(off.argmax())
                wrong.append(Problem(
                    "an axis must have length 1", key="joints.base_axis", cure="divide it by its length",
                    value=f"{np.linalg.norm(axis[i]):.9g} for strut {i + 1}",
                ))  # fmt: skip
            along = 1 - (axis * n).sum(1) ** 2
            if off.max() <= 1e-6 and along.min() < _LOCKED:
                i = int(along.argmin())
                wrong.append(Problem(
                    f"the base axis of strut {i + 1} lies along the strut at home", key="joints.base_axis",
                    value=str(axis[i].tolist()), cure="a universal joint needs it across the strut",
                ))  # fmt: skip
    if wrong:
        raise InputError(problems=wrong)
