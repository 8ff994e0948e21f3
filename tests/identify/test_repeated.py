"""Deviations where the model lacks something: friction with memory, which comes where the motion does."""

from __future__ import annotations

import numpy as np
import pytest

import gough as gk
from gough.identify.regress import estimate
from gough.identify.repeated import FEWEST, factor, repeats
from gough.identify.rows import columns_of
from gough.mechanics.friction import LuGre

from .motions import fourier, machine_of
from .test_regress import case, white, with_forces


def planted_and_learned(machine, seed: int, cycles: int, period: float):
    """(estimate - truth) over deviation, and the factor: numbers and motion of a seed, friction with bristles."""
    rng = np.random.default_rng(100 + seed)
    f = machine.friction
    true = machine.replace(
        friction=f.replace(coulomb=f.coulomb * rng.uniform(0.7, 1.3), viscous=f.viscous * rng.uniform(0.7, 1.3)),
        platform=machine.platform.replace(mass=machine.platform.mass * rng.uniform(0.9, 1.1)),
    )
    program = fourier(seed, tip=0.04, turn=0.06, period=period * rng.uniform(1, 2), cycles=cycles)
    log = gk.simulate(
        machine, gk.ComputedTorque(bandwidth=25.0), program, plant=true, seed=seed,
        signals=["q_m", "u", "x_r", "saturated"],
    )  # fmt: skip
    found = gk.identify(log, machine).estimate
    truth = columns_of(true, ("coulomb", "viscous"))[2]
    return (found.values - found.base.K @ truth) / found.std, found.factor


@pytest.mark.full("eth-hexaglide-2-*")
@pytest.mark.parametrize(
    "name, cycles, period", [("eth-hexaglide", 2, 3.0), ("eth-hexaglide", 6, 2.0), ("okuma-pm600", 2, 3.0)]
)
def test_intervals_of_95_percent_hold_the_truth_where_friction_has_bristles(name, cycles, period):
    """Asked: 85 to 99 %.  The deviations of stationary noise hold it in 72 to 76 % (by the factor, taken off again)."""
    machine = machine_of(name)
    if name == "okuma-pm600":
        machine = machine.replace(friction=LuGre(coulomb=90.0, viscous=300.0, stiffness=5e7, damping=1e5))
    found = [planted_and_learned(machine, seed, cycles, period) for seed in range(6)]
    off = np.concatenate([z for z, _ in found])
    before = np.concatenate([z * more for z, more in found])
    assert 0.85 < np.mean(np.abs(off) < 1.96) < 0.99
    assert np.mean(np.abs(before) < 1.96) < 0.82


@pytest.mark.full
def test_noise_that_is_noise_keeps_its_deviations():
    """30 records: the factor of white noise is 1 but for what 25 groups scatter."""
    machine, motion, u, _ = case("eth-hexaglide", 0.04)
    rng = np.random.default_rng(5)
    found = [estimate(with_forces(machine, motion, u + 5 * white(rng, u.shape))).factor for _ in range(30)]
    assert np.mean(found) < 1.1 and np.max(found) < 1.3


def test_an_error_that_comes_every_period_is_not_made_surer_by_repeating_the_motion():
    """An error that is the same function of the phase: after 2 and after 8 periods it is the same error, and so must
    its deviation be; by neighbouring rows alone it would fall by a half."""
    rng = np.random.default_rng(2)
    L, r = 100, 5
    once, lack = rng.standard_normal((L, 2, r)), rng.standard_normal((L, 2))
    std = []
    for periods in (2, 8):
        X, e = np.tile(once, (periods, 1, 1)), np.tile(lack, (periods, 1))
        x = X.reshape(-1, r)
        left = (e.ravel() - x @ np.linalg.lstsq(x, e.ravel(), rcond=None)[0]).reshape(e.shape)
        cov = np.linalg.inv(x.T @ x)
        used = np.ones(e.shape, bool)
        assert repeats(X) == L
        std.append(factor(X, left, used, cov, 1.0, repeats(X)) * np.sqrt(np.diag(cov)))
    assert std[1] == pytest.approx(std[0], rel=1e-9)


def test_the_factor_is_that_of_groups_written_out():
    """Equation (1) with the square root of 1 - P_b itself, a second way."""
    rng = np.random.default_rng(3)
    N, r, count = 100, 3, 25
    X, e = rng.standard_normal((N, 1, r)), rng.standard_normal((N, 1)) * np.repeat([1.0, 6.0], 50)[:, None]
    x = X[:, 0]
    H = np.linalg.inv(x.T @ x)
    e = e - (x @ H @ x.T @ e)
    C = np.zeros((r, r))
    for b in range(count):
        rows = slice(4 * b, 4 * b + 4)
        share, V = np.linalg.eigh(np.eye(4) - x[rows] @ H @ x[rows].T)
        s = x[rows].T @ (V / np.sqrt(share)) @ V.T @ e[rows, 0]
        C += np.outer(H @ s, H @ s)
    found = factor(X, e, np.ones((N, 1), bool), H, 1.0, None)
    assert found == pytest.approx(np.sqrt(max(1.0, np.mean(np.diag(C) / np.diag(H)))), rel=1e-9)
    assert found > 3, "rows of deviation 1 and 6 where the covariance asked about is that of 1"


def test_a_motion_that_does_not_repeat_has_no_period_and_one_with_few_parts_no_factor():
    rng = np.random.default_rng(4)
    X = rng.standard_normal((200, 2, 4))
    assert repeats(X) is None and repeats(X[:10]) is None
    e, used = rng.standard_normal((200, 2)), np.ones((200, 2), bool)
    assert factor(X, e, used, np.eye(4), 200 / (2 * FEWEST) + 1, None) is None


def test_the_table_says_where_a_deviation_is_a_lower_bound():
    """Friction that is not where the model has it, alike for half the motion."""
    machine, motion, u, _ = case("eth-hexaglide", 0.02)
    slow = 40 * np.sin(np.linspace(0, 4, len(u)))[:, None] * np.ones(6)
    found = estimate(with_forces(machine, motion, u + slow))
    assert found.factor is None
    from gough.identify.fit import Fit

    assert "deviation: that of noise alone, so a lower bound: what is left hangs together for" in repr(
        Fit(machine, found, ("coulomb", "viscous"))
    )
