"""The laws against their equations written once more in NumPy, at states where no term vanishes."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from gough.control.base import Measurement
from gough.control.computed_torque import State
from gough.frames import (
    abc_of_rotation_np,
    quaternion_of_rotation_np,
    rotation_of_abc_np,
    rotation_of_vector_np,
    rotation_vector_np,
)
from gough.kernel.pack import flatten, unflatten
from gough.observe.forward import Pose
from gough.simulate import tick

PERIOD = 1e-3


@pytest.fixture(scope="module")
def machine():
    return gk.load_machine("okuma-pm600")


def stepped(law, state, r, y):
    """Force and next state, by CasADi's interpreter."""
    theta = ca.SX.sym("theta", len(law.theta))
    command, after = law.step(state, r, y, theta)
    u, after = ca.Function("step", [theta], [ca.SX(command.u), ca.SX(flatten(after))])(law.theta)
    return np.array(u).ravel(), unflatten(state, np.array(after).ravel())


def moving(machine, seed):
    """A row of the reference that moves and turns, and the same place seen a little off it, now and a sample ago."""
    rng = np.random.default_rng(seed)
    x, V, Vd = machine.home + 0.03 * rng.normal(size=6), 0.1 * rng.normal(size=6), rng.normal(size=6)
    q, qd, qdd = machine.joint_motion(x, V, Vd)
    row = tick.rest_row(machine, x)._replace(xd=V, xdd=Vd, q=q, qd=qd, qdd=qdd)

    def off(size):
        R = rotation_of_vector_np(size * rng.normal(size=3)) @ rotation_of_abc_np(x[3:])
        return np.concatenate([x[:3] + size * rng.normal(size=3), abc_of_rotation_np(R)])

    return row, off(1e-4), off(2e-4), rng


@pytest.mark.parametrize("seed", range(5))
def test_the_cascade_is_its_equations(machine, seed):
    law = gk.PID(
        bandwidth=9.0, derivative=2e-3, feedforward=0.8, acceleration_feedforward=0.7, mass=np.arange(200.0, 800, 100)
    ).on(machine, PERIOD)
    r, now, before, rng = moving(machine, seed)
    q, q_ = machine.inverse_kinematics(now), machine.inverse_kinematics(before)
    speed, integral = rng.normal(size=6) * 0.1, rng.normal(size=6) * 1e-3
    state = law.init(r, np.zeros(6))._replace(position=q_, speed=speed, integral=integral)
    u, after = stepped(law, state, r, Measurement(q, np.zeros(6)))
    K_v = 2 * np.pi * 9.0
    w, w_i = 3 * K_v, K_v / 2
    v = (q - q_) / PERIOD  # (1)
    v_c = 0.8 * r.qd + K_v * (r.q - q)  # (2)
    expected = law.mass * (w * ((v_c - v) + w_i * integral - 2e-3 * (v - speed) / PERIOD) + 0.7 * r.qdd)  # (4)
    assert_allclose(u, expected, rtol=1e-12, atol=1e-9 * np.abs(expected).max())
    assert_allclose(after.integral, integral + PERIOD * (v_c - v), rtol=1e-12)  # (3)
    assert_allclose(after.position, q, rtol=1e-15)
    assert_allclose(after.speed, v, rtol=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_computed_torque_is_its_equations(machine, seed):
    law = gk.ComputedTorque(poles=[50.0, 90.0, 170.0]).on(machine, PERIOD)
    r, now, before, rng = moving(machine, seed)
    integral, started = rng.normal(size=6) * 1e-5, rng.normal(size=6) * 50
    R, R_ = rotation_of_abc_np(now[3:]), rotation_of_abc_np(before[3:])
    state = State(Pose(np.concatenate([before[:3], quaternion_of_rotation_np(R_)])), integral, started)
    u, after = stepped(law, state, r, Measurement(machine.inverse_kinematics(now), np.zeros(6)))
    V = np.concatenate([now[:3] - before[:3], rotation_vector_np(R @ R_.T)]) / PERIOD
    e = np.concatenate([r.x[:3] - now[:3], rotation_vector_np(rotation_of_abc_np(r.x[3:]) @ R.T)])  # (1)
    a, b, c = 50.0, 90.0, 170.0
    rate = r.xdd + (a + b + c) * (r.xd - V) + (a * b + b * c + a * c) * e + a * b * c * integral  # (3)
    J = machine.jacobian(now)
    expected = machine.inverse_dynamics(now, V, rate) + np.linalg.solve(J.T, started)  # (4)
    # the pose after two Newton steps is right to 1e-12 m; over a sample and times K_D and the mass that is 1e-4 N
    assert_allclose(u, expected, rtol=1e-9, atol=1e-3)
    assert_allclose(after.integral, integral + PERIOD * e, rtol=1e-8, atol=1e-14)  # (2)
    assert_allclose(after.observer.pose[:3], now[:3], atol=1e-12)
