"""The fuzzy friction compensation: what it can say, what it learns, and what it refuses."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

import gough as gk
from gough.control.sliding import Known
from gough.errors import ExperimentError, InputError
from gough.simulate import tick


@pytest.fixture(scope="module")
def law():
    machine = gk.load_machine("okuma-pm600")
    return gk.FuzzyFriction(slope=100.0, damping=250.0, friction_rate=2e6).on(machine, 1e-3)


def compensation(law):
    """(weights, speeds, errors s) -> (force, weights after), as a function of numbers."""
    machine = law.machine
    r = tick.rest_row(machine, machine.home)
    rows = law.friction_start()[0].size
    A, qd, s = ca.SX.sym("A", rows), ca.SX.sym("qd", 6), ca.SX.sym("s", 6)

    class State:
        weights = A

    known = Known(law, machine, None, None, None, s, qd, r, law.period)
    lost, (after,) = law.friction(State, known)
    return ca.Function("compensation", [A, qd, s], [lost, after])


def test_memberships_add_up_to_one_at_every_speed(law):
    """All rules saying the same force say it at every speed, also far outside the outermost centres."""
    f = compensation(law)
    A = np.zeros((6, 3, 5), order="F")
    A[:, 0, :] = 123.0
    flat = np.concatenate([a.ravel(order="F") for a in A])
    for speed in (-5.0, -0.05, -0.0012, 0.0, 0.003, 0.02, 5.0):
        lost, _ = f(flat, np.full(6, speed), np.zeros(6))
        np.testing.assert_allclose(np.array(lost).ravel(), 123.0, rtol=1e-14)


def test_lopsided_rules_say_what_their_equations_say():
    """Eqs. (14)-(16) in NumPy, on rules that no mirror turns into themselves."""
    c, w = np.array([-0.05, -0.002, 0.0, 0.01, 0.03]), np.array([0.03, 0.002, 0.004, 0.006, 0.015])
    law = gk.FuzzyFriction(slope=100.0, damping=250.0, friction_rate=2e6, centers=c, widths=w)
    law = law.on(gk.load_machine("okuma-pm600"), 1e-3)
    A = np.random.default_rng(7).normal(size=(6, 3, 5)) * 100
    qd = np.array([-0.2, -0.03, -0.001, 0.0004, 0.02, 0.2])
    x = np.clip(qd, c[0], c[-1])
    m = np.exp(-(((x[:, None] - c) / w) ** 2))
    z = np.stack([np.ones(6), x / 0.1, np.tanh(qd / law.friction_smoothing)], -1)
    wanted = np.einsum("ij,ijk,ik->i", z, A, m / m.sum(1, keepdims=True))
    lost, _ = compensation(law)(np.concatenate([a.ravel(order="F") for a in A]), qd, np.zeros(6))
    np.testing.assert_allclose(np.array(lost).ravel(), wanted, rtol=1e-12)


def test_rules_for_one_direction_alone_are_a_partition():
    law = gk.FuzzyFriction(slope=100.0, damping=200.0, centers=[0.04, 0.05], widths=[0.004, 0.004])
    assert law.centers.tolist() == [0.04, 0.05]


def test_nothing_is_known_at_first(law):
    lost, _ = compensation(law)(law.friction_start()[0], np.linspace(-0.1, 0.1, 6), np.zeros(6))
    np.testing.assert_array_equal(np.array(lost).ravel(), 0)


def test_a_strut_that_lags_learns_more_force_in_its_direction_and_no_other_does(law):
    f = compensation(law)
    start = law.friction_start()[0]
    qd, s = np.full(6, 0.03), 1e-3 * (np.arange(6) == 2)
    _, after = f(start, qd, s)
    lost, _ = f(after, qd, np.zeros(6))
    lost = np.array(lost).ravel()
    assert lost[2] > 0
    np.testing.assert_array_equal(lost[np.arange(6) != 2], 0)


def test_entries_stay_within_their_strength(law):
    _, after = compensation(law)(law.friction_start()[0] + 790.0, np.full(6, 0.05), np.full(6, 10.0))
    assert np.array(after).max() == 800.0


@pytest.mark.full
def test_it_learns_a_stribeck_curve_it_was_never_told(law):
    """The update (17) alone, with the error that a wrong force makes: s proportional to what is missing."""
    f = compensation(law)
    weights, rng = law.friction_start()[0], np.random.default_rng(2)

    def friction(v):
        return (90 + 60 * np.exp(-((v / 2e-3) ** 2))) * np.tanh(v / 2e-4) + 400 * v

    speeds = rng.uniform(-0.06, 0.06, (4000, 6))
    speeds[::2] *= 0.1
    for qd in speeds:
        lost, _ = f(weights, qd, np.zeros(6))
        missing = friction(qd) - np.array(lost).ravel()
        _, after = f(weights, qd, missing * 1e-4)
        weights = np.array(after).ravel()
    grid = np.linspace(-0.01, 0.01, 81)
    found = np.array([np.array(f(weights, np.full(6, v), np.zeros(6))[0]).ravel()[0] for v in grid])
    rms = np.sqrt(np.mean((found - friction(grid)) ** 2))
    # what no rules can: the best sum of a sign and a line misses the rise, 11 % of the friction near rest
    plain = np.column_stack([grid, np.tanh(grid / 2e-4)])
    missed = friction(grid) - plain @ np.linalg.lstsq(plain, friction(grid), rcond=None)[0]
    assert rms < 0.5 * np.sqrt(np.mean(missed**2))


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"centers": [-0.05, 0.05], "widths": [0.001, 0.001]}, "partition is empty"),
        ({"centers": [], "widths": []}, "partition is empty: there is no rule"),
        ({"centers": [0.05, -0.05], "widths": [0.05, 0.05]}, "must rise"),
        ({"centers": [-0.05, 0.05], "widths": [0.05]}, "every centre needs a width"),
        ({"widths": [0.02, 0.0, 0.002, 0.003, 0.02]}, "above 0"),
        ({"friction_rate": -1.0}, "at least 0"),
    ],
)
def test_a_partition_without_rules_is_refused(options, text):
    with pytest.raises(InputError, match=text):
        gk.FuzzyFriction(slope=100.0, damping=200.0, **options)


def test_more_accelerations_than_the_machine_has_are_refused():
    with pytest.raises(ExperimentError, match="the machine has 6"):
        gk.FuzzyFriction(slope=100.0, damping=200.0, accelerations=7).on(gk.load_machine("okuma-pm600"), 1e-3)


def test_six_accelerations_are_learned_too():
    """z of eq. (15) is complete: a load that comes with acceleration finds its place in the rules' accelerations."""
    machine = gk.load_machine("okuma-pm600")
    law = gk.FuzzyFriction(slope=100.0, damping=250.0, accelerations=6, acceleration_rate=0.5).on(machine, 1e-3)
    r = tick.rest_row(machine, machine.home)._replace(xdd=np.arange(1.0, 7.0))
    s = ca.SX.sym("s", 6)

    class State:
        weights = ca.DM(law.friction_start()[0])

    _, (after,) = law.friction(State, Known(law, machine, None, None, None, s, ca.DM.zeros(6), r, 1e-3))
    A = np.array(ca.Function("A", [s], [after])(np.full(6, 1e-3))).ravel()[: 9 * 5].reshape(5, 9).T
    scale = [machine.feed.acceleration] * 3 + [machine.feed.angular_acceleration] * 3
    np.testing.assert_allclose(A[3:, 2] / A[0, 2] / 0.5, np.arange(1.0, 7.0) / scale, rtol=1e-12)
