"""What makes one exciting motion better than another, as smooth functions of the information M = X' X / m.

X are the base columns of the regressor at m times, each times its parameter's size (base.py): a change of a parameter
by a share of its size.  With 0 < l_1 <= ... <= l_r the eigenvalues of M,

    volume     -log det M                                                                                          (1)
    condition  log tr(M^p) / (2 p) + log tr(M^-p) / (2 p)                                                          (2)

(1) is the volume of the estimate's ellipsoid (D-optimal); it does not change with the sizes but by a constant.  (2) is
smooth where the condition number kappa = (l_r / l_1)^(1/2) of X is not, and close above its logarithm:

    log kappa <= (2) <= log kappa + log(r) / p                                                                     (3)

Theory: docs/theory/identification.md.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

POWER = 4  # p of eq. (2), a power of 2: with 23 parameters the bound is at most 2.2 times the condition number


def volume(r: int) -> ca.Function:
    """Equation (1), of a symmetric positive M (r, r)."""
    M = ca.SX.sym("M", r, r)
    return ca.Function("volume", [M], [-2 * ca.sum1(ca.log(ca.diag(ca.chol(M))))])


def condition(r: int) -> ca.Function:
    """Equation (2), of a symmetric positive M (r, r)."""
    M = ca.SX.sym("M", r, r)
    size = ca.trace(M) / r  # it drops out of (2), and powers of numbers about 1 do not overflow
    root = ca.inv(ca.chol(M / size))
    return ca.Function("condition", [M], [(_log_trace(M / size) + _log_trace(root @ root.T)) / (2 * POWER)])


def _log_trace(A):
    """log tr(A^POWER) of a symmetric A: the sum of squares of A^(POWER / 2)."""
    for _ in range(int(np.log2(POWER)) - 1):
        A = A @ A
    return ca.log(ca.sumsqr(A))


CRITERIA = {"condition": condition, "volume": volume}
