"""A law in the tick: its step, and the tasks it has at multiples of its period, as functions of flat vectors.

All read theta, state, reference and measurement of the sample and write the state; the step, last, writes the command.
A state that a task leaves for the step is kept by the kernel from tick to tick like any other, so nothing else is
needed where rates differ.
"""

from __future__ import annotations

import math
import re

import casadi as ca
import numpy as np

from ..control.base import Controller, Measurement
from ..control.base import Task as LawTask
from ..errors import ExperimentError, InputError
from ..kernel import Task, period_ticks
from ..kernel.pack import flatten, symbols, unflatten

_READS = ("theta_law", "law", "reference", "q_m", "u")


def rates(law: Controller, period: float) -> tuple[int, ...]:
    """Every how many samples of `period` s each task of `law` runs, and last its step.

    Raises
    ------
    InputError
        the law's period is no multiple of `period`, or that of one of its tasks none of the law's.
    """
    try:
        every = period_ticks(law.period, period)
    except InputError as error:
        raise error.at(key="controller.period") from None
    return (*(every * _multiple(law, task) for task in law.tasks()), every)


def same_rates(laws: list[Controller], period: float) -> None:
    """Refuse laws of one structure that do not all tick together: runs side by side share their samples.

    Raises
    ------
    ExperimentError
        the first law of another period; the periods of its tasks are part of its structure.
    """
    for i, law in enumerate(laws):
        if rates(law, period) != rates(laws[0], period):
            raise ExperimentError(
                "laws of a batch must tick together", key=f"controller.{i}.period",
                value=f"{law.period * 1e3:g} ms; run 0 has {laws[0].period * 1e3:g} ms",
                cure="run those of one period together",
            )  # fmt: skip


def cycle(law: Controller, period: float) -> float:
    """The time after which all tasks of `law` are due together again, s; its period where it has none."""
    every = rates(law, period)
    return law.period * (math.lcm(*every) // every[-1])


def _multiple(law: Controller, task: LawTask) -> int:
    """How many periods of `law` the period of its `task` has."""
    try:
        return period_ticks(task.period, law.period)
    except InputError:
        below = max(1, math.floor(task.period / law.period))
        cure = " or ".join(f"{n * law.period * 1e3:g} ms" for n in (below, below + 1))
        raise InputError(
            f"{law.kind}: the period of a law's task must be a multiple of the law's own, {law.period * 1e3:g} ms",
            key=f"controller.{task.name}_period", value=f"{task.period * 1e3:g} ms", cure=f"give {cure}",
        ) from None  # fmt: skip


def tasks(law: Controller, state, reference, n: int, every: tuple[int, ...]) -> tuple[Task, ...]:
    """The kernel's tasks of a law with n joints, `every` as `rates` gives it."""
    slower = [
        Task(f"law {task.name}", _task(law, task, state, reference, n), _READS, ("law",), ticks)
        for task, ticks in zip(law.tasks(), every[:-1], strict=True)
    ]
    return (*slower, Task("control", _control(law, state, reference, n), _READS, ("u_c", "law"), every[-1]))


def _given(law, state, reference, n):
    """What a law gets in a sample, as fresh symbols: theta, state, r, y."""
    y = Measurement(ca.SX.sym("q_m", n), ca.SX.sym("u", n))
    return ca.SX.sym("theta", len(law.theta)), symbols(state), symbols(reference), y


def _task(law, task: LawTask, state, reference, n: int):
    if not law.symbolic:
        return lambda theta, s, r, q_m, u: flatten(
            task.step(unflatten(state, s), unflatten(reference, r), Measurement(q_m, u), theta)
        )
    theta, s, r, y = _given(law, state, reference, n)
    after = _after(state, task.step(s, r, y, theta))
    name = "law_" + re.sub(r"\W+", "_", task.name).strip("_")
    return ca.Function(name, [theta, flatten(s), flatten(r), y.q, y.u], [flatten(after)])


def _control(law, state, reference, n: int):
    if not law.symbolic:

        def control(theta, s, r, q_m, u):
            command, after = law.step(unflatten(state, s), unflatten(reference, r), Measurement(q_m, u), theta)
            return np.asarray(command.u, float), flatten(after)

        return control
    theta, s, r, y = _given(law, state, reference, n)
    command, after = law.step(s, r, y, theta)
    inputs = [theta, flatten(s), flatten(r), y.q, y.u]
    return ca.Function("control", inputs, [command.u, flatten(_after(state, after))])


def _after(state, after):
    """The next state with the shapes of `state`: what is handed on unchanged and what is put in both pass through."""
    return unflatten(state, ca.SX(flatten(after)))
