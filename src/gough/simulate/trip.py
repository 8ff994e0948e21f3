"""The following-error trip: a run ends at the first sample at which a joint is too far from where it should be.

    |q_r - q_m| <= max(ferror |q_r'| / speed, min_ferror)                                                          (1)

The formula is that of LinuxCNC's motion controller (FERROR, MIN_FERROR, the joint's greatest speed): more is allowed
the faster a joint moves.  What is compared is what a controller can see, the encoder's reading; a fault of the encoder
trips it too.  The trip is latched and told once: the drives are off, so the run is over, and has failed.
"""

from __future__ import annotations

import dataclasses
from functools import lru_cache
from typing import NamedTuple

import casadi as ca
import numpy as np

from ..errors import ExperimentError, FollowingError
from ..kernel import Schedule, Signal, Task
from ..kernel.pack import fields


class Trip(NamedTuple):
    """Numbers of eq. (1): allowed at no speed, m, and for each m/s of it, s."""

    least: float
    slope: float


def trip_of(machine, ferror: float | None, min_ferror: float | None) -> Trip | None:
    """The trip of a run on the believed machine; None without one.

    Without `min_ferror` it is `ferror` at every speed, as in LinuxCNC.

    Raises
    ------
    ExperimentError
        min_ferror alone or above ferror; both, on a machine without limits.speed.
    """
    if ferror is None:
        if min_ferror is not None:
            raise ExperimentError(
                "min_ferror needs ferror, what is allowed at full speed",
                key="run.min_ferror",
                value=f"{min_ferror:g} m",
            )
        return None
    if min_ferror is None or min_ferror == ferror:
        return Trip(ferror, 0.0)
    if min_ferror > ferror:
        raise ExperimentError(
            "min_ferror must not be above ferror", key="run.min_ferror", value=f"{min_ferror:g} m",
            limit=f"{ferror:g} m",
        )  # fmt: skip
    if machine.limits.speed is None:
        raise ExperimentError(
            "a following error that grows with the speed needs the machine's limits.speed", key="run.min_ferror",
            cure='write speed = "18 m/min" in [limits] of the machine, or leave min_ferror out',
        )  # fmt: skip
    return Trip(min_ferror, ferror / machine.limits.speed)


CURE = "look for what holds or moves the joint or its encoder, lower the feed, or allow a larger ferror"


@lru_cache(maxsize=64)
def with_trip(schedule: Schedule, n: int, q_r: int, qd_r: int) -> Schedule:
    """The schedule with n more limits, eq. (1), whose numbers are the parameter "trip" (2,), a Trip.

    `q_r` and `qd_r` say where q and q' begin in the input "reference".
    """
    old, by_name = schedule.limits, schedule.by_name
    given = [ca.SX.sym(name, by_name[name].size) for name in old.reads]
    trip, row, q_m = ca.SX.sym("trip", 2), ca.SX.sym("row", by_name["reference"].size), ca.SX.sym("q_m", n)
    allowed = ca.fmax(trip[1] * ca.fabs(row[qd_r : qd_r + n]), trip[0])
    margins = ca.vertcat(old.function(*given), allowed - ca.fabs(row[q_r : q_r + n] - q_m))
    function = ca.Function("limits", [*given, trip, row, q_m], [margins])
    name = old.writes[0]
    labels = (*by_name[name].labels, *(f"{joint}: following error" for joint in by_name["q_m"].labels))
    signals = [s for s in schedule.signals if s.name != name]
    signals += [Signal(name, len(labels), "wire", labels), Signal("trip", 2, "parameter", ("least", "slope"))]
    limits = Task(old.name, function, (*old.reads, "trip", "reference", "q_m"), old.writes)
    return dataclasses.replace(schedule, signals=tuple(signals), limits=limits)


def where_in(reference) -> tuple[int, int]:
    """Where q and q' begin in a row of the input "reference"."""
    found = fields(reference)
    return found["q"].start, found["qd"].start


def tripped(machine, trip: Trip, joint: int, qd_r: float, stop, place: str | None) -> FollowingError:
    """The error of joint `joint` (from 0), whose reference ran at qd_r m/s when it was too far away."""
    allowed = float(np.fmax(trip.slope * abs(qd_r), trip.least))
    return FollowingError(
        f"{machine.joint_names[joint]}: following error, the drives are off",
        where=place,
        value=f"{(allowed - stop.value) * 1e3:.6g} mm",
        limit=f"{allowed * 1e3:.6g} mm",
        time=stop.time,
        cure=CURE,
    )
