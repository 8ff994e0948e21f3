"""What the data sheet of a hexaglide says of its rails, carriages and legs, and the checks of it when it is made."""

from __future__ import annotations

import numpy as np
from pydantic import model_validator

from ..declare import Array, Part, quantity
from ..errors import InputError, Problem, SheetError
from .limits import COINCIDENT, Limits, singular_home

_UNIT = 1e-6  # how far from 1 the length of a direction may be


class PlatformJoints(Part):
    """Where the legs hold the platform."""

    input_error = SheetError

    platform: Array = quantity("m", "platform joints p_TB, in T (in P where [tool] is given)", shape=(6, 3))


class Rails(Part):
    """The line on which the joint of each carriage runs: p_WS = point + q direction."""

    input_error = SheetError

    point: Array = quantity("m", "where the carriage's joint is at q = 0, in W", shape=(6, 3))
    direction: Array = quantity("1", "the way in which q grows, in W, of length 1", shape=(6, 3))
    rail: Array = quantity(
        "1", "number of the rail of each carriage; those on one rail must not collide", shape=(6,), theta=False
    )
    side: Array = quantity(
        "1", "1: the carriage is on the +q side of its platform joint, -1: on the other; the leg's branch", shape=(6,),
        theta=False,
    )  # fmt: skip

    @model_validator(mode="after")
    def _sound(self):
        if not np.isin(self.side, (-1, 1)).all():
            raise InputError("is 1 or -1 for each carriage", key="side", value=str(self.side.tolist()))
        length = np.linalg.norm(self.direction, axis=1)
        i = int(np.abs(length - 1).argmax())
        if abs(length[i] - 1) > _UNIT:
            raise InputError(
                "a direction must have length 1", key="direction", cure="divide it by its length",
                value=f"{length[i]:.9g} for carriage {i + 1}",
            )  # fmt: skip
        for i, j in self.pairs:
            across = np.cross(self.direction[i], self.direction[j])
            if np.linalg.norm(across) > _UNIT or self.direction[i] @ self.direction[j] < 0:
                raise InputError(
                    f"carriages {i + 1} and {j + 1} run on one rail in different directions", key="direction",
                    cure="give them one direction, or another number in rail",
                )  # fmt: skip
        return self

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """Carriages (from 0) that share a rail."""
        return [(i, j) for i in range(6) for j in range(i + 1, 6) if self.rail[i] == self.rail[j]]


class Legs(Part):
    """Legs of constant length, each between the joint of a carriage and one of the platform."""

    input_error = SheetError

    length: float | Array = quantity("m", "joint to joint: one for all, or one each", above=0, shape=(-1,))
    mass: float | None = quantity(
        "kg", "mass of a leg, spread evenly along it; leave out to neglect it", default=None, above=0
    )

    @model_validator(mode="after")
    def _six(self):
        if np.ndim(self.length) and len(self.length) != 6:
            raise InputError("needs one value or six", key="length", value=str(len(self.length)))
        return self


class Carriage(Part):
    """What runs on a rail."""

    input_error = SheetError

    mass: float = quantity("kg", "mass of a carriage with the moving part of its motor", above=0)


class RailLimits(Limits):
    """What may not be exceeded by a machine of carriages."""

    travel: Array = quantity("m", "both ends of the rails: least and greatest q", shape=(2,))
    gap: float = quantity(
        "m", "least distance of the joints of two carriages on one rail: as long as a carriage", default=0.0, at_least=0
    )
    lean: float = quantity(
        "rad", "least angle by which a leg leans from square across its rail, where its carriage cannot drive it",
        default=np.radians(5), above=0, below=np.pi / 2,
    )  # fmt: skip

    @model_validator(mode="after")
    def _ordered(self):
        if self.travel[0] >= self.travel[1]:
            raise InputError("the first end must be below the second", key="travel", value=f"{self.travel.tolist()} m")
        return self


def legs_np(machine, B: np.ndarray):
    """Distance of platform joints B (..., 6, 3) m, in W, from their rails, and q (NaN out of reach).  (..., 6) m, m."""
    e = machine.rails.direction
    s = B - machine.rails.point
    ee = (e * e).sum(-1)
    along = (e * s).sum(-1) / ee
    across = np.linalg.norm(s - e * along[..., None], axis=-1)
    left = machine.legs.length**2 - across**2
    root = np.sqrt(np.where(left >= 0, left, np.nan) / ee)
    return across, along + machine.rails.side * root


def check_home(machine, B: np.ndarray) -> None:
    """Refuse a hexaglide that cannot stand at home, with its platform joints at B (6, 3) m in W.

    Raises
    ------
    InputError
        for legs that do not reach, carriages beyond their rails or in each other, legs square across their rails, or a
        singular pose; a problem for each.
    """
    rails, limits, wrong = machine.rails, machine.limits, []
    across, q = legs_np(machine, B)
    l = np.broadcast_to(machine.legs.length, 6)
    for i in np.flatnonzero(across > l):
        wrong.append(Problem(
            f"leg {i + 1} cannot reach at home: misses by {1e3 * (across[i] - l[i]):.4g} mm", key="home",
            value=f"{across[i]:.6g} m from joint to rail", limit=f"{l[i]:g} m",
            cure="change home, the joints, the rails or legs.length",
        ))  # fmt: skip
    if not wrong:
        n = (B - rails.point - rails.direction * q[:, None]) / l[:, None]
        share = (n * rails.direction).sum(1)
        lean = np.arcsin(np.minimum(np.abs(share), 1))
        for i in np.flatnonzero(~((q >= limits.travel[0]) & (q <= limits.travel[1]))):
            wrong.append(Problem(
                f"carriage {i + 1} is beyond its rail at home", key="home", value=f"{q[i]:.6g} m",
                limit=f"{limits.travel[0]:g} to {limits.travel[1]:g} m", cure="change home or limits.travel",
            ))  # fmt: skip
        for i in np.flatnonzero(lean < limits.lean):
            wrong.append(Problem(
                f"leg {i + 1} is square across its rail at home, or nearly", key="home",
                value=f"{np.degrees(lean[i]):.4g} deg", limit=f"{np.degrees(limits.lean):g} deg",
                cure="change home, the joints or legs.length",
            ))  # fmt: skip
        for i, j in rails.pairs:
            apart = abs((rails.point[j] + rails.direction[j] * q[j] - rails.point[i]) @ rails.direction[i] - q[i])
            if apart < max(limits.gap, COINCIDENT):
                wrong.append(Problem(
                    f"carriages {i + 1} and {j + 1} are in each other at home", key="home",
                    value=f"{apart:.6g} m apart", limit=f"{limits.gap:g} m",
                    cure="change home, rails.side or limits.gap",
                ))  # fmt: skip
        wrong += singular_home(n, B, limits.condition, share) if lean.min() > 0 else []
    if wrong:
        raise InputError(problems=wrong)
