"""The laws against the linear loops they are designed as: poles by another derivation."""

from __future__ import annotations

import numpy as np
import pytest

import gough as gk
from gough.errors import InputError
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


def test_the_cascade_has_the_poles_it_was_given_on_one_axis():
    """(s + 20)(s + 80)(s + 200), and the larger of the two K_v that give them."""
    axis, poles = gk.load_machine("emps").frictionless(), [20.0, 80.0, 200.0]
    law = gk.PID(poles=poles)
    # the delay of a sample in speed and force: K_D Ts = 300 x 2e-5 = 0.6 %, over the pole spacing
    assert_same_poles(decay_rates(axis, law), [-20.0, -80.0, -200.0], relative=0.02)
    K_v, w, w_i = law.gains(law)
    assert K_v > w_i > 0
    np.testing.assert_allclose([w, w * (K_v + w_i), w * w_i * K_v], [300, 21_600, 320_000], rtol=1e-14)


def test_the_gains_of_bouzgarrou_2001_are_those_of_a_cascade_with_round_numbers():
    """k_V = 50 and 100 1/s, k_I = 7500 and 3e4 1/s2 (MACHINES.md 4.2); the printed low k_p is no cascade's."""
    for gains, k_V, k_I in (([300, 2.25e4, 3.75e5], 50, 7500), ([600, 9e4, 3e6], 100, 30_000)):
        law = gk.PID(poles=-np.roots([1, *gains]).real)
        K_v, w, w_i = law.gains(law)
        np.testing.assert_allclose([K_v, w * w_i], [k_V, k_I], rtol=1e-12)
    assert not np.isreal(np.roots([1, 300, 2.25e3, 3.75e5])).all()


def test_poles_that_no_cascade_has_are_refused_with_by_how_much():
    text = r"poles: no cascade has these poles: K_v would not be real, got K_P\^2 / \(4 K_D K_I\) = 0\.7812"
    with pytest.raises(InputError, match=text):
        gk.PID(poles=[100.0, 100.0, 200.0])
    gk.PID(poles=[10.0, 30.0, 90.0])  # 1 : 3 : 9, as the message says


@pytest.mark.parametrize("law", [gk.PID, gk.ComputedTorque])
def test_a_law_is_tuned_in_one_way(law):
    with pytest.raises(InputError, match='bandwidth: is missing; write bandwidth = "1. Hz", or give three poles'):
        law()
    with pytest.raises(InputError, match="bandwidth: give (either bandwidth or|one of bandwidth and) poles; take "):
        law(bandwidth=10.0, poles=[10.0, 30.0, 90.0])


def test_gains_that_let_the_error_grow_are_refused():
    with pytest.raises(InputError, match=r"the error would grow: K_D K_P must be above K_I, got 200 1/s3"):
        gk.ComputedTorque(error_gains=[10.0, 20.0, 300.0])


@pytest.mark.quick("okuma-pm600")
def test_computed_torque_by_gains_swings_as_its_polynomial_does(machine):
    """The low gains as Bouzgarrou et al. 2001 print them: a pair at 35.6 1/s with a damping of 0.047."""
    gains = [300.0, 2.25e3, 3.75e5]
    roots = np.roots([1, *gains])
    assert sorted(-roots.real / np.abs(roots))[0] == pytest.approx(0.0467, abs=1e-4)
    found = decay_rates(machine, gk.ComputedTorque(error_gains=gains))
    # K_D Ts = 0.6 % of each pole's size moves a pole whose real part is a twentieth of it: 1 % of |pole|
    assert_same_poles(found, list(roots) * 6, relative=0.01)


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
