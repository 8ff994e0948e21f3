"""Forward kinematics in C: no wrong answer, the last good pose where there is none."""

from __future__ import annotations

import numpy as np
import pytest
from compiled import InC, needs_gcc
from test_c_machine import (
    GENHEX,
    MACHINES,
    NOT_FINITE,
    OK,
    OUTSIDE_LIMITS,
    SINGULAR,
    motions,
)  # fmt: skip

import gough as gk
from gough.export.c.solver_text import MOST

pytestmark = needs_gcc
SAME = 1e-9  # m and rad: two poses of one assembly mode that are nearer are one; others are 1e-2 apart


def apart(found, expected):
    """Greatest difference of each row, angles within half a turn."""
    e = np.abs(found - expected)
    e[:, 3:] = np.abs((e[:, 3:] + np.pi) % (2 * np.pi) - np.pi)
    return e.max(-1)


def hold_everywhere(in_c, count, seed=3):
    """From a pose beside, from home, and from any other pose: found, and the same."""
    x, rng = motions(in_c.machine, count, seed)[0], np.random.default_rng(seed)
    q = in_c.machine.inverse_kinematics(x)
    beside = x + rng.uniform(-1, 1, x.shape) * np.array([5e-3] * 3 + [0.02] * 3)[: x.shape[1]]
    for near in (beside, in_c.machine.home, x[rng.permutation(count)]):
        status, found, report = in_c.forward(q, near)
        assert np.bincount(status, minlength=7)[1:].sum() == 0
        assert apart(found, x).max() < SAME
        assert report["residual"].max() < 1e-12
        assert report["evaluations"].max() <= MOST // 2
    return x


def test_two_thousand_poses_of_the_default_hexapod_are_found_from_anywhere(genhex):
    x = hold_everywhere(genhex, 2000)
    assert np.degrees(np.abs(x[:, 5]).max()) > 79  # as far as the sheet lets it turn


@pytest.mark.full("nist-octahedral")
@pytest.mark.parametrize("name", MACHINES[:4])
def test_poses_of_every_machine_that_needs_a_search_are_found_from_anywhere(name, tmp_path):
    hold_everywhere(InC(tmp_path, gk.load_machine(name)), 5000)


@pytest.mark.full
def test_twenty_thousand_poses_of_the_default_hexapod_are_found_from_anywhere(genhex):
    hold_everywhere(genhex, 20_000)


@pytest.mark.slow
def test_a_million_poses_of_the_default_hexapod_are_found_from_anywhere(genhex):
    for seed in range(10, 20):
        hold_everywhere(genhex, 100_000, seed)


def test_beyond_60_degrees_where_adding_to_angles_diverges_three_evaluations_are_enough(genhex):
    x = np.tile(genhex.machine.home, (80, 1))
    x[:, 5] = np.radians(np.linspace(60, 80, 80))
    status, found, report = genhex.forward(genhex.machine.inverse_kinematics(x), x + 1e-4)
    assert not status.any()
    assert apart(found, x).max() < 1e-12
    assert report["evaluations"].max() <= 3


def test_within_two_degrees_of_the_singular_turn_the_pose_is_refused_as_singular(genhex):
    x = np.tile(genhex.machine.home, (40, 1))
    x[:, 5] = np.radians(np.linspace(88.0, 89.9, 40)) * np.tile([1, -1], 20)
    near = np.tile(genhex.machine.home, (40, 1))
    near[:, 5] = np.sign(x[:, 5]) * np.radians(86)
    status, found, report = genhex.forward(genhex.machine.inverse_kinematics(x), near)
    assert set(status) == {SINGULAR}
    assert np.array_equal(found, near)
    assert (report["determinant"] < 0.02).all()
    assert (report["determinant"] > 0).all()


def test_the_mirror_image_below_the_base_is_never_an_answer(genhex):
    """genhexkins gives the pose at z = -20 in from a start below the base, and says that all is well."""
    machine = genhex.machine
    q = machine.inverse_kinematics(machine.home)
    starts = np.tile(machine.home, (60, 1))
    starts[:, 2] = np.linspace(-1.0, 1.2, 60)
    status, found, _ = genhex.forward(np.tile(q, (60, 1)), starts)
    good = status == OK
    assert apart(found[good], starts[good] * 0 + machine.home).max() < SAME
    assert np.array_equal(found[~good], starts[~good])
    assert good[starts[:, 2] < 0].all()  # a start in the mirror image is none: it is sought from home


def test_joint_coordinates_of_another_assembly_mode_or_of_none_leave_the_last_good_pose(genhex):
    rng, machine = np.random.default_rng(8), genhex.machine
    q = machine.inverse_kinematics(machine.home) * rng.uniform(0.2, 3.0, (3000, 6))
    q[:6] = [[-1.0] * 6, [0.0] * 6, [1e300] * 6, [1e-300] * 6, [5e-324] * 6, [1e9] * 6]
    status, found, report = genhex.forward(q, machine.home)
    bad = status != OK
    assert bad[:6].all()
    assert bad.sum() > 1000
    assert (found[bad] == machine.home).all()
    assert np.isfinite(found).all()
    assert report["evaluations"].max() <= 2 * MOST
    back = machine.inverse_kinematics(found[~bad]) if (~bad).any() else q[:0]
    assert np.abs(back - q[~bad]).max(initial=0) < 1e-10


def test_a_pose_beyond_the_limits_is_found_and_refused_with_the_limit_told(genhex):
    machine = genhex.machine
    x = machine.home + [[0, 0, 0.15, 0, 0, 0], [0.12, 0, 0, 0, 0, 0]]
    status, found, report = genhex.forward(machine.inverse_kinematics(x), machine.home)
    assert status.tolist() == [OUTSIDE_LIMITS, OUTSIDE_LIMITS]
    assert np.array_equal(found, np.tile(machine.home, (2, 1)))
    assert report["limit"].tolist() == [1, 0]  # height, radius of the workspace
    assert np.abs(report["margin"] - [-0.05, -0.02]).max() < 1e-8  # 1e-9 m count as inside


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf])
def test_joints_that_are_no_numbers_leave_the_pose_and_a_pose_that_is_none_becomes_home(genhex, wrong):
    machine = genhex.machine
    q = np.tile(machine.inverse_kinematics(machine.home), (6, 1))
    bad = q.copy()
    bad[np.arange(6), np.arange(6)] = wrong
    near = machine.home + 1e-3
    status, found, _ = genhex.forward(bad, near)
    assert set(status) == {NOT_FINITE}
    assert (found == near).all()
    starts = np.tile(near, (6, 1))
    starts[np.arange(6), np.arange(6)] = wrong
    status, found, _ = genhex.forward(q, starts)
    assert set(status) == {NOT_FINITE}
    assert (found == machine.home).all()


@pytest.mark.full
def test_a_path_through_the_singular_turn_stops_there_and_never_comes_out_in_another_mode(tmp_path):
    """Servo steps of C from 80 to 100 degrees: each answer is the last good pose of the next."""
    machine = gk.load_machine(GENHEX).replace(**{"limits.workspace": None})
    in_c, turns = InC(tmp_path, machine, options=("-O0",)), np.radians(np.linspace(80, 100, 2001))
    x = np.tile(machine.home, (len(turns), 1))
    x[:, 5] = turns
    q, pose, told, greatest = machine.inverse_kinematics(x), x[:1].copy(), [], 0.0
    for k in range(len(turns)):
        status, pose, _ = in_c.forward(q[k : k + 1], pose)
        told.append(int(status[0]))
        greatest = max(greatest, np.degrees(pose[0, 5]))
    first = told.index(SINGULAR)
    assert set(told[:first]) == {OK}
    assert 87 < np.degrees(turns[first]) < 88
    # the struts of a turn beyond 90 deg are also those of one before it, which is then what is found
    assert greatest < 88
    assert set(told) <= {OK, SINGULAR}
