"""A machine at home, for somebody who has just described it: what its numbers come to, and what is seldom meant.

A data sheet without a mistake may still describe another machine than the one in the hall: struts written in another
order than the joints, a drive that cannot hold the weight.  Nothing here is an error, since such machines can be built.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations

import numpy as np

from ..machine.workspace import condition
from . import abilities

CROSSING = 0.03  # m between the axes of two struts: less than the thickness of any strut of a machine tool
FAR_BETTER = 0.5  # of the condition number: no other order of the library's struts is shorter and better at all
_ENDS = 0.05  # share of a strut at each end, where struts that share a joint or stand side by side come near


@dataclass(frozen=True)
class Standing:
    """What a machine is at home: joint coordinates, condition number of J, greatest share of a drive's force."""

    joints: np.ndarray  # (n,) m
    condition: float
    load: float | None  # of the drives' limit, to hold the machine; None without a limit
    remarks: tuple[str, ...]

    def words(self, machine) -> str:
        """One line for people."""
        low, high = self.joints.min(), self.joints.max()
        text = f"{low:.4g} m" if high - low < 5e-4 * max(abs(high), 1e-3) else f"{low:.4g} to {high:.4g} m"
        parts = [f"{machine.joint_names[0].rpartition(' ')[0] or 'joint'}s at {text}"]
        length = getattr(machine.limits, "length", None)
        if length is not None:
            parts[0] += f" of {length[0]:g} to {length[1]:g} m"
        if len(machine.task) > 1:
            parts.append(f"condition number {self.condition:.3g}")
        if self.load is not None:
            parts.append(f"its weight takes {100 * self.load:.2g} % of the drives' force")
        return f"at home: {', '.join(parts)}"


def standing(machine) -> Standing:
    """What the machine is at home.

    Raises
    ------
    WorkspaceError, SingularityError
        it cannot stand there.
    """
    home = np.asarray(machine.home, float)
    force = machine.at_rest(home)[1]
    greatest = float(abilities.limits_of(machine)[2])
    load = float(np.abs(force).max() / greatest) if np.isfinite(greatest) else None
    joints = np.atleast_1d(machine.inverse_kinematics(home))
    number = float(condition(machine, machine.jacobian(home)[None])[0]) if len(machine.task) > 1 else 1.0
    remarks = _another_order(machine, home) or _crossings(machine, home)
    if load is not None and load > 1:
        i = int(np.abs(force).argmax())
        remarks.append(
            f"{machine.joint_names[i]} cannot hold the machine at home: {abs(force[i]):.4g} N of {greatest:.4g} N; "
            "look at the masses, drive.torque_limit and drive.lead"
        )
    return Standing(joints, number, load, tuple(remarks))


def _crossings(machine, home) -> list[str]:
    """Struts of a hexapod whose axes meet between their joints: most often rows of joints in another order."""
    if machine.kind != "hexapod":
        return []
    lines = {line["name"]: np.array(line["points"]) for line in machine.drawing(home)}
    ends = [lines[name] for name in machine.joint_names]
    out = []
    for i in range(len(ends)):
        for j in range(i):
            apart, at = between(*ends[i], *ends[j])
            if apart < CROSSING and all(_ENDS < share < 1 - _ENDS for share in at):
                out.append(f"{j + 1} and {i + 1}")
    if not out:
        return []
    return [
        f"struts {', '.join(out)} cross at home; are the rows of joints.base and joints.platform in one order? "
        "gough show draws the machine"
    ]


def _another_order(machine, home) -> list[str]:
    """Rows of platform joints in whose place another order gives shorter struts and a far better machine."""
    if machine.kind != "hexapod":
        return []
    lines = {line["name"]: np.array(line["points"]) for line in machine.drawing(home)}
    A, B = (np.array([lines[name][end] for name in machine.joint_names]) for end in (0, 1))
    orders = np.array(list(permutations(range(len(B)))))  # the first is the order as written
    s = B[orders] - A
    l = np.linalg.norm(s, axis=-1, keepdims=True)
    n, r = s / l, (B - home[:3])[orders]  # velocities are those of the tool's tip, as for limits.condition
    numbers, length = condition(machine, np.concatenate([n, np.cross(r, n)], -1)), l.sum((1, 2))
    better = (length < length[0]) & (numbers < FAR_BETTER * numbers[0])
    if not better.any():
        return []
    best = int(np.where(better, length, np.inf).argmin())
    order = ", ".join(str(i + 1) for i in orders[best])
    return [
        f"with the platform joints in the order {order} the condition number at home would be {numbers[best]:.3g}, not "
        f"{numbers[0]:.3g}; are the rows of joints.base and joints.platform in one order?"
    ]


def between(a, b, c, d) -> tuple[float, tuple[float, float]]:
    """Distance of the lines through a, b and c, d (3,) m, and where they are nearest, as shares of a to b and c to d.

    The shares of parallel lines are infinite.
    """
    u, v, w = b - a, d - c, a - c
    uu, uv, vv, uw, vw = u @ u, u @ v, v @ v, u @ w, v @ w
    whole = uu * vv - uv * uv
    if whole < 1e-12 * uu * vv:
        return float(np.linalg.norm(np.cross(u, w)) / np.sqrt(uu)), (np.inf, np.inf)
    s, t = (uv * vw - vv * uw) / whole, (uu * vw - uv * uw) / whole
    return float(np.linalg.norm(w + s * u - t * v)), (float(s), float(t))
