"""The experiments of this study as jobs, and their results by name.  A half of the study adds its JOBS here."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ..study import Experiment, Tick
from . import beyond, checks, continuous, flexible, poses, rigid
from .setup import HIGH, LOW, machine


def in_continuous_time(tick: Tick | None) -> dict[tuple[str, str], continuous.Errors]:
    """Both laws at both gains without samples, by gains and law."""
    out, jobs = {}, [(key, gains, name) for key, gains in (("low", LOW), ("high", HIGH)) for name in rigid.LAWS]
    for i, (key, gains, name) in enumerate(jobs):
        out[key, name] = continuous.follow(name, gains, machine())
        if tick is not None:
            tick(i + 1, len(jobs))
    return out


JOBS: dict[str, Callable[[Tick | None], Any]] = {
    **rigid.JOBS,
    "rigid, continuous time": in_continuous_time,
    "elimination": checks.elimination,
    **poses.JOBS,
    **flexible.JOBS,
    **beyond.JOBS,
}
EXPERIMENTS = [Experiment(label, work) for label, work in JOBS.items()]


class Results:
    """The results of EXPERIMENTS by their names."""

    def __init__(self, results: Sequence[Any]):
        self.of = dict(zip(JOBS, results, strict=True))
        self.known: dict[tuple[str, str], rigid.Course] = self.of["rigid, known"]
        self.unlike: dict[tuple[str, str], rigid.Course] = self.of["rigid, centres of mass off"]
        self.other_side: dict[str, rigid.Course] = self.of["rigid, arm 1 on the other side"]
        self.continuous: dict[tuple[str, str], continuous.Errors] = self.of["rigid, continuous time"]
        self.elimination: checks.Elimination = self.of["elimination"]
        self.ends: dict[str, poses.Standing] = self.of["flexible, at both ends"]
        self.sections: list[poses.Section] = self.of["flexible, map"]
        self.statics: poses.Statics = self.of["flexible, static algorithm"]
        self.flexible: dict[tuple[str, str], rigid.Course] = self.of["flexible"]
        self.compensated: dict[tuple[str, str, str], rigid.Course] = self.of["flexible, gravity compensated"]
        self.modes: dict[tuple[str, str], flexible.Mode] = self.of["flexible, modes of the loop"]
        self.vibration: dict[tuple[str, str, str], beyond.Moved] = self.of["vibration"]
