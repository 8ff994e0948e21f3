"""The course: the path as it is driven, with blends at its corners and splines through its short lines.

The programmed path stays sharp; errors are measured against it.  Each block of the course belongs to a stretch of the
programmed path, and a place on it to a place there: in proportion to the length travelled, a blend on either side of
its corner by itself, so that the corner stands where the blend's knot is:

    s(u) = s_0 + (s_k - s_0) u / u_k  up to the knot,  s_k + (s_1 - s_k) (u - u_k) / (L - u_k)  behind it          (1)

s(u) is continuous and grows along the course (eq. (7) of docs/theory/course.md).  Where nothing is blended the course
is the path itself.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..errors import ProgramError
from .assemble import Stretches, assembled
from .blend import blend
from .limits import Limits
from .path import Path
from .spline import splined
from .worth import worth

_ARM = 0.1  # m, of the tool that the tip's tolerance turns where the axis has none of its own


class Rules(NamedTuple):
    """What may happen at the corners of a path: the options of Program of these names; `tolerance` m.

    `smooth` says that a jump of the curvature is a corner too: a jerk-limited feed needs it.
    """

    corner: str | None = None
    tolerance: float = 20e-6
    axis_tolerance: float | None = None
    spline: bool = False
    smooth: bool = False


class Place(NamedTuple):
    """Places on the programmed path: block, extent in it and path length.  (n,) each."""

    block: np.ndarray
    u: np.ndarray
    s: np.ndarray


class Course:
    """`path` is driven, `programmed` is what was asked for; `stretches` is None where they are the same."""

    def __init__(self, path: Path, programmed: Path, stretches: Stretches | None = None):
        self.path, self.programmed, self.stretches = path, programmed, stretches

    def place(self, j, u) -> Place:
        """The place on the programmed path of the extent u (n,) in the course's blocks j (n,), eq. (1)."""
        path = self.programmed
        if self.stretches is None:
            return Place(j, u, path.s0[j] + np.where(path.length[j] > 0, u, 0.0))
        first, second, start, knot, end, to_knot = (column[j] for column in self.stretches)
        rest, length = path.length[first] == 0, self.path.length[j]
        behind = (second != first) & (u >= to_knot)
        a, b = np.where(behind, knot, start), np.where(behind, end, knot)
        whole = np.where(behind, length - to_knot, to_knot)
        part = np.where(behind, u - to_knot, u) / np.where(rest, 1.0, whole)
        s = np.where(rest, start, np.where(part >= 1, b, a + (b - a) * part))
        block = np.where(behind, second, first)
        inside = np.minimum(np.maximum(s - path.s0[block], 0.0), path.length[block])
        return Place(block, np.where(rest, u, inside), s)


def course_of(path: Path, rules: Rules | None = None, limits: Limits | None = None) -> Course:
    """The course along `path` that the rules allow.  With `limits` a corner keeps its stop where that takes less time.

    Raises
    ------
    ProgramError
        a spline is asked for where no junction has a tolerance.
    """
    rules = rules or Rules()
    tolerance = _tolerances(path, rules)
    if not (tolerance[:-1] > 0).any():
        if rules.spline and len(path) > 1:
            cure = 'write corner = "blend", or G64 in the program'
            raise ProgramError("no corner has a tolerance, so no lines can run as a spline", cure=cure)
        return Course(_with(path, tolerance), path)
    axis_tolerance = np.maximum(tolerance, 0.0) / _ARM
    if rules.axis_tolerance is not None:
        axis_tolerance = np.full(len(path), rules.axis_tolerance)
    base = splined(path, tolerance, axis_tolerance) if rules.spline else path
    blends = blend(base, path, tolerance, axis_tolerance, rules.smooth)
    if limits is not None:
        pays = worth(base, blends, limits)
        blends = blends if pays.all() else blends.chosen(np.flatnonzero(pays))
    if base is path and not len(blends.after):
        return Course(_with(path, tolerance), path)
    driven, stretches = assembled(base, path, tolerance, blends, np.inf if limits is None else limits.rapid)
    return Course(driven, path, stretches)


def _tolerances(path, rules):
    """The tolerance of each junction under the rules: -1 exact stop, 0 exact path, > 0 m.  (m,)."""
    if rules.corner == "blend":
        return np.full(len(path), rules.tolerance)
    if rules.corner is not None:
        return np.zeros(len(path))
    return np.where(np.isinf(path.tolerance), rules.tolerance, path.tolerance)


def _with(path, tolerance):
    """The same path with these tolerances: itself, or a copy that shares all else."""
    if np.array_equal(path.tolerance, tolerance):
        return path
    out = object.__new__(Path)
    out.__dict__.update(path.__dict__, tolerance=tolerance)
    return out
