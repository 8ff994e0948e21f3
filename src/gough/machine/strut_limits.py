"""What limits the struts of a hexapod, and the checks of a hexapod's geometry when it is made."""

from __future__ import annotations

import numpy as np
from pydantic import model_validator

from ..declare import Array, quantity
from ..errors import InputError, Problem
from .limits import COINCIDENT, Limits, check_points, check_weight, singular_home


class StrutLimits(Limits):
    """What may not be exceeded by a machine of struts."""

    length: Array = quantity("m", "shortest and longest strut", shape=(2,), above=0)

    @model_validator(mode="after")
    def _ordered(self):
        if self.length[0] >= self.length[1]:
            value = f"[{self.length[0]:g}, {self.length[1]:g}] m"
            raise InputError("the shortest must be below the longest", key="length", value=value)
        return self


def check_joints(base: np.ndarray, platform: np.ndarray) -> None:
    """Refuse joints (6, 3) m that make no machine.

    Raises
    ------
    InputError
        for two joints in one place on both ends, joints on one line, or a span that looks like millimetres.
    """
    for name, points in (("base", base), ("platform", platform)):
        check_points(name, points)
    for i in range(6):
        for j in range(i):
            apart = [np.linalg.norm(points[i] - points[j]) for points in (base, platform)]
            if max(apart) < COINCIDENT:
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
    longest, places = machine.limits.length[1], []
    if machine.strut is not None:
        places = [
            (f"strut.{part}.center", abs(getattr(machine.strut, part).center), longest) for part in ("moving", "fixed")
        ]
    check_weight(machine, places)


def possible_lengths(machine, q):
    """Rows (N,) of lengths q (N, 6) m that some pose may have, and `why(row)` says what is wrong with another.

    Two struts and the chords between their joints close a quadrangle: |l_i - l_j| <= |A_i A_j| + |B_i B_j|.
    """
    positive = (q > 0).all(-1)
    A, B = machine.joints.base, machine.joints.platform
    i, j = np.triu_indices(len(A), 1)
    reach = np.linalg.norm(A[i] - A[j], axis=-1) + np.linalg.norm(B[i] - B[j], axis=-1)
    l = np.where(positive[:, None], q, 0).T
    wrong = np.zeros(len(q), bool)
    for first, second, allowed in zip(i, j, reach, strict=True):
        wrong |= np.abs(l[first] - l[second]) > allowed

    def why(row):
        if not positive[row]:
            return "must be above 0 m", machine.joint_names[int(np.flatnonzero(q[row] <= 0)[0])]
        k = int(np.flatnonzero(np.abs(l[i, row] - l[j, row]) > reach)[0])
        pair = f"{machine.joint_names[i[k]]} and {machine.joint_names[j[k]]}"
        return f"lengths differ by more than their joints allow ({reach[k]:.4g} m)", pair

    return positive & ~wrong, why


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


def _other_unit(l: np.ndarray, limits: np.ndarray) -> str:
    """The cure for struts of l m beyond their limits: the unit, where a thousandth or a thousandfold would fit."""
    for factor, said in ((1e-3, "limits.length in mm"), (1e3, "limits.length in m")):
        if ((l >= limits[0] * factor) & (l <= limits[1] * factor)).all():
            return f"did you mean {said}?"
    return "change home, the joints or limits.length"


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
    for word, off in (("short", l < limits.length[0]), ("long", l > limits.length[1])):
        outside = np.flatnonzero(off)
        if not len(outside):
            continue
        first, last = (f"{length:.6g}" for length in (l[outside].min(), l[outside].max()))
        who = "strut" if len(outside) == 1 else "struts"
        wrong.append(Problem(
            f"{who} {', '.join(str(i + 1) for i in outside)} {'is' if len(outside) == 1 else 'are'} too {word} at home",
            key="home", value=f"{first} m" if first == last else f"{first} to {last} m",
            limit=f"{limits.length[0]:g} to {limits.length[1]:g} m", cure=_other_unit(l[outside], limits.length),
        ))  # fmt: skip
    if l.min() > 0:
        n = s / l[:, None]
        wrong += singular_home(n, B, limits.condition)
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
