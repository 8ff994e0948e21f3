"""Metrics as a tree of names: of one run nested dicts of numbers, of many the same of arrays (runs,)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

WHOLE = ("line", "count", "samples", "counted")  # numbers that count
_UNITS = {"at": "s", "line": "1", "count": "1", "samples": "1", "counted": "1", "saturated": "1"}
_TOP = {"orientation_error": "rad", "strut_force": "N", "strut_velocity": "m/s"}


def leaves(tree: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """(dotted name, value) of every entry of nested dicts."""
    for name, value in tree.items():
        if isinstance(value, Mapping):
            yield from leaves(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


def nested(flat: Mapping[str, Any]) -> dict[str, Any]:
    """Nested dicts of dotted names."""
    out: dict[str, Any] = {}
    for name, value in flat.items():
        *path, last = name.split(".")
        inner = out
        for part in path:
            inner = inner.setdefault(part, {})
        inner[last] = value
    return out


def columns(metrics: Sequence[Mapping[str, Any]]) -> dict[str, np.ndarray]:
    """Metrics of runs, one dict a run, as one array (runs,) a number; NaN for None."""
    names = dict.fromkeys(name for one in metrics for name, _ in leaves(one))
    flat = [dict(leaves(one)) for one in metrics]
    return {name: np.array([math.nan if one.get(name) is None else one[name] for one in flat], float) for name in names}


def told(name: str) -> tuple[str, str]:
    """Unit and meaning of the metric of that dotted name."""
    head, _, rest = name.partition(".")
    unit = _UNITS.get(name.rpartition(".")[2]) or _TOP.get(head, "m")
    return unit, f"{head.replace('_', ' ')}, {rest}" if rest else head
