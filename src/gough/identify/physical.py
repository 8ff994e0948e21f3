"""The nearest parameters that bodies can have, where least squares gives some that none can.

With b the estimate of the base parameters, C its covariance, pi_d the parameters that the base leaves out, s their
sizes and J_1, J_2, ... the pseudo-inertias of the bodies (cholesky.py), which are linear in pi,

    q(pi) = |C^-1/2 (K pi - b)|^2 + w^2 |(pi_d - sheet_d) / s_d|^2                                                 (1)
    minimise q over the pi whose J_k are all positive definite                                                     (2)

w is so small that what the motion shows decides.  Where least squares has given bodies that can exist, q is 0 there:
its numbers are the answer, as they are.  Else the answer lies at the edge, where a mass is all in one plane, and the
log-Cholesky numbers at infinity.  (2) is convex, so it is found by Newton's method on

    t q(pi) - sum over k of log det J_k,   log det J_k = 2 (lambda_11 + lambda_22 + ...)                           (3)

for growing t: a body that can exist in every step, at last within order / t of the least q (order: of all J_k).
Boyd and Vandenberghe, Convex Optimization, 2004, ch. 11, for (3).  Theory: docs/theory/identification.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import RunError
from .bodies import Body, bodies_of
from .cholesky import log_cholesky
from .regress import Estimate

_W = 1e-3  # w: a thousandth of a deviation for what no row shows
_SHARPEST = 1e-9  # of a size: a deviation below it is rounding
_LEAST = 1e-8  # of the largest eigenvalue of the correlations, which lags of noise leave unsure
_EDGE = 1e-9  # least eigenvalue, as a share, from which a body is taken as one that can exist
_GAP = 1e-6  # of a squared deviation, and of the least q: how near the answer is to it
_STEPS = 60  # of Newton's method for one t; ten are usual
_GROWTH = 10.0


@dataclass(frozen=True)
class Physical:
    """Parameters of bodies that can exist."""

    values: np.ndarray  # (p,) SI
    impossible: tuple[str, ...]  # bodies that no distribution of mass has, before
    away: float  # the largest change of a base parameter, in its deviations; 0: nothing was changed
    log_cholesky: dict[str, np.ndarray]  # lambda of each body that was sought


def physical_parameters(found: Estimate) -> Physical:
    """The parameters of an estimate, or where they are no bodies' the nearest that are, eq. (2).

    Raises
    ------
    RunError
        the search did not converge, or what the user holds at the sheet's values is no body's.
    """
    bodies = [body for body in bodies_of(found.rows.names) if found.free[list(body.places)].any()]
    wrong = tuple(body.name for body in bodies if body.least(found.full) < _EDGE)
    values = found.full if not wrong else _nearest(found, bodies)
    off = found.base.K @ values - found.values
    away = float(np.abs(off / _deviations(found)).max()) if wrong else 0.0
    return Physical(values, wrong, away, {body.name: log_cholesky(body.pseudo(values)) for body in bodies})


def _deviations(found: Estimate) -> np.ndarray:
    return np.maximum(found.std, _SHARPEST * np.abs(found.rows.values).max())


def _nearest(found: Estimate, bodies: list[Body]) -> np.ndarray:
    """Equation (2) by (3).  (p,)."""
    sheet, base = found.rows.values, found.base
    size = np.maximum(np.abs(sheet), np.abs(found.full))
    size = np.where(size > 0, size, 1.0)
    value, vector = np.linalg.eigh(found.cov / np.outer(found.std, found.std))
    whiten = (vector / np.sqrt(np.maximum(value, _LEAST * value[-1]))).T / _deviations(found)
    rest = np.setdiff1d(np.flatnonzero(found.free), base.kept)
    prior = np.zeros((len(rest), len(size)))
    prior[np.arange(len(rest)), rest] = _W / size[rest]
    A = np.concatenate([whiten @ base.K, prior])
    b = np.concatenate([whiten @ found.values, prior @ sheet])
    move = np.flatnonzero(found.free)  # what is held is no variable
    A_y = A[:, move] * size[move]
    slopes = []
    for body in bodies:
        S = np.zeros((len(size), body.order, body.order))
        S[list(body.places)] = body.basis()
        slopes.append(S[move] * size[move][:, None, None])
    pi = _inside(found, bodies)
    order = sum(body.order for body in bodies)
    t = order / max(1.0, float(np.sum((A @ pi - b) ** 2)))
    while True:
        pi = _centred(pi, t, A, b, A_y, slopes, bodies, move, size)
        q = float(np.sum((A @ pi - b) ** 2))
        if order / t < _GAP * max(1.0, q):
            return pi
        t *= _GROWTH


def _centred(pi, t, A, b, A_y, slopes, bodies, move, size) -> np.ndarray:
    """The least of (3) for one t, from a pi inside."""
    for _ in range(_STEPS):
        r = A @ pi - b
        gradient, hessian = 2 * t * (A_y.T @ r), 2 * t * (A_y.T @ A_y)
        for body, S in zip(bodies, slopes, strict=True):
            X = np.linalg.solve(body.pseudo(pi), S)  # J^-1 dJ/dy, one matrix a variable
            gradient -= np.trace(X, axis1=1, axis2=2)
            hessian += np.einsum("aij,bji->ab", X, X)
        scale = np.sqrt(np.diag(hessian))
        step = -np.linalg.solve(hessian / np.outer(scale, scale), gradient / scale) / scale
        decrement = float(-gradient @ step)
        if decrement < 1e-8:  # (3) is within it of its least
            return pi
        share = 1.0 if decrement < 0.06 else 1 / (1 + np.sqrt(decrement))  # such steps stay inside, and (3) falls
        new = pi.copy()
        new[move] += share * size[move] * step
        while not all(body.least(new) > 0 for body in bodies):  # for rounding at the very edge
            share /= 2
            if share < 1e-12:
                return pi
            new = pi.copy()
            new[move] += share * size[move] * step
        if share < 1 and np.abs(share * step).max() < 1e-13:
            return pi
        pi = new
    raise RunError("no bodies were found near the estimate", value=f"{_STEPS} steps of Newton's method", cure=_CURE)


_CURE = "log a longer motion, or name fewer parameters with free"


def _inside(found: Estimate, bodies: list[Body]) -> np.ndarray:
    """A start well inside: the sheet's bodies, and where the sheet has a number that is 0 a part of the estimate's."""
    pi = np.where(found.free, found.rows.values, found.full)
    for body in bodies:
        share = 1e-3
        while body.least(pi) < 1e-6:
            places = [k for k in body.places if found.free[k]]
            if share > 1 or len(places) < len(body.places):
                raise RunError(
                    "the sheet's values are no body's, and some are held",
                    where=body.name,
                    cure="let free name all of it",
                )
            J = body.pseudo(pi)
            usual = np.abs(np.diag(J)).max() or 1.0
            pi[places] = np.einsum("kij,ij->k", body.form, J + share * usual * np.eye(body.order))
            share *= 10
    return pi
