"""What the paper leaves to further work: vibration, by the feed and by the flexible model, at equal cycle time.

A straight line from START to END, of the length L, in CYCLE s at the same greatest speed V.  What is left of the time,
CYCLE - L / V, is spent on accelerating, on a ramp of the acceleration, or on the delay of a shaper:

    V / A = CYCLE - L / V                     steps of the acceleration                                             (1)
    V / A + A / J = CYCLE - L / V,  A / J = 1 / f      a bounded jerk, a period of the mode for a ramp
    V / A + t_n = CYCLE - L / V               steps, and a shaper of the delay t_n

so the smoother ones accelerate harder.  f and the damping are those of the closed loop's first mode at END.  Laws:
computed torque by the rigid model, the same with gravity compensation along the path, and with flexible feedforward.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...control.base import Controller
from ...control.flexible_feedforward import FlexibleFeedforward
from ...control.gravity_compensation import GravityCompensation
from ...program.shaper import shaper_of
from ...program.standard.line import Line
from ..study import Tick, parts
from .flexible import LEAD, Course, at_rest, follow, loop_modes
from .rigid import GAINS
from .setup import END, PERIOD, START, law

CYCLE, SPEED = 0.6, 2.2  # s, m/s
BEHIND = 0.6  # s of rest behind the line
BAND = 20e-6  # m: the tool is there when it stays within
LAWS: dict[str, Callable[[Controller], Controller]] = {
    "computed torque": lambda control: control,
    "gravity compensation": lambda control: GravityCompensation(law=control),
    "flexible feedforward": lambda control: FlexibleFeedforward(law=control),
}


class Moved(NamedTuple):
    """One run along the line."""

    course: Course
    largest: float  # m, error of the tip on its way
    behind: float  # m, largest distance from where it comes to rest, from the end of the line on
    settled: float  # s from the end of the line until it stays within BAND of there
    off: float  # m, where it comes to rest from where it should


def feeds(frequency: float, damping: float) -> dict[str, Line]:
    """The programs of (1), by name."""
    L = float(np.linalg.norm(END - START))
    spare = CYCLE - L / SPEED
    line = Line(to=END - START, feed=SPEED, settle=BEHIND, lead_in=LEAD)
    out = {"steps": line.replace(acceleration=SPEED / spare)}
    A = SPEED / (spare - 1 / frequency)
    out["jerk limited"] = line.replace(acceleration=A, profile="jerk_limited", jerk=A * frequency)
    for kind in ("zv", "zvd", "ei"):
        A = SPEED / (spare - shaper_of(kind, frequency, damping).delay)
        out[kind] = line.replace(acceleration=A, shaper=kind, shaper_frequency=frequency, shaper_damping=damping)
    return out


def table(tick: Tick | None) -> dict[tuple[str, str, str], Moved]:
    """Every feed under every law, by gains, feed and law."""
    modes, out = loop_modes(None), {}
    jobs = []
    for key in GAINS:
        mode = modes[key, "computed torque"]
        for feed, program in feeds(mode.frequency, mode.damping).items():
            jobs += [(key, feed, name, program) for name in LAWS]
    for (key, feed, name, program), t in zip(jobs, parts(tick, [1.0] * len(jobs)), strict=True):
        out[key, feed, name] = moved(follow(LAWS[name](law("computed torque", GAINS[key])), program, t))
    return out


def moved(course: Course) -> Moved:
    """What a run along the line came to."""
    end = LEAD + CYCLE
    on = (course.t >= LEAD) & (course.t <= end)
    gap = from_rest(course)
    late = np.flatnonzero((gap > BAND) & (course.t > end))
    return Moved(
        course, float(np.linalg.norm(course.tip[on], axis=1).max()), float(gap[course.t > end].max()),
        float(late[-1] * PERIOD + PERIOD - end) if len(late) else 0.0, float(np.linalg.norm(at_rest(course))),
    )  # fmt: skip


def from_rest(course: Course) -> np.ndarray:
    """Distance m of the tip from where it comes to rest.  (n,)."""
    return np.linalg.norm(course.tip - at_rest(course), axis=1)


JOBS: dict[str, Callable[[Tick | None], Any]] = {"vibration": table}
