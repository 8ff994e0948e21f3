"""Kinematics of the library hexapods: inverse, forward, and their rates."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gough.frames import abc_of_rotation_np, rotation_of_abc_np, rotation_of_vector_np, rotation_vector_np
from gough.machine import forward
from gough.machine.workspace import random_poses
from oracle.machines import elementary

N = 100_000
FIVE_MM, ONE_DEG = 5e-3, np.radians(1)


def directions(rng, count):
    d = rng.normal(size=(count, 3))
    return d / np.linalg.norm(d, axis=1)[:, None]


def displaced(rng, x, distance, angle):
    """Poses `distance` m and `angle` rad away from x in random directions."""
    R = rotation_of_vector_np(directions(rng, len(x)) * angle) @ rotation_of_abc_np(x[:, 3:])
    return np.concatenate([x[:, :3] + distance * directions(rng, len(x)), abc_of_rotation_np(R)], -1)


def angle_between(x, y):
    R = rotation_of_abc_np
    return np.linalg.norm(rotation_vector_np(np.swapaxes(R(x[:, 3:]), -1, -2) @ R(y[:, 3:])), axis=-1)


# -- the promise of the issue -----------------------------------------------------------------------------------------


@pytest.mark.quick("okuma-pm600")
def test_forward_undoes_inverse_kinematics_from_5_mm_and_1_deg_away(library_machine):
    m, rng = library_machine, np.random.default_rng(100)
    x = random_poses(m, N, rng)
    found, status = m.forward_kinematics(
        m.inverse_kinematics(x), near=displaced(rng, x, FIVE_MM, ONE_DEG), on_fail="nan"
    )
    assert (status == 0).all()
    assert np.linalg.norm(found[:, :3] - x[:, :3], axis=1).max() < 1e-10  # m
    assert angle_between(found, x).max() < 1e-10  # rad


@pytest.mark.quick("okuma-pm600")
def test_forward_kinematics_from_home_is_right_or_refused(library_machine):
    m, rng = library_machine, np.random.default_rng(101)
    x = random_poses(m, N, rng)
    found, status = m.forward_kinematics(m.inverse_kinematics(x), on_fail="nan")
    ok = status == 0
    assert np.linalg.norm(found[ok, :3] - x[ok, :3], axis=1).max() < 1e-10
    assert angle_between(found[ok], x[ok]).max() < 1e-10
    assert np.isnan(found[~ok]).all()
    assert ok.all(), "both sheets say that forward kinematics from home is right in all of the workspace"


def test_hostile_starts_are_never_answered_with_a_wrong_pose(library_machine):
    """Starts half a metre away and turned any way: most end in no answer, none in one of another assembly mode."""
    m, rng = library_machine, np.random.default_rng(102)
    x = random_poses(m, 20_000, rng)
    q = m.inverse_kinematics(x)
    near = np.concatenate([m.home[:3] + rng.normal(size=(len(x), 3)) * 0.5, rng.uniform(-np.pi, np.pi, (len(x), 3))], 1)
    found, status = m.forward_kinematics(q, near=near, on_fail="nan")
    ok = status == 0
    assert ok.any() and (status == 3).any() and (status == 2).any(), "starts of every fate"
    assert np.isnan(found[~ok]).all()
    assert np.abs(m.inverse_kinematics(found[ok]) - q[ok]).max() < 1e-10
    assert (np.linalg.det(m.jacobian(found[ok])) * np.linalg.det(m.jacobian(m.home)) > 0).all()
    assert angle_between(found[ok], x[ok]).max() < 1e-8 and np.abs(found[ok] - x[ok])[:, :3].max() < 1e-8


def test_newton_on_rotations_converges_quadratically(nist):
    """Four to six iterations from 5 mm and 1 deg; rotation increments added to roll, pitch and yaw need 15 and more."""
    rng = np.random.default_rng(103)
    x = random_poses(nist, 1000, rng)
    q = nist.inverse_kinematics(x)
    _, steps = forward.newton(nist, q, displaced(rng, x, FIVE_MM, ONE_DEG), np.ones(len(x), bool))
    assert steps.max() <= 6


@pytest.mark.parametrize("b", [60, 85, 90])
def test_forward_kinematics_do_not_care_how_steep_the_machine_stands_in_W(okuma, b):
    """Rotation increments added to roll, pitch and yaw diverge beyond 55 deg; on SO(3) it takes the same few steps."""
    Q = elementary(1, np.radians(b))
    turned = okuma.replace(**{
        "joints.base": okuma.joints.base @ Q.T, "joints.base_axis": okuma.joints.base_axis @ Q.T,
        "limits.workspace": None,
        "home": np.r_[Q @ okuma.home[:3], abc_of_rotation_np(Q @ rotation_of_abc_np(okuma.home[3:]))],
    })  # fmt: skip
    rng = np.random.default_rng(104)
    x = random_poses(okuma, 200, rng)
    x = np.concatenate([x[:, :3] @ Q.T, abc_of_rotation_np(Q @ rotation_of_abc_np(x[:, 3:]))], 1)
    q, near = turned.inverse_kinematics(x), displaced(rng, x, FIVE_MM, ONE_DEG)
    z, steps = forward.newton(turned, q, near, np.ones(len(x), bool))
    assert turned.arrays.run("landing", z, q)[1].max() < 1e-13 and steps.max() <= 6
    assert angle_between(turned.forward_kinematics(q, near=near), x).max() < 1e-10


# -- rates ------------------------------------------------------------------------------------------------------------


def path(m, t, rng):
    """A smooth motion through home's neighbourhood: poses at times t (n,), and its twist and twist rate at t = 0.

    p = p0 + v t + a t^2 / 2;  R = exp(w t + wd t^2 / 2) R0, whose angular velocity at 0 is w and its rate wd.
    """
    x0 = random_poses(m, 1, rng)[0]
    v, a, w, wd = (rng.normal(size=3) for _ in range(4))
    t = np.asarray(t)[:, None]
    R = rotation_of_vector_np(w * t + wd * t**2 / 2) @ rotation_of_abc_np(x0[3:])
    return np.concatenate([x0[:3] + v * t + a * t**2 / 2, abc_of_rotation_np(R)], 1), np.r_[v, w], np.r_[a, wd]


@pytest.mark.quick("nist-octahedral", "full-general")
def test_joint_rates_and_accelerations_are_the_differences_of_lengths(machine):
    rng = np.random.default_rng(105)
    h = 1e-3
    for _ in range(50):
        x, V, Vd = path(machine, h * np.arange(-3, 4), rng)
        q, (_, qd, qdd) = machine.inverse_kinematics(x), machine.joint_motion(x[3], V, Vd)
        # central differences of sixth order: h^6 = 1e-18 in truth, 1e-16 / h^2 = 1e-10 of rounding
        assert_allclose(np.array([-1, 9, -45, 0, 45, -9, 1]) / 60 / h @ q, qd, atol=1e-10)
        assert_allclose(np.array([2, -27, 270, -490, 270, -27, 2]) / 180 / h**2 @ q, qdd, atol=1e-8)
        assert_allclose(machine.jacobian(x[3]) @ V, qd, atol=1e-13)


def test_a_row_of_the_jacobian_is_direction_and_moment_of_its_strut(machine):
    x = random_poses(machine, 5, np.random.default_rng(106))
    for pose, J in zip(x, machine.jacobian(x), strict=True):
        R = elementary(2, pose[5]) @ elementary(1, pose[4]) @ elementary(0, pose[3])
        B = pose[:3] + machine.platform_joints_np() @ R.T
        s = B - machine.joints.base
        n = s / np.linalg.norm(s, axis=1)[:, None]
        assert_allclose(J, np.concatenate([n, np.cross(B - pose[:3], n)], 1), atol=1e-15)


def test_arrays_keep_leading_axes_and_rows_do_not_depend_on_their_company(okuma):
    x = random_poses(okuma, 24, np.random.default_rng(107)).reshape(2, 3, 4, 6)
    q = okuma.inverse_kinematics(x)
    assert q.shape == (2, 3, 4, 6) and okuma.jacobian(x).shape == (2, 3, 4, 6, 6)
    assert okuma.forward_kinematics(q).shape == x.shape and okuma.forward_kinematics(q[0, 0, 0]).shape == (6,)
    assert np.array_equal(okuma.inverse_kinematics(x[1, 2, 3]), q[1, 2, 3])
    assert okuma.inverse_dynamics(x, np.zeros(6), np.zeros(6), wrench=np.ones(6)).shape == x.shape
