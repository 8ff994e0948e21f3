"""Limits of a machine's pose, and the checks of its geometry when it is made."""

from __future__ import annotations

import numpy as np
from pydantic import model_validator

from ..declare import Array, Part, quantity
from ..errors import InputError, SheetError


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
    cone: float | None = quantity(
        "rad", "greatest angle of each joint from its direction at home", default=None, above=0, below=np.pi
    )
    condition: float = quantity(
        "1", "greatest condition number of J, lengths divided by the platform's radius", default=100.0, above=1
    )
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
            raise InputError(f"{name} joints span a strange distance", key=f"joints.{name}", value=f"{span:g} m", cure=cure)
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
