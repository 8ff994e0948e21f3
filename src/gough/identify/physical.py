"""The nearest parameters that bodies can have, where least squares gives some that none can.

With b the estimate of the base parameters, C its covariance, pi(lambda) the parameters of bodies that can exist
(cholesky.py), pi_d those that the base leaves out and s their sizes,

    minimise  |C^-1/2 (K pi(lambda) - b)|^2 + w^2 |(pi_d(lambda) - sheet_d) / s_d|^2   over lambda                  (1)

w is so small that what the motion shows decides.  Where least squares has given bodies that can exist, both parts are
0 there: its numbers are the answer, as they are.  In pi (1) is convex, and the map from lambda one to one, so there is
one minimum.  Solved by Gauss-Newton steps with trust regions (scipy's trf).  Theory: docs/theory/identification.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import RunError
from .bodies import Body, bodies_of
from .cholesky import log_cholesky
from .regress import Estimate

_W = 1e-3  # w: a thousandth of a deviation for what no row shows
_HELD = 1e6  # the same of what the user holds
_SHARPEST = 1e-9  # of a size: a deviation below it is rounding
_EDGE = 1e-9  # least eigenvalue, as a share, from which a body is taken as one that can exist
_LEAST = 1e-8  # of the largest eigenvalue of the correlations
_STILL = 1e-9  # of a squared deviation: steps that gain less end the search
_INSIDE = 1e-3  # of the sheet's body: how far inside the search begins
_EVALUATIONS = 500


@dataclass(frozen=True)
class Physical:
    """Parameters of bodies that can exist."""

    values: np.ndarray  # (p,) SI
    impossible: tuple[str, ...]  # bodies that no distribution of mass has, before
    away: float  # the largest change of a base parameter, in its deviations; 0: nothing was changed


def physical_parameters(found: Estimate) -> Physical:
    """The parameters of an estimate, or where they are no bodies' the nearest that are, eq. (1).

    Raises
    ------
    RunError
        the solver did not converge.
    """
    wrong = impossible_bodies(found)
    if not wrong:
        return Physical(found.full, (), 0.0)
    return _nearest(found, [body for body in bodies_of(found.rows.names) if _sought(body, found)], wrong)


def impossible_bodies(found: Estimate) -> tuple[str, ...]:
    """Bodies that the estimate, with the sheet's values for what it leaves out, gives numbers no body has."""
    return tuple(
        body.name for body in bodies_of(found.rows.names) if _sought(body, found) and body.least(found.full) < _EDGE
    )


def _sought(body: Body, found: Estimate) -> bool:
    return bool(found.free[list(body.places)].any())


def _nearest(found: Estimate, bodies: list[Body], wrong) -> Physical:
    from scipy.optimize import least_squares

    rows, base = found.rows, found.base
    size = np.maximum(np.abs(rows.values), np.abs(found.full))
    size = np.where(size > 0, size, 1.0)
    std = np.maximum(found.std, _SHARPEST * size[base.kept])
    value, vector = np.linalg.eigh(found.cov / np.outer(found.std, found.std))
    # what lags of correlated noise make of the smallest eigenvalues is not sure to a thousandth
    whiten = (vector / np.sqrt(np.maximum(value, _LEAST * value[-1]))).T / std
    rest = np.setdiff1d(np.arange(len(size)), base.kept)
    weight = np.where(found.free[rest], _W, _HELD) / size[rest]
    lengths = [body.order * (body.order + 1) // 2 for body in bodies]
    edges = np.concatenate([[0], np.cumsum(lengths)])

    def parameters(lam):
        pi, slope = found.full.copy(), np.zeros((len(size), edges[-1]))
        for body, a, b in zip(bodies, edges[:-1], edges[1:], strict=True):
            pi[list(body.places)], slope[list(body.places), a:b] = body.made(lam[a:b])
        return pi, slope

    def residual(lam):
        pi = parameters(lam)[0]
        # the 1: ftol is then a share of one deviation, not of a sum that may go to 0
        return np.concatenate([whiten @ (base.K @ pi - found.values), weight * (pi - rows.values)[rest], [1.0]])

    def slope(lam):
        d = parameters(lam)[1]
        return np.concatenate([whiten @ (base.K @ d), weight[:, None] * d[rest], np.zeros((1, len(lam)))])

    start = np.concatenate([_start(body, found.full, rows.values) for body in bodies])
    answer = least_squares(residual, start, jac=slope, xtol=1e-10, ftol=_STILL, gtol=None, max_nfev=_EVALUATIONS)
    pi = parameters(answer.x)[0]
    if not (answer.success and np.isfinite(pi).all()):
        raise RunError("no bodies were found that are near the estimate", value=str(answer.message), cure=_CURE)
    return Physical(pi, wrong, float(np.abs((base.K @ pi - found.values) / std).max()))


_CURE = "log a longer motion, or name fewer parameters with free"


def _start(body: Body, full, sheet) -> np.ndarray:
    """lambda of the estimate's body, or where that cannot exist of the nearest on the edge and a little of the sheet's."""
    J, usual = body.pseudo(full), body.pseudo(sheet)
    scale = np.sqrt(np.maximum(np.abs(np.diag(J)), np.abs(np.diag(usual))))
    scale[scale == 0] = 1.0
    J, usual = J / np.outer(scale, scale), usual / np.outer(scale, scale)
    value, vector = np.linalg.eigh(J)
    if value[0] < _INSIDE:
        J = (vector * np.maximum(value, 0)) @ vector.T + _INSIDE * (np.eye(body.order) + usual)
    return log_cholesky(J * np.outer(scale, scale))
