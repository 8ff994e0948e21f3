"""Factors: what `vary` of a [sweep] table changes from run to run, checked against the experiment.

    vary = { "plant.friction.coulomb" = "uniform(0.8, 1.2) x", "controller.bandwidth" = ["10 Hz", "20 Hz"] }

A list is a grid: every run is done at each of its values.  A text is a distribution (distributions.py), drawn anew for
every run.  A key of several names, "plant.friction.coulomb, plant.friction.static", sets them all to the same value.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ..errors import ExperimentError, InputError, Problem
from ..experiment import Experiment
from ..quantities import brief
from .distributions import Distribution, distribution_of, is_distribution
from .settings import Setter

MOST_FACTORS = 64
MOST_VALUES = 10_000
# quantiles at which a distribution is tried: its middle, and where it has ends, just inside of them
_MIDDLE, _ENDS = 0.5, (2.0**-40, 1 - 2.0**-40)


class Factor(NamedTuple):
    """One entry of `vary`: the settings that it is, and its values or its distribution."""

    key: str  # as written in `vary`
    names: tuple[str, ...]
    values: tuple[Any, ...] = ()
    distribution: Distribution | None = None

    def settings(self, value: Any) -> dict[str, Any]:
        """The settings of one value, as a file would write it."""
        return dict.fromkeys(self.names, value)


def factors_of(vary: Any, experiment: Experiment, setter: Setter | None = None) -> list[Factor]:
    """The factors that a `vary` table describes.

    Raises
    ------
    ExperimentError
        with every mistake, its file, line and key: names that are none (with the nearest right one), impossible
        distributions, values that the experiment cannot have.
    """
    setter, problems, factors = setter or Setter(experiment), [], []
    if not isinstance(vary, Mapping) or not vary:
        cure = 'write vary = { "controller.bandwidth" = ["10 Hz", "20 Hz"] }'
        wrong = Problem("must be a table of factors", key="sweep.vary", value=brief(vary), cure=cure)
        raise experiment.document.locate(ExperimentError(problems=[wrong]))
    flat = dict(_flat(vary))
    if len(flat) > MOST_FACTORS:
        problems.append(Problem(f"at most {MOST_FACTORS} factors", key="sweep.vary", value=str(len(flat))))
        flat = {}
    taken: dict[str, str] = {}
    for key, raw in flat.items():
        try:
            factor = _factor(key, raw, setter)
            for place in (place for name in factor.names for place in setter.places(name)):
                if place in taken:
                    raise ExperimentError(f"sets {place}, which {taken[place]!r} sets already", cure="keep one")
                taken[place] = key
            factors.append(factor)
        except InputError as error:
            problems += [_placed(problem, key) for problem in error.problems]
    if problems:
        raise experiment.document.locate(ExperimentError(problems=problems))
    return factors


def _flat(table: Mapping[str, Any], above: str = ""):
    """(dotted key, value): vary = { plant.payload = ... } is vary = { "plant.payload" = ... }."""
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{above}{key}.")
        else:
            yield f"{above}{key}", value


def _placed(problem: Problem, key: str) -> Problem:
    """The problem at its entry of `vary`; the setting that it names stands in the rule where it is another."""
    inner, rule = problem.key, problem.rule
    if inner and inner != key:
        rule = f"{inner} {rule}"
    return Problem(**{**problem.__dict__, "key": f"sweep.vary.{key}", "rule": rule, "file": None, "line": None})


def _factor(key: str, raw: Any, setter: Setter) -> Factor:
    names = tuple(name.strip() for name in key.split(","))
    for name in names:
        setter.places(name)
    if isinstance(raw, list):
        if not raw or len(raw) > MOST_VALUES:
            raise ExperimentError(f"a list of 1 to {MOST_VALUES} values", value=f"{len(raw)} of them")
        twice = next((value for i, value in enumerate(raw) if value in raw[:i]), None)
        if twice is not None:
            raise ExperimentError("stands twice in the list", value=brief(twice), cure="keep one")
        for value in raw:
            if is_distribution(value):
                raise ExperimentError("a distribution stands alone, not in a list", value=brief(value))
            _try(setter, names, value)
        return Factor(key, names, values=tuple(raw))
    if isinstance(raw, str) and is_distribution(raw):
        found = distribution_of(raw)
        for u in (_MIDDLE, *(_ENDS if found.bounded else ())):
            _try(setter, names, found.written(found.quantile(np.array([u]))[0]), f" in {raw!r}")
        return Factor(key, names, distribution=found)
    raise ExperimentError(
        "must be a list of values or a distribution", value=brief(raw),
        cure=f'write [{brief(raw)}], or e.g. "normal(1.0, 0.2) x"',
    )  # fmt: skip


def _try(setter: Setter, names: tuple[str, ...], value: Any, told: str = "") -> None:
    """Refuse a value that the experiment cannot have; names that are none get the nearest right one."""
    try:
        setter(dict.fromkeys(names, value))
    except InputError as error:
        problems = []
        for problem in error.problems:
            if problem.rule == "no such key":
                near = setter.near(_as_named(problem.key or "", names))
                problem = Problem("names nothing of this experiment", key=problem.key, cure=near)
            else:
                problem = Problem(**{**problem.__dict__, "value": f"{problem.value or brief(value)}{told}"})
            problems.append(problem)
        raise ExperimentError(problems=list(dict.fromkeys(problems))) from None


def _as_named(key: str, names: tuple[str, ...]) -> str:
    """The name whose place a key is: "controller.0.bandwith" may stand for "controller.bandwith"."""
    head, _, rest = key.partition(".")
    number, _, inner = rest.partition(".")
    short = f"{head}.{inner}"
    return short if head == "controller" and number.isdecimal() and short in names else key
