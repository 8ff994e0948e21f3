"""The machine on arrays: shapes, broadcasting, and no answer that is not a number."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import gough as gk
from gough.errors import ExperimentError, SingularityError


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
