"""Linear models at rest: against the machine's own arrays, closed forms, and loops written down by hand."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from gough.errors import ExperimentError, SingularityError
from gough.frames import abc_of_rotation_np, abc_rate_matrix_np, rotation_of_abc_np, rotation_of_vector_np
from gough.simulate.bandwidth import bandwidth_of, response, with_bandwidth
from gough.simulate.loop import Loop, closed_loop, loop_eigenvalues

SHORT = 2e-5  # s: the sampled loop is the continuous one but for w Ts, some 0.7 % at the bandwidths below
POLES = gk.ComputedTorque(poles=[100.0, 100.0, 200.0])
SURFACE = gk.RobustAdaptive(slope=150.0, damping=370.0)


@pytest.fixture(scope="module")
def nist():
    return gk.load_machine("nist-octahedral")


def moved(x, d):
    """The pose x displaced by d = [dp; rotation vector] in axes of W."""
    return np.concatenate([x[:3] + d[:3], abc_of_rotation_np(rotation_of_vector_np(d[3:]) @ rotation_of_abc_np(x[3:]))])


# -- the plant ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["nist-octahedral", "okuma-pm600"])
def test_the_plant_is_the_derivative_of_forward_dynamics(name):
    machine = gk.load_machine(name)
    x = machine.home + np.array([0.05, -0.03, 0.02, 0.1, -0.08, 0.12])
    A, B, C, D = gk.linearize(machine, x)
    u0, still = machine.inverse_dynamics(x, np.zeros(6), np.zeros(6)), np.zeros(6)
    h = 1e-5  # of central differences: errors of h^2 times third derivatives, and of rounding, 1e-16 g / h = 1e-10

    def slopes(f):
        return np.stack([(f(d) - f(-d)) / (2 * h) for d in h * np.eye(6)], -1)

    pose = slopes(lambda d: machine.forward_dynamics(moved(x, d), still, u0))
    twist = slopes(lambda d: machine.forward_dynamics(x, d, u0))
    assert_allclose(A[:6], np.hstack([np.zeros((6, 6)), np.eye(6)]))
    assert_allclose(A[6:, :6], pose, atol=1e-7 * np.abs(pose).max())
    assert_allclose(A[6:, 6:], twist, atol=1e-7)  # Coriolis forces are of second order in the speed
    assert_allclose(B[6:], np.linalg.solve(machine.mass_matrix(x), machine.jacobian(x).T), rtol=1e-9, atol=1e-15)
    assert not B[:6].any() and not D.any() and not C[:, 6:].any()
    assert_allclose(C[:, :6], slopes(lambda d: moved(x, d)), atol=1e-9)
    assert_allclose(C[3:, 3:6], np.linalg.inv(abc_rate_matrix_np(x[3:])), atol=1e-12)


def test_without_gravity_no_force_turns_with_the_pose(nist):
    A = gk.linearize(nist.replace(gravity=[0, 0, 0.0]), nist.home).A
    assert not np.abs(A[6:]).max()


@pytest.mark.full
def test_scipy_takes_it_as_it_is(nist):
    """A force held for t lifts the tool by a t^2 / 2 of that force's acceleration, but for gravity's stiffness."""
    from scipy.signal import StateSpace, lsim

    bare = nist.replace(gravity=[0, 0, 0.0])
    t = np.linspace(0, 0.01, 11)
    u = np.tile([10.0, 0, 0, 0, 0, -5.0], (11, 1))
    _, x, _ = lsim(StateSpace(*gk.linearize(bare, bare.home)), u, t)
    a = bare.forward_dynamics(bare.home, np.zeros(6), u[0])
    assert_allclose(x, a * t[:, None] ** 2 / 2, rtol=1e-9, atol=1e-18)


def test_poses_that_have_no_linear_model_are_refused(nist):
    with pytest.raises(ExperimentError, match=r"pose must have shape \(..., 6\), got \(5,\)"):
        gk.linearize(nist, np.zeros(5))
    with pytest.raises(ExperimentError, match=r"x: linearize takes one pose, got shape \(2, 6\)"):
        gk.linearize(nist, np.zeros((2, 6)))
    turned = nist.replace(gravity=[9.81, 0, 0])  # the same machine in a W that lies on its side: b is 90 deg at home
    R = rotation_of_abc_np(np.array([0, np.pi / 2, 0]))
    side = turned.replace(**{"joints.base": nist.joints.base @ R.T, "joints.base_axis": nist.joints.base_axis @ R.T,
                             "home": [0, 0, 0, 0, np.pi / 2, 0]})  # fmt: skip
    with pytest.raises(SingularityError, match=r"a b c have no rates, got b = 1.5708 rad"):
        gk.linearize(side, side.home)


# -- closed loops ---------------------------------------------------------------------------------------------------


def transfer(numerator, denominator, f):
    s = 2j * np.pi * f
    return np.polyval(numerator, s) / np.polyval(denominator, s)


@pytest.mark.parametrize("axis", range(6))
def test_computed_torque_is_its_closed_form_in_the_continuous_limit(nist, axis):
    """(K_P s + K_I) / (s^3 + K_D s^2 + K_P s + K_I) with poles 100, 100, 200."""
    space, f = closed_loop(nist, POLES, SHORT, 1), np.geomspace(0.1, 200, 40)
    wanted = transfer([5e4, 2e6], [1, 400, 5e4, 2e6], f)
    # half a sample in the speed, half in the held force: a phase of w Ts = 2.5 % at 200 Hz, times K_D / w = 0.3
    assert_allclose(response(space, SHORT, f, axis), wanted, atol=0.01)


@pytest.mark.quick("robust_adaptive")
@pytest.mark.parametrize("law", [SURFACE, gk.FuzzyFriction(slope=150.0, damping=370.0)], ids=lambda law: law.kind)
def test_a_sliding_law_is_its_closed_form_in_the_continuous_limit(nist, law):
    """L k / (s^2 + (L + k) s + L k): friction has no part in it, nor has adaptation."""
    space, f = closed_loop(nist, law, SHORT, 1), np.geomspace(0.1, 200, 40)
    wanted = transfer([150 * 370.0], [1, 520.0, 150 * 370.0], f)
    for axis in range(6):
        assert_allclose(response(space, SHORT, f, axis), wanted, atol=0.01)


@pytest.mark.quick("0")
@pytest.mark.parametrize("delay", [0, 1])
def test_computed_torque_at_1_khz_is_a_sampled_double_integrator_under_its_law(nist, delay):
    """Four lines of the loop by hand, one axis: exact sampling of p'' = a, speed by difference, Euler's integral.

    What the tool hangs in is a stiffness of 7 to 54 1/s2 on K_P = 5e4: 0.1 %.
    """
    Ts, f = 1e-3, np.geomspace(0.1, 400, 30)
    machine = nist.replace(**{"drive.delay": delay})
    G = response(closed_loop(machine, POLES, Ts, 4), Ts, f, 0)
    z = np.exp(2j * np.pi * f * Ts)
    # p = P a with P = Ts^2 (z + 1) / (2 (z - 1)^2) / z^d,
    # a = K_P (r - p) + K_I Ts / (z - 1) (r - p) - K_D (1 - 1/z) / Ts p
    P = Ts**2 * (z + 1) / (2 * (z - 1) ** 2) / z**delay
    forward = P * (5e4 + 2e6 * Ts / (z - 1))
    by_hand = forward / (1 + forward + P * 400 * (1 - 1 / z) / Ts)
    assert_allclose(G, by_hand, atol=3e-3)


def test_a_small_step_of_the_reference_is_answered_as_the_linear_loop_says(nist):
    """The tick itself, iterated over 100 samples from a reference that has jumped by 10 um and 10 urad."""
    loop = Loop(nist, POLES.on(nist, 1e-3), 1e-3, 4, nist.home)
    A, B = loop.jacobians()
    s0 = np.concatenate(list(loop.states.values()))
    d = 1e-5 * np.array([1.0, -0.5, 0.3, 0.7, -1.0, 0.2])
    from gough.kernel.pack import flatten
    from gough.simulate import tick

    row = flatten(tick.rest_row(loop.machine, nist.home + d))
    s, ds = s0, np.zeros(len(s0))
    for _ in range(100):
        s, ds = np.array(loop.step(np.concatenate([s, row]))).ravel(), A @ ds + B @ d
    where = loop.rows["z"]
    assert np.abs(ds[where][:3]).max() > 5e-6
    # curvature: displacement squared over the struts' length and the platform's radius, 1e-10 / 0.35
    assert_allclose((s - s0)[where], ds[where], atol=3e-9)


def test_frozen_adaptation_is_adaptation_at_rate_zero(nist):
    still = SURFACE.replace(inertia_rate=0.0, coulomb_rate=0.0, viscous_rate=0.0)
    f = np.geomspace(1, 300, 10)
    frozen = response(closed_loop(nist, SURFACE, 1e-3, 4), 1e-3, f, 0)
    assert_allclose(frozen, response(closed_loop(nist, still, 1e-3, 4, frozen=False), 1e-3, f, 0), rtol=1e-6)
    learning = response(closed_loop(nist, SURFACE.replace(inertia_rate=100.0), 1e-3, 4, frozen=False), 1e-3, f, 2)
    frozen = response(closed_loop(nist, SURFACE, 1e-3, 4), 1e-3, f, 2)
    assert np.abs(learning / frozen - 1).max() > 1e-3  # masses learned from the weight act as an integral


def test_the_loop_has_the_eigenvalues_that_a_run_is_judged_by(nist):
    """Those of `spectral_radius`, less what stays as it is: eigenvalues of exactly 1."""
    law = POLES.on(nist, 1e-3)
    every = np.sort(np.abs(loop_eigenvalues(nist, law, 1e-3, 4)))[::-1]
    left = np.sort(np.abs(np.linalg.eigvals(closed_loop(nist, law, 1e-3, 4).A)))[::-1]
    gone = len(every) - len(left)
    assert gone == 6  # `started`
    assert_allclose(every[:gone], 1, atol=1e-8)
    assert_allclose(every[gone:][:30], left[:30], atol=1e-6)


# -- bandwidths -----------------------------------------------------------------------------------------------------


def test_bandwidths_are_those_of_the_closed_forms(nist):
    def minus_3_db(numerator, denominator):
        f = np.geomspace(1, 200, 200_001)
        return f[np.argmax(np.abs(transfer(numerator, denominator, f)) < 1 / np.sqrt(2))]

    # w Ts = 0.4 % at the bandwidth, and K_D Ts = 0.8 % of damping
    assert bandwidth_of(nist, POLES, SHORT) == pytest.approx(minus_3_db([5e4, 2e6], [1, 400, 5e4, 2e6]), rel=0.01)
    assert bandwidth_of(nist, SURFACE, SHORT) == pytest.approx(minus_3_db([55500.0], [1, 520.0, 55500.0]), rel=0.01)
    # (w^2 + L^2) (w^2 + k^2) = 2 (L k)^2 by hand
    w2 = (np.sqrt((150**2 + 370**2) ** 2 + 4 * 55500.0**2) - 150**2 - 370**2) / 2
    assert bandwidth_of(nist, SURFACE, SHORT) == pytest.approx(np.sqrt(w2) / 2 / np.pi, rel=0.01)


@pytest.mark.quick("poles")
@pytest.mark.parametrize("law", [POLES, SURFACE, gk.PID(bandwidth=8.0), gk.ComputedTorque(bandwidth=10.0)],
                         ids=["poles", "surface", "pid", "bandwidth"])  # fmt: skip
def test_gains_are_found_for_a_wanted_bandwidth_and_keep_their_ratio(nist, law):
    found = with_bandwidth(nist, law, 25.0, 1e-3)
    assert bandwidth_of(nist, found, 1e-3) == pytest.approx(25.0, rel=1e-5)
    factors = np.concatenate(
        [np.ravel(getattr(found, n) / getattr(law, n)) for n in law.tuned if getattr(law, n) is not None]
    )
    assert_allclose(factors, factors[0], rtol=1e-12)
    assert found.machine is None and found.period is None  # still open, as it was handed in


def test_a_loop_that_creeps_for_hours_is_not_taken_for_an_unstable_one(nist):
    """A pole at 1e-4 1/s: 1e-7 a sample from the unit circle.  The other two, at 20 1/s, set the bandwidth."""
    found = bandwidth_of(nist.replace(gravity=[0, 0, 0.0]), gk.ComputedTorque(poles=[20.0, 20.0, 1e-4]), 1e-3)
    # w^2 + 20^2 = sqrt(2) 20^2; half of K_D Ts = 4 % is damping
    assert found == pytest.approx(20 * np.sqrt(np.sqrt(2) - 1) / 2 / np.pi, rel=0.02)


def test_what_goes_straight_through_adds_to_a_response():
    """x+ = x / 2 + 3 u, y = 5 x + 7 u: 15 / (z - 1/2) + 7; at rest 37, at half the sampling rate -3."""
    space = [np.array([[value]]) for value in (0.5, 3.0, 5.0, 7.0)]
    assert_allclose(response(space, 0.1, [0.0, 5.0], 0), [37, -3], atol=1e-12)


@pytest.mark.full
def test_what_has_no_bandwidth_says_why(nist):
    with pytest.raises(
        ExperimentError, match=r"computed_torque: a loop that is unstable at a period of 1 ms has no band"
    ):
        bandwidth_of(nist, gk.ComputedTorque(bandwidth=120.0), 1e-3)
    with pytest.raises(
        ExperimentError, match=r"axis: the tool has no such axis, got 'a'; there is x, y, z, rx, ry, rz"
    ):
        bandwidth_of(nist, POLES, 1e-3, axis="a")
    with pytest.raises(ExperimentError, match=r"no gains give this bandwidth along x at a period of 1 ms, got 400 Hz"):
        with_bandwidth(nist, POLES, 400.0, 1e-3)
