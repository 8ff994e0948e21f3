"""The experiments of this study as jobs, and what each of them gives to the claims."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..study import Experiment, Tick, parts
from . import circle, learning, limit
from .circle import Turn
from .learning import Learned
from .limit import Limits
from .setup import WEAK, axis_pd, computed_torque

SPEEDS = (0.1, 0.3, 0.4)  # m/s, of the PD rows
FAST = SPEEDS[-1]
DRIFT = 0.2 / learning.TIME  # 1/s: friction 20 % up at the end
TURNED = {deg: np.radians(deg) for deg in (8, 3)}  # rad, of Exercise


def circles(tick: Tick | None) -> list[Turn]:
    """PD at all SPEEDS, then computed torque at the last with its feed-forward 8 % too weak."""
    laws = [(axis_pd(), speed) for speed in SPEEDS] + [(computed_torque(estimates=WEAK), FAST)]
    ticks = parts(tick, [1 / speed for _, speed in laws])
    return [circle.turn(law, speed, part) for (law, speed), part in zip(laws, ticks, strict=True)]


def learns(**options) -> Callable[[Tick | None], Learned]:
    """A run of learning."""
    return lambda tick: learning.learned(tick, **options)


EXPERIMENTS = (
    Experiment("circles", circles),
    Experiment("learning, translation", learns()),
    *(Experiment(f"learning, turns of {deg} deg", learns(turn=turn)) for deg, turn in TURNED.items()),
    Experiment("friction drifts", learns(first=1.0, drift=DRIFT)),
    Experiment("limit cases", limit.limits),
)


class Results:
    """The results of EXPERIMENTS by name."""

    def __init__(self, results: Sequence[Any]):
        self.of = {experiment.label: result for experiment, result in zip(EXPERIMENTS, results, strict=True)}
        turns: list[Turn] = self.of["circles"]
        self.pd = {turn.speed: turn for turn in turns[:-1]}
        self.ctc = turns[-1]
        self.translation: Learned = self.of["learning, translation"]
        self.turned: dict[int, Learned] = {deg: self.of[f"learning, turns of {deg} deg"] for deg in TURNED}
        self.drift: Learned = self.of["friction drifts"]
        self.limits: Limits = self.of["limit cases"]
