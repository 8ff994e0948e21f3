"""Ellipses by arc length, many at a time; the methods are those of segments.py.

    p(phi) = c + a cos(phi) e1 + b sin(phi) e2,   a >= b,      ds/dphi = a sqrt(1 - k cos^2 phi),   k = 1 - (b/a)^2  (1)
    s(phi) = a (E(phi - pi/2 | k) - E(phi_0 - pi/2 | k))       E: incomplete elliptic integral, second kind (2)

phi of a given s is found by Newton's method on (2): its derivative (1) lies between b and a, never zero.
"""

from __future__ import annotations

import numpy as np

from .minimise import closest_parameter
from .segments import _rows, dot, norm, rotated, within

_TABLE = 64  # entries of the starting table for a quarter turn


class Ellipses:
    """Arcs of ellipses (1): centre (m, 3), the two half axes as perpendicular vectors `first` and `second` (m, 3),
    from phi = `start` on by `sweep` > 0 rad (m,), turning from `first` towards `second`, several turns allowed."""

    def __init__(self, center, first, second, start, sweep):
        self.center, self.first, self.second = _rows(center), _rows(first), _rows(second)
        self.start, self.sweep = (np.array(a, float).reshape(-1) for a in (start, sweep))
        self._major, self._minor, self._from = self.first.copy(), self.second.copy(), self.start.copy()
        # (2) needs the long axis first: turn the names by a quarter
        swap = norm(self.first) < norm(self.second)
        self._major[swap], self._minor[swap] = self.second[swap], -self.first[swap]
        self._from[swap] -= np.pi / 2
        self.a, self.b = norm(self._major), norm(self._minor)
        self.k = 1 - (self.b / self.a) ** 2
        every = np.arange(len(self.a))
        self._offset = np.zeros(len(self.a))
        self._offset = self._arc_length(every, self._from)
        self.length = self._arc_length(every, self._from + self.sweep)

    def _arc_length(self, i, phi):
        """s(phi), eq. (2).  (n,) m."""
        if not len(i):
            return np.zeros(0)
        from scipy.special import ellipeinc  # here, so that programs without ellipses do not wait for scipy

        return self.a[i] * ellipeinc(phi - np.pi / 2, self.k[i]) - self._offset[i]

    def _angle(self, i, s):
        """phi(s), the inverse of (2).  (n,) rad."""
        phi = np.empty(len(i))
        for j in np.unique(i):  # a starting table for each ellipse; programs have few
            turns = 4 * int(np.ceil(self.sweep[j] / (2 * np.pi))) * _TABLE
            grid = self._from[j] + np.linspace(0, self.sweep[j], turns + 1)
            rows = i == j
            phi[rows] = np.interp(s[rows], self._arc_length(np.full(turns + 1, j), grid), grid)
        a, k = self.a[i], self.k[i]
        going = np.ones(len(i), bool)  # each row stops by itself, so that it does not depend on the others
        for _ in range(8):
            step = (self._arc_length(i, phi) - s) / (a * np.sqrt(1 - k * np.cos(phi) ** 2))
            phi = np.where(going, phi - step, phi)
            going &= np.abs(step) > 1e-15 * (1 + np.abs(phi))
            if not going.any():
                break
        return np.where(np.isnan(s), np.nan, phi)

    def parameter(self, i, s):
        """The parameter phi of the arc lengths s (n,) from the start, counted from `first`.  (n,) rad."""
        return self._angle(i, s) + (self.start - self._from)[i]

    def _frame(self, i, s):
        phi = self._angle(i, s)
        c, n = np.cos(phi)[:, None], np.sin(phi)[:, None]
        major, minor = self._major[i], self._minor[i]
        speed = c * minor - n * major  # dp/dphi
        return c, n, major, minor, speed / norm(speed)[:, None], norm(speed)[:, None]

    def point(self, i, s):
        c, n, major, minor, _, _ = self._frame(i, s)
        return self.center[i] + c * major + n * minor

    def tangent(self, i, s):
        return self._frame(i, s)[4]

    def bend(self, i, s):
        c, n, major, minor, t, rate = self._frame(i, s)
        pull = -(c * major + n * minor)  # d2p/dphi2
        return (pull - dot(pull, t)[:, None] * t) / rate**2

    def sharpest(self):
        return self.a / self.b**2

    def third(self):
        # the third derivative is k' n - k^2 t;  k = a b / v^3, v = ds/dphi,
        # k' = -3 a b (a^2 - b^2) sin(phi) cos(phi) / v^6
        phi = np.linspace(0, np.pi / 2, 721)  # by symmetry; the maximum lies within 1e-5 of the largest sample
        a, b = self.a[:, None], self.b[:, None]
        v = np.sqrt((a * np.sin(phi)) ** 2 + (b * np.cos(phi)) ** 2)
        change = 3 * a * b * (a * a - b * b) * np.sin(phi) * np.cos(phi) / v**6
        return 1.00001 * np.hypot(change, (a * b / v**3) ** 2).max(1, initial=0.0)

    def closest(self, i, p, lo, hi, near):
        d = p - self.center[i]
        a, b = self.a[i], self.b[i]
        x, y = dot(d, self._major[i]) / a, dot(d, self._minor[i]) / b

        def distance(q, phi):
            q = (q, None)
            return (a[q] * np.cos(phi) - x[q]) ** 2 + (b[q] * np.sin(phi) - y[q]) ** 2

        def slope(q, phi):
            q = (q, None)
            c, n, a2, b2 = np.cos(phi), np.sin(phi), a[q] ** 2, b[q] ** 2
            g = a[q] * x[q] * n - b[q] * y[q] * c - (a2 - b2) * n * c
            return g, a[q] * x[q] * c + b[q] * y[q] * n - (a2 - b2) * (c * c - n * n)

        low, high = self._angle(i, lo), self._angle(i, hi)
        phi = closest_parameter(distance, slope, low, high)
        s = self._arc_length(i, phi)
        return within(np.where(phi == low, lo, np.where(phi == high, hi, s)), lo, hi)

    def placed(self, p_WO, R_WO) -> Ellipses:
        """The same segments moved: position p_WO + R_WO p."""
        first, second = rotated(R_WO, self.first), rotated(R_WO, self.second)
        return Ellipses(p_WO + rotated(R_WO, self.center), first, second, self.start, self.sweep)
