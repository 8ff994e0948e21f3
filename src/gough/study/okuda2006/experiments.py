"""The experiments of this study as jobs, and what each of them gives to the claims."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...identify.regress import Estimate, estimate
from ...identify.signals import Signals, signals_of
from ...log import Log
from ...log.build import LogBuilder
from ...machine.hexapod import Hexapod
from ...simulate.run import simulate
from ..study import Experiment, Tick, parts
from . import load, model, setup

CUTOFF = 10.0  # Hz, of the low-pass before identification: the circles turn in 38 s and more
SIGNALS = ("q_m", "u")


class Circle(NamedTuple):
    """A circle in air: torques as they are read, and as predicted."""

    tilt: str
    angle: np.ndarray  # (N,) rad, along the circle
    read: np.ndarray  # (N, 6) N m
    predicted: np.ndarray  # (N, 6) N m


class Learned(NamedTuple):
    """What was learned from circles, and what it predicts of others."""

    found: Estimate
    loaded: Estimate  # the same rows with joint torques that grow with the load
    circles: list[Circle]


def measured(program, true: Hexapod, seed: int | None, tick: Tick | None) -> Log:
    """A log of the true machine on a program: readings, and forces as the torques tell them; exact without a seed."""
    believed = setup.machine()
    log = simulate(
        believed, setup.law(), program, true, period=setup.PERIOD, signals=SIGNALS, progress=tick,
        on_fail="raise",
    )  # fmt: skip
    lead = believed.drive.lead
    builder = LogBuilder(log.t, believed.task, believed.joints_count)
    builder.add("q_m", log["q_m"])
    builder.add("u", log["u"] if seed is None else setup.read(log["u"], lead, seed) / setup.radius_of(lead))
    return builder.build({})


def moving(log: Log) -> list[Signals]:
    """The filtered motion of a log."""
    return signals_of(log, setup.machine(), CUTOFF, setup.PERIOD)


TAUGHT = [(setup.TAUGHT, tilt, way) for tilt in setup.TILTS.values() for way in ("ccw", "cw")]
SHOWN = [(setup.RADIUS, tilt, "ccw") for tilt in setup.TILTS.values()]


def duration(radius: float) -> float:
    """About how long a circle takes, s."""
    return 2 * np.pi * radius / setup.FEED + 2 * setup.SETTLE


def learned(tick: Tick | None) -> Learned:
    """m_T, m_S, f_0 and t_0 from circles of 100 mm both ways at both tilts; torques of 144 mm from them."""
    every, true = [*TAUGHT, *SHOWN], setup.true()
    ticks = parts(tick, [duration(radius) for radius, _, _ in every])
    logs = [measured(setup.circle(*one), true, seed, ticks[seed]) for seed, one in enumerate(every)]
    found, grows = (fitted(logs[: len(TAUGHT)], loaded) for loaded in (False, True))
    circles = [predicted(name, log, found.full) for name, log in zip(setup.TILTS, logs[len(TAUGHT) :], strict=True)]
    return Learned(found, grows, circles)


def planted(tick: Tick | None) -> Estimate:
    """The same identification where the model's friction is all there is, and torques are read as they are."""
    ticks = parts(tick, [duration(radius) for radius, _, _ in TAUGHT])
    true = setup.planted()
    return fitted([measured(setup.circle(*one), true, None, part) for one, part in zip(TAUGHT, ticks, strict=True)])


def fitted(logs: Sequence[Log], loaded: bool = False) -> Estimate:
    """Least squares of the model on circles; `loaded` as in model.rows_of."""
    return estimate(model.rows_of(setup.machine(), [s for log in logs for s in moving(log)], loaded))


def predicted(tilt: str, log: Log, values) -> Circle:
    """The torques of a circle as read, and as the model with `values` (14,) tells them from the readings."""
    believed = setup.machine()
    (s,) = moving(log)
    known, Y = model.columns(believed, s.x, model.joint_speeds(believed, s.x, s.xd), s.sign)
    R = setup.radius_of(believed.drive.lead)
    speed = np.linalg.norm(s.xd[:, :2], axis=1)
    on = speed > 0.9 * setup.FEED
    place = s.x[:, :2] - np.array(setup.CENTER[:2])
    angle = np.unwrap(np.arctan2(place[:, 1], place[:, 0]))
    return Circle(tilt, angle[on], R * s.u[on], R * (known + Y @ values)[on])


EXPERIMENTS = (
    Experiment("circles", learned),
    Experiment("circles, friction of the model", planted),
    Experiment("static load", load.loads),
    Experiment("static load, no friction", load.perfect),
)


class Results:
    """The results of EXPERIMENTS by name."""

    def __init__(self, results: Sequence[Any]):
        of = {experiment.label: result for experiment, result in zip(EXPERIMENTS, results, strict=True)}
        self.learned: Learned = of["circles"]
        self.planted: Estimate = of["circles, friction of the model"]
        self.loads: dict[str, load.Loaded] = of["static load"]
        self.perfect: dict[str, load.Loaded] = of["static load, no friction"]
