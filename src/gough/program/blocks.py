"""Blocks: what a path is made of, as descriptions, and their packing into the batches of segments.py."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..errors import ProgramError
from .ellipse import Ellipses
from .segments import Arcs, Lines, Points, dot, norm


class Line(NamedTuple):
    """A straight segment, from `start` to `end`, (3,) m."""

    start: tuple
    end: tuple


class Arc(NamedTuple):
    """A circular arc or helix: from `start`, right-handed about `normal` through `center`, by `sweep` rad,
    rising by `rise` m along `normal`.  `center` may lie at any height of the axis; sweep < 0 turns the other way."""

    start: tuple
    center: tuple
    normal: tuple
    sweep: float
    rise: float = 0.0


class Ellipse(NamedTuple):
    """An arc of an ellipse: center + cos(phi) first + sin(phi) second, phi from `begin` on by `sweep` > 0 rad."""

    center: tuple
    first: tuple
    second: tuple
    begin: float
    sweep: float


class Rest(NamedTuple):
    """The tip rests at `at`, (3,) m, while the tool turns, or waits."""

    at: tuple


class Block(NamedTuple):
    """One segment with everything the feed needs to know.

    `feed` is m/s along a segment and rad/s for a turn at rest; it is not used for a rapid or a dwell.
    """

    segment: Line | Arc | Ellipse | Rest
    abc0: tuple = (0.0, 0.0, 0.0)
    abc1: tuple = (0.0, 0.0, 0.0)
    feed: float = 0.0
    rapid: bool = False
    line: int = 0
    dwell: float = 0.0


class CircleOfPath(NamedTuple):
    """A circle on the path, for the polar plot: `id` from 1 on, centre and unit normal in the path's frame.

    The tool runs right-handed about `normal`; `ccw` tells whether that is counter-clockwise seen from +z.
    """

    id: int
    line: int
    center: np.ndarray
    radius: float
    normal: np.ndarray
    feed: float
    ccw: bool

    def to_json(self) -> dict:
        """Plain numbers, for the log."""
        out = self._asdict()
        return {**out, "center": [float(v) for v in self.center], "normal": [float(v) for v in self.normal]}


KINDS = {Line: 0, Arc: 1, Ellipse: 2, Rest: 3}
LINE, ARC, ELLIPSE, REST = range(4)


def batches(segments):
    """The four batches Lines, Arcs, Ellipses, Points of a list of segments, each in the order of the list.

    Raises
    ------
    ProgramError
        an arc without radius or sweep.
    """
    lines, arcs, ellipses, rests = ([s for s in segments if type(s) is kind] for kind in KINDS)
    with np.errstate(divide="ignore", invalid="ignore"):  # no length: found by the path's own check, with its line
        out = [Lines([s.start for s in lines], [s.end for s in lines])]
    start = np.array([s.start for s in arcs], float).reshape(-1, 3)
    center = np.array([s.center for s in arcs], float).reshape(-1, 3)
    normal = np.array([s.normal for s in arcs], float).reshape(-1, 3)
    sweep, rise = (np.array([getattr(s, name) for s in arcs], float) for name in ("sweep", "rise"))
    # one form: right-handed about the normal, centre at the height of the start
    back = np.where(sweep < 0, -1.0, 1.0)
    normal = normal * back[:, None] / norm(normal)[:, None] + 0.0 if len(arcs) else normal  # + 0.0: no -0
    sweep, rise = np.abs(sweep), rise * back
    center = center + dot(start - center, normal)[:, None] * normal
    if (~(norm(start - center) > 0) | ~(sweep > 0)).any():
        raise ProgramError("an arc must have a radius and a sweep above 0")
    out.append(Arcs(center, start - center, normal, sweep, rise))
    out.append(Ellipses(*([getattr(s, name) for s in ellipses] for name in Ellipse._fields)))
    out.append(Points([s.at for s in rests], [(0.0, 0.0, 1.0)] * len(rests)))
    return out
