"""The hybrid machine against Lagrange's equations of three coordinates, and the paper's own elimination in six."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gough.machine.sheet import load_machine
from gough.machine.workspace import random_poses

from .hybrid_lagrange import Lagrange, Partitioned

COUNT = 100
# rounding of the largest of some 1e5 N: products of seven bodies, divided by cos(phi) > 0.9
AGREE = 1e-12


def skewed():
    """ifma-hsm with nothing left at zero: centres and inertias of any kind, gravity askew."""
    m = load_machine("ifma-hsm")
    return m.replace(
        name="skewed", gravity=[2.0, -8.5, 3.0],
        link2=m.link2.replace(center=[0.6, -0.2, 0.1], inertia=[[22, 1, -2], [1, 18, 3], [-2, 3, 25]]),
        link5=m.link5.replace(center=[-0.1, 0.25, -0.05], inertia=[[6, 0.5, 1], [0.5, 5, -0.4], [1, -0.4, 8]]),
        ram=m.ram.replace(center=[0.1, -0.15, -0.3], inertia=[[30, 2, 1], [2, 28, -3], [1, -3, 14]]),
    )  # fmt: skip


MACHINES = {"ifma-hsm": lambda: load_machine("ifma-hsm"), "skewed": skewed}


@pytest.fixture(params=MACHINES, scope="module")
def case(request):
    """Machine, oracle, and random places, speeds and accelerations of the slides; up to 3 m/s and 20 m/s2."""
    m, rng = MACHINES[request.param](), np.random.default_rng(21)
    x = random_poses(m, COUNT, rng)
    return m, Lagrange(m), m.coordinates(x), rng.normal(size=(COUNT, 3)) * 1.5, rng.normal(size=(COUNT, 3)) * 15


def test_the_tip_is_where_the_lengths_of_the_slides_put_it(case):
    m, oracle, z, *_ = case
    wanted = np.array([oracle.tip(row[:3])[0] for row in z])
    assert_allclose(m.forward_kinematics(z[:, :3]), wanted, rtol=0, atol=1e-14)


def test_inverse_dynamics_are_those_of_lagranges_equations(case):
    m, oracle, z, sd, sdd = case
    x, xd, xdd = task(m, z, sd, sdd)
    wanted = np.array([oracle.force(*row) for row in zip(z[:, :3], sd, sdd, strict=True)])
    assert_allclose(m.inverse_dynamics(x, xd, xdd), wanted, rtol=0, atol=AGREE * np.abs(wanted).max())


def test_forward_dynamics_are_those_of_lagranges_equations(case):
    m, oracle, z, sd, sdd = case
    x, xd, xdd = task(m, z, sd, sdd)
    u = np.array([oracle.force(*row) for row in zip(z[:, :3], sd, sdd, strict=True)])
    assert_allclose(m.forward_dynamics(x, xd, u), xdd, rtol=0, atol=AGREE * np.abs(xdd).max())


def test_a_wrench_on_the_tool_does_the_work_of_its_tip_and_its_turning(case):
    """-u = J_T' w by the tip's Jacobian of the oracle, and by phi' = (s65' - s21') / (2 b cos phi)."""
    m, oracle, z, *_ = case
    rng, b = np.random.default_rng(2), m.base.half_width
    w = rng.normal(size=(COUNT, 6)) * 500
    x = m.forward_kinematics(z[:, :3])
    u = m.inverse_dynamics(x, 0 * x, 0 * x, w) - m.inverse_dynamics(x, 0 * x, 0 * x)
    for row in range(COUNT):
        _, J = oracle.tip(z[row, :3])
        turn = np.array([-1, 1, 0]) / (2 * b * np.cos(z[row, 4]))
        assert_allclose(-u[row], J.T @ w[row, :3] + turn * w[row, 5], rtol=0, atol=1e-11 * np.abs(u).max())


def task(m, z, sd, sdd):
    """The tip's place, speed and acceleration of slides at s, s', s'': the machine's own J, which others test."""
    x = m.forward_kinematics(z[:, :3])
    J = m.jacobian(x)
    xd = np.linalg.solve(J, sd[..., None])[..., 0]
    bias = m.joint_motion(x, xd, 0 * xd)[2]
    return x, xd, np.linalg.solve(J, (sdd - bias)[..., None])[..., 0]


# -- the paper's elimination ------------------------------------------------------------------------------------------


def test_the_repaired_c_s_of_the_paper_is_lagranges_and_the_printed_one_is_not(case):
    """Their C_S after eq. (6) lacks Phi_phi^-1 behind M_phiphi; its unit is wrong too."""
    m, oracle, z, sd, sdd = case
    paper, worst, scale = Partitioned(m), 0.0, 0.0
    for q, v, a in zip(z, sd, sdd, strict=True):
        found, wanted = paper.at(q, v), oracle.force(q[:3], v, a)
        assert_allclose(found.M @ a + found.C @ v + found.G, wanted, rtol=0, atol=1e-11 * np.abs(wanted).max())
        rest = oracle.force(q[:3], 0 * v, 0 * v)
        coriolis = oracle.force(q[:3], v, 0 * v) - rest
        worst = max(worst, np.abs(found.printed @ v - coriolis).max())
        scale = max(scale, np.abs(coriolis).max())
    # Phi_phi is some 2 b = 1.8 m, so what it divides is off by as much: the forces are wrong by more than they are
    assert worst > scale


def test_whole_dynamics_reduce_to_the_machines_own_by_the_papers_blocks():
    """M_S by eq. (6) of the paper from `Partitioned` is `velocity_mass`, block by block."""
    m = skewed()
    x = random_poses(m, 20, np.random.default_rng(4))
    paper = Partitioned(m)
    wanted = np.array([paper.at(q, np.zeros(3)).M for q in m.coordinates(x)])
    assert_allclose(m.velocity_mass(x), wanted, rtol=0, atol=1e-12 * np.abs(wanted).max())
