"""The laws against the linear loops they are designed as: poles by another derivation."""

from __future__ import annotations

import numpy as np
import pytest

import gough as gk
from gough.simulate import stability
from oracle.machines import MACHINES

PERIOD = 2e-5  # s: short against every pole, so the sampled loop is the continuous one to w Ts = 1 %


def decay_rates(machine, law):
    """Continuous poles, 1/s, of the sampled loop at home, without friction, slowest first."""
    law = law.on(machine, PERIOD)
    eigenvalues = stability.loop_eigenvalues(machine, law, PERIOD, 1)
    moving = eigenvalues[(np.abs(eigenvalues) > 0.5) & (np.abs(eigenvalues - 1) > 1e-7)]
    return np.log(moving) / PERIOD


@pytest.fixture(scope="module", params=["nist-octahedral", "okuma-pm600", "general"])
def machine(request):
    return MACHINES[request.param]()


def assert_same_poles(found, expected, relative):
    found, left = list(found), list(expected)
    assert len(found) == len(left)
    for pole in found:
        nearest = min(left, key=lambda other: abs(other - pole))
        left.remove(nearest)
        assert abs(pole - nearest) < relative * abs(nearest), (pole, nearest)


@pytest.mark.quick("okuma-pm600")
def test_computed_torque_has_the_poles_it_was_given_in_all_six_directions(machine):
    """(s + 60)(s + 100)(s + 200), six times: the model cancels masses and couplings."""
    found = decay_rates(machine, gk.ComputedTorque(poles=[60.0, 100.0, 200.0]))
    # half a sample of delay in the speed and half in the held force: K_D Ts = 360 x 2e-5 = 0.7 %, over the pole spacing
    assert_same_poles(found, [-60.0] * 6 + [-100.0] * 6 + [-200.0] * 6, relative=0.05)


def test_computed_torque_by_bandwidth_is_by_poles(machine):
    w = 2 * np.pi * 16.0
    law, same = gk.ComputedTorque(bandwidth=16.0), gk.ComputedTorque(poles=[w, w, 2 * w])
    np.testing.assert_allclose(law.gains(law), same.gains(same), rtol=1e-14)
    # Garagic and Srinivasan's 100 rad/s: K_D = 400, K_P = 5e4, K_I = 2e6
    np.testing.assert_allclose(
        same.replace(poles=[100.0, 100.0, 200.0]).gains(same.replace(poles=[100.0, 100.0, 200.0])), [400, 5e4, 2e6]
    )


@pytest.mark.quick("okuma-pm600")
def test_the_cascade_has_the_poles_of_its_coupled_joints(machine):
    """M_q q'' = D w (v_c - v + w_i int), v_c = K_v e: in each direction of M_q^-1 D with eigenvalue k,

    s^3 + k w s^2 + k w (K_v + w_i) s + k w K_v w_i = 0
    """
    law = gk.PID(bandwidth=8.0).on(machine, PERIOD)
    K_v, w, w_i = law.gains(law)
    J, M = machine.jacobian(machine.home), machine.mass_matrix(machine.home)
    spread = np.linalg.eigvals(J @ np.linalg.solve(M, J.T) * law.mass).real
    expected = [p for k in spread for p in np.roots([1, k * w, k * w * (K_v + w_i), k * w * K_v * w_i])]
    # k w Ts reaches 4.1 x 151 x 2e-5 = 1.2 %
    assert_same_poles(decay_rates(machine, gk.PID(bandwidth=8.0)), expected, relative=0.05)
