"""The [tune] table of an experiment: what may be changed, what is wanted, and within which limits.

[tune]
vary      = { "controller.bandwidth" = ["5 Hz", "80 Hz"] }
goal      = "worst"                  # over the machines: or "mean"
metric    = "contour_error.max"      # or contour_error.rms, contour_error.mean
machines  = 8                        # drawn by [sweep], to tune on
held_out  = 8                        # drawn further, never tuned on, told beside
saturated = 0.0                      # greatest share of samples with a drive at its limit
force     = "8 kN"                   # greatest force of a joint; left out: what drives give
overshoot = "20 um"                  # of a joint past a reference at rest; left out: any
method    = "cma"                    # or "evolution", or "gradient" of what is smooth; cma where left out and
                                     # there are two gains or more
budget    = 200                      # candidates tried, at most
seed      = 0
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Literal, NamedTuple

from pydantic import Field

from ..declare import Part, quantity
from ..errors import ExperimentError, InputError
from ..experiment import Experiment
from ..sweep.design import design_of
from ..sweep.settings import Setter
from .gains import Gain, gains_of

EXAMPLE = 'write [tune] and vary = { "controller.bandwidth" = ["5 Hz", "80 Hz"] }'


class Table(Part):
    """The [tune] table of an experiment, but for `vary`."""

    goal: Literal["worst", "mean"] = Field("worst", description="of the metric over the machines")
    metric: Literal["contour_error.max", "contour_error.rms", "contour_error.mean"] = Field(
        "contour_error.max", description="what is made small"
    )
    machines: int | None = Field(None, ge=1, le=10_000, description="drawn by [sweep], to tune on; 8 if left out")
    held_out: int | None = Field(None, ge=0, le=10_000, description="drawn further, not tuned on; 8 if left out")
    saturated: float = quantity(
        "1", "greatest share of samples with a drive at its limit", default=0.0, at_least=0, at_most=1
    )
    force: float | None = quantity("N", "greatest force of a joint", default=None, above=0)
    overshoot: float | None = quantity("m", "greatest of a joint past a reference at rest", default=None, above=0)
    method: Literal["cma", "evolution", "gradient"] | None = Field(None, description="how is searched")
    budget: int = Field(200, ge=1, le=100_000, description="candidates tried, at most")
    seed: int = Field(0, ge=0, lt=2**32, description="of the search")


class Task(NamedTuple):
    """What is to be tuned, checked."""

    experiment: Experiment
    table: Table
    gains: list[Gain]
    machines: list[dict[str, Any]]  # settings of the machines to tune on
    held_out: list[dict[str, Any]]  # and of those that are told beside
    setter: Setter


def task_of(experiment: Experiment, budget: int | None = None, seed: int | None = None) -> Task:
    """The task that the [tune] table of an experiment describes; `budget` and `seed` take the place of what it says.

    Raises
    ------
    ExperimentError
        with every mistake of the tables [tune] and [sweep].
    """
    document, raw = experiment.document, experiment.document.data.get("tune")
    if not isinstance(raw, Mapping):
        rule = "the table is missing" if raw is None else "must be a table"
        raise document.locate(ExperimentError(rule, key="tune", cure=EXAMPLE))
    if len(experiment.controllers) > 1:
        kinds = ", ".join(controller.kind for controller in experiment.controllers)
        error = ExperimentError(
            "one controller is tuned at a time", key="controller", value=kinds,
            cure=f"give --controller {experiment.controllers[0].kind}, or remove the others",
        )  # fmt: skip
        raise document.locate(error)
    problems, setter = [], Setter(experiment)
    found: dict[str, Any] = {}
    for make in (
        lambda: found.update(table=Table.from_file({key: value for key, value in raw.items() if key != "vary"})),
        lambda: found.update(gains=gains_of(raw.get("vary"), experiment, setter)),
    ):
        try:
            make()
        except InputError as error:
            problems += document.locate(error, "tune").problems
    if problems:
        raise ExperimentError(problems=problems)
    table, gains = found["table"], found["gains"]
    if table.method == "gradient" and (table.goal, table.metric) != ("mean", "contour_error.rms"):
        raise document.locate(
            ExperimentError(
                "a gradient needs a smooth goal", key="tune.method", value=f"{table.goal} {table.metric}",
                cure='write goal = "mean" and metric = "contour_error.rms", or method = "cma"',
            )
        )  # fmt: skip
    changed = {name: given for name, given in (("budget", budget), ("seed", seed)) if given is not None}
    for name, given in changed.items():
        try:
            table = table.replace(**{name: given})
        except InputError as error:
            raise ExperimentError(problems=[replace(problem, key=f"--{name}") for problem in error.problems]) from None
    try:
        machines, held_out = _machines(experiment, table, gains, setter)
    except ExperimentError as error:
        raise document.locate(error) from None
    return Task(experiment, table, gains, machines, held_out, setter)


def _machines(experiment: Experiment, table: Table, gains: list[Gain], setter: Setter):
    """The settings of the machines to tune on and of those held out."""
    if "sweep" not in experiment.document.data:
        for name in ("machines", "held_out"):
            if getattr(table, name):
                raise ExperimentError(
                    "counts machines that [sweep] draws, and there is no such table", key=f"tune.{name}",
                    cure='write [sweep] and vary = { "plant.friction.coulomb" = "normal(1.0, 0.2) x" }',
                )  # fmt: skip
        return [{}], []
    design = design_of(experiment, setter=setter)
    tuned = {place for gain in gains for place in setter.places(gain.key)}
    for factor in design.factors:
        for name in factor.names:
            if tuned & set(setter.places(name)):
                raise ExperimentError("is tuned, so it cannot be drawn too", key=f"sweep.vary.{factor.key}")
    drawn = any(factor.distribution is not None for factor in design.factors)
    if not drawn:
        for name in ("machines", "held_out"):
            if getattr(table, name):
                raise ExperimentError(
                    "counts draws of distributions, and [sweep] has lists alone", key=f"tune.{name}",
                    cure="leave it out: every point of the lists is tuned on",
                )  # fmt: skip
        return design.grid(), []
    count = 8 if table.machines is None else table.machines
    further = 8 if table.held_out is None else table.held_out
    grid, every = design.grid(), design.machines(0, count + further)
    whole = [[{**machine, **point} for point in grid] for machine in every]
    return [one for part in whole[:count] for one in part], [one for part in whole[count:] for one in part]
