"""Parts of blocks: their segments from one arc length to another, batch by batch."""

from __future__ import annotations

import numpy as np

from .blocks import ARC, CURVE, ELLIPSE, LINE, REST
from .curves import Curves
from .ellipse import Ellipses
from .segments import Arcs, Lines, Points


def cut(path, i, lo, hi):
    """The segments of the blocks i (n,) from arc length lo to hi (n,), whole ones as they are.

    Returns (batches, index): as in Path, `index` (n,) says where in its batch each stands.
    """
    whole = (lo == 0) & (hi == path.length[i])
    kind, index, batches = path.kind[i], np.zeros(len(i), np.int64), []
    for k, part in ((LINE, _lines), (ARC, _arcs), (ELLIPSE, _ellipses), (REST, _points), (CURVE, _curves)):
        rows = np.flatnonzero(kind == k)
        index[rows] = np.arange(len(rows))
        batches.append(part(path.batches[k], path.index[i[rows]], lo[rows], hi[rows], whole[rows][:, None]))
    return batches, index


def _lines(lines, i, lo, hi, whole):
    start, end = lines.point(i, lo), lines.point(i, hi)
    return Lines(np.where(whole, lines.start[i], start), np.where(whole, lines.end[i], end))


def _arcs(arcs, i, lo, hi, whole):
    radius, gain = arcs.radius[i][:, None], arcs.gain[i]
    theta = lo / gain
    c, n = np.cos(theta)[:, None], np.sin(theta)[:, None]
    radial = radius * np.where(whole, arcs.e1[i], c * arcs.e1[i] + n * arcs.e2[i])
    center = arcs.center[i] + (arcs.pitch[i] * theta)[:, None] * arcs.normal[i]
    sweep = np.where(whole[:, 0], arcs.sweep[i], (hi - lo) / gain)
    return Arcs(center, radial, arcs.normal[i], sweep, np.where(whole[:, 0], arcs.rise[i], arcs.pitch[i] * sweep))


def _ellipses(ellipses, i, lo, hi, whole):
    begin, sweep = ellipses.start[i], ellipses.sweep[i]
    if len(i):
        phi0, phi1 = ellipses.parameter(i, lo), ellipses.parameter(i, hi)
        begin, sweep = np.where(whole[:, 0], begin, phi0), np.where(whole[:, 0], sweep, phi1 - phi0)
    return Ellipses(ellipses.center[i], ellipses.first[i], ellipses.second[i], begin, sweep)


def _points(points, i, lo, hi, whole):
    return Points(points.position[i], points.direction[i])


def _curves(curves, i, lo, hi, whole):
    whole = whole[:, 0]
    if whole.all():
        return curves.chosen(i)
    both = Curves.joined([curves.chosen(i[whole]), curves.cut(i[~whole], lo[~whole], hi[~whole])])
    place = np.empty(len(i), np.int64)
    place[np.concatenate([np.flatnonzero(whole), np.flatnonzero(~whole)])] = np.arange(len(i))
    return both.chosen(place)
