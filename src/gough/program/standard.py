"""Standard programs: one curve each, run once.

A program starts where its curve starts, not at the frame's zero: the machine is put there before the time begins.
The tool keeps the angles `abc` along the whole curve.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field

from ..declare import Array, quantity
from ..errors import InputError
from ..frames import rotation_of_abc_np
from ..quantities import Quantity
from . import blocks
from .base import Program
from .blocks import Arc, Block
from .path import Path


class _Points(Quantity):
    """A list of at least two points: a quantity of shape (n, 3)."""

    def check(self, raw, from_file):
        value = np.array(self._si(raw, from_file), float)
        if value.ndim != 2 or value.shape[1] != 3 or len(value) < 2:
            shape = " x ".join(map(str, value.shape)) or "one number"
            raise InputError("must be two or more points of x y z", value=shape)
        if not np.isfinite(value).all():
            raise InputError("must be finite")
        value.setflags(write=False)
        return value


def _feed():
    return quantity("m/s", "speed along the path", above=0)


def _abc():
    return quantity("rad", "angles a b c of the tool along the path", default=(0.0, 0.0, 0.0), shape=(3,))


def _center():
    return quantity("m", "centre of the curve", default=(0.0, 0.0, 0.0), shape=(3,))


def _plane():
    return quantity(
        "rad", "angles a b c that turn the x-y plane into the plane of the curve", default=(0.0, 0.0, 0.0), shape=(3,)
    )


def _direction():
    return Field("ccw", description="counter-clockwise, or clockwise, seen from +z of the plane")


class Circle(Program):
    """A circle about `center`, from the angle `start` (from x towards y of its plane) on for `turns` turns."""

    radius: float = quantity("m", "radius", above=0)
    feed: float = _feed()
    center: Array = _center()
    start: float = quantity("rad", "angle of the first point", default=0.0)
    turns: float = quantity("", "turns, 0.5 is half a circle", default=1.0, above=0, at_most=1000)
    direction: Literal["ccw", "cw"] = _direction()
    plane: Array = _plane()
    abc: Array = _abc()

    def path(self) -> Path:
        R = rotation_of_abc_np(self.plane)
        first = self.center + self.radius * (np.cos(self.start) * R[:, 0] + np.sin(self.start) * R[:, 1])
        sweep = 2 * np.pi * self.turns * (1 if self.direction == "ccw" else -1)
        arc = Arc(tuple(first), tuple(self.center), tuple(R[:, 2]), sweep)
        return Path([Block(arc, tuple(self.abc), tuple(self.abc), self.feed)], circle_from=0.0)


class Ellipse(Program):
    """An ellipse about `center` with the half axes `first` along x and `second` along y of its plane."""

    first: float = quantity("m", "half axis along x", above=0)
    second: float = quantity("m", "half axis along y", above=0)
    feed: float = _feed()
    center: Array = _center()
    start: float = quantity("rad", "parameter phi of the first point", default=0.0)
    turns: float = quantity("", "turns", default=1.0, above=0, at_most=1000)
    direction: Literal["ccw", "cw"] = _direction()
    plane: Array = _plane()
    abc: Array = _abc()

    def path(self) -> Path:
        R = rotation_of_abc_np(self.plane)
        back = 1 if self.direction == "ccw" else -1
        curve = blocks.Ellipse(
            tuple(self.center),
            tuple(self.first * R[:, 0]),
            tuple(back * self.second * R[:, 1]),
            back * self.start,
            2 * np.pi * self.turns,
        )
        return Path([Block(curve, tuple(self.abc), tuple(self.abc), self.feed)])


class Polyline(Program):
    """Straight lines from point to point, with the corners that `corner` says."""

    points: Array = Field(
        description="the points",
        json_schema_extra={"quantity": _Points("m", "two or more points"), "theta": False},
    )
    feed: float = _feed()
    abc: Array = _abc()

    def path(self) -> Path:
        points, abc = [tuple(row) for row in self.points.tolist()], tuple(self.abc.tolist())
        return Path(
            [Block(blocks.Line(a, b), abc, abc, self.feed) for a, b in zip(points[:-1], points[1:], strict=True)]
        )


class Line(Program):
    """A straight line, there and, with `back`, back again."""

    to: Array = quantity("m", "last point", shape=(3,))
    begin: Array = quantity("m", "first point", default=(0.0, 0.0, 0.0), shape=(3,))
    back: bool = Field(False, description="come back to the first point")
    feed: float = _feed()
    abc: Array = _abc()

    def path(self) -> Path:
        points = [self.begin, self.to, self.begin][: 3 if self.back else 2]
        return Polyline(points=np.array(points), feed=self.feed, abc=self.abc).path()
