"""Chatter: how deep a mill may cut before the tool shakes by itself, from the frequency response at its tip.

Zeroth order, after Altintas and Budak, Analytical prediction of stability lobes in milling, CIRP Annals 44 (1995): in
the frame of force.py, with K_t = K_tc, K_r = K_rc / K_tc, straight flutes and the coefficients of the dynamic chip
Delta = u(t) - u(t - T) averaged over a turn,

    F = (a K_t / 2) (N / 2 pi) A Delta,     A = integral of [ -sin 2 phi - K_r (1 - cos 2 phi),
                                                             -(1 + cos 2 phi) - K_r sin 2 phi;
                                                              (1 - cos 2 phi) - K_r sin 2 phi,
                                                              sin 2 phi - K_r (1 + cos 2 phi) ]                     (1)

over phi from phi_1 to phi_2.  At the limit a response H(i w), 2 x 2 in m/N, keeps itself up with

    det(1 + Lambda A H) = 0,   Lambda = -(N / 4 pi) a K_t (1 - exp(-i w T)) = Lambda_R + i Lambda_I                 (2)
    a = -(2 pi / (N K_t)) Lambda_R (1 + kappa^2),   kappa = Lambda_I / Lambda_R                                     (3)
    w T = pi - 2 atan(kappa) + 2 pi k,   k = 0, 1, 2 ...,   Omega = 2 pi / (N T)                                    (4)

It is exact for one tooth's even force; few teeth at small radial depths also have islands of another kind (flips)
that it does not see.  `multiplier` does: semi-discretisation after Insperger and Stepan, Int. J. Numer. Meth. Eng. 55
(2002), of a model with modes, with the true coefficients of every step of a tooth period.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..errors import ExperimentError, InputError
from .coefficients import Coefficients

LOBES = 40  # k of eq. (4) up to it


class Lobes(NamedTuple):
    """Points of the border of stability: at `speed` rad/s a cut `depth` m deep begins to shake at `frequency` Hz."""

    speed: np.ndarray  # (n,)
    depth: np.ndarray  # (n,)
    frequency: np.ndarray  # (n,)

    @property
    def least(self) -> float:
        """The depth that is stable at every speed, m."""
        return float(self.depth.min()) if len(self.depth) else np.inf

    def limit(self, speed) -> np.ndarray:
        """Greatest stable depth at speeds (...) rad/s: the lowest of the lobes there.  (...) m, inf where none is."""
        speed = np.asarray(speed, float)
        out = np.full(speed.shape, np.inf)
        for a, b in zip(self._starts[:-1], self._starts[1:], strict=True):
            w, depth = self.speed[a:b], self.depth[a:b]
            turns = np.flatnonzero(np.diff(np.sign(np.diff(w)))) + 1  # where the speed along a lobe turns back
            for i, j in zip([0, *turns], [*turns, len(w) - 1], strict=True):
                way = 1 if w[j] > w[i] else -1
                part = np.interp(speed, w[i : j + 1][::way], depth[i : j + 1][::way], left=np.inf, right=np.inf)
                out = np.minimum(out, part)
        return out

    @property
    def _starts(self) -> np.ndarray:
        jumps = np.flatnonzero(np.diff(self.frequency) <= 0) + 1
        return np.concatenate([[0], jumps, [len(self.speed)]])


def directional(K: Coefficients, first: float, last: float) -> np.ndarray:
    """A of eq. (1), (2, 2), for a tooth within phi from `first` to `last` rad."""
    r = K.radial / K.tangential

    def to(phi):
        s, c = np.sin(2 * phi) / 2, np.cos(2 * phi) / 2
        return np.array([[c - r * (phi - s), -(phi + s) + r * c], [(phi - s) + r * c, -c - r * (phi + s)]])

    return to(last) - to(first)


def lobes(frequency, response, K: Coefficients, teeth: int, first: float, last: float, count: int = LOBES) -> Lobes:
    """The border of stability, eqs. (2)-(4).

    Parameters
    ----------
    frequency : (n,) Hz, rising, above 0
    response : (n, 2, 2) complex, m/N
        displacement of the tip by a force on it, in x (feed) and y of the frame of force.py; it may be measured.
    first, last : rad
        phi_1, phi_2 of the radial depth, `force.window`.

    Raises
    ------
    ExperimentError
        wrong shapes, numbers that are not finite, frequencies that do not rise, no teeth, no chip.
    """
    f, H = np.asarray(frequency, float), np.asarray(response, complex)
    if f.ndim != 1 or H.shape != (len(f), 2, 2):
        raise ExperimentError("needs n frequencies and n x 2 x 2 responses", key="response", value=str(H.shape))
    if not (np.isfinite(f).all() and np.isfinite(H).all()):
        raise ExperimentError("must be finite", key="response")
    if len(f) < 2 or f[0] <= 0 or (np.diff(f) <= 0).any():
        raise ExperimentError("frequencies must rise from above 0 Hz", key="frequency", value=f"{f[:2].tolist()} ...")
    _check(teeth, first, last)
    w = 2 * np.pi * f
    # det(1 + Lambda A H) = 0: Lambda = -1 / eigenvalue of A H; the two eigenvalues are followed along f
    eigen = _followed(np.linalg.eigvals(directional(K, first, last) @ H))
    out = []
    for branch in eigen.T:
        with np.errstate(divide="ignore", invalid="ignore"):
            value = -1 / branch
            kappa = value.imag / value.real
            depth = -2 * np.pi * value.real / (teeth * K.tangential) * (1 + kappa**2)
        good = np.isfinite(depth) & (depth > 0)
        for stretch in _stretches(good):
            for k in range(count):
                T = (np.pi - 2 * np.arctan(kappa[stretch]) + 2 * np.pi * k) / w[stretch]
                out.append((2 * np.pi / (teeth * T), depth[stretch], f[stretch]))
    if not out:
        return Lobes(*np.zeros((3, 0)))
    return Lobes(*(np.concatenate(column) for column in zip(*out, strict=True)))


def _check(teeth, first, last):
    if teeth < 1:
        raise ExperimentError("must be at least 1", key="teeth", value=str(teeth))
    if not 0 <= first < last <= np.pi + 1e-9:
        raise ExperimentError(
            "no chip: a tooth must be in the stock from an angle to a later one", key="first",
            value=f"{first:g} to {last:g} rad",
        )  # fmt: skip


def _followed(values):
    """Pairs (n, 2) put in order so that each column is continuous."""
    out = values.copy()
    for i in range(1, len(out)):
        straight = np.abs(out[i] - out[i - 1]).sum()
        if np.abs(out[i, ::-1] - out[i - 1]).sum() < straight:
            out[i] = out[i, ::-1]
    return out


def _stretches(good) -> list[slice]:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], good, [False]]).astype(int)))
    return [slice(a, b) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a > 1]


class Modes(NamedTuple):
    """A structure by its modes, each of unit modal mass: what a tip in x and y of force.py is carried by."""

    frequency: np.ndarray  # (m,) Hz, undamped
    damping: np.ndarray  # (m,) ratio
    shape: np.ndarray  # (2, m) 1/sqrt(kg): x and y of the tip

    def response(self, frequency) -> np.ndarray:
        """H(i w) at frequencies (n,) Hz.  (n, 2, 2) m/N."""
        w, w_n = 2 * np.pi * np.asarray(frequency)[:, None], 2 * np.pi * np.asarray(self.frequency)
        g = 1 / (w_n**2 - w**2 + 2j * np.asarray(self.damping) * w_n * w)
        U = np.asarray(self.shape)
        return np.einsum("am,nm,bm->nab", U, g, U)


def multiplier(
    modes: Modes, K: Coefficients, teeth: int, first: float, last: float, speed: float, depth: float, steps: int = 80
) -> float:
    """Greatest size of a Floquet multiplier of the cut over a tooth period, straight flutes; above 1 it shakes.

    Over each of `steps` steps h = T / steps the coefficients a(t) are their means and the delayed displacement is that
    of the middle of its step: y_i+1 = e^(A_i h) y_i + (integral of e^(A_i s)) B_i (u_i-m + u_i-m+1) / 2.

    Raises
    ------
    InputError
        numbers that make no cut.
    """
    from scipy.linalg import expm

    _check(teeth, first, last)
    if not (speed > 0 and depth >= 0 and steps >= 4):
        raise InputError("needs a speed above 0, a depth from 0 and 4 steps", value=f"{speed:g}, {depth:g}, {steps}")
    U, w_n = np.asarray(modes.shape, float), 2 * np.pi * np.asarray(modes.frequency, float)
    m, T = len(w_n), 2 * np.pi / (teeth * speed)
    h, pitch = T / steps, 2 * np.pi / teeth
    n = 2 * m
    size = n + 2 * steps
    total = np.eye(size)
    for i in range(steps):
        G = np.zeros((2, 2))  # F = G (u - u_T)
        for j in range(teeth):
            mean = _mean_coefficients(K, first, last, i * pitch / steps + j * pitch, pitch / steps)
            G += depth * K.tangential / 2 * mean
        push = U.T @ G
        A = np.zeros((n, n))
        A[:m, m:] = np.eye(m)
        A[m:, :m] = -np.diag(w_n**2) + push @ U
        A[m:, m:] = -np.diag(2 * np.asarray(modes.damping) * w_n)
        B = np.concatenate([np.zeros((m, 2)), -push])
        whole = expm(h * np.block([[A, B], [np.zeros((2, n + 2))]]))
        step = np.zeros((size, size))
        step[:n, :n] = whole[:n, :n]
        step[:n, size - 4 : size - 2] = step[:n, size - 2 :] = whole[:n, n:] / 2
        # the trail: u_i first, older ones behind
        step[n : n + 2, :m] = U
        step[n + 2 :, n : size - 2] = np.eye(size - n - 2)
        total = step @ total
    return float(np.abs(np.linalg.eigvals(total)).max())


def _mean_coefficients(K, first, last, begin, width):
    """Mean of the integrand of eq. (1) while a tooth turns from `begin` by `width`, 0 outside the stock."""
    total = np.zeros((2, 2))
    begin = begin % (2 * np.pi)
    for turn in (0.0, -2 * np.pi):
        a, b = max(begin + turn, first), min(begin + width + turn, last)
        if b > a:
            total += directional(K, a, b)
    return total / width
