"""The pose from measured joints: what the docstring of observe/forward.py promises of two Newton steps."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

import gough as gk
from gough.frames import (
    abc_of_rotation_np,
    abc_rate_matrix_np,
    quaternion_of_abc_np,
    rotation_of_abc_np,
    rotation_of_quaternion_np,
    rotation_of_vector_np,
    rotation_vector_np,
)
from gough.machine.workspace import random_poses
from gough.observe import forward


@pytest.fixture(scope="module", params=["nist-octahedral", "okuma-pm600"])
def machine(request):
    return gk.load_machine(request.param)


def observer(machine, period, iterations=2):
    """One sample in CasADi's interpreter: coordinates and twist from the last coordinates and the joints."""
    p, theta = machine.symbols
    z, q = ca.SX.sym("z", 7), ca.SX.sym("q", 6)
    found, V, _ = forward.estimate(machine, p, forward.Pose(z), q, period, iterations)
    f = ca.Function("observe", [theta, z, q], [found, V])
    return lambda z, q: tuple(np.array(out).ravel() for out in f(machine.theta, z, q))


def coordinates(x):
    return np.concatenate([x[:3], quaternion_of_abc_np(x[3:])])


def distance(z, x):
    """(m, rad) between coordinates z and a pose x."""
    R = rotation_of_quaternion_np(z[3:])
    return np.linalg.norm(z[:3] - x[:3]), np.linalg.norm(rotation_vector_np(R @ rotation_of_abc_np(x[3:]).T))


def test_two_steps_follow_a_tool_at_its_fastest(machine):
    """0.2 m/s and 0.5 rad/s at 1 ms: the start is 0.2 mm and 0.5 mrad away, the answer as good as rounding."""
    observe = observer(machine, 1e-3)
    rng = np.random.default_rng(0)
    for x in random_poses(machine, 20, rng):
        v, w = (
            scale * d / np.linalg.norm(d) for scale, d in zip((0.2e-3, 0.5e-3), rng.normal(size=(2, 3)), strict=True)
        )
        before = coordinates(x)
        R = rotation_of_vector_np(w) @ rotation_of_abc_np(x[3:])
        after = np.concatenate([x[:3] + v, abc_of_rotation_np(R)])
        z, V = observe(before, machine.inverse_kinematics(after))
        metres, radians = distance(z, after)
        # Newton squares a relative distance of 5e-4 twice, (5e-4)^4 = 6e-14, times the curvature of the struts over J
        assert metres < 1e-12 and radians < 1e-12
        np.testing.assert_allclose(V, np.concatenate([v, w]) / 1e-3, rtol=0, atol=1e-8)


def test_each_step_squares_the_distance(machine):
    """The order of Newton's method on SO(3); steps on roll, pitch and yaw would be linear away from c = 0."""
    x = machine.home + np.array([0.03, -0.02, 0.02, 0.1, -0.1, 0.3])
    target = x + np.array([4e-3, -3e-3, 2e-3, 0.01, 0.012, -0.01])
    q = machine.inverse_kinematics(target)
    far = [distance(coordinates(x), target)]
    for iterations in (1, 2):
        z, _ = observer(machine, 1e-3, iterations)(coordinates(x), q)
        far.append(distance(z, target))
    size = [m / 0.3 + r for m, r in far]  # both as angles, with a platform of 0.3 m
    order = np.log(size[2] / size[1]) / np.log(size[1] / size[0])
    assert 1.7 < order < 2.5


def test_the_twist_is_the_mean_one_of_the_sample(machine):
    """A steady turn about a tilted axis: the estimate is that axis times its rate, in W."""
    observe = observer(machine, 1e-3)
    x = machine.home + np.array([0.01, 0.02, 0.0, 0.1, 0.15, 0.2])
    abc_rate = np.array([0.3, -0.2, 0.4])
    after = x + np.concatenate([[0.1, 0.0, -0.05], abc_rate]) * 1e-3
    _, V = observe(coordinates(x), machine.inverse_kinematics(after))
    w = abc_rate_matrix_np((x + after)[3:] / 2) @ abc_rate  # at the middle of the sample
    # the mean over the sample differs from its middle by (w Ts)^2 / 24 of w
    np.testing.assert_allclose(V, np.concatenate([[0.1, 0.0, -0.05], w]), rtol=0, atol=1e-7)
