"""Flank milling: the side of the tool follows a ruled surface, written as a CAM system writes it, in short lines.

The tool's axis n lies along the surface's rulings.  With c = 0 the angles of an axis are the only ones near zero,
    n = Ry(b) Rx(a) ez = (cos a sin b, -sin a, cos a cos b)    so    a = -asin n_y,   b = atan2(n_x, n_z)          (1)
and a closed path comes back to the angles it began with; nor does the tool turn about itself but by -b' sin a.
A, B change in proportion along a line.  A chord of a curve r(u) over a step h of u leaves it by h^2 |r''_p| / 8, r''_p
the part of r'' across the curve, so that the error is the same everywhere if the steps go as
    dn/du = sqrt(|r''_p| / (8 chord)),                                                                              (2)
with the larger of the r''_p of the two rails: the tip's path, and that of the point of the axis `height` above it.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ...errors import ExperimentError
from ..blocks import Block, Line, Rest
from ..path import Path

PAUSE = 0.5  # s, behind the rapid: what is cut is not to show how the machine settles
_DENSE = 8001  # parameters at which (2) is looked at
_MOST = 100_000  # lines


def angles_of_axis(n):
    """Angles a b c of the tool, c = 0, that give it the axis n, eq. (1).  (..., 3) unit -> (..., 3) rad."""
    return np.stack([-np.arcsin(n[..., 1]), np.arctan2(n[..., 0], n[..., 2]), np.zeros(n.shape[:-1])], -1)


def axis_of_angles(abc):
    """Eq. (1) the other way, c = 0.  (..., 3) rad -> (..., 3) unit."""
    a, b = abc[..., 0], abc[..., 1]
    return np.stack([np.cos(a) * np.sin(b), -np.sin(a), np.cos(a) * np.cos(b)], -1)


class Flank:
    """The tool along a ruled surface: tip(u) (n, 3) m and axis(u) (n, 3) unit, u (n,) in [0, 1].

    height: m, up to which the surface goes along the axis.
    """

    def __init__(self, tip: Callable, axis: Callable, height: float):
        self.tip, self.axis, self.height = tip, axis, height

    def rail(self, u, share: float):
        """The points of the rulings at `share` of the height.  (n, 3) m."""
        return self.tip(u) + share * self.height * self.axis(u)

    def knots(self, chord: float) -> np.ndarray:
        """Ends of the fewest lines, spaced as (2), that stay within `chord` m of both rails.  (n + 1,).

        Raises
        ------
        ExperimentError
            more than 100 000 lines.
        """
        u = np.linspace(0, 1, _DENSE)
        across = np.zeros(_DENSE)
        for share in (0.0, 1.0):
            d = np.gradient(self.rail(u, share), u, axis=0, edge_order=2)
            dd = np.gradient(d, u, axis=0, edge_order=2)
            t = d / np.linalg.norm(d, axis=1)[:, None]
            across = np.maximum(across, np.linalg.norm(dd - (dd * t).sum(1)[:, None] * t, axis=1))
        density = np.sqrt(across / (8 * chord))
        count = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2)]) / (_DENSE - 1)
        lines = max(4, math.ceil(count[-1])) if count[-1] <= _MOST else _MOST + 1
        while lines <= _MOST:
            knots = np.interp(np.linspace(0, count[-1], lines + 1), count, u)
            if self.deviation(knots) <= chord:
                return knots
            lines += math.ceil(lines / 100)
        raise ExperimentError(f"more than {_MOST} lines", key="chord", value=f"{chord:g} m", cure="a larger chord")

    def deviation(self, knots) -> float:
        """How far the two rails of the lines between `knots` (n + 1,) leave those of the surface.  m."""
        tip, abc = self.tip(knots), angles_of_axis(self.axis(knots))
        worst, h = 0.0, 1e-5
        for part in np.linspace(0, 1, 9)[1:-1]:
            u = knots[:-1] + part * np.diff(knots)
            p = tip[:-1] + part * np.diff(tip, axis=0)
            n = axis_of_angles(abc[:-1] + part * np.diff(abc, axis=0))
            for share in (0.0, 1.0):
                off = p + share * self.height * n - self.rail(u, share)
                t = self.rail(u + h, share) - self.rail(u - h, share)
                t /= np.linalg.norm(t, axis=1)[:, None]
                # along the rail both are only at another parameter
                worst = max(worst, np.linalg.norm(off - (off * t).sum(1)[:, None] * t, axis=1).max())
        return worst

    def path(self, chord: float, feed: float, tolerance: float, approach: float, clearance: float) -> Path:
        """Down along the tool by a rapid, a pause to settle, along the tangent, the surface, off and up.

        chord: m, as `knots`.  tolerance: m, how far the short lines may be blended.
        approach, clearance: m, of the tangents at both ends and of the rapids.
        """
        u = self.knots(chord)
        tip, axis = self.tip(u), self.axis(u)
        abc = angles_of_axis(axis) + 0.0  # no -0
        begin = tip[0] - approach * _unit(tip[1] - tip[0])
        end = tip[-1] + approach * _unit(tip[-1] - tip[-2])
        points = np.vstack([begin + clearance * axis[0], begin, tip, end, end + clearance * axis[-1]]).tolist()
        angles = [abc[0].tolist()] * 2 + abc.tolist() + [abc[-1].tolist()] * 2
        last = len(points) - 2
        out = [
            Block(
                Line(tuple(points[k]), tuple(points[k + 1])), tuple(angles[k]), tuple(angles[k + 1]), feed,
                rapid=k in (0, last), tolerance=tolerance if 0 < k < last - 1 else 0.0,
            )
            for k in range(last + 1)
        ]  # fmt: skip
        pause = Block(Rest(tuple(points[1])), tuple(angles[1]), tuple(angles[1]), dwell=PAUSE)
        return Path([out[0], pause, *out[1:]])


def _unit(a):
    return a / np.linalg.norm(a)
