"""The design of a sweep: which runs there are.  Points of the grid times draws of the distributions.

    [sweep]
    vary   = { "plant.friction.coulomb" = "uniform(0.8, 1.2) x", "controller.bandwidth" = ["10 Hz", "20 Hz"] }
    method = "random"                  # of the distributions: or "sobol"; "grid" where there are only lists
    runs   = 100                       # draws of the distributions; each is run at every point of the grid
    seed   = 0                         # of the draws
    metric = "contour_error.max"       # what the summary is about

Draw i is the same whatever `runs` is, so more runs go on where fewer ended.  Its encoder noise has the seed `run.seed`
+ i: points of the grid are compared on the same machines under the same noise.
"""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from pydantic import Field

from ..declare import Part
from ..errors import ExperimentError, InputError, Problem, did_you_mean
from ..experiment import Experiment
from ..quantities import brief
from .distributions import EXTREMES
from .factors import Factor, factors_of
from .settings import Setter

MOST_RUNS = 10_000_000
DRAWS = 100  # where nothing is said
SEED = "run.seed"
METRICS = (
    *(f"{name}.{what}" for name in ("contour_error", "orientation_error") for what in ("max", "rms", "mean")),
    *(f"{name}.{what}" for name in ("lag", "tracking") for what in ("max", "rms")),
    "reversals.largest", "strut_force.peak", "strut_velocity.peak", "overshoot.max", "saturated",
)  # fmt: skip


class Table(Part):
    """The [sweep] table of an experiment, but for `vary`."""

    method: Literal["grid", "random", "sobol"] | None = Field(None, description="how distributions are drawn")
    runs: int | None = Field(None, ge=1, le=MOST_RUNS, description="draws of the distributions")
    seed: int = Field(0, ge=0, lt=2**63, description="of the draws")
    metric: str = Field("contour_error.max", description="what the summary is about")


class Drawn(NamedTuple):
    """One point of the design."""

    draw: int
    point: int  # of the grid
    settings: dict[str, Any]


@dataclass(frozen=True)
class Design:
    """The runs of a sweep, but for the controllers."""

    factors: list[Factor]
    method: str
    draws: int
    seed: int
    metric: str
    noise: int | None  # seed of the noise of draw 0; None: as the experiment says, or a factor of its own

    @property
    def points(self) -> int:
        """Points of the grid."""
        return math.prod(len(factor.values) for factor in self.factors if factor.distribution is None)

    def __len__(self) -> int:
        return self.draws * self.points

    def quantiles(self, first: int, last: int) -> np.ndarray:
        """The numbers of draws first .. last - 1 between 0 and 1, (draws, distributions)."""
        count = sum(factor.distribution is not None for factor in self.factors)
        if not count:
            return np.zeros((last - first, 0))
        rng = np.random.default_rng(self.seed)
        if self.method == "random":
            u = rng.random((last, count))[first:]
        else:
            from scipy.stats import qmc

            engine = _sobol(qmc, count, rng)
            if first:
                engine.fast_forward(first)
            with warnings.catch_warnings():  # of numbers of draws that are no power of 2, which are as good a mean
                warnings.simplefilter("ignore", UserWarning)
                u = engine.random(last - first)
        return np.clip(u, *EXTREMES)  # no distribution has a value at 0 and 1

    def machines(self, first: int = 0, last: int | None = None) -> list[dict[str, Any]]:
        """The settings of draws first .. last - 1: what the distributions give, as a file writes it."""
        last = self.draws if last is None else last
        u, drawn = self.quantiles(first, last), [factor for factor in self.factors if factor.distribution is not None]
        columns = [factor.distribution.quantile(u[:, j]) for j, factor in enumerate(drawn)]
        out = []
        for i in range(last - first):
            settings: dict[str, Any] = {} if self.noise is None else {SEED: (self.noise + first + i) % 2**63}
            for factor, column in zip(drawn, columns, strict=True):
                settings |= factor.settings(factor.distribution.written(column[i]))
            out.append(settings)
        return out

    def grid(self) -> list[dict[str, Any]]:
        """The settings of each point of the grid, in the order of the lists; the last list runs fastest."""
        lists = [factor for factor in self.factors if factor.distribution is None]
        out = []
        for values in itertools.product(*(factor.values for factor in lists)):
            settings: dict[str, Any] = {}
            for factor, value in zip(lists, values, strict=True):
                settings |= factor.settings(value)
            out.append(settings)
        return out

    def __iter__(self) -> Iterator[Drawn]:
        grid = self.grid()
        for draw, machine in enumerate(self.machines()):
            for point, settings in enumerate(grid):
                yield Drawn(draw, point, {**machine, **settings})

    def to_file(self) -> dict[str, Any]:
        """The [sweep] table with nothing left open."""
        vary = {f.key: list(f.values) if f.distribution is None else f.distribution.text for f in self.factors}
        runs = {} if self.method == "grid" else {"runs": self.draws}
        return {"vary": vary, "method": self.method, **runs, "seed": self.seed, "metric": self.metric}


def design_of(
    experiment: Experiment, runs: int | None = None, seed: int | None = None, setter: Setter | None = None
) -> Design:
    """The design that the [sweep] table of an experiment describes; `runs` and `seed` take the place of what it says.

    Raises
    ------
    ExperimentError
        with every mistake of the table.
    """
    raw = experiment.document.data.get("sweep")
    if not isinstance(raw, dict):
        rule = "the table is missing" if raw is None else "must be a table"
        cure = 'write [sweep] and vary = { "controller.bandwidth" = ["10 Hz", "20 Hz"] }'
        raise experiment.document.locate(ExperimentError(rule, key="sweep", cure=cure))
    problems, factors, table = [], [], Table()
    try:
        factors = factors_of(raw.get("vary"), experiment, setter)
    except InputError as error:
        problems += error.problems
    try:
        table = Table.from_file({key: value for key, value in raw.items() if key != "vary"})
    except InputError as error:
        problems += experiment.document.locate(error, "sweep").problems
    if table.metric not in METRICS:
        wrong = Problem("no such metric", key="metric", value=brief(table.metric), cure=_metrics(table.metric))
        problems += experiment.document.locate(ExperimentError(problems=[wrong]), "sweep").problems
    if problems:
        raise ExperimentError(problems=problems)
    try:
        design = _design(table, factors, runs, seed, experiment.run.seed)
    except ExperimentError as error:
        raise experiment.document.locate(error, "sweep") from None
    if len(design) * len(experiment.controllers) > MOST_RUNS:
        raise experiment.document.locate(
            ExperimentError("too many runs", key="sweep", value=f"{len(design)}", limit=f"{MOST_RUNS}")
        )
    return design


def _metrics(name: str) -> str:
    return did_you_mean(name, METRICS)


def _design(table: Table, factors: list[Factor], runs: int | None, seed: int | None, noise: int) -> Design:
    drawn = [factor for factor in factors if factor.distribution is not None]
    method = table.method or ("random" if drawn else "grid")
    if method == "grid" and drawn:
        raise ExperimentError(
            "a grid has lists alone", key=f"vary.{drawn[0].key}", value=brief(drawn[0].distribution.text),
            cure='write a list, or method = "random" or "sobol"',
        )  # fmt: skip
    if method != "grid" and not drawn:
        cure = 'leave it out, or vary something by a distribution, as "choice(10, 20) Hz"'
        raise ExperimentError("draws distributions, and there is none", key="method", value=repr(method), cure=cure)
    for given, told in ((runs, "--runs"), (table.runs, None)):
        if given is not None and not drawn:
            raise ExperimentError(
                "counts the draws of distributions, and there is none", key="runs", value=told, cure="leave it out"
            )
    draws = (runs or table.runs or DRAWS) if drawn else 1
    varied = any(name == SEED for factor in factors for name in factor.names)
    chosen = table.seed if seed is None else seed
    return Design(factors, method, draws, chosen, table.metric, noise if drawn and not varied else None)


def _sobol(qmc, count: int, rng):
    try:
        return qmc.Sobol(count, rng=rng)
    except TypeError:  # before SciPy 1.15
        return qmc.Sobol(count, seed=rng)
