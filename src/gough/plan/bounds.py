"""All that bounds where a machine can stand, as margins >= 0 inside: joints, cones, singularity, drives, space.

The margins of a machine (`Machine.margins`: strokes, cones, det J), the condition number of J as 1 / condition minus
1 / limit, which a check of poses asks for as well; when asked for, the forces of the drives at rest, and the declared
workspace.
"""

from __future__ import annotations

import numpy as np

from ..machine.workspace import outside_workspace, space_names
from . import abilities

CONDITION = "near a singularity: condition number of J"
HOLD = "the drive cannot hold the machine"

_TWO_SIDED = (("too short", "too long"), ("the start", "the end"), ("the least", "the greatest"))


class Bounds:
    """The limits of a machine; with `force` those of its drives at rest under `wrench` (6,) on the tool, with
    `workspace` the declared one."""

    def __init__(self, machine, force: bool = False, workspace: bool = False, wrench=None):
        self.machine, self._margins = machine, abilities.Evaluated("bounds", machine, wrench)
        limit = abilities.limits_of(machine)[2]
        self.limit = limit if force and np.isfinite(limit) else None
        self.workspace = workspace and machine.limits.workspace is not None
        self.names = (*machine.limit_names, *((CONDITION,) if len(machine.task) > 1 else ()))
        self.own = len(self.names)  # those that the machine has of its own
        if self.limit is not None:
            self.names += tuple(f"{joint}: {HOLD}" for joint in machine.joint_names)
        self.forces = len(self.names)
        if self.workspace:
            self.names += space_names(machine)
        self.length = abilities.platform_length(machine)
        self.scale = self._scales(self.of(np.atleast_2d(np.asarray(machine.home, float)))[0][0])

    def of(self, x) -> tuple[np.ndarray, np.ndarray]:
        """Margins of poses (N, d), columns as `names`, and those of the declared workspace (empty without one)."""
        limits, space, u = self._margins(x)
        more = []
        if self.limit is not None:
            more.append(self.limit - np.abs(u))
        if self.workspace:
            more.append(space)
        return (np.concatenate([limits, *more], 1) if more else limits), space

    def nearest(self, margins) -> tuple[np.ndarray, np.ndarray]:
        """Of margins (N, k): what is left of the nearest limit, as a share of its scale, and its number.

        NaN and -1 where no joint coordinates have the pose, and no limit says so.
        """
        share = margins / self.scale
        known = np.where(np.isnan(share), np.inf, share)
        index = known.argmin(-1)
        least = np.take_along_axis(known, index[:, None], 1)[:, 0]
        lost = np.isnan(share).any(-1) & ~(least < 0)
        return np.where(lost, np.nan, least), np.where(lost, -1, index).astype("i2")

    def _scales(self, at_home) -> np.ndarray:
        """What margins are measured by: half the range of a limit with two ends; of others the greatest at home of
        their sort ("platform joint beyond its cone")."""
        names = list(self.names)
        sorts = [name.rpartition(": ")[2] for name in names]
        out = np.ones(len(names))
        for i, name in enumerate(names):
            partner = next(
                (names.index(name.replace(a, b)) for pair in _TWO_SIDED for a, b in (pair, pair[::-1])
                 if a in name and name.replace(a, b) in names), None,
            )  # fmt: skip
            own = max(at_home[k] for k, sort in enumerate(sorts) if sort == sorts[i])
            found = own if partner is None else (at_home[i] + at_home[partner]) / 2
            out[i] = found if found > 0 else 1.0
        return out

    def told(self, x, margins) -> tuple[str, str | None, str | None]:
        """Rule, value and limit of the worst of the margins (k,) of a pose x (d,) that is not inside, in words."""
        lost = self.machine.unreachable(x) if np.isnan(margins).any() else None
        if lost is not None:
            problem = lost[1].problems[0]
            return problem.rule, problem.value, problem.limit
        index = int(np.nanargmin(margins / self.scale))
        return self.told_of(index, float(margins[index]))

    def told_of(self, index: int, margin: float) -> tuple[str, str | None, str | None]:
        """Rule, value and limit of the limit `index` whose margin is `margin`, in words."""
        if index < len(self.machine.limit_names):
            return self.machine.limit_told(index, margin)
        if index < self.own:
            left = margin + 1 / self.machine.limits.condition
            return CONDITION, f"{1 / left:.3g}" if left > 0 else "infinite", f"{self.machine.limits.condition:g}"
        if index < self.forces:
            return self.names[index], f"{self.limit - margin:.6g} N", f"{self.limit:.6g} N"
        problem = outside_workspace(self.machine, index - self.forces, margin, None).problems[0]
        return problem.rule, problem.value, problem.limit
