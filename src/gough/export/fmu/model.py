"""What is in the FMU of a plant: the plant's half of a tick, its start, and the variables a master sees.

The tick is that of `simulate.tick`, the law left out: drive, sub-steps, sensors.  So at a communication point t_k the
outputs are those of sample k, the forces that are set are held over [t_k, t_k+1), and a loop closed outside gives what
gk.simulate gives inside.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from ...control.axis_pd import AxisPD
from ...errors import ExperimentError
from ...kernel.schedule import Schedule, Task
from ...kernel.tape import Tape, trace
from ...machine.base import Machine
from ...simulate import start, tick
from ...simulate.plant import Plant
from ...simulate.stability import choose_substeps
from ..c.fold import baked
from ..c.names import identifier, suggested

UNITS = {"m": "m", "rad": "rad"}
RATES = {"m": "m/s", "rad": "rad/s"}


class Variable(NamedTuple):
    """One number that a master sets or reads; its value reference is its place among the instance's numbers."""

    name: str
    place: int
    causality: str  # "input" or "output"
    unit: str
    start: float | None  # of an input
    meaning: str


class Model(NamedTuple):
    """What is printed: the calls of a step in order, where each signal lies, the numbers at the start."""

    name: str
    about: str
    period: float
    substeps: int
    drive: Task
    substep: tuple[Task, ...]
    sense: tuple[Task, ...]
    limits: Task
    limit_names: tuple[str, ...]
    tapes: dict[str, Tape]
    places: dict[str, tuple[int, int]]  # signal -> first place, size
    first: np.ndarray
    variables: tuple[Variable, ...]


def model_of(what: Any, name: str | None = None) -> Model:
    """The model of a Machine at home, or of an Experiment's plant at the program's first place.

    Raises
    ------
    ExperimentError
        the plant has what an FMU does not: encoder noise or faults, friction that drifts, a cut.
    """
    if isinstance(what, Machine):
        believed, plant, period, substeps, row = what, Plant(machine=what), 1e-3, None, None
    elif all(hasattr(what, key) for key in ("machine", "program", "run")):
        believed, period, substeps = what.machine, what.run.period, what.run.substeps
        plant = what.plant if what.plant is not None else Plant(machine=believed)
        first = what.program.plan(believed).sample(0, 1, period)
        row = type(first)(*(np.asarray(column)[0] for column in first))
    else:
        raise ExperimentError("only machines and experiments become an FMU", value=type(what).__name__)
    true = plant.true_machine
    _check(plant, true)
    row = tick.rest_row(believed, np.asarray(believed.home, float)) if row is None else row
    law = AxisPD(stiffness=1e6).on(believed, period)  # any law: its task is left out
    rest = start.at_rest(believed, true, law, plant, row)
    steps = choose_substeps(true, period, substeps)
    schedule = tick.build(true, law, rest.law, row, period, steps)
    pose = _pose(true)
    tapes = {t.name: _tape(schedule, t, true.theta) for t in schedule_tasks(schedule)}
    tapes["pose"] = baked(trace(pose.function), {0: true.theta})
    places, at = {}, 0
    sizes = {s.name: s.size for s in schedule.signals if s.name not in ("theta_plant", "theta_law", "law", "reference")}
    sizes |= {"x": len(true.task), "rate": len(true.task)}
    for signal, size in sizes.items():
        places[signal] = (at, size)
        at += size
    values = np.zeros(at)
    known = start.states(schedule, rest, row) | {"wrench": plant.wrench, "u_c": rest.u}
    for signal, value in known.items():
        if signal in places:
            values[places[signal][0] :][: places[signal][1]] = np.ravel(value)
    title = f"{true.name} as a plant: drives, friction and encoders; gough"
    by_name = {t.name: t for t in schedule.tasks}
    return Model(
        identifier(suggested(true.name) if name is None else name), title, period, steps, by_name["drive"],
        schedule.substep, (by_name["sense"], pose), schedule.limits, tuple(true.limit_names), tapes, places, values,
        _variables(true, places, rest.u, plant.wrench),
    )  # fmt: skip


def schedule_tasks(schedule: Schedule) -> list[Task]:
    """The tasks of a plant: all but the law's."""
    return [t for t in (*schedule.tasks, *schedule.substep, schedule.limits) if t.name in ("sense", "drive", "limits")
            or t in schedule.substep]  # fmt: skip


def _check(plant: Plant, true: Machine) -> None:
    """Refuse what would be left out without a word."""
    found = {
        "drive.noise": true.drive.noise is not None,
        "plant.faults": bool(plant.faults),
        "plant.friction_drift": bool(plant.friction_drift),
        "plant.cutting": plant.cutting is not None,
    }
    for key, there in found.items():
        if there:
            raise ExperimentError(
                "an FMU has no such thing", key=key, cure="leave it out of the plant that is exported"
            )


def _tape(schedule: Schedule, task: Task, theta) -> Tape:
    tape = schedule.tapes[task.name]
    return baked(tape, {i: theta for i, name in enumerate(task.reads) if name == "theta_plant"})


def _pose(machine: Machine) -> Task:
    """What the tool does: task coordinates and their rate."""
    p, theta, z, v, _ = tick.symbols_of(machine)
    found = ca.Function("pose", [theta, z, v], [machine.task_of(p, z), machine.task_rate_of(p, z, v)])
    return Task("pose", found, ("theta_plant", "z", "v"), ("x", "rate"))


def _variables(machine: Machine, places, u0, wrench) -> tuple[Variable, ...]:
    joints, out = machine.joint_names, []

    def add(signal, names, causality, units, meaning, starts=None):
        for k, (name, unit) in enumerate(zip(names, units, strict=True)):
            value = None if starts is None else float(np.ravel(starts)[k])
            told = f"{meaning}, {joints[k]}" if len(names) == len(joints) and "[" in name else meaning
            out.append(Variable(name, places[signal][0] + k, causality, unit, value, told))

    n = range(1, len(joints) + 1)
    add("u_c", [f"u_c[{i}]" for i in n], "input", ["N"] * len(joints), "force asked of the drive", u0)
    add(
        "wrench", [f"wrench.{k}" for k in ("fx", "fy", "fz", "mx", "my", "mz")], "input", ["N"] * 3 + ["N.m"] * 3,
        "on the tool at its tip, in axes of W", wrench,
    )  # fmt: skip
    for signal, unit, meaning in (
        ("q", "m", "true joint coordinate"), ("qd", "m/s", "true joint speed"), ("q_m", "m", "reading of the encoder"),
        ("u", "N", "force that the drive applied over the last step"), ("friction", "N", "friction of the joint"),
        ("saturated", "1", "1 where the drive was at its limit over the last step"),
    ):  # fmt: skip
        add(signal, [f"{signal}[{i}]" for i in n], "output", [unit] * len(joints), meaning)
    task = machine.task
    add("x", [f"pose.{name}" for name, _ in task], "output", [UNITS[u] for _, u in task], "tool, in W")
    letters = ("vx", "vy", "vz", "wx", "wy", "wz")[: len(task)]
    rates = [RATES[u] for _, u in task]
    add("rate", [f"twist.{k}" for k in letters], "output", rates, "velocity of the tool, in axes of W")
    return tuple(out)
