"""The static load test: a force on the tool from 0 to 3.5 kN and back in steps of 0.5 kN, told from the drives alone.

The printed range is 0 to 3.5 N; an error of "about 240 N" says that kN is meant.  The machine is held by its loops; the
estimate is the static form of observe/disturbance.py, eq. (3), read at the end of each step.
"""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np

from ... import kernel as kernels
from ...machine.hexapod import Hexapod
from ...observe.disturbance import DisturbanceObserver
from ...observe.recorded import Recorder
from ...simulate import start, tick
from ...simulate.plant import Plant
from ..study import Tick
from . import setup

LEVELS = np.concatenate([np.arange(0, 3501, 500), np.arange(3000, -1, -500)]).astype(float)  # N
WAIT = 2.0  # s at each level
DIRECTIONS = {"X": 0, "Y": 1}
BANDWIDTH = 5.0  # Hz, of the estimate


class Loaded(NamedTuple):
    """A static load test."""

    force: np.ndarray  # (15, 3) N, on the tool
    estimate: np.ndarray  # (15, 3) N
    bound: np.ndarray  # (3,) N: sum of f_0 |l| over the struts

    def error(self, axis: int) -> np.ndarray:
        """Of the component that is loaded.  (15,) N."""
        return self.estimate[:, axis] - self.force[:, axis]


def loads(progress: Tick | None) -> dict[str, Loaded]:
    """Both directions on the machine as it is."""
    return {name: loaded(axis, setup.true(), True, 100 + axis) for name, axis in DIRECTIONS.items()}


def perfect(progress: Tick | None) -> dict[str, Loaded]:
    """The same without friction, and with torques as they are."""
    machine = setup.machine().frictionless()
    machine = machine.replace(drive=machine.drive.perfect())
    return {name: loaded(axis, machine, False, 0) for name, axis in DIRECTIONS.items()}


def loaded(axis: int, true: Hexapod, read: bool, seed: int) -> Loaded:
    """One direction: hold the machine while the force steps, then tell the force from readings and torques."""
    count = round(WAIT / setup.PERIOD)
    wrench = np.zeros((count * len(LEVELS), 6))
    wrench[:, axis] = np.repeat(LEVELS, count)
    believed = setup.machine()
    q, u = held(believed, true, wrench)
    if read:
        R = setup.radius_of(believed.drive.lead)
        u = setup.read(u, believed.drive.lead, seed) / R
    observer = DisturbanceObserver(form="static", bandwidth=BANDWIDTH).on(believed, setup.PERIOD)
    before = np.concatenate([u[:1], u[:-1]])
    found = Recorder(observer, believed.home).rows(q, before)["wrench_hat"]
    ends = (np.arange(len(LEVELS)) + 1) * count - 1
    bound = (setup.F_0 * setup.SPREAD) @ np.abs(believed.jacobian(believed.home)[:, :3])
    return Loaded(wrench[ends, :3], found[ends, :3], bound)


def held(believed: Hexapod, true: Hexapod, wrench) -> tuple[np.ndarray, np.ndarray]:
    """Readings and applied forces (N, 6) of the machine at home under wrenches (N, 6), each for a sample."""
    law, row = setup.law().on(believed, setup.PERIOD), tick.rest_row(believed, believed.home)
    first = start.at_rest(believed, true, law, Plant(machine=true), row)
    schedule = tick.build(true, law, first.law, row, setup.PERIOD, 8)
    signals = [dataclasses.replace(s, kind="input") if s.name == "wrench" else s for s in schedule.signals]
    kernel = kernels.compile(dataclasses.replace(schedule, signals=tuple(signals)))
    simulation = kernel.start(
        {"theta_plant": true.theta, "theta_law": law.theta}, tick.first_states(schedule, first.z, first.law, first.u)
    )
    n = len(wrench)
    reference = np.concatenate([np.broadcast_to(np.ravel(part), (n, np.size(part))) for part in row], axis=1)
    out = simulation.advance(n, {"reference": reference, "wrench": np.asarray(wrench, float)})[:, 0]
    return out[:, kernel.columns["q_m"]], out[:, kernel.columns["u"]]
