"""An observer beside the law: what it finds in every sample becomes variables of the log.

It reads what the law reads, the encoders behind their faults and the forces of the last sample, in the same sample and
before the law; nothing of the run depends on it.
"""

from __future__ import annotations

import dataclasses
from functools import lru_cache

import casadi as ca
import numpy as np

from ..declare import Shape
from ..errors import InputError
from ..kernel import Schedule, Signal, Task, period_ticks
from ..kernel.pack import flatten, names
from ..observe.base import Observer
from ..observe.tasks import fields_of, function_of


def with_observer(schedule: Schedule, observer: Observer | None) -> Schedule:
    """The tick of `tick.build` with the observer.

    Raises
    ------
    InputError
        the observer's period is no multiple of the schedule's.
    """
    if observer is None:
        return schedule
    try:
        every = period_ticks(observer.period, schedule.period)
    except InputError as error:
        raise error.at(key="observer.period") from None
    return _with(schedule, Shape(observer), every)


@lru_cache(maxsize=64)
def _with(schedule: Schedule, shape: Shape, every: int) -> Schedule:
    observer = shape.part
    n, labels = observer.machine.joints_count, names(observer.init(observer.machine.home))
    theta, s = ca.SX.sym("theta", len(observer.theta)), ca.SX.sym("s", len(labels))
    q, u = ca.SX.sym("q", n), ca.SX.sym("u", n)
    flagged = "flagged" in schedule.by_name  # by the encoders' check: what they read is not there
    flags = ca.SX.sym("flags", n if flagged else 0)
    found, after = function_of(observer)(theta, s, q, u, ca.sum1(flags) == 0 if flagged else 1)
    told = dict(zip(logged(observer), fields_of(observer).values(), strict=True))
    function = ca.Function(
        "observe", [theta, s, q, u, flags][: 4 + flagged], [*(found[part] for part in told.values()), after]
    )
    reads = ("theta_observer", "observer", "q_m", "u", *(("flagged",) if flagged else ()))
    task = Task("observe", function, reads, (*told, "observer"), every)
    signals = [
        Signal("theta_observer", len(observer.theta), "parameter", observer.names),
        Signal("observer", len(labels), "state", labels),
        *(Signal(name, part.stop - part.start, "wire") for name, part in told.items()),
    ]
    at = [one.name for one in schedule.tasks].index("control")
    return dataclasses.replace(
        schedule, signals=(*schedule.signals, *signals), tasks=(*schedule.tasks[:at], task, *schedule.tasks[at:]),
        log=(*schedule.log, *told),
    )  # fmt: skip


def logged(observer: Observer | None) -> dict[str, tuple[str, str, str]]:
    """Variable of the log: (dimension, unit, meaning), of all that the observer finds, in its order."""
    if observer is None:
        return {}
    return {name if name == "wrench_hat" else f"observer.{name}": told for name, told in observer.found.items()}


def parameters(observer: Observer | None) -> dict:
    """The parameters that the observer adds to those of a run."""
    return {} if observer is None else {"theta_observer": observer.theta}


def states(observer: Observer | None, x0) -> dict:
    """The state that the observer adds to those of a run that begins at the pose x0."""
    return {} if observer is None else {"observer": flatten(observer.init(x0))}


def columns(observer: Observer | None, row, part, signals) -> dict:
    """What the observer found in a chunk, thinned by the slice `part`, of `signals` (None: all).

    Single numbers have no axis of their own.
    """
    found = {}
    for name, (dimension, _, _) in logged(observer).items():
        if signals is None or name in signals:
            values = row[name][part]
            found[name] = np.ascontiguousarray(values if dimension else values[..., 0])
    return found


def told(observer: Observer | None, name: str) -> tuple | None:
    """Dimensions, unit and meaning of what the observer found; None for another variable."""
    found = logged(observer).get(name)
    return None if found is None else ((found[0],) if found[0] else (), found[1], found[2])
