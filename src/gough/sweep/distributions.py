"""Distributions as texts: "normal(1.0, 0.2) x", "uniform(10, 20) Hz".  A closed grammar: nothing is evaluated.

    text     = name "(" number ("," number)* ")" unit?
    normal(mean, deviation)              or normal(mean, deviation, low, high): cut off at both ends
    lognormal(median, deviation)         deviation of the natural logarithm: 0.2 is about 20 %
    uniform(low, high)
    loguniform(low, high)                every decade is as likely
    triangular(low, peak, high)
    integers(low, high)                  whole numbers, both ends among them
    choice(a, b, ...)                    one of these numbers, each as likely

A draw is the quantile of a number u between 0 and 1, so random and Sobol numbers give the same distribution.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from .. import units
from ..errors import ExperimentError, InputError, did_you_mean
from ..quantities import brief

_TEXT = re.compile(r"\s*([A-Za-z_]+)\s*\(([^()]*)\)\s*([^()]*)")
_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]{1,3})?")
_LONGEST = 200
EXTREMES = (2.0**-54, 1 - 2.0**-53)  # least and greatest probability that is ever drawn


class Distribution(NamedTuple):
    """One distribution: its name, its numbers in `unit`, and the text that it was written as."""

    name: str
    numbers: tuple[float, ...]
    unit: str
    text: str

    def quantile(self, u: np.ndarray) -> np.ndarray:
        """Values in `unit` at the probabilities u, (n,) between 0 and 1, both excluded; (n,)."""
        return _KINDS[self.name].quantile(np.asarray(u, float), *self.numbers)

    @property
    def bounded(self) -> bool:
        """Whether there is a least and a greatest value."""
        return self.name not in ("normal", "lognormal") or len(self.numbers) == 4

    def written(self, value: float) -> Any:
        """A value as a file writes it, to the last bit: "0.97 x", 12.5, 3."""
        if self.name == "integers":
            return int(value) if not self.unit else f"{int(value)} {self.unit}"
        return f"{float(value)!r} {self.unit}" if self.unit else float(value)


class _Kind(NamedTuple):
    counts: tuple[int, ...]  # of numbers; (): one or more
    example: str
    check: Callable[..., str | None]  # the rule that the numbers break
    quantile: Callable[..., np.ndarray]


def is_distribution(raw: Any) -> bool:
    """Whether a value of `vary` is meant as a distribution: a text with a bracket."""
    return isinstance(raw, str) and "(" in raw


def distribution_of(text: str) -> Distribution:
    """The distribution that a text describes.

    Raises
    ------
    InputError
        no such distribution, wrong numbers for it, or no such unit.
    """
    if len(text) > _LONGEST or not text.isascii():
        raise ExperimentError(f"a distribution has at most {_LONGEST} ASCII characters", value=brief(text))
    match = _TEXT.fullmatch(text)
    if not match:
        raise ExperimentError("is not a distribution", value=brief(text), cure='write e.g. "normal(1.0, 0.2) x"')
    name, inner, unit = match[1], match[2], match[3].strip()
    if name not in _KINDS:
        raise ExperimentError("no such distribution", value=brief(name), cure=did_you_mean(name, _KINDS))
    kind = _KINDS[name]
    numbers = tuple(_number(part, kind, text) for part in inner.split(",")) if inner.strip() else ()
    if (kind.counts and len(numbers) not in kind.counts) or not numbers:
        need = " or ".join(map(str, kind.counts)) or "one or more"
        raise ExperimentError(
            f"{name} takes {need} numbers", value=brief(text), cure=f'write e.g. "{kind.example} {unit}"'.strip()
        )
    units.unit(unit)
    rule = kind.check(*numbers)
    if rule:
        raise ExperimentError(f"impossible distribution: {rule}", value=brief(text), cure=f'as in "{kind.example}"')
    found = Distribution(name, numbers, unit, text)
    with np.errstate(over="ignore", invalid="ignore"):
        ends = found.quantile(np.array(EXTREMES))
    if not np.isfinite(ends).all():
        rule = "impossible distribution: some of its values are beyond all numbers"
        raise ExperimentError(rule, value=brief(text), cure=f'as in "{kind.example}"')
    return found


def _number(text: str, kind: _Kind, whole: str) -> float:
    text = text.strip()
    if not _NUMBER.fullmatch(text):
        cure = f'numbers alone, the unit behind the bracket: "{kind.example} Hz"'
        raise ExperimentError("is not a number", value=f"{brief(text)} in {brief(whole)}", cure=cure)
    value = float(text)
    if not math.isfinite(value):
        raise InputError("must be finite", value=brief(whole))
    return value


# -- rules ----------------------------------------------------------------------------------------------------------


def _check_normal(_mean, deviation, low=-math.inf, high=math.inf):
    if not deviation > 0:
        return "the deviation must be above 0"
    if not low < high:
        return "the low end must be below the high one"
    inside = np.diff(_normal_cdf(np.array([low, high]), _mean, deviation))[0]
    return None if inside > 1e-6 else "less than a millionth of it lies between its ends"


def _check_lognormal(median, deviation):
    if not median > 0:
        return "the median must be above 0"
    return None if deviation > 0 else "the deviation must be above 0"


def _check_uniform(low, high):
    return None if low < high else "the low end must be below the high one"


def _check_loguniform(low, high):
    return "the low end must be above 0" if not low > 0 else _check_uniform(low, high)


def _check_triangular(low, peak, high):
    return _check_uniform(low, high) or (None if low <= peak <= high else "the peak must lie between its ends")


def _check_integers(low, high):
    if low != int(low) or high != int(high) or max(abs(low), abs(high)) >= 2**53:
        return "both ends must be whole numbers"
    return None if low <= high else "the low end must not be above the high one"


# -- quantiles ------------------------------------------------------------------------------------------------------


def _normal_cdf(x, mean, deviation):
    from scipy.special import ndtr

    return ndtr((x - mean) / deviation)


def _normal(u, mean, deviation, low=None, high=None):
    from scipy.special import ndtri

    if low is None:
        return mean + deviation * ndtri(u)
    a, b = _normal_cdf(np.array([low, high]), mean, deviation)
    return np.clip(mean + deviation * ndtri(a + u * (b - a)), low, high)


def _lognormal(u, median, deviation):
    from scipy.special import ndtri

    return median * np.exp(deviation * ndtri(u))


def _uniform(u, low, high):
    return low + u * (high - low)


def _loguniform(u, low, high):
    return np.clip(low * np.exp(u * math.log(high / low)), low, high)


def _triangular(u, low, peak, high):
    # the distribution function is (x - low)^2 / ((high - low) (peak - low)) up to the peak, and its mirror image behind
    share = (peak - low) / (high - low)
    rising = low + np.sqrt(u * (high - low) * (peak - low))
    falling = high - np.sqrt((1 - u) * (high - low) * (high - peak))
    return np.where(u < share, rising, falling)


def _integers(u, low, high):
    return np.minimum(low + np.floor(u * (high - low + 1)), high)


def _choice(u, *values):
    return np.asarray(values, float)[np.minimum((u * len(values)).astype(int), len(values) - 1)]


_KINDS = {
    "normal": _Kind((2, 4), "normal(1.0, 0.2)", _check_normal, _normal),
    "lognormal": _Kind((2,), "lognormal(1.0, 0.2)", _check_lognormal, _lognormal),
    "uniform": _Kind((2,), "uniform(0.8, 1.2)", _check_uniform, _uniform),
    "loguniform": _Kind((2,), "loguniform(1, 100)", _check_loguniform, _loguniform),
    "triangular": _Kind((3,), "triangular(0.8, 1.0, 1.2)", _check_triangular, _triangular),
    "integers": _Kind((2,), "integers(0, 9)", _check_integers, _integers),
    "choice": _Kind((), "choice(1, 2, 5)", lambda *_: None, _choice),
}
KINDS = tuple(_KINDS)
