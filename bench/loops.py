"""The closed loop that is timed: nist-octahedral on a circle of 0.2 m at 3 m/min, 1 kHz, RK4 at 0.25 ms.

Under computed torque with several frictions, and under several laws with the friction of the sheet; and ccu-3prs on the
circle of Chen and Tsai 2008 under equivalent errors at their gains.
"""

from __future__ import annotations

import time

import numpy as np

import gough as gk
from gough import kernel as kernels
from gough.program.reference import Reference
from gough.simulate import start
from gough.simulate.supervise import Supervision
from gough.study.chen2008 import setup as chen

PERIOD, SUBSTEPS, TICKS = 1e-3, 4, 4000
PROGRAM = gk.Circle(radius=0.2, feed=0.05)
LAW = gk.ComputedTorque(bandwidth=16.0)
LAWS = {
    "CCTPID": LAW,
    "CDAC": gk.RobustAdaptive(slope=200.0, damping=400.0),
    "FCDAC": gk.FuzzyFriction(slope=200.0, damping=400.0),
}
CHEN = "equivalent errors, 3-PRS"
RUNS = 16  # of a batch
CURVE = {"coulomb": 300.0, "static": 400.0, "stribeck": 2e-3, "viscous": 930.0}


def machines() -> dict[str, gk.Hexapod]:
    """Name of the friction -> machine."""
    sheet = gk.load_machine("nist-octahedral")
    bare = sheet.replace(friction=None, joints=sheet.joints.replace(friction=None))
    return {
        "none": bare,
        "Stribeck": bare.replace(friction={"kind": "stribeck", **CURVE, "smoothing": 1e-3}),
        "LuGre": bare.replace(friction={"kind": "lugre", **CURVE, "stiffness": 1e9, "damping": 8.85e5}),
        "LuGre with the load": sheet,
    }


class Loop:
    """Schedule, parameters, states and reference table of the loop on one machine, and its kernels."""

    def __init__(self, machine, law=LAW, program=PROGRAM):
        law = law.on(machine, PERIOD)
        table = program.plan(machine).sample(0, TICKS, PERIOD)
        row = Reference(*(column[0] for column in table))
        plant, asked = gk.Plant(machine=machine), Supervision(None, None, 0.0, None)
        first = start.at_rest(machine, machine, law, plant, row)
        self.schedule = start.schedule_of(machine, machine, law, first.law, row, PERIOD, SUBSTEPS, 0, asked)
        self.parameters = start.parameters(machine, machine, law, plant, PERIOD, 0, asked)
        self.states = start.states(self.schedule, first, row)
        self.table = np.concatenate(table, axis=1)

    def compiled(self, lanes, **options):
        return kernels.compile(self.schedule, lanes=lanes, **options)

    def rate(self, kernel, runs: int, ticks: int = TICKS) -> float:
        """Simulated seconds of all runs a CPU second, of the machine code alone."""
        simulation = kernel.start(self.parameters, self.states, runs=runs)
        out = np.empty((ticks, -(-runs // kernel.lanes) * kernel.lanes, kernel.width))
        begun = time.process_time()
        rows = simulation.advance(ticks, {"reference": self.table[:ticks]}, out)
        spent = time.process_time() - begun
        assert len(rows) == ticks and simulation.alive.all()
        return runs * ticks * PERIOD / spent


def published():
    """Machine, law and motion of Chen and Tsai 2008: printed gains, no friction, 24 s as the hexapod's circle."""
    return chen.machine(), chen.law(chen.CIRCLE), chen.program(chen.CIRCLE, 24.0)


def single(machine, law=LAW, program=PROGRAM) -> float:
    """Simulated seconds a CPU second of gk.simulate(): reference, checks, contour error and log of one run."""
    begun = time.process_time()
    log = gk.simulate(machine, law, program, substeps=SUBSTEPS)
    assert log.status == "done"
    return log.info["simulated_time"] / (time.process_time() - begun)


def batch(machine, plants, law=LAW, program=PROGRAM) -> float:
    """The same of a batch with metrics only, all runs together."""
    begun = time.process_time()
    log = gk.simulate(machine, law, program, plant=plants, keep="metrics", substeps=SUBSTEPS)
    assert log.status == "done"
    return log.info["simulated_time"] / (time.process_time() - begun)


def plants_of(machine):
    return [gk.Plant(machine=machine, payload=1.0 + i) for i in range(RUNS)]
