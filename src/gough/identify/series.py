"""The Fourier series of an exciting motion, written in the numbers that are free.

A coordinate is sum over k <= K of sine_k sin(k w t) + cosine_k (cos(k w t) - 1), w = 2 pi / period.  It begins at rest
where sum k sine_k = 0 and sum k^2 cosine_k = 0; c, 2 (K - 1) numbers a coordinate, are its coefficients in orthonormal
bases of those.  Moments are linear in c: value, rate and acceleration of every coordinate, w (18,) of design.py = G c.
"""

from __future__ import annotations

import numpy as np

from ..program.standard.fourier import Fourier


def bases(K: int) -> tuple[np.ndarray, np.ndarray]:
    """Orthonormal bases of the sines and the cosines that begin at rest.  (K, K - 1) each."""
    k = np.arange(1.0, K + 1)
    return tuple(np.linalg.svd((k**power)[None])[2][1:].T for power in (1, 2))


def times(period: float, count: int) -> np.ndarray:
    """Times of a period, none at its ends: distances from home have no derivative there.  (count,) s."""
    return (np.arange(count) + 0.5) * period / count


def moments(t, period: float, K: int, columns: int) -> np.ndarray:
    """G of every time t (m,) s, for `columns` coordinates; c coordinate by coordinate.  (m, 18, columns 2 (K - 1))."""
    B = _moments(t, period, bases(K))
    m, _, f = B.shape
    G = np.zeros((m, 18, columns * f))
    for j in range(columns):
        first = 9 * (j // 3) + j % 3  # p, p', p'' then abc, abc', abc''
        for order in range(3):
            G[:, first + 3 * order, j * f : (j + 1) * f] = B[:, order]
    return G


def program_of(c, period: float, cycles: int, K: int, columns: int) -> Fourier:
    """The program of the free numbers c."""
    basis = bases(K)
    c = np.asarray(c).reshape(columns, 2 * (K - 1))
    both = [basis[i] @ c[:, i * (K - 1) : (i + 1) * (K - 1)].T for i in range(2)]
    full = [np.pad(rows, ((0, 0), (0, 6 - columns))) for rows in both]
    keys = (("sine", "cosine"), ("turn_sine", "turn_cosine"))
    series = {
        keys[j][i]: full[i][:, 3 * j : 3 * j + 3] for i in range(2) for j in range(2) if full[i][:, 3 * j :].any()
    }
    return Fourier(period=period, cycles=cycles, **series)


def _moments(t, period, basis) -> np.ndarray:
    """Value, rate and acceleration of one coordinate at the times, by its free numbers.  (m, 3, 2 (K - 1))."""
    k = np.arange(1.0, len(basis[0]) + 1) * 2 * np.pi / period
    phase = np.multiply.outer(t, k)
    sine, cosine = np.sin(phase), np.cos(phase)
    a = np.stack([sine, cosine * k, -sine * k**2], 1) @ basis[0]
    b = np.stack([cosine - 1, -sine * k, -cosine * k**2], 1) @ basis[1]
    return np.concatenate([a, b], -1)
