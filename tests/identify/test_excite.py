"""Exciting motions: within every limit, better than chance, the same every time, and never a failed optimisation."""

from __future__ import annotations

import dataclasses
from importlib import import_module

import casadi as ca
import numpy as np
import pytest

import gough as gk
from gough.errors import ExperimentError, RunError, WorkspaceError
from gough.identify.criterion import POWER, condition, volume
from gough.identify.design import acceleration_of, design_of, speed_of
from gough.identify.excite import excite, shown, start_of, usual_period
from gough.identify.series import bases, moments, times

from .motions import fourier, machine_of

module = import_module("gough.identify.search")


@pytest.fixture(scope="module")
def hexaglide():
    return machine_of("eth-hexaglide")


@pytest.fixture(scope="module")
def found(hexaglide):
    """A short series: some seconds of optimising."""
    return excite(hexaglide, period=5.0, harmonics=3)


def test_the_series_begins_at_rest_whatever_its_numbers_are():
    sine, cosine = bases(5)
    k = np.arange(1, 6)
    assert np.abs(k @ sine).max() < 1e-14 and np.abs(k**2 @ cosine).max() < 1e-13
    assert sine.T @ sine == pytest.approx(np.eye(4), abs=1e-14)


def test_a_moment_of_the_design_is_that_of_the_program(hexaglide):
    """The optimiser's regressor and limits at a time are those of the machine at that time of the Fourier program."""
    K, period = 4, 6.0
    program, basis = fourier(8, harmonics=K, period=period), bases(K)
    c = np.concatenate([
        np.concatenate([basis[i].T @ program.series(key)[:, j] for i, key in enumerate(pair)])
        for pair in (("sine", "cosine"), ("turn_sine", "turn_cosine")) for j in range(3)
    ])  # fmt: skip
    t = times(period, 7)
    w = moments(t, period, K, 6) @ c
    assert w.reshape(7, 6, 3).transpose(1, 0, 2) == pytest.approx(np.array(program.poses(t)), abs=1e-12)
    design = design_of(hexaglide)
    step = t[1] - t[0]
    motion = program.plan(hexaglide)
    motion.lead_in = -t[0]
    r = motion.sample(0, 7, step)
    Y = hexaglide.regressor(r.x, r.xd, r.xdd)[..., design.kept[:11]] * design.size[design.kept[:11]]
    X, g = (np.array(v) for v in design.row.map(7)(w.T))
    X = X.reshape(6, 7, -1).transpose(1, 0, 2)
    assert X[..., :11] == pytest.approx(Y, abs=1e-9 * np.abs(Y).max())
    q, qd, qdd = hexaglide.joint_motion(r.x, r.xd, r.xdd)
    rows = [i for i, name in enumerate(design.limits) if name.endswith(": speed") and name != "tool: speed"]
    assert np.abs(g[rows].T - (1 - (qd / speed_of(hexaglide)) ** 2)).max() < 1e-9
    (row,) = (i for i, name in enumerate(design.limits) if name == "tool: speed")
    speed = np.linalg.norm(r.xd[:, :3], axis=1) / hexaglide.feed.rapid
    assert np.abs(g[row] - (1 - speed**2)).max() < 1e-9
    rows = [i for i, name in enumerate(design.limits) if name.endswith(": acceleration")]
    assert np.abs(g[rows].T - (1 - (qdd / acceleration_of(hexaglide)) ** 2)).max() < 1e-9


def test_a_start_is_the_seeds_and_is_within_the_limits(hexaglide):
    design = design_of(hexaglide)
    G = moments(times(10.0, 42), 10.0, 3, 6)
    a, b, c = (start_of(design, G, 3, seed) for seed in (0, 0, 1))
    assert np.array_equal(a, b) and not np.array_equal(a, c)


@pytest.mark.parametrize("r", [3, 23])
def test_the_criterion_is_a_bound_of_the_condition_number_as_sharp_as_is_said(r):
    """Equations (1) to (3) of criterion.py, against eigenvalues of matrices whose are known."""
    rng = np.random.default_rng(r)
    for spread in (0.0, 2.0, 9.0):
        values = np.exp(spread * rng.uniform(-1, 1, r))
        Q = np.linalg.qr(rng.standard_normal((r, r)))[0]
        M = 7.0 * Q @ np.diag(values) @ Q.T
        bound, kappa = float(condition(r)((M + M.T) / 2)), np.sqrt(values.max() / values.min())
        assert np.log(kappa) - 1e-9 <= bound <= np.log(kappa) + np.log(r) / POWER + 1e-9
        by_hand = (np.log(np.sum(values**POWER)) + np.log(np.sum(values**-POWER))) / (2 * POWER)
        assert bound == pytest.approx(by_hand, abs=1e-6)
        assert float(volume(r)((M + M.T) / 2)) == pytest.approx(-np.log(7 * values).sum(), abs=1e-9)


@pytest.mark.full
def test_the_motion_is_within_every_limit_and_nearly_reaches_one(hexaglide, found):
    r = found.plan(hexaglide).sample(0, 5001, 1e-3)
    u = hexaglide.inverse_dynamics(r.x, r.xd, r.xdd)
    used = [
        np.abs(r.qd).max() / speed_of(hexaglide),
        np.abs(r.qdd).max() / acceleration_of(hexaglide),
        np.abs(u).max() / 2500,
        np.linalg.norm(r.xd[:, :3], axis=1).max() / hexaglide.feed.rapid,
    ]
    assert max(used) <= 1
    edge = np.abs(r.x[:, :3]).max(0) / [0.25, 0.25, 0.15]
    assert edge.max() <= 1
    assert max(*used, *edge) > 0.9, "a motion that leaves every limit untouched could be larger, and show more"


@pytest.mark.full
def test_the_motion_shows_all_and_better_than_a_hundred_random_ones(hexaglide, found):
    best = shown(hexaglide, found)
    assert best.rank == 23
    others = []
    for seed in range(100):
        motion = fourier(seed, tip=0.08, turn=0.06, period=5.0, harmonics=3)
        others.append(shown(hexaglide, motion, period=0.05).condition)
    assert best.condition < 0.5 * np.min(others)


@pytest.mark.slow
def test_left_to_itself_it_halves_the_condition_number_of_straight_lines_with_turns(hexaglide):
    """Issue 6: the study's lines with turns of 8 deg, for which 32 is reported, and the least volume within the same
    limits, which is another aim."""
    from gough.study.honegger1998.exercise import Exercise

    lines = shown(hexaglide, Exercise(turn=np.radians(8), settle=0.0)).condition
    best = shown(hexaglide, excite(hexaglide)).condition
    sharp = shown(hexaglide, excite(hexaglide, criterion="volume")).condition
    assert 30 < lines < 35
    assert best < 0.6 * lines and best < 0.8 * sharp


@pytest.mark.full
def test_the_tool_is_as_slow_as_is_asked(hexaglide):
    program = excite(hexaglide, period=5.0, harmonics=3, tool_speed=0.3)
    r = program.plan(hexaglide).sample(0, 5001, 1e-3)
    assert 0.25 < np.linalg.norm(r.xd[:, :3], axis=1).max() <= 0.3


@pytest.mark.full("emps-*")
@pytest.mark.parametrize("name, rank", [("emps", 3), ("ccu-3prs", 19)])
def test_machines_of_one_and_of_three_coordinates_have_exciting_motions(name, rank):
    machine = machine_of(name)
    program = excite(machine)
    best = shown(machine, program)
    rng, others = np.random.default_rng(0), []
    for _ in range(20):  # the same harmonics at random, of the same greatest coefficient
        scaled = {}
        for key in ("sine", "cosine"):
            rows = getattr(program, key)
            if rows is not None:
                k = np.arange(1.0, len(rows) + 1)[:, None] ** (1 if key == "sine" else 2)
                mixed = rng.uniform(-1, 1, rows.shape) * np.abs(rows).max() * np.any(rows, axis=0)
                mixed[-1] -= (k * mixed).sum(0) / k[-1]
                scaled[key] = 0.3 * mixed / k[-1]
        others.append(shown(machine, program.replace(**scaled)).condition)
    assert best.rank == rank and best.condition < 0.5 * np.min(others)


@pytest.mark.full
def test_the_same_arguments_give_the_same_motion(hexaglide, found):
    assert excite(hexaglide, period=5.0, harmonics=3) == found


def test_a_period_that_is_left_out_is_that_of_the_workspace():
    """Five crossings at the tool's speed, from 1 to 10 s: 0.5 m at 1 m/s; 0.6 m at 100 m/min; 0.4 m at 0.12 m/s."""
    periods = [usual_period(machine_of(name)) for name in ("eth-hexaglide", "okuma-pm600", "emps")]
    assert periods == pytest.approx([2.5, 1.8, 10.0])
    assert usual_period(machine_of("eth-hexaglide"), 0.5) == pytest.approx(5.0)


@pytest.mark.full
def test_a_failed_optimisation_is_an_error_and_no_motion(hexaglide, monkeypatch):
    """RELIABILITY S4: an optimiser that gave up, and one that says nothing is wrong with a NaN."""
    for key, value in (("_CAP", 1), ("_LAST", 1), ("_ROUNDS", 2)):
        monkeypatch.setattr(module, key, value)
    with pytest.raises(
        RunError, match="the optimiser found no exciting motion, got IPOPT ends with Maximum_Iterations_Exc"
    ):
        excite(hexaglide, period=10.0, harmonics=2)

    def broken(*_):
        def solver(**_):
            return {"x": ca.DM([np.nan] * 12)}

        solver.stats = lambda: {"return_status": "Solve_Succeeded"}
        return solver

    monkeypatch.setattr(module.ca, "nlpsol", broken)
    with pytest.raises(RunError, match="the optimiser found no exciting motion"):
        excite(hexaglide, period=10.0, harmonics=2)


@pytest.mark.full
def test_a_motion_that_still_leaves_a_limit_after_all_rounds_is_an_error_with_the_limit(hexaglide, monkeypatch):
    monkeypatch.setattr(module, "_ROUNDS", 1)
    with pytest.raises(RunError, match=r"leaves a limit between the times it was optimised at, got [\d.]+ % beyond"):
        excite(hexaglide, period=2.5)


def test_what_cannot_be_is_refused(hexaglide):
    with pytest.raises(ExperimentError, match="period must be above 0 s and harmonics from 2 to 32, got -1, 5"):
        excite(hexaglide, period=-1)
    with pytest.raises(ExperimentError, match="criterion: no such criterion, got conditions; did you mean condition?"):
        excite(hexaglide, criterion="conditions")
    with pytest.raises(ExperimentError, match="tool_speed: must be above 0 m/s, got 0"):
        excite(hexaglide, tool_speed=0)
    with pytest.raises(ExperimentError, match="free: no such parameter, got platfrom; did you mean platform?"):
        excite(hexaglide, free=["platfrom"])
    space = hexaglide.limits.workspace
    tight = hexaglide.replace(limits=hexaglide.limits.replace(workspace=space.replace(tilt=0.0)))
    with pytest.raises(WorkspaceError, match="no motion about home is within the limits"):
        excite(tight, harmonics=2)


@pytest.mark.slow
def test_half_a_minute_shows_what_takes_minutes_to_learn():
    """Issue 6: the sheet's numbers wrong by a fifth, 20 s of machine time, friction with memory, encoders of 0.1 um:
    every parameter of table 1 within 1 %, where learning on line is asked for 5 %."""
    true = machine_of("eth-hexaglide")
    program = excite(true, period=10.0, cycles=2)
    assert program.plan(true).duration < 30
    wrong = true.replace(
        platform=true.platform.replace(mass=1.2 * true.platform.mass), carriage=true.carriage.replace(mass=80.0),
        friction=true.friction.replace(coulomb=100.0, viscous=500.0),
    )  # fmt: skip
    log = gk.simulate(wrong, gk.ComputedTorque(bandwidth=30.0), program, plant=true)
    fit = gk.identify(log, wrong)
    truth = dict(zip(*true.parameters_of(friction=True)[:2], strict=True))
    assert len(fit.names) == 23 and not fit.unseen
    for name, value in zip(fit.names, fit.values, strict=True):
        if truth[name]:
            assert value == pytest.approx(truth[name], rel=0.01), name
    assert fit.impossible == ()
    assert dataclasses.asdict(fit.physical)["away"] == 0
