"""Computed torque on the hybrid machine against eqs. (4)-(9) of Bouzgarrou et al. 2001, written once more in NumPy."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from gough.control.base import Measurement
from gough.control.computed_torque import State
from gough.kernel.pack import flatten, symbols
from gough.machine.workspace import random_poses
from gough.observe.forward import Pose
from gough.simulate import stability, tick
from oracle.hybrid_lagrange import Partitioned

PERIOD = 1e-4
GAINS = (300.0, 2.25e4, 3.75e5)  # 1/s, 1/s2, 1/s3: the low ones, k_p repaired


@pytest.fixture(scope="module")
def hsm():
    return gk.load_machine("ifma-hsm")


def test_computed_torque_on_the_slides_is_that_of_the_paper(hsm):
    """u = M_S (s_d'' + K_D (s_d' - s') + K_P (s_d - s) + K_I int) + C_S s' + G_S, C_S repaired, by their blocks."""
    law, paper, rng = gk.ComputedTorque(error_gains=GAINS).on(hsm, PERIOD), Partitioned(hsm), np.random.default_rng(7)
    forces = forces_of(law, hsm)
    K_D, K_P, K_I = GAINS
    for x in random_poses(hsm, 20, rng):
        xd, xdd = rng.normal(size=3), rng.normal(size=3) * 10
        s_d, sd_d, sdd_d = hsm.joint_motion(x, xd, xdd)
        row = tick.rest_row(hsm, x)._replace(xd=xd, xdd=xdd, q=s_d, qd=sd_d, qdd=sdd_d)
        s = s_d + rng.normal(size=3) * 1e-3
        before = s - PERIOD * (sd_d + rng.normal(size=3) * 0.1)
        now, then = (hsm.coordinates(hsm.forward_kinematics(q)) for q in (s, before))
        integral = rng.normal(size=3) * 1e-4
        u = forces(State(Pose(then), integral, np.zeros(3)), row, Measurement(s, np.zeros(3)))
        v = (now[:3] - then[:3]) / PERIOD
        reduced = paper.at(now, v)
        u_0 = reduced.M @ (sdd_d + K_D * (sd_d - v) + K_P * (s_d - now[:3]) + K_I * integral)  # their (8)
        expected = u_0 + reduced.C @ v + reduced.G  # (7)
        # the pose after two Newton steps from 0.2 mm away is right to 1e-12 m; over a sample, K_D and M: 1e-3 N
        assert_allclose(u, expected, rtol=1e-9, atol=1e-2)


def forces_of(law, machine):
    """(state, reference, measurement) -> u, by CasADi's interpreter."""
    theta, rest = ca.SX.sym("theta", len(law.theta)), tick.rest_row(machine, machine.home)
    trees = [symbols(tree) for tree in (law.init(rest, np.zeros(3)), rest, Measurement(rest.q, np.zeros(3)))]
    command, _ = law.step(*trees, theta)
    f = ca.Function("u", [*(ca.SX(flatten(tree)) for tree in trees), theta], [ca.SX(command.u)])
    return lambda *values: np.array(f(*(flatten(value) for value in values), law.theta)).ravel()


@pytest.mark.parametrize("place", [[0.0, 1.2, 0.0], [-0.315, 1.83, 0.55]], ids=["start", "end"])
def test_its_error_has_the_poles_of_the_gains_at_both_ends_of_the_move(hsm, place):
    """(9) of the paper, three times, whatever the pose: the sampled loop at 20 us."""
    period, m = 2e-5, hsm.replace(home=place, **{"limits.workspace": None})
    law = gk.ComputedTorque(error_gains=GAINS).on(m, period)
    eigenvalues = stability.loop_eigenvalues(m, law, period, 1)
    moving = eigenvalues[(np.abs(eigenvalues) > 0.5) & (np.abs(eigenvalues - 1) > 1e-7)]
    found = np.sort((np.log(moving) / period).real)
    # half a sample of delay in speed and half in the held force: K_D Ts = 0.6 %, over the pole spacing
    assert_allclose(found, np.sort(np.repeat(np.roots([1, *GAINS]).real, 3)), rtol=0.02)


def test_the_mass_of_the_cascade_is_the_diagonal_of_m_s_at_the_start(hsm):
    """MACHINES.md 4.3: 706, 711 and 316 kg, the paper's "mean mass"."""
    law = gk.PID(poles=[20.0, 80.0, 200.0]).on(hsm, PERIOD)
    assert_allclose(law.mass, [706, 711, 316], rtol=0, atol=0.5)
    assert_allclose(law.mass, np.diag(Partitioned(hsm).at(hsm.coordinates(hsm.home), np.zeros(3)).M), rtol=1e-12)
    assert len(flatten(law.init(tick.rest_row(hsm, hsm.home), np.zeros(3)))) == 9
