"""Weighted least squares of the base parameters, with covariance and the error on motion that was held out.

    minimise sum over joints j, rows i of (u_ij - Y_ij pi)^2 / s_j^2                                               (1)

over what the motion shows (base.py); what it does not show stays at the sheet's value.  s_j^2 is the mean square of
joint j's residuals, found by solving again with the last ones.  The deviations are those of covariance.py, which minds
that residuals of neighbouring rows are alike, times the factor of repeated.py, which minds that what the model lacks
is no noise.

The held-out error: the rows in FOLDS parts, one behind the other; each part predicted from the estimate of the others.
Theory: docs/theory/identification.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import ExperimentError, LogError, did_you_mean
from .base import LIMIT, BaseParameters, base_parameters, sizes
from .covariance import covariance
from .repeated import factor, repeats
from .rows import Rows

CONDITION = 1e5  # from which least squares turns a model error of 1e-5 into one of 1: no drive's force is as sure
FOLDS = 5
_ROUNDS = 3  # of weights; the second changes them by a few per cent
_EXACT = 1e-14  # of the force: residuals below are rounding


@dataclass(frozen=True)
class Estimate:
    """What a motion says of the parameters.  SI; (r,) of the base, (p,) of all."""

    rows: Rows
    base: BaseParameters
    free: np.ndarray  # (p,) bool: what was sought
    values: np.ndarray  # (r,) of the base parameters
    cov: np.ndarray  # (r, r)
    full: np.ndarray  # (p,) the sheet's values with the estimates in the places of the kept columns
    sigma: np.ndarray  # (n,) deviation of a joint's residuals, N
    residual_rms: float  # N
    held_out: np.ndarray  # (N, n) error of each row, predicted from the other parts; NaN where it takes no part
    memory: float  # rows that tell as much as one that is independent
    factor: float | None  # of the deviations, over those of stationary noise; None: cannot be judged (repeated.py)

    @property
    def std(self) -> np.ndarray:
        """Standard deviations of `values`.  (r,)."""
        return np.sqrt(np.diag(self.cov))

    @property
    def held_out_rms(self) -> float:
        """Root mean square of `held_out`, N."""
        return float(np.sqrt(np.nanmean(self.held_out**2)))

    def residuals(self) -> np.ndarray:
        """u - Y pi, NaN where a row takes no part.  (N, n) N."""
        return np.where(self.rows.used, self.rows.u - self.rows.Y @ self.full, np.nan)


def estimate(rows: Rows, free: Sequence[str] | None = None) -> Estimate:
    """Equation (1) on rows; `free` are the parameters sought, whole names or beginnings ("platform", "friction").

    Raises
    ------
    ExperimentError
        `free` names nothing.
    LogError
        fewer rows than parameters, or the motion is hopeless: nothing is shown, or the condition is beyond CONDITION.
    """
    chosen = chosen_of(rows.names, free)
    used = rows.used
    if used.sum() < 2 * chosen.sum():
        raise LogError(
            "too few rows for so many parameters", value=f"{int(used.sum())} forces for {int(chosen.sum())}",
            cure="log a longer motion, or name fewer with --free",
        )  # fmt: skip
    force = np.sqrt(np.mean(rows.u[used] ** 2)) or 1.0
    columns = np.sqrt(np.mean(np.where(used[..., None], rows.Y, 0.0) ** 2, axis=(0, 1)))
    with np.errstate(divide="ignore"):
        fallback = np.where(columns > 0, force / columns, 1.0)
    size = sizes(rows.names, rows.units, rows.values, fallback)
    target = rows.u - rows.Y @ rows.values  # what the sheet does not explain
    sigma, base, delta = np.full(rows.u.shape[1], force), None, None
    for k in range(_ROUNDS):
        base, delta = _solve(rows, target, used, chosen, size, sigma, noise=k > 0)
        sigma = _sigma(target - rows.Y @ delta, used, base.rank, force)
    names = [n for n, c in zip(rows.names, chosen, strict=True) if c]
    if not base.rank:
        raise LogError("the motion shows none of what is sought", value=_few(names), cure=_CURE)
    _check_asked(rows.names, base, free)
    if base.condition > CONDITION:
        raise LogError(
            "the motion shows too little: condition number of the regressor", value=f"{base.condition:.3g}",
            limit=f"{CONDITION:g}", cure=_CURE,
        )  # fmt: skip
    residual = np.where(used, target - rows.Y @ delta, 0.0)
    X, e = rows.Y[..., base.kept] / sigma[:, None], residual / sigma
    cov, lag = covariance(X, e, used)
    more = factor(X, e, used, cov, lag, repeats(rows.Y))
    full = rows.values + delta
    return Estimate(
        rows, base, chosen, base.K @ full, cov if more is None else more**2 * cov, full, sigma,
        float(np.sqrt(np.mean(residual[used] ** 2))), _held_out(rows, target, used, base, sigma), lag, more,
    )  # fmt: skip


def _check_asked(names, base, free) -> None:
    """Refuse what was asked for by name and is not shown."""
    seen = dict(zip(names, base.seen, strict=True))
    for word in [] if free is None else [free] if isinstance(free, str) else free:
        meant = [name for name in names if _means(word, name)]
        if all(seen[name] == "not" for name in meant):
            raise LogError(
                f"the motion does not show {word}", cure=_CURE,
                value=f"its part of the forces is below {1 / LIMIT:g} of their noise",
            )  # fmt: skip


_CURE = "log a motion that moves all joints and turns the tool, for example that of gough.identify.excite"


def chosen_of(names: Sequence[str], free: Sequence[str] | None) -> np.ndarray:
    """Which of the names `free` means: itself, or what begins with it and a dot or a bracket.  (p,) bool.

    Raises
    ------
    ExperimentError
        for a word that is none of them; the nearest is said.
    """
    if free is None:
        return np.ones(len(names), bool)
    words = [free] if isinstance(free, str) else list(free)
    chosen = np.zeros(len(names), bool)
    for word in words:
        found = [_means(word, name) for name in names]
        if not any(found):
            known = [*names, *{name.partition(".")[0] for name in names}]
            raise ExperimentError("no such parameter", key="free", value=str(word)[:60], cure=did_you_mean(word, known))
        chosen |= found
    if not chosen.any():
        raise ExperimentError("names no parameter", key="free", cure=f"there is {', '.join(names[:5])}, ...")
    return chosen


def _means(word: str, name: str) -> bool:
    return name == word or name.startswith((f"{word}.", f"{word}["))


def _solve(rows, target, used, chosen, size, sigma, noise) -> tuple[BaseParameters, np.ndarray]:
    """Base parameters of the weighted rows and the change (p,) from the sheet's values that explains `target` best."""
    p = len(rows.names)
    weight = np.where(used, 1 / sigma, 0.0)
    A = (rows.Y * weight[..., None]).reshape(-1, p) * np.where(chosen, size, 0.0)
    base = base_parameters(A, rows.names, rows.units, size, noise)
    delta = np.zeros(p)
    if base.rank:
        b = (target * weight).reshape(-1)
        # twice: what rounding left of the first is small, and found again by as many digits
        for _ in range(2):
            Q, R = np.linalg.qr(A[:, base.kept])
            step = np.linalg.solve(R, Q.T @ (b - A[:, base.kept] @ (delta / size)[base.kept]))
            delta[base.kept] += step * size[base.kept]
    return base, delta


def _sigma(residual, used, rank, force) -> np.ndarray:
    """Deviation of each joint's residuals, its share of the fit's freedoms taken off.  (n,) N."""
    count = np.maximum(used.sum(0), 1)
    square = (np.where(used, residual, 0.0) ** 2).sum(0)
    left = np.maximum(count - rank * count / count.sum(), 1)
    return np.maximum(np.sqrt(square / left), _EXACT * force)


def parts_of(count: int) -> np.ndarray:
    """Where the FOLDS parts of so many rows begin, and where the last one ends.  (FOLDS + 1,)."""
    return np.linspace(0, count, FOLDS + 1).astype(int)


def _held_out(rows, target, used, base, sigma) -> np.ndarray:
    """Errors on parts of the motion that their prediction has not seen.  (N, n) N, NaN where a row takes no part."""
    N, errors = len(rows.u), np.full(rows.u.shape, np.nan)
    weight = np.where(used, 1 / sigma, 0.0)
    Y = rows.Y[..., base.kept]
    edges = parts_of(N)
    for a, b in zip(edges[:-1], edges[1:], strict=True):
        part = np.zeros(N, bool)
        part[a:b] = True
        w = np.where(part[:, None], 0.0, weight)
        A = (Y * w[..., None]).reshape(-1, base.rank)
        scale = np.linalg.norm(A, axis=0)
        scale[scale == 0] = 1.0
        found = np.linalg.lstsq(A / scale, (target * w).reshape(-1), rcond=1e-12)[0] / scale
        errors[a:b] = np.where(used[a:b], target[a:b] - Y[a:b] @ found, np.nan)
    return errors


def _few(names) -> str:
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")
