"""What is asked of a plant before it runs may be shared among plants; what comes out may not change by that."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

import gough as gk
from gough.declare import Part, quantity
from gough.frames import quaternion_of_abc_np
from gough.machine.workspace import random_poses
from gough.simulate import loads, stability, tick


@pytest.fixture(scope="module")
def nist():
    return gk.load_machine("nist-octahedral")


def loads_one_by_one(machine):
    """The largest loads by CasADi's interpreter, pose by pose, on poses drawn for this very machine."""
    poses = [machine.home, *random_poses(machine, loads.POSES, np.random.default_rng(0))]
    feed, function, still = machine.feed, tick.loads_function(machine), np.zeros(6)
    steps = np.diag([feed.acceleration] * 3 + [feed.angular_acceleration] * 3)
    found = []
    for x in poses:
        z = np.concatenate([x[:3], quaternion_of_abc_np(x[3:])])
        for a in (still, *steps, *-steps):
            u = machine.inverse_dynamics(x, still, a)
            found.append(np.array(function(machine.theta, z, still, np.zeros(machine.memory_count), a, u)).ravel())
    return np.max(found, axis=0)


@pytest.mark.quick("gravity", "strut.tube")
@pytest.mark.parametrize("changes", [
    {}, {"friction.static": 0.27, "friction.stiffness": 2e9, "joints.friction.coefficient": 0.3},
    {"platform.mass": 240.0, "friction.coulomb": 0.27, "friction.static": 0.3}, {"strut.moving.mass": 66.0},
    {"limits.workspace.radius": 0.1}, {"strut.tube": 1.05}, {"feed.acceleration": 4.0}, {"gravity": [0.0, 0.0, -3.7]},
], ids=lambda changes: next(iter(changes), "sheet"))  # fmt: skip
def test_loads_of_a_plant_are_its_own_whatever_others_were_asked_before(nist, changes):
    """Poses are shared by machines of one geometry, loads by those that differ in friction only; to rounding, from
    another compiler."""
    machine = nist.replace(**changes)
    np.testing.assert_allclose(stability.largest_loads(machine), loads_one_by_one(machine), rtol=1e-12)


def test_a_pole_at_grown_friction_is_that_of_the_machine_with_grown_friction(nist):
    from gough.mechanics.friction import Stribeck
    from gough.simulate.drift import scaled

    for machine in (nist, nist.replace(friction=Stribeck(coulomb=300.0, viscous=930.0, smoothing=1e-3))):
        grown = scaled(machine, 1.3)
        assert stability.fastest_pole(machine, 1.3) == pytest.approx(stability.fastest_pole(grown), rel=1e-9)
        assert stability.load_gain(machine, 1.3) == pytest.approx(stability.load_gain(grown), rel=1e-12)


def test_numbers_that_are_kept_cannot_be_written_to(nist):
    with pytest.raises(ValueError, match="read-only"):
        nist.theta[0] = 1.0
    assert nist.replace(**{"platform.mass": 240.0}).theta[list(nist.names).index("platform.mass")] == 240.0


def test_what_a_class_declares_is_kept_by_class_and_not_mixed_up():
    class One(Part):
        """One."""

        a: float = quantity("m", "a length", default=1.0)

    class Two(One):
        """Two."""

        b: float = quantity("kg", "a mass", default=2.0)

    assert list(One.specs()) == ["a"] and list(Two.specs()) == ["a", "b"] and list(One.specs()) == ["a"]
    assert Two().names == ("a", "b") and One().names == ("a",)


def test_coordinates_on_arrays_are_the_symbolic_ones(nist):
    x = np.array([0.05, -0.03, 0.02, 0.1, -0.08, 0.12])
    np.testing.assert_allclose(
        nist.coordinates(x), np.array(ca.DM(nist.coordinates_of(nist, ca.DM(x)))).ravel(), atol=1e-15
    )
    assert nist.coordinates(np.zeros((4, 2, 6))).shape == (4, 2, 7)
