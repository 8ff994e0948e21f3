"""How surely a force is told, by pose."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from gough.cutting.uncertainty import wrench_uncertainty
from gough.errors import ExperimentError
from gough.machine.workspace import random_poses


@pytest.fixture(scope="module")
def machine():
    return gk.load_machine("okuma-pm600")


def test_the_ellipsoid_is_how_errors_of_the_drives_scatter(machine):
    x = machine.home + [0.05, 0.02, 0.03, 0.1, -0.05, 0.02]
    sigma = np.array([5.0, 8.0, 3.0, 6.0, 4.0, 7.0])
    found = wrench_uncertainty(machine, x, sigma)
    errors = np.random.default_rng(1).normal(size=(200_000, 6)) * sigma
    wrench = errors @ machine.jacobian(x)
    # 200 000 draws: variances to 1 %
    assert_allclose(np.cov(wrench.T), found.covariance, rtol=0.02, atol=0.02 * found.covariance.max())
    along = wrench[:, :3] @ found.force_directions
    assert_allclose(along.std(0), found.force_axes, rtol=0.01)


def test_the_axes_fall_and_grow_with_the_deviation(machine):
    x = random_poses(machine, 20, np.random.default_rng(2))
    one, two = wrench_uncertainty(machine, x, 1.0), wrench_uncertainty(machine, x, 2.0)
    assert (np.diff(one.force_axes) <= 0).all() and (np.diff(one.moment_axes) <= 0).all()
    assert_allclose(two.force_axes, 2 * one.force_axes, rtol=1e-12)
    assert one.poor.shape == (20,)


def test_a_poor_pose_is_flagged(machine):
    strict = machine.replace(**{"limits.condition_warning": 3.0})
    x = np.array([machine.home, machine.home + [0, 0, 0, 0, np.radians(24), 0]])
    found = wrench_uncertainty(strict, x, 1.0)
    assert_allclose(found.poor, found.condition > 3.0)
    assert found.condition[1] > found.condition[0]


def test_what_it_cannot_tell_is_refused(machine):
    with pytest.raises(ExperimentError, match="only a machine with six freedoms tells all of a wrench, got ccu-3prs"):
        wrench_uncertainty(gk.load_machine("ccu-3prs"), np.zeros(3), 1.0)
    with pytest.raises(ExperimentError, match="deviation: must be finite and at least 0 N, got nan"):
        wrench_uncertainty(machine, machine.home, np.nan)
