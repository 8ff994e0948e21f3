"""Bodies that can exist: mass above 0, inertias of some distribution of mass, by numbers without any condition.

A body's pseudo-inertia is the second moment of its mass in homogeneous coordinates,

    J = integral of [r; 1] [r; 1]' dm = [[S, m c], [(m c)', m]],   S = tr(I) / 2 - I                               (1)

with I about the frame's origin.  J is positive definite for every body that has volume, and for no other set of ten
numbers: mass > 0, I positive, the triangle inequality about any axis.  Its Cholesky factor with the logarithms of the
diagonal, written row by row, is a set of numbers that may be anything,

    J = U U',   U upper triangular,   lambda = [log U_11, U_12, ..., log U_22, ...]                                 (2)

A slender body (mass on a line) has the same with one coordinate: J = [[I_t, m c], [m c, m]].
Wensing, Kim and Slotine, IEEE Robotics and Automation Letters 3(1), 2018, for (1); Rucker and Wensing, the same 7(2),
2022, for (2).  Theory: docs/theory/identification.md.
"""

from __future__ import annotations

import numpy as np

PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))  # in which inertias are listed: xx yy zz xy xz yz


def pseudo_inertia(pi) -> np.ndarray:
    """J of eq. (1) for m, m c, I as [m, mcx, mcy, mcz, Ixx, Iyy, Izz, Ixy, Ixz, Iyz].  (..., 10) -> (..., 4, 4)."""
    pi = np.asarray(pi, float)
    I = np.empty((*pi.shape[:-1], 3, 3))
    for k, (i, j) in enumerate(PAIRS):
        I[..., i, j] = I[..., j, i] = pi[..., 4 + k]
    J = np.empty((*pi.shape[:-1], 4, 4))
    J[..., :3, :3] = np.trace(I, axis1=-2, axis2=-1)[..., None, None] / 2 * np.eye(3) - I
    J[..., :3, 3] = J[..., 3, :3] = pi[..., 1:4]
    J[..., 3, 3] = pi[..., 0]
    return J


def of_pseudo_inertia(J) -> np.ndarray:
    """The ten numbers of J, the inverse of `pseudo_inertia`.  (..., 4, 4) -> (..., 10)."""
    J = np.asarray(J, float)
    S = J[..., :3, :3]
    I = np.trace(S, axis1=-2, axis2=-1)[..., None, None] * np.eye(3) - S
    entries = [J[..., 3, 3], *(J[..., k, 3] for k in range(3)), *(I[..., i, j] for i, j in PAIRS)]
    return np.stack(entries, -1)


def log_cholesky(J) -> np.ndarray:
    """lambda of eq. (2).  (k, k) -> (k (k + 1) / 2,).

    Raises
    ------
    numpy.linalg.LinAlgError
        J is not positive definite.
    """
    J = np.asarray(J, float)
    flip = J[::-1, ::-1]  # numpy's factor is lower: of the matrix read backwards it is the upper one
    U = np.linalg.cholesky(flip)[::-1, ::-1]
    rows = [np.concatenate([[np.log(U[i, i])], U[i, i + 1 :]]) for i in range(len(J))]
    return np.concatenate(rows)


def of_log_cholesky(lam, k: int) -> tuple[np.ndarray, np.ndarray]:
    """J of eq. (2) and its derivatives by lambda.  (k (k + 1) / 2,) -> (k, k), (k (k + 1) / 2, k, k)."""
    lam = np.asarray(lam, float)
    U, dU = np.zeros((k, k)), np.zeros((len(lam), k, k))
    place = 0
    for i in range(k):
        U[i, i] = dU[place, i, i] = np.exp(lam[place])
        for j in range(i + 1, k):
            U[i, j] = lam[place + j - i]
            dU[place + j - i, i, j] = 1.0
        place += k - i
    slope = dU @ U.T
    return U @ U.T, slope + np.swapaxes(slope, -1, -2)
