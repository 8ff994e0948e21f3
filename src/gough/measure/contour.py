"""Contour error: how far the tool is from the path, not from where it should be on it.

At a sample, with the tip of the tool in use truly at p (T stands at R o from it), the reference at path length s_r
and a window of 5 mm + 0.1 s of feed:

    s = argmin |p - P(s)|, |s - s_r| <= window;   contour error |p - P(s)|;   lag s_r - s                           (1)
    orientation error: the angle between the true tool axis and the programmed one at s                             (2)
    on a circle: radial error |p' - c| - r, p' the projection of p into its plane; outside +                       (3)

The path is the programmed one: corners are sharp, whatever blends were driven.  The window alone keeps the search on
its own branch of the path.  Where a turn at rest lies between s and s_r the path has two orientations at one s; the
axis of the reference is taken then, as during the turn itself.

Blocks whose midpoint is farther from p than the reference is, by more than half their length, cannot hold the closest
point: no point of a block is farther from its midpoint than half its length.  Sixteen blocks together are tried first.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..frames import rotation_of_quaternion_np
from ..program.blocks import REST
from ..program.reference import Book, Motion
from ..program.segments import cross, dot, norm, rotated

_BUNDLE = 16
_ALONG = 1e-11  # of a window of 10 mm 1e-13 m: above rounding, below what is measured
_SLAB = 200_000  # pairs of sample and block looked at together, some 30 MB


class Contour(NamedTuple):
    """Rows for n samples, or (n, runs)."""

    contour_error: np.ndarray  # m, >= 0
    orientation_error: np.ndarray  # rad, >= 0
    lag: np.ndarray  # m, positive when the tool is behind
    radial_error: np.ndarray  # m, outside +; 0 where circle is 0
    circle: np.ndarray  # int16, number of the circle the reference is on, or 0


class ContourMeter:
    """Measures against the path of one motion."""

    def __init__(self, motion: Motion):
        self.motion = motion
        path = motion.path
        self._path = path
        self._blocks = _Balls(path, path.s0[:-1], path.s0[1:])
        first = np.arange(0, len(path), _BUNDLE)
        self._bundles = _Balls(path, path.s0[first], path.s0[np.minimum(first + _BUNDLE, len(path))])
        # a new stretch begins behind every turn at rest
        self._stretch = np.cumsum(path.turning_at_rest)
        self._offset = bool(path.tool.any())
        # with another tool another tip is on the path: what the last one ran along is not the path of this one
        self._tool = np.concatenate([[0], np.cumsum((path.tool[1:] != path.tool[:-1]).any(1))])
        rounds = path.circles
        none = [np.zeros(3)]
        self._center = np.array(none + [c.center for c in rounds])
        self._normal = np.array(none + [c.normal for c in rounds])
        self._radius = np.array([0.0] + [c.radius for c in rounds])

    def __call__(self, k0: int, k1: int, Ts: float, x_true, book: Book | None = None) -> Contour:
        """Errors at samples k0 ... k1 - 1 of period Ts s.

        `x_true` (n, 7) or (n, runs, 7): true position of T in W, m, and unit quaternion w x y z of R_WT.  What is
        measured is the tip of the tool in use.
        Rows with NaN give NaN.  `book` says where on the path the samples belong, columns (n,) or (n, runs), if not
        where the motion has them.
        """
        x_true = np.asarray(x_true, float)
        runs = x_true.shape[1:-1]
        book = self.motion.book(k0, k1, Ts) if book is None else book
        place = (a if a.ndim > len(runs) else np.repeat(a, runs[0]) for a in (book.s, book.window, book.block, book.u))
        out = self._measure(*(a.reshape(-1) for a in place), x_true.reshape(-1, 7))
        return Contour(*(a.reshape((k1 - k0,) + runs) for a in out))

    def _measure(self, s_r, window, block, u_r, x):
        path, p = self._path, x[:, :3]
        if self._offset:  # the tip of the tool in use: T stands at `tool` from it
            p = p - rotated(rotation_of_quaternion_np(x[:, 3:]), path.tool[block])
        distance, at, s = self.closest(p, s_r, window, block)
        # the programmed axis at the closest point, or that of the reference
        own = (path.kind[block] == REST) | (self._stretch[at] != self._stretch[block])
        there = np.where(own, block, at)
        where = np.where(own, u_r, s - path.s0[at])
        programmed = path.rotation(path.angles(there, where))[..., 2]
        true = axis_of_quaternion(x[:, 3:])
        angle = np.arctan2(norm(cross(true, programmed)), dot(true, programmed))
        circle = path.circle[block]
        d = p - self._center[circle]
        height = dot(d, self._normal[circle])[:, None]
        radial = norm(d - height * self._normal[circle]) - self._radius[circle]
        return distance, angle, s_r - s, np.where(circle > 0, radial, 0.0), circle

    def closest(self, p, s_r, window, block):
        """Distance m, block and path length m of the points closest to p (n, 3), within `window` (n,) of s_r (n,).

        `block` (n,) is the block of the reference: its own point is the first candidate.
        """
        path = self._path
        lo, hi = np.maximum(s_r - window, 0.0), np.minimum(s_r + window, path.s0[-1])
        at, s = block.astype(np.int64), s_r.copy()
        distance = norm(p - path.point(at, s_r - path.s0[at]))
        # blocks that overlap the window
        first = np.searchsorted(path.s0[1:], lo, "left")
        last = np.searchsorted(path.s0[:-1], hi, "right") - 1
        last = np.minimum(np.maximum(last, first), len(path) - 1)
        first = np.minimum(first, last)
        few = last - first < _BUNDLE
        for rows, many in ((np.flatnonzero(few), False), (np.flatnonzero(~few), True)):
            start = 0
            while start < len(rows):
                count = (last - first)[rows[start:]] + 1
                stop = start + max(1, int(np.searchsorted(np.cumsum(count), _SLAB)))
                part = rows[start:stop]
                pairs = _pairs(part, first[part], last[part])
                if many:
                    pairs = self._by_bundles(part, p, distance, first, last)
                self._improve(*pairs, p, lo, hi, s_r, distance, at, s)
                start = stop
        return distance, at, s

    def _by_bundles(self, rows, p, distance, first, last):
        """Pairs of rows and blocks, by bundles that are near enough."""
        row, bundle = _pairs(rows, first[rows] // _BUNDLE, last[rows] // _BUNDLE)
        near = self._bundles.reach(row, bundle, p, distance)
        row, bundle = row[near], bundle[near]
        begin = np.maximum(bundle * _BUNDLE, first[row])
        return _pairs(row, begin, np.minimum(bundle * _BUNDLE + _BUNDLE - 1, last[row]))

    def _improve(self, row, block, p, lo, hi, s_r, distance, at, s):
        """Take the closest points of the given pairs of row and block where they are nearer than what is known."""
        path = self._path
        near = self._blocks.reach(row, block, p, distance)
        if self._tool[-1]:
            near &= self._tool[block] == self._tool[at[row]]
        row, block = row[near], block[near]
        if not len(row):
            return
        begin, length = path.s0[block], path.length[block]
        low, high = np.maximum(lo[row] - begin, 0.0), np.minimum(hi[row] - begin, length)
        low = np.minimum(low, high)
        tip = p[row]
        u = path.closest(block, tip, low, high, s_r[row] - begin)
        found = norm(tip - path.point(block, u))
        # the best of each row.  Where the path runs back over itself two points are equally near to rounding; the one
        # nearest to the reference is the tool's then, so metres along the path count a little
        cost = found + _ALONG * np.abs(begin + u - s_r[row])
        order = np.lexsort((cost, row))
        row, block, u, found, cost = row[order], block[order], u[order], found[order], cost[order]
        lead = np.flatnonzero(np.concatenate([[True], row[1:] != row[:-1]]))
        lead = lead[cost[lead] < distance[row[lead]] + _ALONG * np.abs(s[row[lead]] - s_r[row[lead]])]
        best = row[lead]
        distance[best], at[best], s[best] = found[lead], block[lead], path.s0[block[lead]] + u[lead]


class _Balls:
    """For pieces of the path, from path length a to b: midpoint and half the length."""

    def __init__(self, path, a, b):
        self.half = (b - a) / 2
        i, u = path.locate((a + b) / 2)
        u = np.minimum(u, path.length[i])
        self.middle = path.point(i, u)

    def reach(self, row, piece, p, distance):
        """Whether a piece may hold a point nearer than `distance` to p; NaN may not."""
        gap = norm(p[row] - self.middle[piece]) - self.half[piece]
        return gap <= distance[row] + 1e-12  # rounding of positions of metres


def _pairs(rows, first, last):
    """Each of rows with each of first ... last, in the order of rows."""
    count = np.where(last >= first, last - first + 1, 0)
    row = np.repeat(rows, count)
    begin = np.repeat(np.cumsum(count) - count, count)
    return row, np.arange(len(row)) - begin + np.repeat(first, count)


def axis_of_quaternion(quat):
    """Third column of R(q), the tool axis.  (..., 4) w x y z -> (..., 3)."""
    w, x, y, z = (quat[..., i] for i in range(4))
    return np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), w * w - x * x - y * y + z * z], -1)
