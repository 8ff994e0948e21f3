"""Leaning the spindle against the cut while it goes on: from the observer's force to the reference of the law.

In each sample, after the observer and before the law, with C as in cutting/compensation.py on the reference:

    d      = y . f_hat - d_0,     d_0 the mean of y . f_hat over the air cut, s from `air[0]` to `air[1]`           (1)
    theta* = f(d), at most `most` either way;  0 up to the end of the air cut                                       (2)
    theta'' = w^2 (theta* - theta) - 2 w theta',     w = 2 pi `bandwidth`                                           (3)

(3) is stepped exactly, with theta* held over a sample.  The law then gets the reference moved and turned by eqs. (1),
(2) there; its joints are those of the corrected pose on the believed machine.  The tilt has no jump, nor has its rate,
and the feed goes on: there is no dwell in which the tool would cut free.  The log's reference stays the program's, and
so do contour error and lag; `controller.tilt` and `controller.shift` say what was added.
"""

from __future__ import annotations

import dataclasses
from functools import lru_cache

import casadi as ca
import numpy as np
from pydantic import model_validator

from .. import frames
from ..cutting.deflection import Leaning
from ..declare import Array, Part, Shape, quantity
from ..errors import ExperimentError, InputError
from ..kernel import Schedule, Signal, Task
from ..kernel.pack import flatten, symbols
from ..program.reference import Reference

VARIABLES = {
    "controller.tilt": ("tilt", (), "rad", "how far the tool is leant against the cut, about the feed"),
    "controller.shift": ("shift", (), "m", "how far its tip is moved against the cut, across the feed"),
    "controller.normal_force": ("normal_force", (), "N", "estimated force across the feed, less that of the air cut"),
}


class Compensation(Part):
    """Eqs. (1)-(3): what is believed of the tool, and how the tilt may change."""

    height: float = quantity("m", "height of the wall, R_a", above=0)
    law: Leaning = Leaning()
    bandwidth: float = quantity("Hz", "of the tilt", default=8.0, above=0)
    air: Array = quantity("m, m", "the way through air on which the estimate is tared", shape=(2,), at_least=0)
    most: float = quantity("rad", "greatest tilt", default=np.radians(0.5), above=0, at_most=0.05)

    @model_validator(mode="after")
    def _fits(self):
        if not self.air[1] > self.air[0]:
            raise InputError("must go from a place to one behind it", key="air", value=f"{self.air.tolist()}")
        return self


def check(machine, observer, compensation: Compensation | None) -> None:
    """Refuse a compensation that has no force to go by, or a machine that cannot lean.  ExperimentError."""
    if compensation is None:
        return
    if observer is None or "wrench_hat" not in observer.found:
        raise ExperimentError(
            "needs an observer of the force on the tool", key="compensation", value="none",
            cure="give observer=gk.DisturbanceObserver(bandwidth=10.0)",
        )  # fmt: skip
    if len(machine.task) < 6:
        raise ExperimentError("only a machine with six freedoms can lean its tool", key="machine", value=machine.name)


def check_air(compensation: Compensation | None, motion) -> None:
    """Refuse a way through air that the path does not hold: the tool would never lean.  ExperimentError."""
    if compensation is None:
        return
    length = float(getattr(motion, "course", motion).path.s0[-1])
    if compensation.air[1] >= length:
        raise ExperimentError(
            "the air cut ends behind the end of the path: the tool would never lean", key="compensation.air",
            value=f"{compensation.air[1]:g} m", limit=f"{length:g} m", cure="places count metres along the path",
        )  # fmt: skip


def parameters(believed, compensation: Compensation | None) -> dict[str, np.ndarray]:
    """The parameters that it adds to those of a run."""
    return {} if compensation is None else {"theta_leaning": compensation.theta, "theta_believed": believed.theta}


def states(compensation: Compensation | None) -> dict[str, np.ndarray]:
    """The states that it adds: theta, theta', and sum and count of the air cut."""
    return {} if compensation is None else {"lean": np.zeros(4)}


def with_leaning(schedule: Schedule, believed, row: Reference, compensation: Compensation | None) -> Schedule:
    """The tick of `tick.build` with an observer, and eqs. (1)-(3) between it and the law."""
    if compensation is None:
        return schedule
    sizes = tuple(np.size(part) for part in row)
    return _with(schedule, Shape(believed), sizes, Shape(compensation))


@lru_cache(maxsize=64)
def _with(schedule: Schedule, believed: Shape, sizes: tuple[int, ...], shape: Shape) -> Schedule:
    m, compensation = believed.part, shape.part
    course = "course" if "course" in schedule.by_name else "reference"
    reference = schedule.by_name["reference"]
    known = "theta_believed" in schedule.by_name
    signals = [
        *([] if known else [Signal("theta_believed", len(m.theta), "parameter", m.names)]),
        Signal("theta_leaning", len(compensation.theta), "parameter", compensation.names),
        Signal("lean", 4, "state", ("tilt", "tilt_rate", "air_sum", "air_count")),
        Signal("leant", reference.size, "wire", reference.labels),
        *(Signal(name, 1, "wire") for name in ("tilt", "shift", "normal_force")),
    ]
    function = _lean(m, compensation, sizes, schedule.period)
    reads = ("theta_believed", "theta_leaning", course, "wrench_hat", "lean")
    lean = Task("lean", function, reads, ("leant", "tilt", "shift", "normal_force", "lean"))
    tasks = []
    for task in schedule.tasks:
        follows = task.name == "control" or task.name.startswith("law ")
        if follows and lean not in tasks:
            tasks.append(lean)
        swap = {"reference": "leant", course: "leant"} if follows else {}
        tasks.append(dataclasses.replace(task, reads=tuple(swap.get(name, name) for name in task.reads)))
    observe = [task.name for task in tasks].index("observe")
    if observe > tasks.index(lean):  # behind tasks of the law: nothing between writes what it reads
        tasks.insert(tasks.index(lean), tasks.pop(observe))
    return dataclasses.replace(
        schedule, signals=(*schedule.signals, *signals), tasks=tuple(tasks),
        log=(*schedule.log, "tilt", "shift", "normal_force"),
    )  # fmt: skip


def _lean(m, compensation, sizes, period) -> ca.Function:
    p, theta_m = m.symbols
    theta_c = ca.SX.sym("theta", len(compensation.theta))
    c, r = compensation.at(theta_c), symbols(Reference(*(np.zeros(size) for size in sizes)))
    w, state = ca.SX.sym("w", 6), ca.SX.sym("state", 4)
    quat = frames.quaternion_of_abc(r.x[3:])
    axis = frames.rotation_of_quaternion(quat)[:, 2]
    across = r.tangent - ca.dot(r.tangent, axis) * axis
    e_x = across / ca.fmax(ca.norm_2(across), 1e-9)
    e_y = ca.cross(axis, e_x)
    # (1)
    force = ca.dot(e_y, w[:3])
    in_air = ca.logic_and(r.s >= c.air[0], r.s < c.air[1])
    total, count = state[2] + ca.if_else(in_air, force, 0), state[3] + in_air
    tared = ca.if_else(r.s >= c.air[1], force - total / ca.fmax(count, 1), 0)
    # (2)
    size = ca.fabs(tared)
    wanted = ca.sign(tared) * ca.fmin(c.law.linear * size + c.law.quadratic * size * size, c.most)
    # (3): with e = theta - theta*, e(t) = (e + (e' + w e) t) exp(-w t)
    rate = 2 * np.pi * c.bandwidth
    e, ed = state[0] - wanted, state[1]
    slope, fade = ed + rate * e, ca.exp(-rate * period)
    after = wanted + (e + slope * period) * fade
    after_rate = (ed - rate * slope * period) * fade
    acc = rate * rate * (wanted - state[0]) - 2 * rate * state[1]
    x, xd, xdd, shift = _moved(r, e_x, e_y, quat, (state[0], state[1], acc), c.height)
    z = m.coordinates_of(p, x)
    J = m.jacobian_of(p, z)
    q, qd, qdd = m.joints_of(p, z), J @ xd, m.joint_acceleration(p, z, xd, xdd)
    leant = r._replace(x=x, xd=xd, xdd=xdd, q=q, qd=qd, qdd=qdd, axis=frames.rotation_of_abc(x[3:])[:, 2])
    out = [flatten(leant), state[0], shift, tared, ca.vertcat(after, after_rate, total, count)]
    return ca.Function("lean", [theta_m, theta_c, flatten(r), w, state], out)


def _moved(r, e_x, e_y, quat, angle, height):
    """The corrected pose, twist and twist rate, and delta: eqs. (1), (2) of cutting/compensation.py."""
    theta, rate, acc = angle
    turn = ca.cross(r.tangent, r.normal) * r.curvature
    sdd = ca.dot(r.xdd[:3], r.tangent)
    w_C, w_C_rate = turn * r.sd, turn * sdd
    tan = ca.tan(theta)
    delta, delta_d = height * tan, height * (1 + tan * tan) * rate
    delta_dd = height * (1 + tan * tan) * (acc + 2 * tan * rate * rate)

    def turning(a, ad, add, e):
        e_d = ca.cross(w_C, e)
        return a * e, ad * e + a * e_d, add * e + 2 * ad * e_d + a * (ca.cross(w_C_rate, e) + ca.cross(w_C, e_d))

    dp, dp_d, dp_dd = turning(-delta, -delta_d, -delta_dd, e_y)
    rho, rho_d, rho_dd = turning(-theta, -rate, -acc, e_x)
    turned = frames.quaternion_product(frames.quaternion_of_rotation_vector(rho), quat)
    x = ca.vertcat(r.x[:3] + dp, frames.abc_of_rotation(frames.rotation_of_quaternion(turned)))
    return x, r.xd + ca.vertcat(dp_d, rho_d), r.xdd + ca.vertcat(dp_dd, rho_dd), delta


def columns(row, part, signals) -> dict[str, np.ndarray]:
    """Its variables of a chunk, thinned by the slice `part`, of `signals` (None: all)."""
    if "tilt" not in row:
        return {}
    asked = {name: signal for name, (signal, *_) in VARIABLES.items() if signals is None or name in signals}
    return {name: np.ascontiguousarray(row[signal][part][..., 0]) for name, signal in asked.items()}
