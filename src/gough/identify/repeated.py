"""How much surer a motion looks than it is where the model lacks something: covariance by parts of the motion.

What friction with memory, a joint's play or a guide's ripple leaves is no noise: it comes where the motion passes the
same place, and as often as it does.  So the rows are put into groups, one behind the other, and where the motion is
periodic rows of one phase into one group, however often it comes.  With X_b, e_b the weighted rows and residuals of
group b and H = sum X_b' X_b, P_b = X_b H^-1 X_b',

    C = H^-1 [sum over b of s_b s_b'] H^-1,   s_b = X_b' (1 - P_b)^(-1/2) e_b                                      (1)
    factor^2 = max(1, mean over parameters j of C_jj / Cov_jj)                                                     (2)

Cov is that of covariance.py.  C asks nothing of how residuals in a group belong together and needs only that groups do
not; with the root it is H^-1 on the average for white noise (Bell and McCaffrey, Survey Methodology 28(2), 2002, whose
estimator has 25 numbers a parameter here: one factor for all parameters is what that many tell).  What lies in the
span of X in every group alike is in neither: a friction that is everywhere twice as large is that friction.
Theory: docs/theory/identification.md.
"""

from __future__ import annotations

import numpy as np

GROUPS, FEWEST = 25, 15
_SHORTEST = 16  # rows of a period
_SAME = 0.2  # of the columns' rms: rows a period apart differ by no more; rows are a tenth of the fastest motion long


def factor(
    X: np.ndarray, e: np.ndarray, used: np.ndarray, cov: np.ndarray, memory: float, repeat: int | None
) -> float | None:
    """Equation (2), of weighted rows X (N, n, r) and e (N, n), those that are not `used` (N, n) left out.

    `memory` is how many rows tell as much as one (covariance.py), `repeat` after how many the motion begins again.
    None where the motion has not FEWEST parts that do not hang together: nothing tells noise from the rest then.
    """
    N, r = len(X), X.shape[-1]
    length = N if repeat is None else repeat
    count = min(GROUPS, int(length / (2 * np.ceil(memory))))
    if count < FEWEST:
        return None
    X, e = np.where(used[..., None], X, 0.0), np.where(used, e, 0.0)
    value, V = np.linalg.eigh(np.tensordot(X, X, ((0, 1), (0, 1))))
    if not value[0] > 0:
        return None
    root = (V / np.sqrt(value)) @ V.T  # H^(-1/2)
    group = np.arange(N) % length * count // length
    C = np.zeros((r, r))
    for b in range(count):
        rows = group == b
        W = X[rows].reshape(-1, r) @ root  # P_b = W W', and (1 - W W')^(-1/2) W = W (1 - W' W)^(-1/2)
        share, V = np.linalg.eigh(W.T @ W)
        left = 1 - share
        keep = left > _WHOLE  # what one group alone tells has no residual to be judged by
        s = V[:, keep] @ ((V[:, keep].T @ (W.T @ e[rows].ravel())) / np.sqrt(left[keep]))
        C += np.outer(root @ s, root @ s)
    return float(np.sqrt(max(1.0, np.mean(np.diag(C) / np.diag(cov)))))


_WHOLE = 1e-6  # of a direction


def repeats(Y: np.ndarray) -> int | None:
    """After how many rows those of Y (N, n, p) come again, at most two thirds of them; None: they do not."""
    N = len(Y)
    F = Y.reshape(N, -1)
    size = np.sqrt(np.mean(F**2, axis=0))
    F = F[:, size > 0] / size[size > 0]
    most = 2 * N // 3
    if most < _SHORTEST or not F.shape[1]:
        return None
    along = np.zeros(N)  # sum over i and columns of F_i F_{i+l}
    for column in F.T:
        f = np.fft.rfft(column, 2 * N)
        along += np.fft.irfft(f * f.conj(), 2 * N)[:N]
    square = np.cumsum((F**2).sum(1))
    head, tail = square[::-1], square[-1] - np.r_[0.0, square[:-1]]  # of the rows that have one l later, or before
    apart = (head + tail - 2 * along) / (np.arange(N, 0, -1) * F.shape[1])
    for lag in range(_SHORTEST, most):
        if apart[lag] < _SAME**2 and apart[lag] <= apart[lag - 1] and apart[lag] <= apart[lag + 1]:
            return lag
    return None
