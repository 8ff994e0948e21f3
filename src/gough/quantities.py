"""Quantity: what is known of a number before it is given, and the check of one that is."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import units
from .errors import InputError, UnitError


@dataclass(frozen=True)
class Quantity:
    """What is known of a number before it is given: unit, bounds, meaning, shape."""

    unit: str
    meaning: str
    above: float | None = None
    at_least: float | None = None
    below: float | None = None
    at_most: float | None = None
    # (-1,): a single value for all, or one each, as many as the owner has; (-1, -1): a matrix, its size the owner's
    shape: tuple[int, ...] = ()

    def check(self, raw: Any, from_file: bool) -> float | np.ndarray:
        """SI value of `raw`: read-only array or float.

        Raises
        ------
        InputError
            not a quantity, wrong unit or shape, not finite, out of bounds.
        """
        value = np.array(self._si(raw, from_file), float)
        free = (self.shape == (-1,) and value.ndim <= 1) or (self.shape == (-1, -1) and value.ndim == 2)
        if value.shape != self.shape and not free:
            raise InputError(
                f"must have shape {shape_text(self.shape)}", value=shape_text(value.shape), cure=self._shaped(value)
            )
        if not np.isfinite(value).all():
            raise InputError("must be finite", value=brief(raw))
        for bound, wrong, word in (
            (self.above, np.less_equal, "above"),
            (self.at_least, np.less, "at least"),
            (self.below, np.greater_equal, "below"),
            (self.at_most, np.greater, "at most"),
        ):
            if bound is not None and wrong(value, bound).any():
                unit = self._units(1)[0]
                raise InputError(f"must be {word} {with_unit(bound, unit)}", value=brief(raw, unit))
        if value.ndim == 0:
            return float(value)
        value.setflags(write=False)
        return value

    def _likely(self, raw: Any) -> str:
        unit = self._units(1)[0]
        return units.likely(raw, unit) if isinstance(raw, int | float) else unit

    def _shaped(self, value: np.ndarray) -> str | None:
        """What to write instead of an array of another shape, where that can be told."""
        if self.shape == (3, 3) and value.shape == (3,):
            return "a diagonal is written in full, [[a, 0, 0], [0, b, 0], [0, 0, c]]"
        if len(self.shape) == 1 and self.shape[0] > 0:
            return f"give a list of {self.shape[0]}: {self.meaning}"
        return None

    def _si(self, raw: Any, from_file: bool) -> Any:
        if isinstance(raw, bool):
            raise InputError("must be a quantity", value=str(raw).lower())
        if isinstance(raw, str):
            if self.unit == "1" and not raw.strip().endswith(("%", "x")):
                raise InputError("must be a number, without quotes", value=brief(raw))
            return units.to_si(raw, self._units(1)[0])
        if isinstance(raw, Mapping):  # { unit = "m", value = [[...], ...] }
            if set(raw) != {"unit", "value"}:
                raise InputError("an array is written { unit = ..., value = [...] }", value=brief(sorted(raw)))
            scale, dimension = units.unit(_text(raw["unit"]))
            each = self._units(len(raw["value"]) or 1 if isinstance(raw["value"], list | tuple) else 1)
            if len(set(each)) > 1 or not units.same_dimension(dimension, units.unit(each[0])[1]):
                raise UnitError(f"{raw['unit']!r} is not a unit of {self.unit}")
            return np.array(_numbers(raw["value"]), float) * scale
        if isinstance(raw, list | tuple) and raw and all(isinstance(entry, str) for entry in raw):
            each = self._units(len(raw))
            count = self.unit.count(",") + 1  # with a unit of its own for each entry, another number has none
            if count > 1 and len(raw) != count and self.shape == (count,):
                raise InputError(f"must have shape {count}", value=str(len(raw)), cure=f"give {self.meaning}")
            return [units.to_si(entry, unit) for entry, unit in zip(raw, each, strict=True)]
        if from_file and self.unit not in ("", "1"):
            cure = (
                f'write e.g. "{raw} {self._likely(raw)}"'
                if not isinstance(raw, list | tuple)
                else (f'write {{ unit = "{self._units(1)[0]}", value = ... }}')
            )
            raise InputError("has no unit", value=brief(raw), cure=cure)
        return _numbers(raw)

    def _units(self, count: int) -> list[str]:
        """The unit of each entry; "m m m rad rad rad" style lists are written with commas."""
        each = [u.strip() for u in self.unit.split(",")]
        return each if len(each) == count else each[:1] * count


def _numbers(raw: Any) -> Any:
    """Nested lists or arrays of real numbers; booleans and texts are none."""
    if isinstance(raw, list | tuple):
        rows = [_numbers(entry) for entry in raw]
        if len({np.shape(row) for row in rows}) > 1:
            raise InputError("rows of an array must be of one length", value=brief(raw))
        return rows
    if isinstance(raw, np.ndarray) and raw.dtype.kind in "fiu":
        return raw
    if isinstance(raw, bool) or not isinstance(raw, int | float | np.integer | np.floating):
        raise InputError("must be a number", value=brief(raw))
    try:
        return float(raw)
    except OverflowError:  # an integer beyond any float
        return math.inf


def _text(raw: Any) -> str:
    if not isinstance(raw, str):
        raise InputError("a unit is a text", value=brief(raw), cure='write unit = "m"')
    return raw


def written(value: Any, spec: Quantity) -> Any:
    each = spec._units(int(np.size(value)))
    if np.ndim(value) == 0:
        return f"{value!r} {each[0]}" if each[0] not in ("", "1") else value
    if len(set(each)) == 1:
        return {"unit": each[0] or "1", "value": np.asarray(value).tolist()}
    return [f"{float(v)!r} {u}" for v, u in zip(value, each, strict=True)]


def shape_text(shape: tuple[int, ...]) -> str:
    return " x ".join("n" if size < 0 else str(size) for size in shape) if shape else "a single value"


def with_unit(value: float, unit: str) -> str:
    return f"{value:g} {unit}" if unit not in ("", "1") else f"{value:g}"


def brief(raw: Any, unit: str | None = None) -> str:
    if isinstance(raw, float | int | np.floating) and not isinstance(raw, bool) and unit:
        return with_unit(raw, unit)
    text = repr(raw)
    return text if len(text) <= 60 else text[:57] + "..."
