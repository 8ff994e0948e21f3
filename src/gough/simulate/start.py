"""How a run starts: the plant at rest at the first reference, the law so that nothing moves, the tick as scheduled."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..errors import ExperimentError
from ..kernel import Schedule
from ..program.reference import Reference
from . import cut, drift, faults, joints, supervise, tick
from .supervise import Supervision
from .trip import where_in, with_trip


class Start(NamedTuple):
    """One run at rest."""

    z: np.ndarray  # coordinates of the true machine
    law: Any  # the law's first state
    u: np.ndarray  # joint forces, (n,) N


def at_rest(believed, true, law, plant, row: Reference) -> Start:
    """The true machine at the joints of the first reference `row`, or beside it, held against what acts on its tool.

    Raises
    ------
    KinematicsError, WorkspaceError, SingularityError
        the true machine cannot stand there.
    """
    x0, d = row.x, len(believed.task)
    if np.abs(true.inverse_kinematics(x0) - row.q).max() > 1e-12:  # joints as read, on the true geometry
        x0 = true.forward_kinematics(row.q, near=x0)
    if plant.offset is not None:  # the law is told by the encoders where it starts
        x0 = x0 + np.concatenate([plant.offset, np.zeros(d - 3)])
        row = row._replace(x=x0, q=true.inverse_kinematics(x0))
    z0, u0 = true.at_rest(x0, plant.wrench)
    return Start(z0, law.init(row, u0), u0)


def schedule_of(
    believed, true, law, state, row: Reference, period: float, substeps: int, count: int, asked: Supervision,
    signals=None, drifts: bool = False, cutting=None,
) -> Schedule:  # fmt: skip
    """The tick of `tick.build`, with `count` faults of encoders, the supervision that is asked for, friction that
    drifts, forces in the joints where `signals` asks for them, and a cut."""
    schedule = tick.build(true, law, state, row, period, substeps)
    schedule = joints.with_reactions(schedule, true, joints.asked(signals))
    n = true.joints_count
    if asked.ends_at_once is not None:
        schedule = with_trip(schedule, n, *where_in(row))
    schedule = supervise.with_supervision(schedule, believed, asked)
    schedule = faults.with_faults(schedule, n, count) if count else schedule
    schedule = cut.with_cutting(schedule, true, row, cutting)
    return drift.with_drift(schedule, true) if drifts else schedule


def parameters(
    believed, true, law, plant, period: float, count: int, asked: Supervision, drifts: bool = False
) -> dict[str, np.ndarray]:
    """The parameters of one run of that schedule."""
    found = {"theta_plant": true.theta, "theta_law": law.theta, "wrench": plant.wrench}
    if asked.ends_at_once is not None:
        found["trip"] = np.array(asked.trip)
    found |= supervise.parameters(believed, asked)
    if count:
        found["faults"] = faults.numbers(plant.faults, count, period)
    if drifts:
        found["friction_drift"] = np.array([plant.friction_drift or 0.0])
    return found | cut.parameters(plant.cutting)


def states(schedule: Schedule, start: Start, row: Reference) -> dict[str, np.ndarray]:
    """The states at rest of one run of that schedule."""
    found = tick.first_states(schedule, start.z, start.law, start.u) | supervise.states(schedule, row, start.u)
    found |= cut.states(schedule, start.z[:3])
    return found | ({"held": row.q} if "held" in found else {})


def inputs(reference: Reference, k: int, schedule: Schedule) -> dict[str, np.ndarray]:
    """The tables of samples k ..., for that schedule."""
    found = {"reference": np.concatenate(reference, axis=1)}
    timed = "clock" in schedule.by_name
    return found | ({"clock": np.arange(k, k + len(reference.x), dtype=float)} if timed else {})


def check_faults(plant, machine, key: str = "plant.faults") -> int:
    """How many faults of encoders a plant has.  ExperimentError where the machine has no such joint."""
    for i, fault in enumerate(plant.faults):
        if fault.joint > machine.joints_count:
            raise ExperimentError(
                "the machine has no such joint", key=f"{key}.{i}.joint", value=str(fault.joint),
                limit=f"{machine.joints_count}",
            )  # fmt: skip
    return len(plant.faults)
