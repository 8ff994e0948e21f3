"""Projection and switching leakage: estimates stay in their set and are pulled back only from outside the ball."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from gough.control.adaptation import check_bounds, leak, learned
from gough.errors import InputError


def _leak(theta, norm=1.5, strength=2.0):
    x = ca.SX.sym("x", len(theta))
    return float(ca.Function("leak", [x], [leak(x, norm, strength)])(theta))


def _learned(theta, y, step, rate=3.0, leakage=0.0):
    x, power = ca.SX.sym("x", len(theta)), ca.SX.sym("y", len(theta))
    f = ca.Function("learned", [x, power], [learned(x, power, rate, 0.5, 1.5, step, leakage)])
    return np.array(f(theta, y)).ravel()


@pytest.mark.parametrize(
    ("size", "expected"), [(0.0, 0.0), (1.0, 0.0), (1.5, 0.0), (2.25, 1.0), (3.0, 2.0), (30.0, 2.0)]
)
def test_leakage_switches_on_between_m0_and_twice_m0(size, expected):
    """Eq. (2): M_0 = 1.5, s_0 = 2."""
    assert _leak(size * np.array([0.6, -0.8])) == pytest.approx(expected, abs=1e-14)


def test_leakage_never_raises_the_distance_from_a_truth_inside_the_ball():
    """-s theta~' theta <= 0 for |theta*| <= M_0: the term of the Lyapunov function's rate."""
    rng = np.random.default_rng(3)
    for _ in range(300):
        theta, truth = rng.normal(size=4) * 3, rng.normal(size=4)
        truth *= rng.uniform(0, 1.5) / np.linalg.norm(truth)
        assert -_leak(theta) * (theta - truth) @ theta <= 1e-15


def test_an_estimate_that_nothing_teaches_leaks_away_at_the_rate_times_the_leakage():
    """Eq. (1) with y = 0 is theta' = -g s theta: g s t = 0.06 here, in 100 steps, whose error is its square / 200."""
    theta, constant = np.array([1.4, 0.9]), np.array([1.4, 0.9])
    for _ in range(100):
        theta = _learned(theta, np.zeros(2), 1e-3, leakage=0.2)
        constant = _learned(constant, 0.2 * constant, 1e-3, leakage=0.2)  # taught as much as leaks
    np.testing.assert_allclose(theta, np.array([1.4, 0.9]) * np.exp(-0.06), rtol=3e-5)
    np.testing.assert_allclose(constant, [1.4, 0.9], rtol=1e-14)


def test_no_step_however_long_leaves_the_box():
    rng = np.random.default_rng(4)
    for step in (1e-3, 1.0, 1e6):
        after = _learned(rng.uniform(0.5, 1.5, 5), rng.normal(size=5) * 10, step)
        assert np.all((after >= 0.5) & (after <= 1.5))


def test_at_a_bound_only_the_outward_part_of_the_rate_is_dropped():
    """Eq. (3): the projected Euler step is the Euler step of the projected rate."""
    theta, y, step = np.array([1.5, 1.5, 0.5, 0.5, 1.0]), np.array([1.0, -1.0, 1.0, -1.0, 1.0]), 1e-3
    np.testing.assert_allclose((_learned(theta, y, step) - theta) / step, [0, -3, 3, 0, 3], atol=1e-12)


def test_projection_never_raises_the_distance_from_a_truth_in_the_box():
    rng = np.random.default_rng(5)
    for _ in range(300):
        theta, truth, y = rng.uniform(0.5, 1.5, 3), rng.uniform(0.5, 1.5, 3), rng.normal(size=3) * 100
        free = theta + 1e-2 * 3.0 * y
        assert np.linalg.norm(_learned(theta, y, 1e-2) - truth) <= np.linalg.norm(free - truth) + 1e-15


def test_a_number_that_is_none_stays_none():
    """NaN must stop the run, not become a bound."""
    assert np.isnan(_learned(np.ones(1), np.array([np.nan]), 1e-3)).all()


@pytest.mark.parametrize(
    ("bounds", "text"),
    [
        ([1.5, 0.5], r"lower bound must be below the upper, got \[1.5, 0.5\]; write \[0.5, 1.5\]"),
        ([1.0, 1.0], r"lower bound must be below the upper, got \[1, 1\]; leave room on both sides of 1"),
        ([1.1, 2.0], "first estimate"),
    ],
)
def test_bounds_are_the_right_way_round_and_hold_the_first_estimate(bounds, text):
    with pytest.raises(InputError, match=text) as error:
        check_bounds(bounds, "friction_bounds")
    assert "friction_bounds" in str(error.value)
