"""Limits of a machine's pose, and the checks of its geometry when it is made."""

from __future__ import annotations

import numpy as np
from pydantic import model_validator

from ..declare import Array, Part, quantity
from ..errors import InputError, Problem, SheetError


class Workspace(Part):
    """Where the tool is meant to work: a cylinder or a box about home or beside it, with tilt and turn."""

    input_error = SheetError

    radius: float | None = quantity(
        "m", "cylinder: greatest distance of the tip from home, across the third axis of W", default=None, above=0
    )
    size: Array | None = quantity(
        "m",
        "box: extent along first and second axis of W, half on each side of home",
        default=None,
        shape=(2,),
        above=0,
    )
    height: float = quantity("m", "height of the space, half above and half below home", above=0)
    middle: Array | None = quantity(
        "m", "middle of the space, from home in W; else home itself", default=None, shape=(3,)
    )
    tilt: float = quantity("rad", "greatest angle between the tool axis and its direction at home", at_least=0)
    c: float = quantity("rad", "greatest turn c from home", at_least=0)

    @model_validator(mode="after")
    def _one_shape(self):
        if (self.radius is None) == (self.size is None):
            raise InputError("is a cylinder or a box", cure="give radius, or size, and not both")
        return self


class Limits(Part):
    """What may not be exceeded, whatever drives the machine; a kind adds how far its joints go."""

    input_error = SheetError

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


COINCIDENT = 1e-6  # m; joints nearer than this are one joint
_SPAN = (1e-3, 50.0)  # m; outside it the unit was most likely wrong
_GRAVITY = 30.0  # m/s2


def check_points(name: str, points: np.ndarray) -> None:
    """Refuse joints (6, 3) m of joints.`name` on one line, or with a span that looks like millimetres.

    Raises
    ------
    InputError
        with what is wrong.
    """
    span = np.ptp(points, axis=0).max()
    if not _SPAN[0] <= span <= _SPAN[1]:
        cure = 'did you mean mm? write { unit = "mm", value = ... }' if span > _SPAN[1] else "did you mean m?"
        raise InputError(f"{name} joints span a strange distance", key=f"joints.{name}", value=f"{span:g} m", cure=cure)
    singular = np.linalg.svd(points - points.mean(0), compute_uv=False)
    if singular[1] < 1e-9 * singular[0]:
        raise InputError(f"{name} joints lie on one line", key=f"joints.{name}", value=f"span {span:g} m")


def check_weight(machine, places) -> None:
    """Refuse centres of mass far from the joints, and a gravity that is no planet's.

    `places` are more distances to look at, (key, m, greatest m).

    Raises
    ------
    InputError
        a problem for each.
    """
    B, wrong = machine.joints.platform, []
    span = np.linalg.norm(np.ptp(B, axis=0))
    places = [("platform.center", np.linalg.norm(machine.platform.center - B.mean(0)), 5 * span), *places]
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


def singular_home(n: np.ndarray, B: np.ndarray, limit: float, share=1.0) -> list[Problem]:
    """A problem where home is near a singular pose, else none.

    n (6, 3) along the legs, B (6, 3) m their platform joints, in W; `share` (6,) of a leg's speed along itself in that
    of its joint.
    """
    r = B - B.mean(0)
    J = np.concatenate([n, np.cross(r, n) / np.sqrt((r * r).sum(1).mean())], 1)
    condition = np.linalg.cond(J / np.reshape(share, (-1, 1)))
    if condition <= limit:
        return []
    return [Problem(
        "home is a singular pose, or near one", key="home", value=f"condition number {condition:.3g}",
        limit=f"{limit:g}", cure="change home or the joints (similar hexagons one above the other do not hold)",
    )]  # fmt: skip
