"""How sure an estimate is when its noise remembers: covariance from residuals whose rows are correlated.

With rows X_i (n, r) weighted by each joint's deviation, residuals e_i (n,), H = sum X_i' X_i, and the covariance of
residuals l rows apart, across joints, taken as G rho_l,

    Cov = H^-1 M H^-1 / (1 - t),   M = sum over all i, l of rho_|l| X_i' G X_{i+l},   t = tr(H^-1 M) / N           (1)

exact for stationary noise whose joints remember alike.  G = E e_i e_i'.  rho is that of the autoregression

    e_i = a_1 e_{i-1} + ... + a_p e_{i-p} + white                                                                  (2)

that the residuals of all joints together have by Yule and Walker's equations, its order p by Akaike's criterion.  1 - t
puts back what the fit took out: of N numbers of variance 1 it leaves N (1 - t) on the average, N - r if they are white.
Hannan, Multiple Time Series, 1970, ch. VI, for least squares with correlated noise.
Theory: docs/theory/identification.md.
"""

from __future__ import annotations

import numpy as np

_LEFT = 0.25  # of the variance: what residuals have at least, for short records of slow noise
_FAINT = 1e-3  # correlation from which rows count as strangers
_ORDER = 10.0  # times log10 N: the highest order that is tried


def covariance(X: np.ndarray, e: np.ndarray, used: np.ndarray) -> tuple[np.ndarray, float]:
    """Covariance (r, r) of eq. (1), and how many rows tell as much as one that is independent, sum of rho_l, >= 1.

    X (N, n, r) and e (N, n) are weighted; rows that are not `used` (N, n) take no part.
    """
    X = np.where(used[..., None], X, 0.0)
    e = np.where(used, e, 0.0)
    r, count = X.shape[-1], max(1, int(used.sum()))
    H = np.linalg.inv(np.tensordot(X, X, ((0, 1), (0, 1))))
    each = np.sqrt(np.maximum(used.sum(0), 1))
    G = e.T @ e / np.outer(each, each)  # one divisor a joint: no less than 0, whatever rows are left out
    rho = correlation(e, used)
    GX = G @ X
    M = np.zeros((r, r))
    for lag, share in enumerate(rho):
        part = share * np.tensordot(GX[: len(X) - lag], X[lag:], ((0, 1), (0, 1)))
        M += part + part.T if lag else part
    variance = (e * e).sum() / count
    taken = np.trace(H @ M) / variance / count if variance else 0.0
    found = H @ M @ H / max(1 - taken, _LEFT)
    return (found + found.T) / 2, max(1.0, float(2 * rho.sum() - 1))


def correlation(e: np.ndarray, used: np.ndarray) -> np.ndarray:
    """rho_0 = 1, rho_1, ... of eq. (2), until they are faint, from residuals (N, n) of about equal deviation."""
    N, count = len(e), int(used.sum())
    most = min(N // 4, int(_ORDER * np.log10(max(N, 2))))
    total = (e * e).sum() / max(1, count)
    if total == 0 or most < 1:
        return np.ones(1)
    r = np.array([(e[: N - l] * e[l:]).sum() / count / total for l in range(most + 1)])  # one divisor: a stable (2)
    a, best, kept = np.zeros(0), 0.0, np.zeros(0)
    variance, level = 1.0, count * np.log(1.0)
    for p in range(1, most + 1):  # Levinson and Durbin
        k = (r[p] - a @ r[p - 1 : 0 : -1]) / variance if p > 1 else r[1]
        a = np.append(a - k * a[::-1], k)
        variance *= 1 - k * k
        if not variance > 0:
            break
        level = count * np.log(variance) + 2 * p
        if level < best:
            best, kept = level, a.copy()
    if not len(kept):
        return np.ones(1)
    rho = list(r[: len(kept)])
    while len(rho) < N // 2:
        rho.append(float(kept @ rho[: -len(kept) - 1 : -1]))
        if np.abs(rho[-len(kept) :]).max() < _FAINT:
            break
    return np.array(rho)
