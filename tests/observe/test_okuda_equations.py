"""Okuda et al. 2006, eqs. (5)-(14): the repairs by virtual work, and that the observer's terms are those equations."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from gough.frames import rotation_of_abc_np, rotation_of_vector_np
from gough.machine.workspace import random_poses
from gough.observe import kinetic
from oracle import okuda


@pytest.fixture(scope="module")
def machine():
    return gk.load_machine("okuma-pm600")


@pytest.fixture(scope="module")
def poses(machine):
    return random_poses(machine, 10, np.random.default_rng(5))


def at(machine, x):
    return okuda.pose(machine.joints.base, machine.joints.platform, x[:3], rotation_of_abc_np(x[3:]))


def moved(machine, x, twist):
    """The oracle's pose after a small twist, and the tip."""
    p = x[:3] + twist[:3]
    R = rotation_of_vector_np(twist[3:]) @ rotation_of_abc_np(x[3:])
    return okuda.pose(machine.joints.base, machine.joints.platform, p, R), p


def lengths_rate(where, twist):
    """L' of every strut, and the speeds of the platform joints, at a twist of the tip."""
    v_B = twist[:3] + np.cross(twist[3:], where.b)
    return np.sum(v_B * where.l, 1), v_B


def directions(count=6):
    return np.random.default_rng(1).normal(size=(count, 6)) * [1, 1, 1, 3, 3, 3]


def work_lost(machine, x, push):
    """Largest difference between the work of `push` and the energy gained, over small twists, N."""
    lost = []
    for twist in directions():
        h = 1e-5
        gained = [okuda.energy(*moved(machine, x, side * h * twist)) for side in (1, -1)]
        Ld, _ = lengths_rate(at(machine, x), twist)
        lost.append(abs(push @ Ld - (gained[0] - gained[1]) / (2 * h)))
    return max(lost)


def test_the_repaired_gravity_does_the_work_that_lifts_the_bodies(machine, poses):
    """Eq. (7) with g_hat + g_s.  Central differences of 1e-5: rounding of 2 kJ leaves 2e3 x 2e-16 / 1e-5 = 4e-8 W."""
    for x in poses:
        assert work_lost(machine, x, okuda.gravity(at(machine, x))) < 1e-5


def test_the_printed_sign_of_gravity_creates_energy(machine, poses):
    """Eq. (7) with g_hat - g_s misses the axial weight of the struts twice, 2 x 16 kg."""
    assert all(work_lost(machine, x, okuda.gravity(at(machine, x), sign=-1)) > 100 for x in poses)


def test_the_whole_strut_in_m_T_creates_energy(machine, poses):
    """Eq. (10) with "the total mass of one strut" carries the motor, which hangs on the base joint: 18 kg too much."""
    whole = 12.0 + 4.0 + 18.0
    assert all(work_lost(machine, x, okuda.gravity(at(machine, x), m_T=whole)) > 100 for x in poses)


def test_the_repaired_gravity_is_that_of_the_machine(machine, poses):
    """The sheet's moving part is screw and joint, its fixed part the motor: the same bodies."""
    for x in poses:
        rest = machine.inverse_dynamics(x, np.zeros(6), np.zeros(6))
        # 1e-9: forces through J'J, of a condition number below 100
        assert_allclose(okuda.gravity(at(machine, x)), rest, rtol=0, atol=1e-9 * np.abs(rest).max())


def friction_lost(machine, x, twist, **printed):
    """Power that f_hat gives, less what screws and base joints turn to heat."""
    f_0, t_0 = np.linspace(80, 100, 6), np.linspace(7, 9, 6)
    where = at(machine, x)
    Ld, v_B = lengths_rate(where, twist)
    across = np.linalg.norm(v_B - Ld[:, None] * where.l, axis=1)
    heat = f_0 @ np.abs(Ld) + (t_0 / where.L) @ across
    return okuda.friction(where, v_B, f_0, t_0, **printed) @ Ld - heat, heat


def test_the_repaired_friction_gives_the_heat_of_screws_and_joints(machine, poses):
    for x, twist in zip(poses, directions(10), strict=True):
        lost, heat = friction_lost(machine, x, twist)
        assert abs(lost) < 1e-10 * heat


def test_the_printed_sign_of_friction_gives_less_than_no_heat(machine, poses):
    """Eq. (11) with f_hat - f_b: the screws would drive the machine."""
    for x, twist in zip(poses, directions(10), strict=True):
        lost, heat = friction_lost(machine, x, twist, sign=-1)
        assert lost < -heat


def test_the_printed_direction_of_joint_friction_loses_heat(machine, poses):
    """Eq. (13) along d(L l)/dt: part of t_0 / L pushes along the strut, and less is left across it."""
    for x, twist in zip(poses, directions(10), strict=True):
        lost, heat = friction_lost(machine, x, twist, along=True)
        assert abs(lost) > 1e-3 * heat


def test_the_observers_friction_is_eqs_11_to_13(machine, poses):
    """u - F and F_p of observe/kinetic.py, on the twist, against f_hat, far from rest."""
    m = machine.replace(**{"friction.coulomb": np.linspace(80, 100, 6)})
    t_0, rest = np.linspace(7, 9, 6), 1e-9
    p, theta = m.symbols
    z, v, vd, net = (ca.SX.sym(name, k) for name, k in (("z", 7), ("v", 6), ("vd", 6), ("net", 6)))
    J = m.jacobian_of(p, z)
    pi = {key: value for key, (value, _) in m.inertial(p).items()}
    numbers = kinetic.numbers_at(m, p, pi, z, v, vd)
    passive = kinetic.passive_friction(m, p, z, v, vd, net, ca.DM(t_0), rest)
    asked = J.T @ kinetic.drive_friction(numbers, J @ v, rest) - passive
    f = ca.Function("f", [theta, z, v, vd, net], [asked])
    for x, twist in zip(poses, directions(10), strict=True):
        where = at(m, x)
        Ld, v_B = lengths_rate(where, twist)
        z0 = ca.DM(m.coordinates_of(m, ca.DM(x)))
        on_twist = np.array(f(m.theta, z0, twist, np.zeros(6), np.zeros(6))).ravel()
        push = np.linalg.solve(m.jacobian(x).T, on_twist)
        expected = okuda.friction(where, v_B, np.linspace(80, 100, 6), t_0)
        assert_allclose(push, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


def test_the_inertial_force_is_that_of_a_platform_without_struts(machine, poses):
    """Eq. (14) with N_F = -m_P a and rotational inertia neglected: exact for a translation."""
    bare = machine.replace(strut=None, gravity=[0, 0, 0], **{"drive.inertia": None, "friction": None})
    a = np.array([3.0, -2.0, 1.0, 0, 0, 0])
    for x in poses:
        push = bare.inverse_dynamics(x, np.zeros(6), a)
        assert_allclose(okuda.inertia(at(machine, x), a[:3], 150.0), push, rtol=0, atol=1e-8 * np.abs(push).max())


def test_what_actuators_add_is_the_force_on_the_tool_with_the_other_sign(machine, poses):
    """Eq. (5): sum d_j l_j of pushes beyond the weight is -f; and the moment, which the paper leaves out, -m."""
    w = np.array([300.0, -200.0, 100.0, 10.0, -20.0, 15.0])
    for x in poses:
        where = at(machine, x)
        d = machine.inverse_dynamics(x, np.zeros(6), np.zeros(6), w) - okuda.gravity(where)
        assert_allclose(where.l.T @ d, -w[:3], rtol=0, atol=1e-6)
        assert_allclose(np.cross(where.b, where.l).T @ d, -w[3:], rtol=0, atol=1e-6)
