"""The velocity observer against the double integrator it observes."""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca
import numpy as np
import pytest

from gough.observe import velocity

POLE, PERIOD = 1000.0, 3e-4


class Row(NamedTuple):
    """What the observer reads of a reference."""

    q: float
    qd: float
    qdd: float


def numbers(value) -> float:
    return float(ca.DM(value))


def observed(kind, q, a, period=PERIOD, first=(0.0, 0.0), pole=POLE, row=lambda t: Row(0.0, 0.0, 0.0)):
    """(observed speed errors, predicted states) along joint places `q` (N,) under feedback `a` (N,)."""
    state, errors, states = velocity.Speed(*first), [], []
    for k in range(len(q)):
        r = row(k * period)
        states.append([numbers(part) for part in state])
        errors.append(numbers(velocity.speed_error(state, r, q[k], pole, period, kind)))
        state = velocity.Speed(*(numbers(part) for part in velocity.advanced(state, r, q[k], a[k], pole, period, kind)))
    return np.array(errors), np.array(states)


def integrated(a, period, e=0.0, v=0.0):
    """e and e' of e'' = -a, a (N,) held for each sample."""
    out = []
    for held in a:
        out.append((e, v))
        e, v = e + period * v - period**2 / 2 * held, v - period * held
    return np.array(out).T


def test_sampled_exactly_its_error_dies_with_both_poles_where_they_were_placed():
    a = np.random.default_rng(1).uniform(-30, 30, 60)
    e, v = integrated(a, PERIOD, e=2e-5, v=0.01)
    _, states = observed("exact", -e, a)  # the reference stands at 0: e = -q
    wrong = np.stack([e, v]).T - states
    b = np.exp(-POLE * PERIOD)
    # Cayley and Hamilton: (A - b)^2 = 0 for the matrix A that hands the error on, whatever the feedback does
    left = wrong[2:] - 2 * b * wrong[1:-1] + b**2 * wrong[:-2]
    assert np.abs(left / np.abs(wrong).max(0)).max() < 1e-13
    assert np.abs(wrong[40:] / np.abs(wrong).max(0)).max() < 40 * b**38  # so it is gone: b^40 = 6e-6


def test_sampled_exactly_it_does_not_err_once_it_has_converged():
    a = np.random.default_rng(2).uniform(-30, 30, 50)
    e, v = integrated(a, PERIOD, e=1e-5, v=-0.02)
    errors, _ = observed("exact", -e, a, first=(1e-5, -0.02))
    np.testing.assert_allclose(errors, v, rtol=0, atol=1e-14)


def test_by_euler_the_speed_is_too_fast_by_half_a_sample_of_acceleration():
    t, acceleration = np.arange(200) * PERIOD, 10.0
    q = acceleration * t**2 / 2
    row = lambda s: Row(acceleration * s**2 / 2, acceleration * s, acceleration)  # noqa: E731
    errors, _ = observed("euler", q, np.zeros(200), row=row)
    # q_r' - q^' = -q'' Ts / 2 when the poles, 1 - w_0 Ts = 0.7, have done their work
    assert errors[-1] == pytest.approx(-acceleration * PERIOD / 2, rel=1e-9)
    exact, _ = observed("exact", q, np.zeros(200), row=row)
    assert np.abs(exact).max() < 1e-9


@pytest.mark.parametrize(("kind", "bias"), [("exact", -0.5), ("euler", 0.0)])
def test_under_a_steady_force_it_reads_half_a_sample_of_it_sampled_exactly_and_nothing_by_euler(kind, bias):
    """Held still against a force that it does not know, e stands while a pushes; desired_torque.md, (12)."""
    a, e = np.full(200, 7.0), 4e-5
    errors, _ = observed(kind, np.full(200, -e), a)
    assert errors[-1] == pytest.approx(bias * 7.0 * PERIOD, abs=1e-12)


def test_by_euler_its_error_dies_with_both_poles_at_1_minus_w0_ts():
    q = np.zeros(30)
    _, states = observed("euler", q, q, first=(1e-5, 0.0))
    b = 1 - POLE * PERIOD
    left = states[2:] - 2 * b * states[1:-1] + b**2 * states[:-2]
    assert np.abs(left / np.abs(states).max(0)).max() < 1e-12


@pytest.mark.parametrize("kind", ["exact", "euler"])
def test_both_are_the_observer_of_the_paper_when_samples_are_short(kind):
    """From a wrong start at rest: z and q^ of (23) in closed form, q^ = (1 + w_0 t) q^0 exp(-w_0 t) + ..."""
    errors = []
    for period in (1e-5, 5e-6):
        count = round(2e-3 / period)
        first = (1e-5, 0.0)  # e^ or q^ wrong by 10 um
        found, _ = observed(kind, np.zeros(count), np.zeros(count), period=period, first=first)
        t = np.arange(count) * period
        # x'' + 2 w_0 x' + w_0^2 x = 0 from x = 1e-5, x' = -2 w_0 x
        speed = -1e-5 * POLE * np.exp(-POLE * t) * (2 - POLE * t)
        sign = 1 if kind == "exact" else -1
        errors.append(np.abs(sign * found - speed).max() / np.abs(speed).max())
    assert errors[0] < 0.02
    assert errors[1] == pytest.approx(errors[0] / 2, rel=0.1), "of first order in the period"


def test_its_gains_are_those_of_the_paper_when_samples_are_short():
    g, h = (numbers(gain) for gain in velocity.gains(POLE, 1e-8))
    assert g / 1e-8 == pytest.approx(2 * POLE, rel=1e-4)
    assert h / 1e-16 == pytest.approx(POLE**2, rel=1e-4)
