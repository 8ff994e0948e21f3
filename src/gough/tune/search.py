"""Searching: CMA-ES of the package `cma`, or SciPy's differential evolution or L-BFGS-B; a generation is one call.

Points lie in the unit cube, one coordinate a gain.  Who draws has a generator of its own, so one seed is one search, to
the last bit; what a point costs is nothing but its rank to either of the first two.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..errors import ExperimentError

SPREAD = 0.25  # of the first generation of CMA-ES, as a share of the cube
CLOSE = 1e-3  # of the cube: gains that differ by less are one, 0.3 % of a range of ten to one
SAME = 1e-4  # relative: costs that differ by less are one

Judged = Callable[[np.ndarray], np.ndarray]  # points (k, gains) -> costs (k,)
Slopes = Callable[[np.ndarray], np.ndarray]  # a point (gains,) -> derivative of its cost (gains,)


class Spent(Exception):
    """The budget is spent: raised by `judge`, caught here."""


def descent(judge: Judged, slopes: Slopes, start: np.ndarray, scale: float, unsound: float) -> None:
    """L-BFGS-B from `start` along `slopes`, as `cma_es`; draws nothing.

    A point that costs `unsound` or more has no slope: it turns the search back, as high as ten times the start.
    """
    from scipy.optimize import minimize

    def at(u):
        cost = float(judge(u[None])[0])
        if cost >= unsound:
            return 10.0, np.zeros(len(u))
        return cost / scale, slopes(u) / scale

    try:
        minimize(at, start, jac=True, method="L-BFGS-B", bounds=[(0.0, 1.0)] * len(start), options={"ftol": SAME**2})
    except Spent:
        return


def methods() -> dict[str, Callable[[Judged, np.ndarray, float, int], None]]:
    """Name -> search(judge, start, scale, seed): from the point `start`, whose cost is of the size of `scale`."""
    return {"cma": cma_es, "evolution": evolution}


def cma_es(judge: Judged, start: np.ndarray, scale: float, seed: int) -> None:
    """CMA-ES (Hansen) from `start`, until it converges or `judge` raises Spent.

    Raises
    ------
    ExperimentError
        the package is not installed.
    """
    try:
        import cma
    except ImportError:
        raise ExperimentError(
            "CMA-ES needs the package cma", key="tune.method", cure='pip install "gough[tune]", or method = "evolution"'
        ) from None
    rng = np.random.default_rng(seed)
    options = {
        "bounds": [0.0, 1.0], "seed": np.nan, "randn": lambda *shape: rng.standard_normal(shape), "verbose": -9,
        "verb_log": 0, "verb_disp": 0, "tolx": CLOSE, "tolfun": SAME, "tolfunhist": SAME,
    }  # fmt: skip
    # inside of the cube: at its faces the first generation would be folded onto itself
    strategy = cma.CMAEvolutionStrategy(np.clip(start, 0.05, 0.95), SPREAD, options)
    try:
        while not strategy.stop():
            points = strategy.ask()
            strategy.tell(points, list(judge(np.array(points)) / scale))
    except Spent:
        return


def evolution(judge: Judged, start: np.ndarray, scale: float, seed: int) -> None:
    """Differential evolution (Storn and Price) with `start` in its first generation, as `cma_es`."""
    from scipy.optimize import differential_evolution

    rng, count = np.random.default_rng(seed), max(8, 4 * len(start))
    first = (
        rng.permuted(np.tile(np.arange(count), (len(start), 1)), axis=1).T + rng.random((count, len(start)))
    ) / count
    first[0] = start
    try:
        differential_evolution(
            lambda points: judge(points.T) / scale, [(0.0, 1.0)] * len(start), init=first, seed=rng, polish=False,
            vectorized=True, updating="deferred", maxiter=100_000, tol=SAME, atol=0,
        )  # fmt: skip
    except Spent:
        return
