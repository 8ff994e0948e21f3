"""How sure an estimate is when its noise remembers: covariance from residuals whose rows are correlated.

With rows X_i (n, r) weighted by each joint's deviation, residuals e_i (n,), H = sum X_i' X_i, and G_l = E e_i e_{i+l}'
the covariance of residuals l rows apart, across joints,

    Cov = H^-1 M H^-1,   M = sum over l of k(l) sum over i of X_i' G_l X_{i+l}                                      (1)

exact for noise that is stationary.  k(l) is 1 up to twice the lag m behind which five autocorrelations in a row are
none, and falls to 0 at 4 m (flat top; Politis, Econometrics Reviews 23(2), 2004: m where |rho| < 2 sqrt(log10 N / N)).
For white noise m = 0, and (1) is that of weighted least squares, with the correlation between joints.
Theory: docs/theory/identification.md.
"""

from __future__ import annotations

import numpy as np

_RUN = 5  # lags in a row that must be small
_MOST = 0.25  # of the rows, the longest lag that is looked at


def covariance(X: np.ndarray, e: np.ndarray, used: np.ndarray) -> tuple[np.ndarray, int]:
    """Covariance (r, r) of eq. (1), and the lag in rows up to which noise was found to be correlated.

    X (N, n, r) and e (N, n) are weighted; rows that are not `used` (N, n) take no part.
    """
    X = np.where(used[..., None], X, 0.0)
    e = np.where(used, e, 0.0)
    r = X.shape[-1]
    flat = X.reshape(-1, r)
    H = np.linalg.inv(flat.T @ flat)
    count = int(used.sum())
    m = memory(e, used)
    scale = count / max(1, count - r)  # what the fit took out of the residuals
    M = _lagged(X, e, used, 0)
    for lag in range(1, 4 * m):
        k = 1.0 if lag <= 2 * m else 2.0 - lag / (2 * m)
        part = _lagged(X, e, used, lag)
        M = M + k * (part + part.T)
    found = scale * H @ M @ H
    if m and np.linalg.eigvalsh(M)[0] <= 0:  # a flat top is no covariance for every sample; a triangle is
        M = _lagged(X, e, used, 0)
        for lag in range(1, 4 * m):
            part = _lagged(X, e, used, lag, whole=True)
            M = M + (1 - lag / (4 * m)) * (part + part.T)
        found = scale * H @ M @ H
    return (found + found.T) / 2, m


def memory(e: np.ndarray, used: np.ndarray) -> int:
    """The lag m of eq. (1), from residuals (N, n) of equal deviation."""
    N = len(e)
    most = int(_MOST * N)
    total = (e * e).sum() / max(1, used.sum())
    if total == 0 or most < _RUN:
        return 0
    least = 2 * np.sqrt(np.log10(N) / max(1, used.sum()))
    small = 0
    for lag in range(1, most):
        both = used[:-lag] & used[lag:]
        rho = (e[:-lag] * e[lag:])[both].sum() / max(1, both.sum()) / total
        small = small + 1 if abs(rho) < least else 0
        if small == _RUN:
            return lag - _RUN
    return most // 4


def _lagged(X, e, used, lag: int, whole: bool = False) -> np.ndarray:
    """sum over i of X_i' G_l X_{i+l}.  (r, r).  `whole`: G_l of all rows, as a triangle needs it."""
    N = len(e)
    a, b = slice(0, N - lag), slice(lag, N)
    if whole:  # one divisor for all lags: so the matrix of all of them is no less than 0
        each = np.sqrt(used.sum(0).astype(float))
        pairs = np.outer(each, each)
    else:
        pairs = used[a].astype(float).T @ used[b]
    G = e[a].T @ e[b] / np.maximum(pairs, 1.0)
    r = X.shape[-1]
    return (G.T @ X[a]).reshape(-1, r).T @ X[b].reshape(-1, r)
