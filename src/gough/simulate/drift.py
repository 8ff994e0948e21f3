"""Friction that changes while a run goes on: what wears, warms up or runs dry, and nobody tells the controller.

    c(t) = max(1 + d t, 1e-3),     mu(t) = c(t) mu                                                                 (1)

for every number mu that friction is in proportion to (`levels` of a friction law: Coulomb, breakaway and viscous, with
their offsets; the coefficient of passive joints).  Speeds, stiffness and damping of the bristles stay.  t is the time
of the sample, c is held over it; a thousandth is friction that is gone, for bristles need a level at which they end.
What is logged of a sample is what the sub-steps before it left: its friction is that of the c before.

Only the plant's numbers change, so every machine and every law is served; the sheet's numbers are those of t = 0.
"""

from __future__ import annotations

import dataclasses
from functools import lru_cache

import casadi as ca
import numpy as np

from ..declare import Part, Shape
from ..kernel import Schedule, Signal, Task
from .faults import clocked

LEAST = 1e-3  # of c


def levels(machine: Part, above: str = "") -> list[str]:
    """Dotted names of all numbers of a machine that friction is in proportion to, those that are there."""
    found = [f"{above}{name}" for name in getattr(machine, "levels", ()) if getattr(machine, name) is not None]
    for name in type(machine).model_fields:
        inner = getattr(machine, name)
        if isinstance(inner, Part):
            found += levels(inner, f"{above}{name}.")
    return found


def scaled(machine, factor: float):
    """The machine with all its friction times `factor`, above 0."""

    def of(name):
        part = machine
        for key in name.split("."):
            part = getattr(part, key)
        return np.multiply(part, factor)

    return machine.replace(**{name: of(name) for name in levels(machine)})


def drifts(machine) -> np.ndarray:
    """Which entries of theta friction is in proportion to.  (len(theta),) bool."""
    return _drifts(Shape(machine))


@lru_cache(maxsize=64)
def _drifts(shape: Shape) -> np.ndarray:
    wanted = set(levels(shape.part))
    return np.array([name.partition("[")[0] in wanted for name in shape.part.names], bool)


def scale(rate: float | None, time: float) -> float:
    """c of eq. (1)."""
    return max(1 + (rate or 0.0) * time, LEAST)


def with_drift(schedule: Schedule, machine) -> Schedule:
    """The tick of `tick.build` for `machine` with friction by eq. (1).

    It has the parameter "friction_drift" (d, 1/s), the input "clock", the number of the tick, and logs
    "friction_scale" (c).
    """
    return _with(schedule, Shape(machine))


@lru_cache(maxsize=64)
def _with(schedule: Schedule, shape: Shape) -> Schedule:
    machine = shape.part
    rate, clock, theta = ca.SX.sym("rate"), ca.SX.sym("clock"), ca.SX.sym("theta", len(machine.theta))
    scales = [ca.fmax(1 + rate * (at * schedule.period), LEAST) for at in (ca.fmax(clock - 1, 0), clock)]
    sheets = [ca.vertcat(*[theta[i] * c if one else theta[i] for i, one in enumerate(_drifts(shape))]) for c in scales]
    function = ca.Function("drift", [theta, rate, clock], [*sheets, scales[1]])
    names = ("theta_before", "theta_now", "friction_scale")
    drift = Task("drift", function, ("theta_plant", "friction_drift", "clock"), names)

    def reading(task: Task, sheet: str) -> Task:
        return dataclasses.replace(task, reads=[sheet if name == "theta_plant" else name for name in task.reads])

    signals = [
        Signal("friction_drift", 1, "parameter"),
        *(Signal(name, theta.numel(), "wire", machine.names) for name in names[:2]),
        Signal(names[2], 1, "wire"),
    ]
    return dataclasses.replace(
        schedule,
        signals=(*clocked(schedule), *signals),
        tasks=(drift, *(reading(task, "theta_before") for task in schedule.tasks)),
        substep=tuple(reading(task, "theta_now") for task in schedule.substep),
        log=(*schedule.log, "friction_scale"),
    )
