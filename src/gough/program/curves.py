"""Polynomial curves by arc length, many at a time; the methods are those of segments.py.

    p(t) = c_0 + c_1 t + ... + c_5 t^5,   0 <= t <= 1,   v = |dp/dt| > 0                                           (1)
    s(t) = integral of v from 0 to t                          Gauss-Legendre with 8 points on each of 16 pieces     (2)
    T = p' / v,   K = (p'' - (T p'') T) / v^2,   ' = d/dt                                      dp/ds and d2p/ds2    (3)
    dK/ds = (p''' - v'' T - 3 v v' K) / v^3,   v' = T p'',   v'' = (p'' p'' + p' p''' - v'^2) / v                   (4)

(4) is the derivative of p'' = v' T + v^2 K.  t of a given s is found by Newton's method on (2), whose derivative is v,
from a cubic through the ends of its piece.  What v does on a piece decides how exact (2) is: a curve that turns by
150 degrees within a length has its nearest branch point 2.9 half pieces off the real axis, and an error of 1e-12 of
its length.
"""

from __future__ import annotations

import numpy as np

from .minimise import closest_parameter
from .segments import cross, dot, norm, rotated, within

_PIECES = 16
_NODES, _WEIGHTS = (a.tolist() for a in np.polynomial.legendre.leggauss(8))
_ROWS = 4096  # rows worked on together: what they need stays in the cache
_ENOUGH = 1e-9  # a Newton step in t; the error behind it is its square times v'/2v, below rounding
_SAMPLES, _GOLDEN = 33, (np.sqrt(5) - 1) / 2
_MARGIN = 1 + 3e-4  # of sharpest and third: the golden sections end within 1e-3 of t, the value within 1e-5 of its peak


def hermite(p0, p1, v0, v1, a0, a1):
    """Coefficients of the quintics with these ends, velocities and accelerations by t.  (m, 3) each -> (m, 6, 3)."""
    step = p1 - p0
    return np.stack(
        [
            p0,
            v0,
            a0 / 2,
            10 * step - 6 * v0 - 4 * v1 - 1.5 * a0 + 0.5 * a1,
            -15 * step + 8 * v0 + 7 * v1 + 1.5 * a0 - a1,
            6 * step - 3 * v0 - 3 * v1 - 0.5 * a0 + 0.5 * a1,
        ],
        1,
    )


def restricted(c, t0, t1):
    """Coefficients of the same quintics run from t0 to t1 (m,) as from 0 to 1.  (m, 6, 3) -> (m, 6, 3)."""
    out, t0, width = c.copy(), t0[:, None], (t1 - t0)[:, None]
    for k in range(5):  # to powers of t - t0, by synthetic division
        for j in range(4, k - 1, -1):
            out[:, j] += t0 * out[:, j + 1]
    power = width
    for k in range(1, 6):
        out[:, k] *= power
        power = power * width
    return out


class Curves:
    """Curves (1) with the coefficients (m, 6, 3) in m; the speed v may vanish nowhere."""

    def __init__(self, coefficients):
        self.c = np.array(coefficients, float).reshape(-1, 6, 3)
        self.table = np.zeros((len(self.c), _PIECES + 1))  # s at the ends of the pieces
        for k in range(0, len(self.c), _ROWS):
            c = _columns(self.c[k : k + _ROWS])
            for j in range(_PIECES):
                piece = _arc_length(c, np.full(len(c[0]), j / _PIECES), 1 / _PIECES)
                self.table[k : k + _ROWS, j + 1] = self.table[k : k + _ROWS, j] + piece
        self.length = self.table[:, -1].copy()
        self._turning = None

    def parameter(self, i, s):
        """t of the arc lengths s (n,) on the curves i (n,), the inverse of (2).  (n,) in [0, 1]."""
        length = self.length[i]
        out = np.where(s >= length, 1.0, 0.0 * s)  # NaN stays
        inside = np.flatnonzero((s > 0) & (s < length))
        for k in range(0, len(inside), _ROWS):
            rows = inside[k : k + _ROWS]
            out[rows] = self._parameter(i[rows], s[rows])
        return out

    def _parameter(self, i, s):
        table, c = self.table[i], _columns(self.c[i])
        j = (table[:, 1:-1] <= s[:, None]).sum(1)
        row = np.arange(len(i))
        s0, left = table[row, j], j / _PIECES
        right = left + 1 / _PIECES
        t = _start(s - s0, table[row, j + 1] - s0, norm(_first(c, left)), norm(_first(c, right)))
        t = left + np.minimum(np.maximum(t, 0.0), 1.0) / _PIECES
        base, going = left, np.ones(len(i), bool)
        for _ in range(60):
            off = s0 + _arc_length(c, base, t - base) - s
            left, right = np.where(off < 0, t, left), np.where(off > 0, t, right)
            step = t - off / norm(_first(c, t))
            step = np.where((step >= left) & (step <= right), step, (left + right) / 2)
            moved = np.abs(step - t)
            t = np.where(going, step, t)
            going &= moved > _ENOUGH  # NaN does not go on
            if not going.any():
                break
        return t

    def at(self, i, t):
        """Positions at the parameters t (n,).  (n, 3) m."""
        return _stack(_position(_columns(self.c[i]), t))

    def frame(self, i, s):
        """Position, unit tangent and curvature vector, eq. (3).  (n, 3) each."""
        t, c = self.parameter(i, s), _columns(self.c[i])
        d1, d2 = _first(c, t), _second(c, t)
        v = norm(d1)[:, None]
        T = d1 / v
        return _stack(_position(c, t)), T, (d2 - dot(T, d2)[:, None] * T) / v**2

    def point(self, i, s):
        return self.at(i, self.parameter(i, s))

    def tangent(self, i, s):
        d1 = _first(_columns(self.c[i]), self.parameter(i, s))
        return d1 / norm(d1)[:, None]

    def bend(self, i, s):
        return self.frame(i, s)[2]

    def sharpest(self):
        return self._peak(_curvature)

    def third(self):
        return self._peak(_curvature_rate)

    def _peak(self, what):
        """Largest `what`(c, t) of each curve: the largest of the samples, then golden sections beside it."""
        out = np.zeros(len(self.c))
        for k in range(0, len(out), _ROWS):
            c = _columns(self.c[k : k + _ROWS])
            grid = np.linspace(0, 1, _SAMPLES)
            value = np.stack([what(c, np.full(len(c[0]), t)) for t in grid], 1)
            best, top = np.argmax(value, 1), value.max(1)
            a, b = grid[np.maximum(best - 1, 0)], grid[np.minimum(best + 1, _SAMPLES - 1)]
            x, y = b - _GOLDEN * (b - a), a + _GOLDEN * (b - a)
            fx, fy = what(c, x), what(c, y)
            for _ in range(9):  # from 1/16 to 1/1200
                up = fx < fy
                top = np.maximum(top, np.maximum(fx, fy))
                a, b = np.where(up, x, a), np.where(up, b, y)
                x, y = np.where(up, y, b - _GOLDEN * (b - a)), np.where(up, a + _GOLDEN * (b - a), x)
                f = what(c, np.where(up, y, x))
                fx, fy = np.where(up, fy, f), np.where(up, f, fx)
            out[k : k + _ROWS] = np.maximum(top, np.maximum(fx, fy)) * _MARGIN
        return out

    def closest(self, i, p, lo, hi, near):
        if self._turning is None:
            self._turning = self._turned()
        scale = self._turning[i]  # `closest_parameter` wants something like an angle
        c = _columns(self.c[i])

        def row(k):
            return tuple(column[k][:, None, :] for column in c)

        def distance(k, a):
            d = _stack(_position(row(k), a / scale[k, None])) - p[k, None]
            return dot(d, d)

        def slope(k, a):
            t, w = a / scale[k, None], scale[k, None]
            q = row(k)
            d, d1, d2 = _stack(_position(q, t)) - p[k, None], _first(q, t), _second(q, t)
            return dot(d, d1) / w, (dot(d1, d1) + dot(d, d2)) / w**2

        low, high = self.parameter(i, lo) * scale, self.parameter(i, hi) * scale
        a = closest_parameter(distance, slope, low, high)
        s = self.arc_length(i, np.where(np.isnan(a), 0.0, a / scale))
        s = np.where(a == low, lo, np.where(a == high, hi, s))
        return within(np.where(np.isnan(a), np.nan, s), lo, hi)

    def arc_length(self, i, t):
        """s of the parameters t (n,), eq. (2).  (n,) m."""
        j = np.minimum((t * _PIECES).astype(int), _PIECES - 1)
        base = j / _PIECES
        return self.table[i, j] + _arc_length(_columns(self.c[i]), base, t - base)

    def _turned(self):
        """As many times the tangent's largest turn on a piece as there are pieces, at least one sample.  (m,)."""
        c = _columns(self.c)
        most = np.zeros(len(self.c))
        last = _first(c, np.zeros(len(most)))
        for j in range(1, _PIECES + 1):
            d = _first(c, np.full(len(most), j / _PIECES))
            most = np.maximum(most, np.arctan2(norm(cross(last, d)), dot(last, d)))
            last = d
        return _PIECES * most + 0.1

    def cut(self, i, lo, hi) -> Curves:
        """The curves i (n,) from the arc length lo to hi (n,)."""
        return Curves(restricted(self.c[i], self.parameter(i, lo), self.parameter(i, hi)))

    @staticmethod
    def joined(parts) -> Curves:
        """The curves of all parts, in order."""
        out = object.__new__(Curves)
        for name in ("c", "table", "length"):
            setattr(out, name, np.concatenate([getattr(part, name) for part in parts]))
        out._turning = None
        return out

    def chosen(self, i) -> Curves:
        """The curves i (n,), as they are."""
        out = object.__new__(Curves)
        out.c, out.table, out.length, out._turning = self.c[i], self.table[i], self.length[i], None
        return out

    def placed(self, p_WO, R_WO) -> Curves:
        """The same segments moved: position p_WO + R_WO p."""
        moved = object.__new__(Curves)
        moved.c = rotated(R_WO, self.c)
        moved.c[:, 0] += p_WO
        # a rotation only rounds lengths
        moved.table, moved.length, moved._turning = self.table, self.length, self._turning
        return moved


# -- a curve as its six coefficient rows, each (n, 3) or, for many parameters each, (n, 1, 3) ----------------------


def _columns(c):
    return tuple(np.ascontiguousarray(c[:, k]) for k in range(6))


def _stack(parts):
    """Coefficient 0 last: what is small is added up first, so that a curve ends where the next begins, to rounding."""
    start, rest = parts
    return start + rest


def _position(c, t):
    t = t[..., None]
    return c[0], t * (c[1] + t * (c[2] + t * (c[3] + t * (c[4] + t * c[5]))))


def _first(c, t):
    t = t[..., None]
    return c[1] + t * (2 * c[2] + t * (3 * c[3] + t * (4 * c[4] + t * (5 * c[5]))))


def _second(c, t):
    t = t[..., None]
    return 2 * c[2] + t * (6 * c[3] + t * (12 * c[4] + t * (20 * c[5])))


def _third(c, t):
    t = t[..., None]
    return 6 * c[3] + t * (24 * c[4] + t * (60 * c[5]))


def _arc_length(c, base, width):
    """Integral of v from base to base + width, eq. (2)."""
    half = width / 2
    middle = base + half
    total = 0.0
    for x, w in zip(_NODES, _WEIGHTS, strict=True):
        total = total + w * norm(_first(c, middle + half * x))
    return half * total


def _start(s, length, v0, v1):
    """x of the arc length s on a piece of that length, by the cubic with slopes 1/v at its ends; x in [0, 1]."""
    a = s / length
    m0, m1 = length / v0 * _PIECES, length / v1 * _PIECES
    return a * (m0 + a * (3 - 2 * m0 - m1 + a * (m0 + m1 - 2)))


def _curvature(c, t):
    d1, d2 = _first(c, t), _second(c, t)
    v2 = dot(d1, d1)
    return norm(cross(d1, d2)) / (v2 * np.sqrt(v2))


def _curvature_rate(c, t):
    d1, d2, d3 = _first(c, t), _second(c, t), _third(c, t)
    v = norm(d1)
    T = d1 / v[..., None]
    v1 = dot(T, d2)
    v2 = (dot(d2, d2) + dot(d1, d3) - v1 * v1) / v
    K = (d2 - v1[..., None] * T) / (v * v)[..., None]
    return norm(d3 - v2[..., None] * T - (3 * v * v1)[..., None] * K) / v**3
