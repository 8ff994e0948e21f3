"""The rigid rows: every law at every gain on the machine it knows, and on sixteen whose centres of mass are off."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...machine.base import Machine
from ...simulate.plant import Plant
from ...simulate.run import simulate
from ..study import Tick, parts
from .setup import HIGH, LAWS, LOW, PERIOD, PRINTED, TIME, Gains, law, machine, move, perturbed, sheet

GAINS = {"low": LOW, "high": HIGH}
AFTER = 0.2  # s behind the move's end: what still swings there is the loop's own


class Course(NamedTuple):
    """One run, or several side by side: (n, 3), or (n, runs, 3)."""

    t: np.ndarray  # s
    e: np.ndarray  # s_d - s, m
    tip: np.ndarray  # x_d - x, m in W
    u: np.ndarray  # N

    @property
    def largest(self) -> np.ndarray:
        """Largest error of each slide, (3,) m, or (runs, 3)."""
        return np.abs(self.e).max(0)

    @property
    def force(self) -> np.ndarray:
        """Greatest force of each motor, N."""
        return np.abs(self.u).max(0)

    @property
    def swinging(self) -> np.ndarray:
        """Largest error of each slide later than AFTER behind the end of the move, m."""
        return np.abs(self.e[self.t > move().times.max() + AFTER]).max(0)


def run(
    name: str, gains: Gains, plant: Machine | Plant | Sequence[Plant] | None = None, tick: Tick | None = None,
    believed: Machine | None = None, period: float = PERIOD,
) -> Course:  # fmt: skip
    """The move under a law that believes `believed` (default: the study's machine), on `plant` (default: the same)."""
    signals = ["q", "q_r", "x", "x_r", "u"]
    log = simulate(
        believed or machine(), law(name, gains), move(), plant=plant, period=period, signals=signals, progress=tick,
        on_fail="raise",
    )  # fmt: skip
    q, q_r, x, x_r, u = (log.dataset[key].values for key in signals)
    if q.ndim == 3:
        q_r, x_r = q_r[:, None], x_r[:, None]
    x, x_r = x[..., :3], x_r[..., :3]
    return Course(np.arange(len(q)) * period, q_r - q, x_r - x, u)


def known(tick: Tick | None) -> dict[tuple[str, str], Course]:
    """On the machine that the laws know, by gains and law; and the printed low gains under computed torque."""
    jobs = [(key, name, gains) for key, gains in GAINS.items() for name in LAWS]
    jobs.append(("printed", "computed torque", PRINTED))
    ticks = parts(tick, [TIME] * len(jobs))
    return {(key, name): run(name, gains, tick=t) for (key, name, gains), t in zip(jobs, ticks, strict=True)}


def unlike(tick: Tick | None) -> dict[tuple[str, str], Course]:
    """On the sixteen machines of `perturbed`, whose centres the laws do not know."""
    plants = [Plant(machine=m) for m in perturbed(machine())]
    jobs = [(key, name, gains) for key, gains in GAINS.items() for name in LAWS]
    jobs.append(("printed", "computed torque", PRINTED))
    ticks = parts(tick, [TIME] * len(jobs))
    return {(key, name): run(name, gains, plants, t) for (key, name, gains), t in zip(jobs, ticks, strict=True)}


def as_on_the_sheet(tick: Tick | None) -> dict[str, Course]:
    """The cascade with arm 1 where the sheet has it, by gains."""
    ticks = parts(tick, [TIME] * len(GAINS))
    return {
        key: run("PID", gains, tick=t, believed=sheet()) for (key, gains), t in zip(GAINS.items(), ticks, strict=True)
    }


JOBS: dict[str, Callable[[Tick | None], Any]] = {
    "rigid, known": known,
    "rigid, centres of mass off": unlike,
    "rigid, arm 1 on the other side": as_on_the_sheet,
}
