"""The options that several standard programs have, each declared once, and what they mean."""

from __future__ import annotations

import numpy as np
from pydantic import Field

from ...declare import quantity
from ...frames import rotation_of_abc_np


def feed():
    return quantity("m/s", "speed along the path", above=0)


def abc():
    return quantity("rad", "angles a b c of the tool along the path", default=(0.0, 0.0, 0.0), shape=(3,))


def center(meaning="centre of the curve", default=(0.0, 0.0, 0.0)):
    return quantity("m", meaning, default=default, shape=(3,))


def plane():
    return quantity(
        "rad", "angles a b c that turn the x-y plane into the plane of the curve", default=(0.0, 0.0, 0.0), shape=(3,)
    )


def direction(seen="from +z of the plane"):
    return Field("ccw", description=f"counter-clockwise, or clockwise, seen {seen}")


def both_directions():
    return Field("both", description="both ways, counter-clockwise first, or one way only, seen from +z of the plane")


def in_plane(program, points):
    """Points (n, 2) m of the plane of a program with `center` and `plane`, in the program's frame.  (n, 3) m."""
    R = rotation_of_abc_np(program.plane)
    return program.center + np.asarray(points, float) @ R[:, :2].T
