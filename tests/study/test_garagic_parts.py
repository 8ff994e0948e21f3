"""The parts of the study of Garagic and Srinivasan: geometry, the ramp, the bounds, what is believed."""

from __future__ import annotations

import numpy as np
import pytest

from gough.study.garagic2004 import bounds, circle, corner, experiments, limit, setup
from gough.study.garagic2004.circle import angles_of_geometry, distances


@pytest.fixture(scope="module")
def machine():
    return setup.machine()


def test_reversals_by_geometry_are_where_strut_lengths_along_the_circle_are_extreme(machine):
    """A second way: the lengths themselves, on a grid of 0.01 degrees."""
    theta = np.radians(np.arange(0, 360, 0.01))
    x = np.zeros((len(theta), 6))
    x[:, 0], x[:, 1] = circle.RADIUS * np.cos(theta), circle.RADIUS * np.sin(theta)
    rise = np.diff(machine.inverse_kinematics(np.vstack([x, x[:1]])), axis=0) > 0
    rows = np.flatnonzero((rise != np.roll(rise, 1, axis=0)).any(1))
    assert len(rows) == 12
    assert distances(theta[rows], angles_of_geometry(machine)).max() < np.radians(0.01)


def test_reversals_by_geometry_are_those_of_the_design_notes(machine):
    wanted = [25.4, 34.6, 85.3, 94.6, 145.4, 154.6, 205.4, 214.6, 265.3, 274.6, 325.3, 334.6]  # MACHINES.md 1.3
    assert np.degrees(angles_of_geometry(machine)) == pytest.approx(wanted, abs=0.1)


def test_distances_on_the_circle_do_not_see_where_a_turn_begins():
    assert distances(np.radians([359.0, 10.0]), np.radians([1.0, 180.0])) == pytest.approx(np.radians([2.0, 170.0]))


def test_what_is_believed_is_four_fifths_of_every_number_that_is_learned(machine):
    known = setup.believed(machine)
    at = [machine.names.index(name) for text in machine.adaptable for name in text.split(" + ")]
    assert known.theta[at] == pytest.approx(0.8 * machine.theta[at], rel=1e-15)
    assert known.friction.coulomb == pytest.approx(0.8 * 0.18) and known.friction.static == machine.friction.static
    assert np.array_equal(known.joints.base, machine.joints.base), "geometry is known"


@pytest.mark.parametrize("samples", [2, 6, 40])
def test_the_ramp_leaves_velocity_and_position_continuous_and_is_off_the_path_by_equation_2(machine, samples):
    period = 1e-4
    program = corner.program(period, samples=samples)
    motion = program.plan(machine)
    k = round(motion.at / period)
    fine, n = period / 64, 64 * (samples + 4)
    row = motion.sample(64 * k - n, 64 * k + n, fine)
    p, v, a = row.x[:, :3], row.xd[:, :3], row.xdd[:, :3]
    # steps of v and p are no larger than the acceleration of the ramp makes them; 1e-9: for rounding
    ramp = bounds.jump() / (samples * period)
    assert np.abs(np.diff(v, axis=0)).max() <= ramp * fine + 1e-9
    assert np.abs(np.diff(p, axis=0) - fine * (v[1:] + v[:-1]) / 2).max() <= ramp * fine**2
    assert np.linalg.norm(a, axis=1).max() == pytest.approx(ramp, rel=1e-12)
    legs = bounds.directions()
    off = [np.linalg.norm(np.cross(p - motion.corner, leg), axis=1) for leg in legs]
    error = np.minimum(*off).max()
    assert error == pytest.approx(bounds.previewed(ramp), rel=2e-3)  # a 64th of a sample beside the middle
    q, qd, _ = machine.joint_motion(row.x, row.xd, row.xdd)
    assert np.array_equal(row.q, q) and np.array_equal(row.qd, qd)


def test_without_a_ramp_the_velocity_jumps_at_a_sample_and_wait_moves_it(machine):
    for wait in (0.0, 0.3):
        motion = corner.program(1e-3, wait=wait).plan(machine)
        behind = (motion.at + corner.BEFORE) / 1e-3 % 1.0
        assert (wait + behind) % 1.0 == pytest.approx(0.0, abs=1e-6) or (wait + behind) == pytest.approx(1.0, abs=1e-6)
    motion = corner.program(1e-3).plan(machine)
    k = round(motion.at / 1e-3)
    v = motion.sample(k - 1, k + 1, 1e-3).xd[:, :3]
    assert v == pytest.approx(motion.velocity, abs=1e-12)


def test_the_factor_of_the_bound_is_0_0884_for_the_corner_of_the_paper():
    assert np.degrees(bounds.turn()) == pytest.approx(90.0, abs=0.1)
    assert bounds.previewed(1.0) / bounds.jump() ** 2 == pytest.approx(0.0884, abs=5e-5)
    assert bounds.unseen(1.0) / bounds.jump() ** 2 == pytest.approx(0.25, abs=5e-4)
    assert bounds.previewed(bounds.jump() / 0.6e-3) == pytest.approx(15e-6, rel=1e-3)


def test_no_motion_with_the_bounded_acceleration_turns_faster_and_the_swing_halves_the_error():
    """docs/theory/corner.md: equations (2) and the one of a tool that swings out, by their own parabolas."""
    w, a = bounds.jump() / 2, 100.0
    t = np.linspace(-4 * w / a, 4 * w / a, 80001)
    sharp = w * np.abs(t)
    turn = np.where(np.abs(t) < w / a, w**2 / (2 * a) + a * t**2 / 2, sharp)
    assert (turn - sharp).max() == pytest.approx(w**2 / (2 * a))
    E = w**2 / (4 * a)
    swing = E + a * t**2 / 2 - sharp
    inside = np.abs(t) <= w / a
    assert swing[inside].max() == pytest.approx(E) and swing[inside].min() == pytest.approx(-E)


@pytest.mark.parametrize("torque", [40.0, 100.0, 1200.0])
def test_the_greatest_acceleration_is_that_of_a_linear_program_and_the_straight_one_uses_one_motor_up(machine, torque):
    from scipy.optimize import linprog

    x = np.append(corner.POINTS[1], np.zeros(3))
    M, J, still = machine.mass_matrix(x), machine.jacobian(x), np.zeros(6)
    first, second = bounds.directions()
    across = -(first - second * (first @ second))
    force = torque * 2 * np.pi / machine.drive.lead
    level = machine.friction.coulomb * machine.reactions(x, still, still).normal
    weight = machine.inverse_dynamics(x, still, still)
    # u = J^-T M a + weight, |u| <= force + friction
    per = np.linalg.solve(J.T, M)
    limit = np.concatenate([force + level - weight, force + level + weight])
    c = -np.append(across / np.linalg.norm(across), still[:3])
    found = linprog(c, A_ub=np.vstack([per, -per]), b_ub=limit, bounds=(None, None))
    assert bounds.greatest(machine, torque) == pytest.approx(-found.fun, rel=1e-6)
    a = bounds.straight(machine, torque)
    along = (second - first) / np.linalg.norm(second - first)
    u = machine.inverse_dynamics(x, still, np.append(a * along, still[:3]))
    used = (np.abs(u) + level).max()
    assert used == pytest.approx(force, rel=1e-9)


def test_the_torque_for_an_acceleration_gives_that_acceleration(machine):
    for of in (bounds.straight, bounds.greatest):
        assert of(machine, bounds.torque_for(machine, of, 471.4)) == pytest.approx(471.4)


def test_every_ramp_has_its_middle_at_a_sample_and_needs_no_more_than_the_torque(machine):
    for torque in experiments.TORQUES:
        samples = experiments.ramp(machine, torque)
        assert samples % 2 == 0
        assert bounds.jump() / (samples * experiments.FINE) <= bounds.straight(machine, torque)


@pytest.mark.quick("FCDAC")
@pytest.mark.parametrize("law", ["CDAC", "FCDAC"])
def test_without_learning_and_sliding_the_law_is_computed_torque(law):
    assert limit.difference(law) < 1e-6  # N, of forces of 1e5 N


def test_the_limit_case_sees_a_law_that_slides(monkeypatch):
    usual = setup.law
    monkeypatch.setattr(limit, "law", lambda *a, **o: usual(*a, **{**o, "sliding": 1.0}))
    assert limit.difference("CDAC") > 0.1
