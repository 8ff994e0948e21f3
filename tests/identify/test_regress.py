"""Least squares: planted parameters come back, and deviations are what they say."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest

from gough.errors import ExperimentError, LogError
from gough.identify.regress import chosen_of, estimate
from gough.identify.rows import rows_of_motion

from .motions import fourier, machine_of, planted, sampled

MACHINES = ["nist-octahedral", "okuma-pm600", "eth-hexaglide"]


def case(name, Ts=0.02, seed=4):
    """Rows of a motion with forces of planted parameters, and those parameters."""
    machine = machine_of(name)
    x, xd, xdd = sampled(machine, fourier(seed), Ts)
    empty = rows_of_motion(machine, x, xd, xdd, np.zeros((len(x), 6)))
    truth = planted(machine, empty.names)
    return machine, (x, xd, xdd), empty.Y @ truth, truth


def with_forces(machine, motion, u):
    return rows_of_motion(machine, *motion, u)


@pytest.mark.parametrize("name", MACHINES)
def test_planted_base_parameters_come_back_to_1e_8_without_noise(name):
    machine, motion, u, truth = case(name)
    found = estimate(with_forces(machine, motion, u))
    true = found.base.K @ truth
    size = np.abs(true) + 1e-2 * np.abs(found.rows.values[found.base.kept]).max()
    assert np.abs((found.values - true) / size).max() < 1e-8
    assert found.residual_rms < 1e-10 and found.held_out_rms < 1e-9


def coverage(name, trials, noise, Ts=0.02):
    """How often intervals of 1.96 deviations hold the truth, over all parameters; mean of (estimate - truth) / std."""
    machine, motion, u, truth = case(name, Ts)
    level = 0.01 * np.sqrt(np.mean(u**2, axis=0))
    rng = np.random.default_rng(20)
    off = []
    for _ in range(trials):
        found = estimate(with_forces(machine, motion, u + level * noise(rng, u.shape)))
        off.append((found.values - found.base.K @ truth) / found.std)
    off = np.concatenate(off)
    return np.mean(np.abs(off) < 1.96), off.mean()


def white(rng, shape):
    return rng.standard_normal(shape)


def remembering(rng, shape):
    """First-order noise of variance 1 whose neighbours are alike to 0.8."""
    e, out = rng.standard_normal(shape), np.empty(shape)
    out[0] = e[0]
    for k in range(1, len(e)):
        out[k] = 0.8 * out[k - 1] + 0.6 * e[k]
    return out


@pytest.mark.full
def test_intervals_of_95_percent_hold_the_truth_in_90_to_98_of_100_trials_with_1_percent_noise():
    """RELIABILITY C1.  60 trials of 23 parameters; the pooled share has a deviation below 0.01."""
    share, bias = coverage("eth-hexaglide", 60, white)
    assert 0.90 < share < 0.98
    assert abs(bias) < 0.1, "1380 numbers of deviation 1 have a mean of deviation 0.03 to 0.1"


@pytest.mark.full
def test_intervals_are_as_honest_when_noise_remembers():
    """Neighbours alike to 0.8: of 600 rows a joint, nine tell as much as one.  Least squares would be off threefold."""
    share, _ = coverage("eth-hexaglide", 60, remembering, Ts=0.01)
    assert 0.90 < share < 0.98


@pytest.mark.full("eth-hexaglide")
@pytest.mark.parametrize("name", MACHINES)
def test_intervals_are_honest_on_every_machine(name):
    share, _ = coverage(name, 200, white)
    assert 0.90 < share < 0.98


def test_independent_formulas_give_the_same_deviations_for_white_noise():
    """One joint's worth of weight each: (X' W X)^-1 written out in NumPy, to the share that cross-correlations add."""
    machine, motion, u, _ = case("eth-hexaglide")
    u = u + 5.0 * np.random.default_rng(3).standard_normal(u.shape)
    found = estimate(with_forces(machine, motion, u))
    X = found.rows.Y[..., found.base.kept] / found.sigma[:, None]
    X = X.reshape(-1, found.base.rank)
    plain = np.sqrt(np.diag(np.linalg.inv(X.T @ X)))
    assert found.memory < 1.2
    assert np.abs(found.std / plain - 1).max() < 0.15  # 300 rows: correlations of joints are off by 1 / sqrt(300) each
    assert found.sigma == pytest.approx(np.full(6, 5.0), rel=0.1)


def test_what_is_not_free_stays_at_the_sheet_and_what_is_takes_its_share():
    machine, motion, u, truth = case("eth-hexaglide")
    rows = with_forces(machine, motion, u)
    part = chosen_of(rows.names, ["friction"])
    known = estimate(with_forces(machine, motion, rows.Y @ np.where(part, truth, rows.values)), ["friction"])
    assert known.values == pytest.approx(truth[part], rel=1e-10)
    assert np.array_equal(known.full[~part], rows.values[~part])
    assert estimate(rows, "platform.m").base.names == ("platform.m",)


def test_the_held_out_error_shows_a_model_that_fits_and_does_not_predict():
    """Friction that grows all along: the fit spreads it, the prediction of a fifth from the others cannot."""
    machine, motion, u, _ = case("eth-hexaglide")
    rng = np.random.default_rng(0)
    even = estimate(with_forces(machine, motion, u + 5 * rng.standard_normal(u.shape)))
    drift = np.linspace(-100, 100, len(u))[:, None] * np.sign(rows_speed(machine, motion))
    off = estimate(with_forces(machine, motion, u + drift))
    assert even.held_out_rms == pytest.approx(5, rel=0.15)
    assert off.held_out_rms > 1.2 * off.residual_rms


def rows_speed(machine, motion):
    return machine.joint_motion(*motion)[1]


def test_asking_for_what_the_motion_does_not_show_is_refused_with_its_name():
    machine = machine_of("eth-hexaglide")
    x, xd, xdd = sampled(machine, fourier(1, turn=0.0))
    u = machine.inverse_dynamics(x, xd, xdd) + np.random.default_rng(0).standard_normal((len(x), 6))
    rows = rows_of_motion(machine, x, xd, xdd, u)
    assert "platform.Izz" not in estimate(rows).base.names
    with pytest.raises(LogError) as caught:
        estimate(rows, ["platform.m", "platform.Izz"])
    assert str(caught.value) == (
        "the motion does not show platform.Izz, got its part of the forces is below 2 of their noise; log a motion "
        "that moves all joints and turns the tool, for example that of gough.identify.excite"
    )


def test_a_hopeless_condition_is_refused_with_its_number():
    """Two columns apart by a millionth, both far above rounding, and no noise to hide it: a model error would rule."""
    machine, motion, u, _ = case("eth-hexaglide")
    rows = with_forces(machine, motion, u)
    Y = rows.Y.copy()
    Y[..., 1] = Y[..., 0] + 1e-7 * Y[..., 1]
    bad = dataclasses.replace(rows, Y=Y, u=Y @ rows.values)
    with pytest.raises(
        LogError, match=r"shows too little: condition number of the regressor, got [\d.e+]+ \(limit 100000\)"
    ):
        estimate(bad)


def test_too_few_rows_are_refused():
    machine, motion, u, _ = case("eth-hexaglide")
    rows = rows_of_motion(machine, *(m[:5] for m in motion), u[:5])
    with pytest.raises(LogError, match="too few rows for so many parameters, got 30 forces for 23"):
        estimate(rows)


def test_a_wrong_name_is_told_the_nearest_right_one():
    with pytest.raises(
        ExperimentError, match=re.escape("free: no such parameter, got platfrom; did you mean platform?")
    ):
        chosen_of(("platform.m", "drive.m"), ["platfrom"])
    with pytest.raises(ExperimentError, match="names no parameter"):
        chosen_of(("platform.m", "drive.m"), [])
    assert chosen_of(("platform.m", "platform.m cx", "friction.coulomb[0]"), ["platform.m"]).tolist() == [1, 0, 0]
