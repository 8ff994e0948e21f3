"""Forward sensitivities: a schedule that carries, beside every number that moves with a parameter, how it moves.

With y the states and wires of a schedule, p one of its parameters and s_1 ... s_m directions in p,

    y_j+ = f_j(y_j),   S_j+ = df_j/dy S_j + df_j/dp [s_1 ... s_m]                                                  (1)

for every task f_j in the order of the tick, S held in signals "d.<name>" of size (size of the signal) m, column k the
derivative along s_k.  df_j/dy S is CasADi's forward derivative of the task's own function, printed with it in one
function, so what both compute is computed once; and S is exact for the discrete tick: not an approximation of the
sensitivities of a continuous system, but the derivative of what the machine code computes.

Where a task chooses between two expressions the derivative is that of the branch taken: right wherever both agree at
the border, as a clip does, and silent about a jump.  What rounds or takes a sign has none and is refused.
"""

from __future__ import annotations

import dataclasses

import casadi as ca

from ..errors import InputError
from .schedule import Schedule, Signal, Task

JUMPS = ("floor", "ceil", "sign", "copysign", "fmod", "remainder")


def named(signal: str) -> str:
    """The signal that holds the derivatives of a signal."""
    return f"d.{signal}"


def moving(schedule: Schedule, parameter: str) -> set[str]:
    """The signals that may depend on `parameter`, itself among them."""
    found, before = {parameter}, 0
    while len(found) > before:
        before = len(found)
        for task in (*schedule.tasks, *schedule.substep):
            if found & set(task.reads):
                found |= set(task.writes)
    return found


def with_sensitivities(schedule: Schedule, parameter: str, directions: int, log: tuple[str, ...] = ()) -> Schedule:
    """The schedule with eq. (1) for `directions` directions in the parameter signal `parameter`.

    New signals: the parameter "d.<parameter>", the directions by columns; a state "d.<state>" for each state that may
    move, and a wire for each such wire.  The derivatives of the signals in `log` are logged behind what is logged.

    Raises
    ------
    InputError
        no such parameter; a task that moves is plain Python, or rounds, takes a sign or another jump.
    """
    known = [signal.name for signal in schedule.of_kind("parameter")]
    if parameter not in known:
        raise InputError("no such parameter", where="sensitivities", value=parameter, cure=f"one of {', '.join(known)}")
    if not isinstance(directions, int) or directions < 1:
        raise InputError("the number of directions must be 1, 2, 3 ...", where="sensitivities", value=repr(directions))
    moved, made = moving(schedule, parameter), {}
    signals = list(schedule.signals)
    for signal in schedule.signals:
        if signal.name in moved and signal.name != schedule.limit_signal:
            signals.append(Signal(named(signal.name), signal.size * directions, signal.kind))

    def extended(task: Task) -> Task:
        if not moved & set(task.reads):
            return task
        function = _extended(task, schedule, tuple(name in moved for name in task.reads), directions, made)
        reads = (*task.reads, *(named(name) for name in task.reads if name in moved))
        return Task(task.name, function, reads, (*task.writes, *map(named, task.writes)), task.every)

    return dataclasses.replace(
        schedule, signals=tuple(signals), tasks=tuple(map(extended, schedule.tasks)),
        substep=tuple(map(extended, schedule.substep)), log=(*schedule.log, *(named(n) for n in log if n in moved)),
    )  # fmt: skip


def _extended(task: Task, schedule: Schedule, which: tuple[bool, ...], directions: int, made: dict) -> ca.Function:
    """The function of a task with the derivatives of its outputs; one object for all tasks that share it."""
    key = task.function, which
    if key in made:
        return made[key]
    if not task.symbolic:
        raise InputError("a function of plain Python has no derivative", where=f"task {task.name}")
    jumps = sorted({node[0] for node in schedule.tapes[task.name].nodes} & set(JUMPS))
    if jumps:
        raise InputError(
            "has no derivative: it rounds or takes a sign", where=f"task {task.name}", value=", ".join(jumps),
            cure="leave out what jumps (an encoder's resolution, friction without smoothing)",
        )  # fmt: skip
    f = task.function
    x = [ca.SX.sym(f"x{i}", f.size1_in(i), f.size2_in(i)) for i in range(f.n_in())]
    dx = [ca.SX.sym(f"d{i}", x[i].numel(), directions) for i, moves in enumerate(which) if moves]
    out = f.call(x)
    point = ca.vertcat(*(ca.vec(one) for one, moves in zip(x, which, strict=True) if moves))
    flat = ca.vertcat(*(ca.vec(ca.densify(one)) for one in out))
    columns = [ca.jtimes(flat, point, ca.vertcat(*(d[:, k] for d in dx))) for k in range(directions)]
    slopes = ca.densify(ca.horzcat(*columns))
    pieces, at = [], 0
    for one in out:
        pieces.append(ca.vec(slopes[at : at + one.numel(), :]))
        at += one.numel()
    made[key] = ca.Function(f"d_{f.name()}", [*x, *(ca.vec(d) for d in dx)], [*out, *pieces])
    return made[key]
