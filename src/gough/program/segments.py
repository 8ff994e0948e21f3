"""Lines, arcs, helices and points by arc length, many at a time.

A batch holds m segments as arrays.  Its methods take the numbers i of n segments and n arc lengths s from the start of
each, and answer n rows; every kind of segment answers the same six:

    point(i, s)       p(s)         (n, 3) m
    tangent(i, s)     p'(s)        (n, 3) unit
    bend(i, s)        p''(s)       (n, 3) 1/m, towards the centre of curvature; zero where straight
    sharpest()        largest |p''| of each segment, (m,) 1/m
    third()           largest |p'''| of each segment, (m,) 1/m2
    closest(i, p, lo, hi, near)    s in [lo, hi] of the point closest to p; of equally close ones that nearest to `near`

Arc and helix, turning by theta = s / g about the axis n through c, with a rise of h along n for each radian:
    p = c + r (cos theta e1 + sin theta e2) + h theta n,    n = e1 x e2,    g^2 = r^2 + h^2                        (1)

Sums over the three coordinates are written out: BLAS and einsum round differently for different numbers of rows, and
a motion sampled in chunks must be the motion sampled whole, bit for bit.
"""

from __future__ import annotations

import numpy as np

from .minimise import closest_parameter


def dot(a, b):
    """Row-wise scalar product.  (..., 3), (..., 3) -> (...)."""
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]


def norm(a):
    """Row-wise length.  (..., 3) -> (...)."""
    return np.sqrt(dot(a, a))


def cross(a, b):
    """Row-wise vector product.  (..., 3), (..., 3) -> (..., 3)."""
    return np.stack(
        [
            a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1],
            a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2],
            a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0],
        ],
        -1,
    )


def rotated(R, a):
    """R a for every row, summed in one order.  (3, 3) or (..., 3, 3), (..., 3) -> (..., 3)."""
    return np.stack([dot(R[..., i, :], a) for i in range(3)], -1)


def within(s, lo, hi):
    """s limited to [lo, hi]; NaN stays NaN."""
    return np.where(s < lo, lo, np.where(s > hi, hi, s))


def _rows(values, width=3):
    return np.array(values, float).reshape((-1, width))


class Points:
    """Segments without length: the tool rests, or turns about its tip.  `direction` says where the path went to."""

    def __init__(self, position, direction):
        self.position, self.direction = _rows(position), _rows(direction)
        self.length = np.zeros(len(self.position))

    def point(self, i, s):
        return self.position[i]

    def tangent(self, i, s):
        return self.direction[i]

    def bend(self, i, s):
        return np.zeros((len(i), 3))

    def sharpest(self):
        return np.zeros(len(self.length))

    def third(self):
        return np.zeros(len(self.length))

    def closest(self, i, p, lo, hi, near):
        return np.zeros(len(i)) + 0 * p[..., 0]

    def placed(self, p_WO, R_WO) -> Points:
        """The same segments moved: position p_WO + R_WO p."""
        return Points(p_WO + rotated(R_WO, self.position), rotated(R_WO, self.direction))


class Lines:
    """Straight segments from `start`, (m, 3), to `end`, (m, 3).  None has length zero."""

    def __init__(self, start, end):
        self.start, self.end = _rows(start), _rows(end)
        step = self.end - self.start
        self.length = norm(step)
        self.direction = step / self.length[:, None]

    def point(self, i, s):
        # from the nearer end, so that the last point is the end itself and not the end to rounding
        length = self.length[i]
        last = 2 * s > length
        base = np.where(last[:, None], self.end[i], self.start[i])
        return base + np.where(last, s - length, s)[:, None] * self.direction[i]

    def tangent(self, i, s):
        return self.direction[i]

    def bend(self, i, s):
        return np.zeros((len(i), 3))

    def sharpest(self):
        return np.zeros(len(self.length))

    def third(self):
        return np.zeros(len(self.length))

    def closest(self, i, p, lo, hi, near):
        return within(dot(p - self.start[i], self.direction[i]), lo, hi)

    def placed(self, p_WO, R_WO) -> Lines:
        """The same segments moved: position p_WO + R_WO p."""
        return Lines(p_WO + rotated(R_WO, self.start), p_WO + rotated(R_WO, self.end))


class Arcs:
    """Arcs and helices (1).

    `center` (m, 3) lies on the axis at the height of the start, `radial` (m, 3) leads from it to the start,
    `normal` (m, 3) is the unit axis; the turn is right-handed about it by `sweep` > 0 rad (m,), several turns allowed,
    while the point rises by `rise` m (m,) along it.
    """

    def __init__(self, center, radial, normal, sweep, rise):
        self.center, radial, self.normal = _rows(center), _rows(radial), _rows(normal)
        self.sweep, self.rise = (np.array(a, float).reshape(-1) for a in (sweep, rise))
        self.radius = norm(radial)
        self.e1 = radial / self.radius[:, None]
        self.e2 = cross(self.normal, self.e1)
        self.pitch = self.rise / self.sweep
        self.gain = np.hypot(self.radius, self.pitch)
        self.length = self.gain * self.sweep

    def _turn(self, i, s):
        theta = s / self.gain[i]
        return theta, np.cos(theta)[:, None], np.sin(theta)[:, None]

    def point(self, i, s):
        theta, c, n = self._turn(i, s)
        radius, rise = self.radius[i][:, None], (self.pitch[i] * theta)[:, None]
        return self.center[i] + radius * (c * self.e1[i] + n * self.e2[i]) + rise * self.normal[i]

    def tangent(self, i, s):
        _, c, n = self._turn(i, s)
        radius, pitch, gain = (a[i][:, None] for a in (self.radius, self.pitch, self.gain))
        return (radius * (c * self.e2[i] - n * self.e1[i]) + pitch * self.normal[i]) / gain

    def bend(self, i, s):
        _, c, n = self._turn(i, s)
        return -(self.radius / self.gain**2)[i][:, None] * (c * self.e1[i] + n * self.e2[i])

    def sharpest(self):
        return self.radius / self.gain**2

    def third(self):
        return self.radius / self.gain**3

    def closest(self, i, p, lo, hi, near):
        d = p - self.center[i]
        across, along, height = dot(d, self.e1[i]), dot(d, self.e2[i]), dot(d, self.normal[i])
        gain = self.gain[i]
        theta = self._closest_flat(across, along, lo / gain, hi / gain, near / gain)
        helix = self.pitch[i] != 0
        if helix.any():
            k = np.flatnonzero(helix)
            theta[k] = self._closest_helix(i[k], across[k], along[k], height[k], (lo / gain)[k], (hi / gain)[k])
        return within(theta * gain, lo, hi)

    def _closest_flat(self, across, along, lo, hi, near):
        """Closed form for a circle: the angle of p, on the turn nearest to `near` that has it, else the nearer end."""
        angle = np.arctan2(along, across)
        turn = angle + 2 * np.pi * np.round((near - angle) / (2 * np.pi))
        # the turn nearest to `near` may lie just outside while its neighbour is inside
        turn = np.where(turn > hi, turn - 2 * np.pi, np.where(turn < lo, turn + 2 * np.pi, turn))
        inside = (turn >= lo) & (turn <= hi)
        # distance from p to a point of the circle falls with the cosine of the angle between them
        end = np.where(np.cos(hi - angle) > np.cos(lo - angle), hi, lo)
        return np.where(inside | np.isnan(turn), turn, end)

    def _closest_helix(self, i, across, along, height, lo, hi):
        r, h = self.radius[i], self.pitch[i]

        def slope(k, theta):  # half the derivative of the squared distance, and its derivative
            r_, h_ = r[k, None], h[k, None]
            c, n = np.cos(theta), np.sin(theta)
            x, y, z = across[k, None], along[k, None], height[k, None]
            return r_ * (x * n - y * c) + h_ * (h_ * theta - z), r_ * (x * c + y * n) + h_ * h_

        def distance(k, theta):
            r_, h_ = r[k, None], h[k, None]
            x, y, z = across[k, None], along[k, None], height[k, None]
            return (r_ * np.cos(theta) - x) ** 2 + (r_ * np.sin(theta) - y) ** 2 + (h_ * theta - z) ** 2

        return closest_parameter(distance, slope, lo, hi)

    def placed(self, p_WO, R_WO) -> Arcs:
        """The same segments moved: position p_WO + R_WO p."""
        radial = self.radius[:, None] * self.e1
        return Arcs(
            p_WO + rotated(R_WO, self.center), rotated(R_WO, radial), rotated(R_WO, self.normal), self.sweep, self.rise
        )
