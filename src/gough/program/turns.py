"""How the angles a b c change along blocks, as polynomials of the extent, and bounds of the turning they make.

    abc(u) = k_0 + k_1 x + ... + k_5 x^5,   x = u / L                                    L the block's extent      (1)
    w = E abc' = a' e_a + b' e_b + c' e_z,   e_a = Rz Ry e_x,  e_b = Rz e_y;  ' = d/du                              (2)
    e_a' = (c' e_z + b' e_b) x e_a,   e_b' = c' e_z x e_b                                                         (3)

Between samples h apart a vector function f is within h^2 / 8 max |f''| of the chord, so |f| is at most the larger end
value plus that.  |w''| and |w'''| are bounded through (3) by the largest |a'|, |a''| ... of the samples and, the same
way, of the intervals between them: the answer is a bound, a few per cent above the truth.                        (4)
"""

from __future__ import annotations

import numpy as np

from ..frames import abc_rate_matrix_dot_np, abc_rate_matrix_np
from .segments import norm, rotated

_INTERVALS = 16
_ROWS = 4096  # rows worked on together


def linear_bounds(abc0, turn, extent):
    """Largest |w| and a bound of |w'| where the angles change in proportion: from abc0 by turn (m, 3) a unit of extent.

    |w|^2 = a'^2 + b'^2 + c'^2 - 2 a' c' sin b, and by (3) w' = a' (c' e_z + b' e_b) x e_a + b' c' e_z x e_b.
    """
    a, b, c = np.abs(turn).T
    first, last = abc0[:, 1], abc0[:, 1] + turn[:, 1] * extent
    steepest = np.floor(first / np.pi - 0.5) != np.floor(last / np.pi - 0.5)  # passes an odd multiple of 90 deg
    sine = np.where(steepest, 1.0, np.maximum(np.abs(np.sin(first)), np.abs(np.sin(last))))
    return np.sqrt(a * a + b * b + c * c + 2 * a * c * sine), a * c + a * b + b * c


class Turns:
    """Angles (1): coefficients (m, 6, 3) rad, extents (m,) m."""

    def __init__(self, coefficients, extent):
        self.k = np.array(coefficients, float).reshape(-1, 6, 3)
        self.extent = np.array(extent, float).reshape(-1)

    def value(self, i, u):
        """a b c at the extents u (n,) of the blocks i (n,).  (n, 3) rad."""
        k, x = self.k[i], (u / self.extent[i])[:, None]
        return k[:, 0] + x * (k[:, 1] + x * (k[:, 2] + x * (k[:, 3] + x * (k[:, 4] + x * k[:, 5]))))

    def rate(self, i, u):
        """d(abc)/du.  (n, 3) rad/m."""
        L = self.extent[i][:, None]
        return _first(self.k[i], u[:, None] / L) / L

    def bend(self, i, u):
        """d2(abc)/du2.  (n, 3) rad/m2."""
        L = self.extent[i][:, None]
        return _second(self.k[i], u[:, None] / L) / L**2

    def bounds(self):
        """Bounds (4) of |w| and |w'|.  (m,), (m,): rad/m, rad/m2."""
        out = np.zeros((2, len(self.k)))
        for j in range(0, len(self.k), _ROWS):
            w, wd = _bounds(self.k[j : j + _ROWS])
            L = self.extent[j : j + _ROWS]
            out[:, j : j + _ROWS] = w / L, wd / L**2
        return out[0], out[1]


def _first(k, x):
    return k[..., 1, :] + x * (
        2 * k[..., 2, :] + x * (3 * k[..., 3, :] + x * (4 * k[..., 4, :] + x * 5 * k[..., 5, :]))
    )


def _second(k, x):
    return 2 * k[..., 2, :] + x * (6 * k[..., 3, :] + x * (12 * k[..., 4, :] + x * 20 * k[..., 5, :]))


def _bounds(k):
    """Bounds of |w| and |w'| by x, for x from 0 to 1."""
    x = np.linspace(0, 1, _INTERVALS + 1)[None, :, None]
    k = k[:, None]
    abc = k[..., 0, :] + x * (
        k[..., 1, :] + x * (k[..., 2, :] + x * (k[..., 3, :] + x * (k[..., 4, :] + x * k[..., 5, :])))
    )
    d1, d2 = _first(k, x), _second(k, x)
    d3 = 6 * k[..., 3, :] + x * (24 * k[..., 4, :] + x * 60 * k[..., 5, :])
    d4 = 24 * k[..., 4, :] + x * 120 * k[..., 5, :]
    d5 = 120 * np.abs(k[:, 0, 5, :])
    E, Ed = abc_rate_matrix_np(abc), abc_rate_matrix_dot_np(abc, d1)
    w, wd = rotated(E, d1), rotated(E, d2) + rotated(Ed, d1)
    # the largest of each derivative of the three angles, (m, 3): samples and what may lie between them
    sag = 1 / (8 * _INTERVALS**2)
    m4 = np.abs(d4).max(1)  # linear in x: its ends are its extremes
    m3 = np.abs(d3).max(1) + sag * d5
    m2 = np.abs(d2).max(1) + sag * m4
    m1 = np.abs(d1).max(1) + sag * m3
    (a1, b1, c1), (a2, b2, c2), (a3, b3, c3), (a4, b4, c4) = m1.T, m2.T, m3.T, m4.T
    # e_a turns at s1 = |b'| + |c'|, its rates: s1, s2, s3; e_b turns with c'
    s1, s2, s3 = b1 + c1, b2 + c2 + b1 * c1, b3 + c3 + 2 * b2 * c1 + b1 * (c2 + c1 * c1)
    ea1, ea2, ea3 = s1, s2 + s1**2, s3 + 3 * s2 * s1 + s1**3
    eb1, eb2, eb3 = c1, c2 + c1**2, c3 + 3 * c2 * c1 + c1**3
    w2 = a3 + b3 + c3 + 2 * (a2 * ea1 + b2 * eb1) + a1 * ea2 + b1 * eb2
    w3 = a4 + b4 + c4 + 3 * (a3 * ea1 + b3 * eb1) + 3 * (a2 * ea2 + b2 * eb2) + a1 * ea3 + b1 * eb3
    return norm(w).max(1) + sag * w2, norm(wd).max(1) + sag * w3
