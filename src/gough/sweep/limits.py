"""Limits that the runs of a sweep hit: which, how many, drives at their limits, loops that grow; and why runs failed.

Failures are told by their sort: the limit that ended the run, without the number of its joint ("strut: too long"), or
the reason of what ended otherwise, its numbers left out, so that a thousand runs that fail at a thousand times are a
line.
"""

from __future__ import annotations

import re
from typing import Any, NamedTuple

import numpy as np

from .run import Swept
from .table import Lines

UNSTABLE = 1 + 1e-6  # spectral radius; the margin of simulate.stability
_NUMBER = re.compile(r"[+-]?\d+(?:\.\d*)?(?:[eE][+-]?\d+)?")
_JOINT = re.compile(r" \d+(?=:)")


class Failure(NamedTuple):
    """Runs that failed alike."""

    sort: str
    count: int
    first: int  # the line of one of them


def failures(lines: Lines) -> list[Failure]:
    """Runs that failed by their sorts, the most common first."""
    found: dict[str, list[int]] = {}
    for k in np.flatnonzero(lines.status != "done"):
        found.setdefault(sort_of(lines.limit[k], lines.reason[k]), []).append(int(k))
    return sorted((Failure(sort, len(at), at[0]) for sort, at in found.items()), key=lambda one: (-one.count, one.sort))


def sort_of(limit: str, reason: str) -> str:
    """What runs that fail alike have in common."""
    return _JOINT.sub("", limit) if limit else _NUMBER.sub("#", reason)


def hits(lines: Lines, at: np.ndarray) -> dict[str, int]:
    """How many of the lines `at` ended at each sort of limit."""
    found: dict[str, int] = {}
    for limit in (lines.limit[k] for k in at if lines.limit[k]):
        found[_JOINT.sub("", limit)] = found.get(_JOINT.sub("", limit), 0) + 1
    return dict(sorted(found.items()))


def told_of(failure: Failure, lines: Lines) -> str:
    """A sort of failures in a line, with the words of one of them."""
    reason = lines.reason[failure.first]
    if failure.count == 1:
        return f"1 failed: {reason}"
    sort = f" ({failure.sort})" if lines.limit[failure.first] else ""
    return f"{failure.count} failed{sort}, such as: {reason}"


def unstable(swept: Swept, lines: Lines) -> list[str]:
    """Of each controller whose loop grows in some of its runs, by its linearisation at home: how many, and one."""
    out = []
    for i, label in enumerate(swept.experiment.labels):
        at = np.flatnonzero((lines.controller == i) & (np.nan_to_num(lines.radius) > UNSTABLE))
        if len(at):
            worst = int(at[np.argmax(lines.radius[at])])
            out.append(
                f"{label}: the loop is unstable at home in {len(at)} of {int((lines.controller == i).sum())} runs, the "
                f"most in {lines.ids[worst][:10]} (spectral radius {lines.radius[worst]:.6g} a sample); lower the "
                "bandwidth or shorten the period"
            )
    return out


def recorded(hit: dict[str, Any] | None) -> dict[str, Any] | None:
    """What a run's file keeps of the limit that it hit: its name, the time in s; None where it hit none."""
    return None if hit is None else {"limit": str(hit["limit"]), "time": float(hit["time"])}
