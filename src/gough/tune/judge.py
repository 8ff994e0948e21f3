"""Judging candidates: every candidate on every machine, all of them one batch, and one number each to rank by.

    held limits       the goal: worst or mean of the metric over the machines, m                                   (1)
    beyond limits     1e3 + the sum over the limits of value / limit - 1; of a limit of 0 the value itself          (2)
    unstable          1e6 (1 + growth a sample): the linearised loop at home grows, whatever the program showed     (3)
    a run failed      1e7 (1 + share of the samples that were not reached, mean over the machines)                 (4)
    refused           1e9: no controller can have these numbers here                                               (5)

Any candidate of a line ranks before all of the lines below it.  So where nothing holds the limits the search still
knows where to go, and no candidate ends it.
"""

from __future__ import annotations

import math
import warnings
from collections import defaultdict
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError
from .table import Task

BEYOND, UNSTABLE, FAILED, REFUSED = 1e3, 1e6, 1e7, 1e9
GROWS = 1 + 1e-6  # as simulate.stability: ten times the error of its differences


class Score(NamedTuple):
    """What is known of one candidate."""

    settings: dict[str, Any]
    cost: float  # eqs. (1)-(5)
    status: str  # "held", "beyond", "unstable", "failed", "refused"
    goal: float | None  # m
    values: tuple[float, ...] = ()  # the metric on each machine, m; NaN where it failed
    saturated: float | None = None  # largest of all machines
    force: float | None = None  # N
    overshoot: float | None = None  # m
    reason: str = ""

    def to_json(self) -> dict[str, Any]:
        return {**self._asdict(), "values": [v if math.isfinite(v) else None for v in self.values]}


class _Run(NamedTuple):
    """One candidate on one machine, as the batch told it."""

    value: float
    share: float  # of the samples that were reached
    saturated: float
    force: float
    overshoot: float
    radius: float | None
    reason: str


class Judge:
    """Judges candidates of a task on some of its machines."""

    def __init__(self, task: Task, machines: list[dict[str, Any]]):
        self.task, self.machines = task, machines

    def __call__(self, candidates: list[dict[str, Any]]) -> list[Score]:
        """A score for each of the candidates, which are settings."""
        scores: list[Score | None] = [None] * len(candidates)
        made = {}
        for i, settings in enumerate(candidates):
            try:
                made[i] = [self.task.setter({**machine, **settings}) for machine in self.machines]
                self._fits(made[i][0])
            except InputError as error:
                scores[i] = _refused(settings, error)
                made.pop(i, None)
        for i, runs in self._runs(made).items():
            settings = candidates[i]
            scores[i] = _refused(settings, runs) if isinstance(runs, InputError) else self._score(settings, runs)
        return scores

    def _fits(self, experiment) -> None:
        """Refuse numbers that the law cannot have on this machine at this period, before they meet the others."""
        experiment.controllers[0].law.on(experiment.machine, experiment.run.period)

    def _runs(self, made) -> dict[int, list[_Run] | InputError]:
        try:
            return self._batches(made)
        except InputError as error:
            if len(made) < 2:
                return dict.fromkeys(made, error)
        found = {}  # one of them does not go with this program: each alone tells which
        for i, experiments in made.items():
            found |= self._runs({i: experiments})
        return found

    def _batches(self, made) -> dict[int, list[_Run]]:
        """Every run of every candidate; runs that may share a batch do."""
        groups = defaultdict(list)
        for i, experiments in made.items():
            for j, one in enumerate(experiments):
                shared = one.run.replace(seed=0)
                groups[id(one.machine), id(one.program), id(one.observer), shared.digest()].append((i, j, one))
        out = {i: [None] * len(self.machines) for i in made}
        for members in groups.values():
            for (i, j, _), run in zip(members, self._batch([one for *_, one in members]), strict=True):
                out[i][j] = run
        return out

    def _batch(self, experiments) -> list[_Run]:
        from ..simulate.run import simulate

        first = experiments[0]
        options = {name: getattr(first.run, name) for name in type(first.run).model_fields}
        options.update(seed=[one.run.seed for one in experiments], signals=None, log_every=1)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # what is warned of a candidate is in its score
            log = simulate(
                first.machine, [one.controllers[0].law for one in experiments], first.program,
                [one.plant for one in experiments], observer=first.observer, keep="metrics", **options,
            )  # fmt: skip
        metrics, failed = log.metrics, log["failed"] == 1
        head, _, what = self.task.table.metric.partition(".")
        ticks = first.program.plan(first.machine).count(first.run.period)
        out = []
        for k, told in enumerate(log.runs):
            value = math.nan if failed[k] else float(metrics[head][what][k])
            out.append(_Run(
                value, float(metrics["samples"][k]) / ticks, _known(metrics["saturated"][k]),
                _known(metrics["strut_force"]["peak"][k]), _known(metrics["overshoot"]["max"][k]),
                told["spectral_radius"], told["reason"],
            ))  # fmt: skip
        return out

    def _score(self, settings: dict[str, Any], runs: list[_Run]) -> Score:
        table = self.task.table
        values = np.array([run.value for run in runs])
        largest = {
            "saturated": max(run.saturated for run in runs),
            "force": max(run.force for run in runs),
            "overshoot": max(run.overshoot for run in runs),
        }
        about = {"settings": settings, "values": tuple(map(float, values)), **largest}
        bad = next((run for run in runs if not math.isfinite(run.value)), None)
        if bad is not None:
            missed = 1 - float(np.mean([run.share for run in runs]))
            reason = bad.reason or "nothing was measured"
            return Score(cost=FAILED * (1 + missed), status="failed", goal=None, reason=reason, **about)
        goal = float(values.max() if table.goal == "worst" else values.mean())
        radius = max((run.radius for run in runs if run.radius is not None), default=0.0)
        if radius > GROWS:
            reason = f"the loop at home is unstable: spectral radius {radius:.6g} a sample"
            return Score(
                cost=UNSTABLE * (1 + min(1.0, radius - 1)), status="unstable", goal=goal, reason=reason, **about
            )
        excess, reasons = 0.0, []
        for name in ("saturated", "force", "overshoot"):
            limit = getattr(table, name)
            if limit is not None and largest[name] > limit:
                excess += largest[name] / limit - 1 if limit else largest[name]
                reasons.append(f"{name} {largest[name]:.4g}, limit {limit:g}")
        if reasons:
            return Score(cost=BEYOND + excess, status="beyond", goal=goal, reason="; ".join(reasons), **about)
        return Score(cost=goal, status="held", goal=goal, **about)


def _refused(settings: dict[str, Any], error: InputError) -> Score:
    return Score(settings, REFUSED, "refused", None, reason=str(error))


def _known(value) -> float:
    """A metric of which nothing was measured is 0: no drive has a limit, nothing came to rest."""
    return 0.0 if math.isnan(value) else float(value)
