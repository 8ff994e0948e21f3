"""Dense symbolic solvers written out: no pivoting, few operations, stable where their docstring says so."""

from __future__ import annotations

import itertools

import casadi as ca


def solve_spd(M, b):
    """x with M x = b for a symmetric positive definite M, by M = L D L'.  (n, n), (n, m) -> (n, m).

    Stable without pivoting for every positive definite M (Golub and Van Loan, 4.1).  Only the lower triangle is read.
    """
    n = M.shape[0]
    L, d = ca.SX.eye(n), []
    for j in range(n):
        dj = M[j, j]
        for k in range(j):
            dj -= L[j, k] ** 2 * d[k]
        d.append(dj)
        for i in range(j + 1, n):
            s = M[i, j]
            for k in range(j):
                s -= L[i, k] * L[j, k] * d[k]
            L[i, j] = s / dj
    x = ca.SX(b)
    for i in range(n):
        for k in range(i):
            x[i, :] -= L[i, k] * x[k, :]
    for i in range(n):
        x[i, :] /= d[i]
    for i in reversed(range(n)):
        for k in range(i + 1, n):
            x[i, :] -= L[k, i] * x[k, :]
    return x


def solve_square(J, b):
    """x with J x = b for a square, well-conditioned J, through the normal equations J' J x = J' b.

    Squares the condition number: for Newton steps, whose error the next step corrects, and for forces
    (relative error about 1e-16 cond(J)^2; a machine is stopped long before cond(J) = 1e4).
    """
    return solve_spd(J.T @ J, J.T @ b)


def solve_square_transposed(J, b):
    """x with J' x = b:  x = J (J' J)^-1 b.  See `solve_square`."""
    return J @ solve_spd(J.T @ J, b)


def determinant_6(J):
    """det of a (6, 6), by Laplace expansion over the first three columns: no division, so no pivot can vanish."""

    def minor(rows, columns):
        (a, b, c), (i, j, k) = rows, columns
        return (
            J[a, i] * (J[b, j] * J[c, k] - J[b, k] * J[c, j])
            - J[a, j] * (J[b, i] * J[c, k] - J[b, k] * J[c, i])
            + J[a, k] * (J[b, i] * J[c, j] - J[b, j] * J[c, i])
        )

    total = 0
    for rows in itertools.combinations(range(6), 3):
        others = tuple(r for r in range(6) if r not in rows)
        sign = -1 if (sum(rows) - 3) % 2 else 1  # parity of moving `rows` to the front
        total += sign * minor(rows, (0, 1, 2)) * minor(others, (3, 4, 5))
    return total


def clip(x, low, high):
    """x held within [low, high]; NaN stays NaN, which fmin and fmax would turn into a limit."""
    return ca.if_else(x < low, low, ca.if_else(x > high, high, x))
