"""Splines: runs of short lines become one curve through their end points, without a jump of the curvature.

A run's curve is the natural cubic spline of its points p_k by chord length, h_k = |p_k+1 - p_k|:

    h_k-1 M_k-1 + 2 (h_k-1 + h_k) M_k + h_k M_k+1 = 6 (t_k - t_k-1),   t_k = (p_k+1 - p_k) / h_k                   (1)
    p(x) = p_k + x (p_k+1 - p_k - h^2 (2 M_k + M_k+1) / 6) + x^2 h^2 M_k / 2 + x^3 h^2 (M_k+1 - M_k) / 6           (2)

for x from 0 to 1, with M = 0 at the ends.  M is the second derivative at the points.  Along a piece it changes in
proportion, so the piece leaves its chord by no more than h^2 max(|M_k|, |M_k+1|) / 8.  Where that is beyond the
tolerance the run is broken at the end with the larger M, and the pieces are solved again.  The angles a b c are the
same kind of spline by the arc length of the curve.  Derived in docs/theory/course.md, eqs. (8) and (9).
"""

from __future__ import annotations

import numpy as np

from .blocks import CURVE, LINE
from .curves import Curves
from .path import Path
from .segments import cross, dot, norm

BEND = np.radians(30)  # a sharper turn is a corner that was meant
FEWEST = 3  # lines of a run
_ROUNDS = 100
_LENGTHS = 6  # each makes the knots a tenth as wrong or better, for points that show the curve they are on
_SAFE = 0.95  # of the axis tolerance: the closest point of the path is not exactly the one as far along


def splined(path, tolerance, axis_tolerance) -> Path:
    """The path with its runs of short lines as curves, block for block; `path` itself where there are none.

    tolerance (m,) m and axis_tolerance (m,) rad belong to the junctions behind the blocks; 0: none.
    """
    joined = _joined(path, tolerance)
    allowed, axis_allowed = _of_blocks(tolerance), _of_blocks(axis_tolerance) * _SAFE
    for _ in range(_ROUNDS):
        first, last = _runs(joined)
        if not len(first):
            return path
        blocks, start = _members(first, last)
        curves, broken = _solved(path, blocks, start, allowed[blocks])
        angles = None
        if not broken.any():
            angles, broken = _turned(path, blocks, start, curves.length, axis_allowed[blocks])
        if not broken.any():
            return _replaced(path, blocks, curves, angles)
        joined[blocks[broken] - 1] = False  # broken: at the start of these blocks
    return path


def _of_blocks(tolerance):
    """The lower tolerance of the junctions before and behind each block that have one.  (m,)."""
    before = np.append(0.0, tolerance[:-1])
    both = (before > 0) & (tolerance > 0)
    return np.where(both, np.minimum(before, tolerance), np.maximum(before, tolerance))


def _joined(path, tolerance):
    """Whether a run may pass the junction behind each block.  (m,) bool."""
    line = (path.kind == LINE) & ~path.rapid
    i = np.flatnonzero(line[:-1] & line[1:] & (tolerance[:-1] > 0) & (path.tool[1:] == path.tool[:-1]).all(1))
    T = path.batches[LINE].direction
    a, b = T[path.index[i]], T[path.index[i + 1]]
    out = np.zeros(len(path), bool)
    out[i] = np.arctan2(norm(cross(a, b)), dot(a, b)) < BEND
    return out


def _runs(joined):
    """First and last block of each run of at least FEWEST."""
    edge = np.diff(np.concatenate([[0], joined.astype(np.int8), [0]]))
    first, last = np.flatnonzero(edge > 0), np.flatnonzero(edge < 0)
    long = last - first + 1 >= FEWEST
    return first[long], last[long]


def _members(first, last):
    """The blocks of all runs in order, and whether each is the first of its run."""
    count = last - first + 1
    begin = np.cumsum(count) - count
    blocks = np.arange(count.sum()) - np.repeat(begin, count) + np.repeat(first, count)
    start = np.zeros(len(blocks), bool)
    start[begin] = True
    return blocks, start


def _solved(path, blocks, start, allowed):
    """The curves of the runs, and at the start of which pieces a run must be broken to stay in the tolerance."""
    lines, i = path.batches[LINE], path.index[blocks]
    step, h = lines.end[i] - lines.start[i], lines.length[i]
    M0, M1 = _second(step / h[:, None], h, start)
    return Curves(_pieces(lines.start[i], step, h, M0, M1)), _breaks(h, M0, M1, start, allowed)


def _turned(path, blocks, start, length, allowed):
    """Coefficients (n, 6, 3) of a b c along the pieces by length / whole length, and breaks as above."""
    abc0 = path.abc0[blocks]
    step = path.turn[blocks] * path.extent[blocks][:, None]
    if not step.any():
        return None, np.zeros(len(blocks), bool)
    M0, M1 = _second(step / length[:, None], length, start)
    # the axis turns by sqrt(2) |change of a b c| at most: the first and third axis may stand close together
    return _pieces(abc0, step, length, M0, M1), _breaks(length, M0, M1, start, allowed / np.sqrt(2))


def _second(slope, h, start):
    """M of eq. (1) at both ends of each piece, all runs at once.  slope (n, 3), h (n,) -> (n, 3), (n, 3)."""
    from scipy.linalg import solve_banded  # here, so that programs without splines do not wait for scipy

    n = len(h)
    inner = ~start
    # row k belongs to the start of piece k; at the start of a run M = 0
    bands = np.zeros((3, n))
    bands[1] = np.where(inner, 2 * (np.append(0.0, h[:-1]) + h), 1.0)
    bands[0, 1:] = np.where(inner[:-1] & inner[1:], h[:-1], 0.0)
    bands[2, :-1] = np.where(inner[1:] & inner[:-1], h[:-1], 0.0)
    right = np.zeros((n, 3))
    right[1:] = 6 * (slope[1:] - slope[:-1])
    right[start] = 0.0
    M0 = solve_banded((1, 1), bands, right, check_finite=False)
    M1 = np.zeros((n, 3))
    M1[:-1] = np.where(inner[1:, None], M0[1:], 0.0)
    return M0, M1


def _pieces(p, step, h, M0, M1):
    """Coefficients of eq. (2).  (n, 6, 3)."""
    out = np.zeros((len(h), 6, 3))
    h2 = (h * h)[:, None]
    out[:, 0], out[:, 1] = p, step - h2 * (2 * M0 + M1) / 6
    out[:, 2], out[:, 3] = h2 * M0 / 2, h2 * (M1 - M0) / 6
    return out


def _breaks(h, M0, M1, start, allowed):
    """At the start of which pieces to break a run: of a piece too far from its chord the end with the larger M."""
    m0, m1 = norm(M0), norm(M1)
    bad = np.flatnonzero(h * h * np.maximum(m0, m1) / 8 > allowed)
    at = np.where(m0[bad] >= m1[bad], bad, bad + 1)
    out = np.zeros(len(h) + 1, bool)
    out[at] = True
    # a kink shakes its neighbours too: only the largest M of neighbouring breaks counts in this round
    m = np.append(m0, 0.0)
    left, right = np.append(0.0, np.where(out, m, 0.0)[:-1]), np.append(np.where(out, m, 0.0)[1:], 0.0)
    out &= (m >= left) & (m > right)
    return out[:-1] & ~start


def _replaced(path, blocks, curves, angles):
    """The path with these blocks as curves."""
    columns = {name: getattr(path, name).copy() for name in ("kind", "index", "abc0", "feed", "dwell", "tolerance")}
    columns |= {name: getattr(path, name) for name in ("rapid", "line", "tool", "spindle")}
    columns["abc1"] = path.angles(np.arange(len(path)), path.extent)
    columns["kind"][blocks], columns["index"][blocks] = CURVE, np.arange(len(blocks))
    bent = None if angles is None else (blocks, angles)
    return Path.of(columns, [*path.batches[:CURVE], curves], bent, path)


def through(points, angles=None, closed: bool = False):
    """A curve through points (n, 3) m, and angles (n, 3) rad that change with it, both without a jump of a second
    derivative by length; `closed` runs on to the first point and has no jump there either.

    The knots are the lengths of the curve itself, found by solving again with the lengths of the last answer; where
    the points jump about, those of its chords.  An open curve has one cubic on its first two pieces and one on its
    last two.  Returns (Curves, coefficients (m, 6, 3) of a b c or None).
    """
    from scipy.interpolate import CubicSpline

    ends = "periodic" if closed else "not-a-knot"
    if closed:
        points = np.concatenate([points, points[:1]])
        angles = None if angles is None else np.concatenate([angles, angles[:1]])

    def pieces(values, h):
        spline = CubicSpline(np.concatenate([[0.0], np.cumsum(h)]), values, bc_type=ends)
        out = np.zeros((len(h), 6, 3))
        for k in range(4):
            out[:, k] = spline.c[3 - k] * (h**k)[:, None]
        return out

    h = chords = norm(np.diff(points, axis=0))
    for _ in range(_LENGTHS):
        curves = Curves(pieces(points, h))
        if (curves.length > 2 * chords).any():
            break  # points that show no curve: longer knots would make longer loops
        h = curves.length
    return curves, None if angles is None else pieces(angles, h)
