"""One axis: its equations, its limits, its sheet; and that laws and observer work on a machine of one freedom."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from gough.errors import KinematicsError, SheetError, WorkspaceError
from gough.machine.axis import Axis
from gough.machine.sheet import load_machine


@pytest.fixture(scope="module")
def emps():
    return gk.load_machine("emps")


@pytest.fixture(scope="module")
def upright():
    """A carriage on a vertical screw: its weight is held by the drive, the turning parts weigh nothing."""
    return Axis(
        name="upright",
        carriage={"mass": 40.0},
        rail={"direction": [0.0, 0.0, 1.0]},
        drive={"lead": 0.01, "inertia": 1e-3, "torque_limit": 10.0},
        limits={"travel": [0.0, 0.5]},
        home=[0.2],
    )


def test_the_force_is_mass_times_acceleration_plus_weight(upright):
    """With J (2 pi / lead)^2 = 394.8 kg of turning parts beside 40 kg of carriage."""
    turning = 1e-3 * (2 * np.pi / 0.01) ** 2
    force = upright.inverse_dynamics([0.3], [0.1], [2.0], [0, 0, -70.0, 5, 5, 5])
    assert_allclose(force, [(40 + turning) * 2 + 40 * 9.81 + 70], rtol=1e-14)


def test_forward_dynamics_undo_inverse_dynamics(upright):
    x, xd, xdd = (np.linspace(a, b, 7)[:, None] for a, b in ((0.1, 0.4), (-1, 1), (-5, 5)))
    w = np.array([1.0, 2.0, 30.0, 4.0, 5.0, 6.0])
    u = upright.inverse_dynamics(x, xd, xdd, w)
    assert_allclose(upright.forward_dynamics(x, xd, u, w), xdd, rtol=1e-12, atol=1e-12)


def test_the_regressor_times_the_parameters_is_the_force(upright):
    x, xd, xdd = (np.linspace(a, b, 7)[:, None] for a, b in ((0.1, 0.4), (-1, 1), (-5, 5)))
    force = upright.regressor(x, xd, xdd) @ upright.parameters.values
    assert_allclose(force, upright.inverse_dynamics(x, xd, xdd), rtol=1e-12)


def test_the_torque_of_a_screw_is_the_force_times_the_lead_over_a_turn(upright):
    """Okuda et al. 2006, eq. (3): force = K_t i / R, R = lead / 2 pi."""
    assert gk.simulate and upright.drive.limit_of(upright.drive) == pytest.approx(10.0 * 2 * np.pi / 0.01)


def test_kinematics_are_the_place_itself(upright):
    x = np.array([[0.0], [0.25], [0.5]])
    assert_allclose(upright.inverse_kinematics(x), x)
    assert_allclose(upright.forward_kinematics(x), x)
    assert_allclose(upright.jacobian(x), np.ones((3, 1, 1)))
    assert_allclose(upright.tool_pose([0.3]), [0, 0, 0.3, 0, 0, 0])


def test_a_place_beyond_the_rail_is_refused_with_its_end(emps):
    with pytest.raises(WorkspaceError, match="carriage: beyond the end of its rail, got 0.4 m .limit 0.35 m."):
        emps.forward_kinematics([0.4])
    with pytest.raises(KinematicsError, match="carriage must be finite"):
        emps.forward_kinematics([np.nan])


def test_a_run_that_leaves_the_rail_ends_there(emps):
    with pytest.raises(WorkspaceError, match="beyond the end of its rail"):
        gk.simulate(emps, gk.PID(bandwidth=10.0), gk.Line(to=[0.5, 0, 0], feed=0.1), on_fail="raise")


@pytest.mark.parametrize("law", [gk.PID(bandwidth=10.0), gk.ComputedTorque(bandwidth=10.0)], ids=lambda law: law.kind)
def test_laws_and_observer_work_on_one_freedom(emps, law):
    """5 N on the carriage, along the rail and across it: the one is found, the other is the rail's."""
    plant = gk.Plant(machine=emps, wrench=[5.0, 5.0, 0, 0, 0, 0])
    program = gk.Line(to=[0.1, 0, 0], feed=0.05)
    log = gk.simulate(emps, law, program, plant, observer=gk.DisturbanceObserver(bandwidth=10.0))
    assert not log.failed
    assert np.abs(log["x"] - log["x_r"]).max() < 1e-3
    moving = np.abs(log["xd"][:, 0] - 0.05) < 5e-4
    assert log["wrench_hat"].shape == (len(log), 6)
    assert_allclose(np.median(log["wrench_hat"][moving], 0), [5, 0, 0, 0, 0, 0], atol=0.2)


def test_the_sheet_reads_back_to_the_same_machine(emps):
    assert Axis.from_file(emps.to_file()) == emps


WRONG = [
    ('direction = { unit = "1", value = [1, 0, 0] }', 'direction = { unit = "1", value = [1, 1, 0] }',
     "rail.direction: must have length 1, got 1.41421"),
    ('"-0.05 m", "0.35 m"', '"0.35 m", "-0.05 m"', "limits.travel: the least comes first"),
    ('place = ["0 m"]', 'place = ["1 m"]', "home is beyond the rail, got 1 m"),
    ('place = ["0 m"]', 'pose = ["0 m"]', "[home] has one key, place, got pose"),
    ('mass = "95.1089 kg"', 'mass = "0 kg"', "carriage.mass: must be above 0 kg"),
    ('kind      = "stribeck"', 'kind      = "load_stribeck"', "friction."),
    ('encoder = "0.05 um"', 'encoder = "0.05 um"\nlaed = "1 mm"', "drive.laed: no such key; there is encoder, noise, delay, force_limit"),  # noqa: E501
    ('unit    = "V"\nfactor', 'unit    = "V"\nfoctor', "record.forces"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "message"), WRONG)
def test_a_wrong_sheet_is_told(tmp_path, old, new, message):
    text = gk.library()["emps"].read_text()
    assert old in text
    (tmp_path / "axis.toml").write_text(text.replace(old, new, 1))
    with pytest.raises(SheetError) as caught:
        load_machine(tmp_path / "axis.toml")
    assert message in str(caught.value)
