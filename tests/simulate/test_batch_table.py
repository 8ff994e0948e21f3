"""Batches serve what single runs serve: every machine, law, wrapper, observer and friction, lane for lane."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import gough as gk
from gough.control.axis_pd import AxisPD
from gough.control.flexible_feedforward import FlexibleFeedforward
from gough.control.gravity_compensation import GravityCompensation
from gough.cutting.cutting import Cutting
from gough.errors import ExperimentError, GoughError
from gough.observe.disturbance import DisturbanceObserver
from gough.simulate.drift import scaled

RIGID = ("nist-octahedral", "okuma-pm600", "eth-hexaglide", "ccu-3prs", "ifma-hsm", "emps")
LAWS = {
    "pid": lambda f: gk.PID(bandwidth=6.0 * f),
    "axis_pd": lambda f: AxisPD(stiffness=4e5 * f),
    "computed_torque": lambda f: gk.ComputedTorque(bandwidth=6.0 * f),
    "desired_torque_adaptive": lambda f: gk.DesiredTorqueAdaptive(pole=60.0 * f),
    "robust_adaptive": lambda f: gk.RobustAdaptive(slope=60.0 * f, damping=120.0),
    "fuzzy_friction": lambda f: gk.FuzzyFriction(slope=60.0 * f, damping=120.0),
    "equivalent_error": lambda f: gk.EquivalentError(damping=40.0 * f),
    "gravity_compensation": lambda f: GravityCompensation(law=gk.ComputedTorque(bandwidth=6.0 * f)),
    "flexible_feedforward": lambda f: FlexibleFeedforward(law=gk.ComputedTorque(bandwidth=6.0 * f)),
}
WRAPPERS = ("gravity_compensation", "flexible_feedforward")


def frictions(machine):
    """The machine without friction, with one that is a function of speed and with one that has a memory."""
    joints = getattr(machine, "joints", None)
    bare = machine.frictionless()
    curve = {"coulomb": 30.0, "static": 40.0, "stribeck": 2e-3, "viscous": 100.0}
    found = {"sheet": machine, "none": bare}
    found["stribeck"] = bare.replace(friction={"kind": "stribeck", **curve, "smoothing": 1e-3})
    found["lugre"] = bare.replace(friction={"kind": "lugre", **curve, "stiffness": 1e7, "damping": 1e4})
    return found, joints


def program(machine):
    return gk.Circle(radius=0.004, feed=0.05, settle=0.02) if len(machine.task) > 1 else gk.Line(to=[0.004], feed=0.05)


def cases():
    for name in RIGID:
        for law in LAWS:
            yield name, law, law in WRAPPERS, law == "computed_torque"


@pytest.mark.slow
@pytest.mark.parametrize(("name", "law", "flexible", "observed"), cases())
def test_every_lane_is_the_single_run(name, law, flexible, observed):
    print(name, law)
    machine = gk.load_machine(name)
    plants = [gk.Plant(machine=scaled(machine, 1.0 + 0.1 * i), flexible=flexible) for i in range(3)]
    laws = [LAWS[law](1.0 + 0.05 * i) for i in range(3)]
    runs = gk.simulate(machine, laws, program(machine), plant=plants, lanes=1)
    for i in range(3):
        alone = gk.simulate(machine, laws[i], program(machine), plant=plants[i])
        one = runs.run(i)
        assert set(one) == set(alone)
        for key in alone:
            np.testing.assert_array_equal(one[key], alone[key], err_msg=key)
        assert one.metrics == alone.metrics
