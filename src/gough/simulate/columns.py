"""The rows of a chunk as the log's variables, for one run (n, ...) or several side by side (n, runs, ...)."""

from __future__ import annotations

import numpy as np

from ..errors import DivergedError, ExperimentError, RunError, did_you_mean
from ..frames import abc_of_rotation_np, rotation_of_quaternion_np
from ..kernel.pack import fields
from ..log.build import VARIABLES
from ..machine.workspace import beyond
from ..program.reference import Reference
from ..quantities import brief
from . import cut, joints, leaning
from .trip import tripped

# what the reference alone decides is the same for all runs of a batch
SHARED = ("t", "x_r", "xd_r", "q_r", "s_r", "line", "block", "counted")


RESIDUAL = "observer.encoder_residual"


def chosen(signals, state, machine, drifts: bool = False, more=()) -> set[str] | None:
    """The variables of the log that were asked for; None for all.  `more` are names of others there are.

    Raises
    ------
    ExperimentError
        a name that no variable has.
    """
    if signals is None:
        return None
    states = [name if name.startswith("observer.") else f"controller.{name}" for name in fields(state)]
    known = [*VARIABLES, *states, *(["plant.friction_memory"] if machine.memory_count else [])]
    known += [RESIDUAL, *joints.available(machine), *(["plant.friction_scale"] if drifts else []), *more]
    known += cut.VARIABLES
    for i, name in enumerate(signals):
        if name in joints.FORCES and machine.rigid is not machine:
            raise ExperimentError(
                "a flexible plant does not tell the forces in its joints", key=f"run.signals.{i}", value=name,
                cure="ask a plant without flexible = true",
            )  # fmt: skip
        if name not in known:
            cure = did_you_mean(name, known)
            raise ExperimentError("the log has no such variable", key=f"run.signals.{i}", value=brief(name), cure=cure)
    return set(signals)


def tool_rows(row) -> np.ndarray:
    """Position and quaternion of the true T in W among the kernel's signals.  (..., 7)."""
    return row["tool"] if "tool" in row else row["z"]


def columns(period, k, part, reference: Reference, row, book, contour, wrench, state, signals) -> dict[str, np.ndarray]:
    """The variables of samples k ..., thinned by the slice `part`; those of SHARED without the axis of the runs.

    `row` has the kernel's signals, `wrench` (6,) or (runs, 6) what acts on the tool.
    """
    z = tool_rows(row)[part]
    course = _course(reference, row, part)
    d = reference.x.shape[-1]
    if d < 6:
        x = z[..., :3] if d == 3 else row["z"][part][..., :d]  # an axis counts along its rail
    else:
        x = np.concatenate([z[..., :3], abc_of_rotation_np(rotation_of_quaternion_np(z[..., 3:]))], -1)
        x_r = course["x_r"][..., 3:]
        x_r = x_r if x_r.ndim == z.ndim else x_r[:, None]
        x[..., 3:] += 2 * np.pi * np.round((x_r - x[..., 3:]) / (2 * np.pi))  # the turn nearest the reference
    found = {
        "t": (np.arange(k, k + len(row["z"]))[part]) * period,
        "x": x, "xd": row.get("xd", row["v"])[part], "s_r": book.s[part],
        "line": book.line[part], "block": book.block[part], "counted": book.counted[part],
        "wrench": wrench + row["cutting_force"][part] if "cutting_force" in row else np.broadcast_to(
            wrench, (len(z), *np.shape(wrench))
        ),
    } | course  # fmt: skip
    found |= {name: row[name][part] for name in ("q", "q_m", "u_c", "u", "friction", "saturated")}
    found |= {name: value[part] for name, value in contour._asdict().items()}
    for name, where in fields(state).items():
        owner, values = "controller." + name, row["law"][part][..., where]
        found[name if name.startswith("observer.") else owner] = values[..., 0] if values.shape[-1] == 1 else values
    if "flagged" in row:
        found |= {"encoder_flag": row["flagged"][part] > 0, RESIDUAL: row["encoder_residual"][part]}
    if "stopping" in row:
        found["stopping"] = row["stopping"][part][..., 0] > 0
        for name in ("s_r", "line", "block", "counted"):  # runs may stop where others do not
            if found[name].ndim < z.ndim - 1:
                found[name] = np.repeat(found[name][:, None], z.shape[1], 1)
    if "memory" in row:
        found["plant.friction_memory"] = row["memory"][part]
    if "friction_scale" in row:
        found["plant.friction_scale"] = row["friction_scale"][part][..., 0]
    found |= cut.columns(row, part)
    found |= joints.columns(row, part, joints.asked(signals))
    if signals is not None:
        found = {name: value for name, value in found.items() if name == "t" or name in signals}
    return {name: np.ascontiguousarray(value) for name, value in found.items()}


def _course(reference: Reference, row, part) -> dict[str, np.ndarray]:
    """What the law followed: the program's reference, or what a safe stop made of it."""
    if "course" not in row:
        return {"x_r": reference.x[part], "xd_r": reference.xd[part], "q_r": reference.q[part]}
    where, course = fields(Reference(*(column[0] for column in reference))), row["course"][part]
    return {f"{name}_r": course[..., where[name]] for name in ("x", "xd", "q")}


def told(law, name: str) -> tuple:
    """Dimension, unit and meaning of a state, as its law tells; variables of the contract have theirs."""
    if name == "plant.friction_memory":
        return ("joint",), "m", "deflection of the friction's bristles"
    if name == RESIDUAL:
        return ("joint",), "m", "second difference of the readings that no known force explains"
    if name == "plant.friction_scale":
        return (), "1", "friction over that of the plant's numbers"
    if name in cut.VARIABLES:
        return cut.VARIABLES[name][1:]
    if name in leaning.VARIABLES:
        return leaning.VARIABLES[name][1:]
    if name in joints.FORCES:
        return joints.FORCES[name][1]
    said = law.state_told(name.removeprefix("controller."))
    return (None, "", "") if said is None else ((said[0],), said[1], said[2])


def explain(stop, machine, motion, period: float, trip=None) -> RunError:
    """The kernel's stop as an error of the true machine, with time and NC line."""
    line = int(motion.book(stop.tick, stop.tick + 1, period).line[0])
    place = f"NC line {line}" if line else None
    if stop.reason == "not finite":
        return DivergedError(
            f"{stop.signal} is no longer finite",
            where=place,
            key=stop.label,
            value=str(stop.value),
            time=stop.time,
            cure="the loop is most likely unstable: lower the bandwidth or shorten the period",
        )
    joint = stop.index - len(machine.limit_names)
    if joint >= 0 and trip is None:
        return RunError("a safe stop", time=stop.time)  # stopped.py tells why it began
    if joint >= 0:
        qd_r = motion.sample(stop.tick, stop.tick + 1, period).qd[0, joint]
        return tripped(machine, trip, joint, qd_r, stop, place)
    return beyond(machine, stop.index, stop.value, place, stop.time)
