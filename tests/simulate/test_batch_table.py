"""Batches serve what single runs serve: every machine, law, wrapper, observer and friction, lane for lane."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import gough as gk
from gough.control.axis_pd import AxisPD
from gough.control.flexible_feedforward import FlexibleFeedforward
from gough.control.gravity_compensation import GravityCompensation
from gough.errors import ExperimentError
from gough.observe.disturbance import DisturbanceObserver
from gough.simulate.drift import scaled

MACHINES = ("nist-octahedral", "okuma-pm600", "eth-hexaglide", "ccu-3prs", "ifma-hsm", "emps")
LAWS = {
    "pid": lambda f: gk.PID(bandwidth=6.0 * f),
    "axis_pd": lambda f: AxisPD(stiffness=4e5 * f),
    "computed_torque": lambda f: gk.ComputedTorque(bandwidth=6.0 * f),
    "desired_torque_adaptive": lambda f: gk.DesiredTorqueAdaptive(pole=60.0 * f),
    "robust_adaptive": lambda f: gk.RobustAdaptive(slope=60.0 * f, damping=120.0),
    "fuzzy_friction": lambda f: gk.FuzzyFriction(slope=60.0 * f, damping=120.0),
    "equivalent_error": lambda f: gk.EquivalentError(damping=40.0 * f),
    "gravity_compensation": lambda f: GravityCompensation(law=gk.ComputedTorque(bandwidth=3.0 * f)),
    "flexible_feedforward": lambda f: FlexibleFeedforward(law=gk.ComputedTorque(bandwidth=3.0 * f)),
}
WRAPPERS = ("gravity_compensation", "flexible_feedforward")  # of laws that cannot know what gives way
CURVE = {"coulomb": 30.0, "static": 40.0, "stribeck": 2e-3, "viscous": 100.0}
FRICTIONS = {
    "none": None,
    "stribeck": {"kind": "stribeck", **CURVE, "smoothing": 1e-3},
    "lugre": {"kind": "lugre", **CURVE, "stiffness": 1e7, "damping": 1e4},
}
FERROR = 4e-3  # m; the loops above are slow, and follow within 2 mm; those of machines that give way within 4 mm
# what no run can have, single or not, and what is said of it
REFUSED = {
    ("ccu-3prs", "robust_adaptive"): "machine.friction: the believed machine has no friction to learn factors of",
    ("ifma-hsm", "robust_adaptive"): "machine.friction: the believed machine has no friction to learn factors of",
    ("emps", "equivalent_error"): "controller: contour errors are across a path in space",
    ("emps", "gravity_compensation"): "flexible: emps has no ",
    ("emps", "flexible_feedforward"): "flexible: emps has no ",
}


def program(machine, wide=False):
    if len(machine.task) == 1:
        return gk.Line(to=[0.004, 0.0, 0.0], feed=0.05, settle=0.02)
    return gk.Circle(radius=0.012 if wide else 0.002, feed=0.1 if wide else 0.05, settle=0.02)


def same(one, alone):
    assert set(one) == set(alone)
    for key in alone:
        np.testing.assert_array_equal(one[key], alone[key], err_msg=key)
    assert one.metrics == alone.metrics and (one.status, one.reason) == (alone.status, alone.reason)


def check(machine, laws, plants, observer=None, **options):
    """Lane for lane the single run, and in lanes of the processor's width no bit from a neighbour that fails."""
    swings = plants[0].flexible
    path, ferror = program(machine, swings), FERROR * (2 if swings else 1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of laws that are shaken or slow here: it is bits that are compared
        runs = gk.simulate(machine, laws, path, plant=plants, observer=observer, lanes=1, **options)
        for i, (law, plant) in enumerate(zip(laws, plants, strict=True)):
            same(runs.run(i), gk.simulate(machine, law, path, plant=plant, observer=observer, **options))
        assert not np.array_equal(runs["q"][:, 0], runs["q"][:, 1]), "lanes have numbers of their own"
        limited = [limit(plant, 1e5) for plant in plants]
        weak = limit(plants[1], 1e-3)  # its drives push with a newton: it stays behind, or falls
        options |= {"ferror": ferror}
        wide = gk.simulate(machine, laws, path, plant=limited, observer=observer, **options)
        beside = gk.simulate(
            machine, [laws[0], laws[1], laws[1], laws[2]], path, observer=observer,
            plant=[limited[0], weak, limited[1], limited[2]], **options,
        )  # fmt: skip
    assert not wide.failed and beside["failed"].tolist() == [0, 1, 0, 0]
    assert beside.runs[1]["limit_hit"]["time"] > 0 and beside.runs[1]["limit_hit"]["limit"]
    for i, place in enumerate((0, 2, 3)):
        same(beside.run(place), wide.run(i))
    assert np.abs(wide["q"] - runs["q"]).max() < 2 * ferror, "lanes of any number follow the same path"


def limit(plant, factor: float):
    """The plant with drives of `factor` kN."""
    key = "torque_limit" if "lead" in type(plant.machine.drive).model_fields else "force_limit"
    lead = getattr(plant.machine.drive, "lead", 2 * np.pi)
    return plant.replace(**{f"machine.drive.{key}": factor * 1e3 * lead / (2 * np.pi)})


def plants_of(machine, **options):
    """Three that differ: in friction where there is some, else in their offset from the path or where they stand."""
    if machine.friction is not None:
        return [gk.Plant(machine=scaled(machine, 1.0 + 0.2 * i), **options) for i in range(3)]
    return [gk.Plant(machine=machine, wrench=[5.0 * i, 0, 3.0 * i, 0, 0, 0], **options) for i in range(3)]


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("name", MACHINES)
def test_every_lane_of_every_machine_and_law_is_the_single_run(name, law):
    machine = gk.load_machine(name)
    laws = [LAWS[law](1.0 + 0.05 * i) for i in range(3)]
    if (name, law) in REFUSED:
        for given in (laws, laws[0]):
            with pytest.raises(ExperimentError) as caught:
                gk.simulate(machine, given, program(machine), plant=gk.Plant(machine=machine, flexible=law in WRAPPERS))
            assert str(caught.value).startswith(REFUSED[name, law])
        return
    check(machine, laws, plants_of(machine, flexible=law in WRAPPERS))


@pytest.mark.full
@pytest.mark.parametrize(
    "friction", [one if one == "lugre" else pytest.param(one, marks=pytest.mark.slow) for one in FRICTIONS]
)
def test_every_lane_with_every_friction_and_an_observer_is_the_single_run(friction):
    """The sheet's own friction, LuGre that scales with the load, is in the table above."""
    sheet = gk.load_machine("nist-octahedral")
    machine = sheet.replace(friction=FRICTIONS[friction], joints=sheet.joints.replace(friction=None))
    laws = [gk.ComputedTorque(bandwidth=6.0 + i) for i in range(3)]
    check(machine, laws, plants_of(machine), observer=DisturbanceObserver(bandwidth=20.0))


@pytest.mark.slow
@pytest.mark.parametrize("name", MACHINES)
def test_every_lane_of_every_machine_beside_an_observer_is_the_single_run(name):
    machine = gk.load_machine(name)
    laws = [gk.PID(bandwidth=6.0 + i) for i in range(3)]
    check(machine, laws, plants_of(machine), observer=DisturbanceObserver(bandwidth=20.0))
