"""Singular values of a small matrix, written out: a fixed number of rotations, no branch that depends on numbers.

One-sided Jacobi: columns a, b of A are turned in their plane until they are square to each other,

    tan 2 phi = 2 a.b / (|a|^2 - |b|^2),   (a, b) <- (c a + s b, c b - s a),   |phi| <= pi/4                         (1)

pair after pair, `SWEEPS` times over all pairs; the norms of the columns are then the singular values.  The small ones
are found to the precision of A, because A'A is never formed.  Convergence is quadratic at the end.

Source: Hestenes, Inversion of matrices by biorthogonalization and related results, J. SIAM 6, 1958, 51-90.
docs/theory/maps.md, section 2.
"""

from __future__ import annotations

import casadi as ca

SWEEPS = 7  # of 100 000 matrices (6, 6) with condition numbers up to 1e6, six leave 1 % in some; seven leave rounding


def singular_values(A):
    """Singular values (k,) of A (n, k), n >= k, in no order, eq. (1)."""
    columns = [A[:, j] for j in range(A.shape[1])]
    for _ in range(SWEEPS if len(columns) > 2 else 1):
        for i in range(len(columns)):
            for j in range(i + 1, len(columns)):
                a, b = columns[i], columns[j]
                c, s = _rotation(ca.dot(a, a) - ca.dot(b, b), ca.dot(a, b))
                columns[i], columns[j] = c * a + s * b, c * b - s * a
    return ca.vertcat(*[ca.norm_2(column) for column in columns])


def extremes(A):
    """Least and greatest eigenvalue of a symmetric A (3, 3), by six sweeps of two-sided rotations."""
    A = [[A[i, j] for j in range(3)] for i in range(3)]
    for _ in range(6):
        for i, j in ((0, 1), (0, 2), (1, 2)):
            k = 3 - i - j
            c, s = _rotation(A[i][i] - A[j][j], A[i][j])
            ii, jj, ij, ik, jk = A[i][i], A[j][j], A[i][j], A[i][k], A[j][k]
            A[i][i] = c * c * ii + 2 * c * s * ij + s * s * jj
            A[j][j] = s * s * ii - 2 * c * s * ij + c * c * jj
            A[i][j] = A[j][i] = c * s * (jj - ii) + (c * c - s * s) * ij
            A[i][k] = A[k][i] = c * ik + s * jk
            A[j][k] = A[k][j] = c * jk - s * ik
    least = ca.fmin(A[0][0], ca.fmin(A[1][1], A[2][2]))
    return least, ca.fmax(A[0][0], ca.fmax(A[1][1], A[2][2]))


def _rotation(difference, product):
    """cos and sin of the smaller angle of eq. (1), by (|a|^2 - |b|^2, a . b); 1 and 0 where both are 0."""
    # t = tan(phi) = 2 ab / (d + sign(d) sqrt(d^2 + 4 ab^2)); a number too small to matter keeps 0 / 0 away
    size = ca.sqrt(difference * difference + 4 * product * product)
    t = 2 * product / (difference + ca.if_else(difference < 0, -1, 1) * (size + 1e-300))
    c = 1 / ca.sqrt(1 + t * t)
    return c, c * t
