"""The machine on arrays: shapes, broadcasting, and no answer that is not a number."""

from __future__ import annotations

import tracemalloc

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_array_equal

import gough as gk
from gough import frames
from gough.errors import ExperimentError, KinematicsError, SingularityError
from gough.frames import abc_of_rotation_np, rotation_of_abc_np
from gough.machine import forward, workspace
from gough.machine.workspace import random_poses


@pytest.fixture(scope="module")
def nist():
    return gk.load_machine("nist-octahedral")


def test_leading_axes_are_kept_and_broadcast(nist):
    x = nist.home + np.zeros((2, 3, 6))
    assert nist.inverse_kinematics(nist.home).shape == (6,)
    assert nist.inverse_kinematics(x).shape == (2, 3, 6)
    assert nist.jacobian(x).shape == (2, 3, 6, 6)
    assert nist.inverse_dynamics(x, np.zeros(6), np.zeros((3, 6))).shape == (2, 3, 6)
    assert nist.forward_dynamics(nist.home, np.zeros(6), np.zeros((4, 6))).shape == (4, 6)
    assert nist.forward_kinematics(nist.inverse_kinematics(x)).shape == (2, 3, 6)
    assert nist.regressor(x, x * 0, x * 0).shape == (2, 3, 6, len(nist.parameters.values))
    assert nist.regressor(x, x * 0, x * 0, friction=True).shape[-1] == len(nist.parameters_of(friction=True).values)
    assert nist.inverse_kinematics(np.zeros((0, 6))).shape == (0, 6)


def test_a_row_does_not_depend_on_the_others(nist):
    x = nist.home + np.random.default_rng(0).uniform(-0.05, 0.05, (11, 6))
    whole = nist.inverse_dynamics(x, x * 0, x)
    for i in range(11):
        assert_array_equal(nist.inverse_dynamics(x[i], x[i] * 0, x[i]), whole[i])


def test_forward_kinematics_of_a_row_do_not_depend_on_its_block(nist):
    """Rows are searched in blocks, those that have arrived are left out: the others' bits must not notice."""
    rng = np.random.default_rng(1)
    x = random_poses(nist, forward.BLOCK + 100, rng)
    near = x + rng.uniform(-1, 1, (len(x), 1)) * np.array([5e-3] * 3 + [0.02] * 3)
    q = nist.inverse_kinematics(x)
    whole = nist.forward_kinematics(q, near=near)
    assert np.abs(whole - x).max() < 1e-11
    for i in (0, 7, forward.BLOCK - 1, forward.BLOCK, len(x) - 1):
        assert_array_equal(nist.forward_kinematics(q[i], near=near[i]), whole[i])
    part = slice(50, 61)
    assert_array_equal(nist.forward_kinematics(q[part], near=near[part]), whole[part])


def test_the_row_that_fails_is_named_behind_the_first_block(nist):
    q = np.tile(nist.inverse_kinematics(nist.home), (forward.BLOCK + 10, 1))
    q[forward.BLOCK + 3] += [0.5, 0, 0.5, 0, 0.5, 0]
    with pytest.raises(KinematicsError, match=rf"^index \[{forward.BLOCK + 3}\]: forward kinematics found no pose"):
        nist.forward_kinematics(q)
    _, status = nist.forward_kinematics(q, on_fail="nan")
    assert status[forward.BLOCK + 3] == 2 and np.count_nonzero(status) == 1


def test_many_rows_take_the_memory_of_their_answers_and_little_more(nist):
    """No copy of the arguments, none of a wrench for every row: answers, the det J that is checked, small buffers."""
    count = 100_000
    x = np.tile(nist.home, (count, 1))
    zero, q = np.zeros((count, 6)), nist.inverse_kinematics(x)
    calls = {
        "inverse kinematics": (lambda: nist.inverse_kinematics(x), 6),
        "inverse dynamics": (lambda: nist.inverse_dynamics(x, zero, zero), 6 + 1),
        "forward dynamics": (lambda: nist.forward_dynamics(x, zero, zero), 6),
        "forward kinematics": (lambda: nist.forward_kinematics(q), 6 + 1),  # and the status
    }
    for name, (call, numbers) in calls.items():
        call()
        tracemalloc.start()
        call()
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        # conditions of a check are a byte a row; a block of forward kinematics has some 60 numbers a row
        assert peak < 8 * count * numbers + 2 * count + 80 * 8 * forward.BLOCK, name


def test_the_workspace_is_what_numpy_says_it_is(nist):
    """A second derivation of radius, height, tilt and turn, by rotations as matrices."""
    x = random_poses(nist, 200, np.random.default_rng(2)) + np.array([0.1, 0, 0.02, 0.1, 0, 0.3])
    R, R_home = rotation_of_abc_np(x[:, 3:]), rotation_of_abc_np(nist.home[3:])
    space, off = nist.limits.workspace, x[:, :3] - nist.home[:3]
    turn = abc_of_rotation_np(R)[:, 2] - nist.home[5]
    expected = np.stack([
        space.radius - np.hypot(off[:, 0], off[:, 1]), space.height / 2 - np.abs(off[:, 2]),
        space.tilt - np.arccos(np.clip(R[:, :, 2] @ R_home[:, 2], -1, 1)),
        space.c - np.abs(np.arctan2(np.sin(turn), np.cos(turn))),
    ], -1)  # fmt: skip
    found = workspace.workspace_margins(nist, nist.arrays.run("coordinates", x)[0])
    # 1e-9: what the edge is widened by; arccos loses half the digits near zero, 1e-8 of an angle
    np.testing.assert_allclose(found - 1e-9, expected, rtol=0, atol=2e-8)


def test_angles_of_a_rotation_are_the_same_symbolic_and_in_numpy():
    rng = np.random.default_rng(3)
    R_ = ca.SX.sym("R", 3, 3)
    angles = ca.Function("abc", [R_], [frames.abc_of_rotation(R_)])
    abc = rng.uniform(-np.pi, np.pi, (50, 3)) * [1, 0.5, 1]
    abc[:4, 1] = [np.pi / 2, -np.pi / 2, 0.0, np.pi / 2 - 1e-13]
    for one in rotation_of_abc_np(abc):
        assert np.abs(np.array(angles(one)).ravel() - abc_of_rotation_np(one)).max() < 1e-15 * 4


def test_an_answer_that_is_no_number_is_refused(nist):
    """A strut of no length has no direction; 1e200 m is no machine."""
    folded = np.concatenate([nist.joints.base[0] - nist.joints.platform[0], np.zeros(3)])
    for call in (nist.jacobian, nist.mass_matrix):
        with pytest.raises(SingularityError, match="has no finite answer here"):
            call(folded)
    with pytest.raises(SingularityError, match=r"index \[1\]: inverse kinematics has no finite answer"):
        nist.inverse_kinematics([nist.home, [1e200] * 6])
    with pytest.raises(SingularityError):
        nist.forward_dynamics(nist.home, [1e200] * 6, np.zeros(6))


@pytest.mark.parametrize(
    ("x", "message"),
    [
        ("abc", "pose must be real numbers, got 'abc'"),
        ([1, 2, 3], r"pose must have shape \(\.\.\., 6\), got \(3,\)"),
        ([0, 0, 0, 0, 0, np.nan], r"index \[5\]: pose must be finite, got nan"),
        (np.zeros(6, complex), "pose must be real numbers"),
        ([[0] * 6, [0] * 5], "pose must be real numbers"),
    ],
)
def test_what_is_no_pose_is_said(nist, x, message):
    with pytest.raises(ExperimentError, match=message):
        nist.inverse_kinematics(x)


def test_axes_that_do_not_fit_are_said(nist):
    with pytest.raises(ExperimentError, match=r"the leading axes do not fit together, got \(2, 6\), \(3, 6\), \(6,\)"):
        nist.forward_dynamics(np.zeros((2, 6)), np.zeros((3, 6)), np.zeros(6))
