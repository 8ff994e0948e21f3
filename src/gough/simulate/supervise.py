"""Supervision in the tick: encoders are flagged, and what would end a run may bring it to rest first.

    check     flags encoders, from the readings and the forces of two samples (observe.encoders)
    stop      at the first flag, or where the following-error trip would end the run: the safe stop (safe_stop) takes
              the program's place as the law's reference, and what a flagged encoder should read is told from the forces

Both are options of a run, `encoder_check` and `stop_ramp`.  With the check alone a run goes on; its flags are logged
and told.  A stop is latched: once begun, it ends the run.  stopped.py says what came of it.
"""

from __future__ import annotations

import dataclasses
from functools import lru_cache
from typing import NamedTuple

import casadi as ca
import numpy as np

from ..declare import Shape
from ..errors import ExperimentError
from ..kernel import Schedule, Signal, Task
from ..kernel.pack import flatten, size, symbols, unflatten
from ..observe import encoders
from ..program.reference import Reference
from . import safe_stop
from .trip import Trip

AT_REST = "at rest after a safe stop"  # the limit by which a stop ends a run


class Supervision(NamedTuple):
    """What a run asks for.  With a `ramp` the trip begins the stop; without one it ends the run (simulate.trip)."""

    check: float | None  # N, F of observe.encoders
    ramp: float | None  # m/s2, a of safe_stop
    turn: float  # rad/s2, alpha of safe_stop
    trip: Trip | None

    @property
    def ends_at_once(self) -> Trip | None:
        """The trip that ends a run without a ramp."""
        return self.trip if self.ramp is None else None


def supervision_of(machine, run, trip: Trip | None) -> Supervision:
    """The supervision that the options of a Run ask for on the believed machine.

    Raises
    ------
    ExperimentError
        a ramp that nothing could begin.
    """
    if run.stop_ramp is not None and run.encoder_check is None and trip is None:
        raise ExperimentError(
            "stop_ramp needs something that begins it", key="run.stop_ramp", value=f"{run.stop_ramp:g} m/s2",
            cure='write encoder_check = "1 kN" or ferror = "1 mm" beside it',
        )  # fmt: skip
    return Supervision(run.encoder_check, run.stop_ramp, machine.feed.angular_acceleration, trip)


def parameters(believed, asked: Supervision) -> dict[str, np.ndarray]:
    """The parameters that supervision adds to those of one run."""
    found = {}
    if asked.check is not None:
        found["unknown"] = np.array([asked.check])
    if asked.ramp is not None:
        found["stop"] = np.array([asked.ramp, asked.turn, *(asked.trip or (0.0, 0.0))])
    return found | ({"theta_believed": believed.theta} if found else {})


def states(schedule: Schedule, row: Reference, u0) -> dict[str, np.ndarray]:
    """The states that supervision adds to those of one run, at rest at `row` under the forces u0."""
    known = {
        "readings": np.concatenate([row.q, row.q]),
        "force_before": np.asarray(u0),
        "course_before": np.concatenate([row.x, row.xd, row.xdd, row.qdd]),
        "carried": np.concatenate([row.q, row.qd]),
    }
    zero = ("flagged", "stopping", "origin", "cause", "unexplained")
    there = {s.name: s.size for s in schedule.of_kind("state")}
    found = {name: value for name, value in known.items() if name in there}
    return found | {name: np.zeros(there[name]) for name in zero if name in there}


def with_supervision(schedule: Schedule, believed, asked: Supervision) -> Schedule:
    """The tick of `tick.build` with what is asked for; the numbers are parameters."""
    if asked.check is None and asked.ramp is None:
        return schedule
    check, ramp = asked.check is not None, asked.ramp is not None
    return _with(schedule, Shape(believed), check, ramp, ramp and asked.trip is not None)


@lru_cache(maxsize=64)
def _with(schedule: Schedule, shape: Shape, check: bool, ramp: bool, trip: bool) -> Schedule:
    m = shape.part
    n, names = m.joints_count, m.joint_names
    signals, watch, log = [Signal("theta_believed", len(m.theta), "parameter", m.names)], [], []
    tasks, limits = schedule.tasks, schedule.limits
    if check:
        signals += [
            Signal("unknown", 1, "parameter"),
            *(Signal(name, n, "state", names) for name in ("force_before", "flagged")),
            Signal("readings", 2 * n, "state"),
            Signal("course_before", 3 * len(m.task) + n, "state"),
            *(Signal(name, n, "wire", names) for name in ("encoder_residual", "encoder_allowed", "forced")),
        ]
        watch.append(_check(m, schedule.period))
        log += ["flagged", "encoder_residual"]
    if ramp:
        reference = schedule.by_name["reference"]
        signals += [
            Signal("stop", 4, "parameter", ("ramp", "turn", "least", "slope")),
            Signal("course", reference.size, "wire", reference.labels),
            Signal("reading", n, "wire", names),
            *(Signal(name, k, "state") for name, k in (("stopping", 1), ("origin", size(_origin(m))), ("cause", 3))),
            *([Signal("carried", 2 * n, "state"), Signal("unexplained", n, "state")] if check else []),
        ]
        watch.append(_stop(m, schedule.period, check, trip))
        log += ["stopping", "course"]
        swap = {"reference": "course", "q_m": "reading"}
        tasks = [
            dataclasses.replace(t, reads=tuple(swap.get(r, r) for r in t.reads)) if t.name == "control" else t
            for t in tasks
        ]
        limits, margins = _with_end(schedule, m, check)
        signals += [margins, *(s for s in schedule.signals if s.name != margins.name)]
    else:
        signals += schedule.signals
    if check:
        watch.append(_remember(m, "course" if ramp else "reference"))
    at = [task.name for task in tasks].index("sense") + 1
    return dataclasses.replace(
        schedule, signals=tuple(signals), tasks=(*tasks[:at], *watch, *tasks[at:]), limits=limits,
        log=(*schedule.log, *log),
    )  # fmt: skip


def _origin(m) -> safe_stop.Origin:
    """An Origin on machine `m`, to be cut from a vector."""
    d = len(m.task)
    return safe_stop.Origin(np.zeros(d), np.zeros(d), np.zeros(3), np.zeros(1))


def _row(m) -> Reference:
    """A row of the reference of machine `m`, to be cut from a vector."""
    d, n = len(m.task), m.joints_count
    return Reference(*(np.zeros(k) for k in (d, d, d, n, n, n, 1, 1, 3, 3, 1, 3)))


def _check(m, period) -> Task:
    """Residual and bound, which encoders are flagged and for how many samples, and what the last force did."""
    p, theta = m.symbols
    n, d = m.joints_count, len(m.task)
    unknown, q_m, u, old, flagged = (ca.SX.sym(s, k) for s, k in zip("Fquof", (1, n, n, n, n), strict=True))
    readings, course = ca.SX.sym("r", 2 * n), ca.SX.sym("c", 3 * d + n)
    a, G = encoders.explained(m, p, *(course[k * d : (k + 1) * d] for k in range(3)), course[3 * d :])
    mean = a + G @ ((u + old) / 2)
    r, allowed = encoders.residual(p, mean, G, q_m, readings[:n], readings[n:], unknown, period)
    wrong = ca.logic_or(ca.logic_not(ca.fabs(r) <= allowed), flagged > 0)  # so is what is no number
    out = [ca.if_else(wrong, flagged + 1, 0), ca.vertcat(q_m, readings[:n]), u, r, allowed, a + G @ u]
    return Task(
        "check encoders",
        ca.Function("check", [theta, unknown, q_m, u, old, flagged, readings, course], out),
        ("theta_believed", "unknown", "q_m", "u", "force_before", "flagged", "readings", "course_before"),
        ("flagged", "readings", "force_before", "encoder_residual", "encoder_allowed", "forced"),
    )


def _remember(m, course: str) -> Task:
    """What the check of the next sample needs of the reference of this one."""
    given = symbols(_row(m))
    found = ca.vertcat(given.x, given.xd, given.xdd, given.qdd)
    return Task("remember", ca.Function("remember", [flatten(given)], [found]), (course,), ("course_before",))


def _stop(m, period, check: bool, trip: bool) -> Task:
    """The law's reference and readings: the program's and the encoders', until a stop begins."""
    p, theta = m.symbols
    n = m.joints_count
    stop, q_m = ca.SX.sym("stop", 4), ca.SX.sym("q_m", n)
    row, origin = symbols(_row(m)), ca.SX.sym("origin", size(_origin(m)))
    stopping, cause = ca.SX.sym("stopping"), ca.SX.sym("cause", 3)
    given = [theta, stop, flatten(row), q_m, stopping, origin, cause]
    reads = ["theta_believed", "stop", "reference", "q_m", "stopping", "origin", "cause"]
    if check:
        flagged, r, allowed, forced, d = (ca.SX.sym(s, n) for s in ("f", "r", "b", "a", "d"))
        carried, readings = ca.SX.sym("carried", 2 * n), ca.SX.sym("readings", 2 * n)
        given += [flagged, r, allowed, forced, carried, d, readings]
        reads += ["flagged", "encoder_residual", "encoder_allowed", "forced", "carried", "unexplained", "readings"]
    # why a stop would begin now: the number of the joint, below 0 for the trip; what was seen, what is allowed
    why = ca.SX.zeros(3)
    if trip:
        limit = ca.fmax(stop[3] * ca.fabs(row.qd), stop[2])
        error = ca.fabs(row.q - q_m)
        for j in reversed(range(n)):
            why = ca.if_else(error[j] <= limit[j], why, ca.vertcat(-1 - j, error[j], limit[j]))
    if check:
        for j in reversed(range(n)):
            why = ca.if_else(flagged[j] > 0, ca.vertcat(1 + j, ca.fabs(r[j]), allowed[j]), why)
    on = stopping > 0
    begins = ca.logic_and(ca.logic_not(on), why[0] != 0)
    origin_now = ca.if_else(on, origin, flatten(safe_stop.origin(row)))
    stopping_now = ca.if_else(on, stopping + 1, begins)
    start = unflatten(_origin(m), origin_now)
    T = safe_stop.duration(start, stop[0], stop[1], period)
    braked = safe_stop.ramp(m, p, row, start, ca.fmax(stopping_now - 1, 0) * period, T)
    course = ca.if_else(stopping_now > 0, flatten(braked), flatten(row))
    reading, out, writes = q_m, [], []
    if check:
        qd_r = unflatten(_row(m), course).qd
        q, qd, d = encoders.followed(q_m, readings[n:], qd_r, carried[:n], carried[n:], forced, d, r, flagged, period)
        reading = ca.if_else(ca.logic_and(stopping_now > 0, flagged > 0), q, q_m)
        out = [ca.vertcat(q, qd), d]
        writes = ["carried", "unexplained"]
    out = [course, reading, stopping_now, origin_now, ca.if_else(begins, why, cause), *out]
    writes = ["course", "reading", "stopping", "origin", "cause", *writes]
    return Task("stop", ca.Function("stop", given, out), tuple(reads), tuple(writes))


def _with_end(schedule: Schedule, m, check: bool) -> tuple[Task, Signal]:
    """The limits with one more, the end of a stop, and their signal."""
    old, by_name = schedule.limits, schedule.by_name
    given = [ca.SX.sym(name, by_name[name].size) for name in old.reads]
    stop, stopping, origin = ca.SX.sym("stop", 4), ca.SX.sym("stopping"), ca.SX.sym("origin", size(_origin(m)))
    margins = old.function(*given)
    T = safe_stop.duration(unflatten(_origin(m), origin), stop[0], stop[1], schedule.period)
    flagged = ca.SX.sym("flagged", m.joints_count) if check else ca.SX.zeros(m.joints_count)
    rest = ca.if_else(ca.mmax(flagged) > 0, safe_stop.REST_UNSEEN, safe_stop.REST)
    # half a sample more, so that rounding does not decide
    left = ca.if_else(stopping > 0, T + rest - (stopping - 1.5) * schedule.period, 1)
    given += [stop, stopping, origin, *([flagged] if check else [])]
    function = ca.Function("limits", given, [ca.vertcat(margins, left)])
    name = old.writes[0]
    labels = (*by_name[name].labels, AT_REST)
    reads = (*old.reads, "stop", "stopping", "origin", *(("flagged",) if check else ()))
    task = Task(old.name, function, reads, old.writes)
    return task, Signal(name, len(labels), "wire", labels)
