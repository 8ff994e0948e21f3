"""Gains: what `vary` of a [tune] table may change, each between two ends.

    vary = { "controller.bandwidth" = ["5 Hz", "80 Hz"], "controller.speed_ratio" = [2, 5] }

A gain is searched from 0 to 1, logarithmically where both ends are above 0: u -> low (high / low)^u, else linearly.
What is tried is written with six digits, so a file with the number in it runs the very candidate.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from .. import units
from ..errors import ExperimentError, InputError, Problem
from ..experiment import Experiment
from ..quantities import brief
from ..sweep.settings import Setter

MOST_GAINS = 32
DIGITS = 6
_NUMBER = re.compile(r"\s*[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?\s*")


class Gain(NamedTuple):
    """One entry of `vary`: the key of a setting, its ends and their unit, as text behind the number."""

    key: str
    low: float
    high: float
    unit: str

    @property
    def logarithmic(self) -> bool:
        return self.low > 0

    @property
    def names(self) -> list[str]:
        """The names inside the law: "controller.0.law.bandwidth" -> law, bandwidth."""
        names = self.key.split(".")[1:]
        return names[1:] if names[0].isdecimal() else names

    def of(self, law: Any) -> Any:
        """The number of a law that this is, SI; None where it has none."""
        for name in self.names:
            law = getattr(law, name, None)
        return law

    def slope(self, number: float, own: float | None) -> float:
        """d number / du where the number of the law is `number`, SI; `own` is that of the experiment as it stands."""
        if self.logarithmic:
            return number * math.log(self.high / self.low)
        factor = own if self.unit == "x" else units.parse(f"1 {self.unit}")[0] if self.unit else 1.0
        return (self.high - self.low) * factor

    def value(self, u: float) -> Any:
        """What a file says at u in [0, 1]."""
        u = min(1.0, max(0.0, float(u)))
        found = self.low * (self.high / self.low) ** u if self.logarithmic else self.low + (self.high - self.low) * u
        rounded = float(f"{found:.{DIGITS}g}")
        return f"{rounded!r} {self.unit}" if self.unit else rounded

    def place(self, value: Any) -> float | None:
        """u of a value as a file says it, or as SI number; None where it lies outside of the ends."""
        try:
            si = units.parse(value)[0] if isinstance(value, str) else float(value)
        except (InputError, TypeError, ValueError):
            return None
        factor = units.parse(f"1 {self.unit}")[0] if self.unit else 1.0
        x = si / factor
        if not self.low <= x <= self.high:
            return None
        return math.log(x / self.low) / math.log(self.high / self.low) if self.logarithmic else (x - self.low) / (
            self.high - self.low
        )  # fmt: skip


def settings(gains: list[Gain], u: np.ndarray) -> dict[str, Any]:
    """The settings of the point u (gains,) of the search."""
    return {gain.key: gain.value(each) for gain, each in zip(gains, u, strict=True)}


def gains_of(vary: Any, experiment: Experiment, setter: Setter) -> list[Gain]:
    """The gains that `vary` describes.

    Raises
    ------
    ExperimentError
        with every mistake, at its key: no gain of the controller (with the nearest), ends that are none or that the
        controller cannot have.
    """
    if not isinstance(vary, Mapping) or not vary:
        cure = 'write vary = { "controller.bandwidth" = ["5 Hz", "80 Hz"] }'
        raise ExperimentError(
            "must be a table of gains, each with its two ends", key="vary", value=brief(vary), cure=cure
        )
    if len(vary) > MOST_GAINS:
        raise ExperimentError("too many gains", key="vary", value=str(len(vary)), limit=str(MOST_GAINS))
    problems, found = [], []
    for key, ends in vary.items():
        try:
            found.append(_gain(key, ends, setter))
        except InputError as error:
            for problem in error.problems:
                said = f"{problem.key} {problem.rule}" if problem.key not in (None, "", key) else problem.rule
                problems.append(Problem(**{**problem.__dict__, "rule": said, "key": f"vary.{key}"}))
    if problems:
        raise ExperimentError(problems=problems)
    return found


def _gain(key: str, ends: Any, setter: Setter) -> Gain:
    if not key.startswith("controller."):
        setter.places(key)  # a name that is none at all gets the nearest right one
        raise ExperimentError(
            "is no gain: only what a controller has is tuned", cure="vary it in [sweep], to tune for all its values"
        )
    setter.places(key)
    if not isinstance(ends, list) or len(ends) != 2:
        raise ExperimentError("must be two ends", value=brief(ends), cure='write ["5 Hz", "80 Hz"]')
    (low, unit), (high, other) = (_number(end) for end in ends)
    if unit != other:
        raise ExperimentError("both ends must have one unit", value=f"{brief(ends[0])} and {brief(ends[1])}")
    if not low < high:
        raise ExperimentError("the first end must lie below the second", value=f"{brief(ends[0])} and {brief(ends[1])}")
    for end in ends:
        setter({key: end})
    return Gain(key, low, high, unit)


def _number(end: Any) -> tuple[float, str]:
    """The number of an end and the text of its unit."""
    if isinstance(end, bool) or not isinstance(end, int | float | str):
        raise ExperimentError("an end must be a number or a quantity", value=brief(end))
    if not isinstance(end, str):
        if not math.isfinite(end):
            raise ExperimentError("an end must be finite", value=brief(end))
        return float(end), ""
    units.parse(end)  # refuses what is none, and inf
    digits = _NUMBER.match(end).group()
    return float(digits), end[len(digits) :].strip()
