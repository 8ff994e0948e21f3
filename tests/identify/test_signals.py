"""From the columns of a log to rows: filter, derivatives, the time at which a force acts, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from gough.errors import LogError
from gough.identify.base import sizes
from gough.identify.regress import estimate
from gough.identify.rows import rows_of_log
from gough.identify.signals import _low_pass, signals_of
from gough.log import Log

from .motions import fourier, log_of, machine_of, planted


@pytest.fixture(scope="module")
def hexaglide():
    return machine_of("eth-hexaglide")


@pytest.fixture(scope="module")
def plain(hexaglide):
    """A log of one period, forces at the rows' own times; its planted parameters."""
    rows = (*hexaglide.parameters.names, *(f"friction.{k}[{i}]" for k in ("coulomb", "viscous") for i in range(6)))
    truth = planted(hexaglide, rows)
    return log_of(hexaglide, fourier(5), truth), truth


def usual(machine, found):
    """What each kept parameter is usually as large as: an inertia of 0 is known to a share of the others."""
    rows = found.rows
    values = np.where([name.startswith("friction") for name in rows.names], 100.0, rows.values)
    return sizes(rows.names, rows.units, values, np.ones(len(values)))[found.base.kept]


def test_the_filter_delays_nothing_and_has_the_gain_of_a_butterworth_both_ways():
    t = np.arange(20_000) * 1e-3
    for f in (2.0, 10.0, 20.0, 40.0):
        wave = np.stack([np.sin(2 * np.pi * f * t), np.cos(2 * np.pi * f * t)], 1)
        middle = slice(8000, 12_000)
        gain = 1 / (1 + (f / 20) ** 8)
        # what the turned-over ends do has died out here; 1e-6 of it is left
        assert np.abs(_low_pass(20.0, 1e-3)(wave)[middle] - gain * wave[middle]).max() < 1e-6


def test_the_filter_leaves_a_straight_line_as_it_is():
    line = np.outer(np.arange(500.0), [1.0, -2.0]) + [3.0, 1e6]
    assert np.abs(_low_pass(20.0, 1e-3)(line) - line).max() < 1e-8


def test_a_motion_comes_back_from_its_joints_alone(hexaglide, plain):
    log, _ = plain
    (s,) = signals_of(log, hexaglide, cutoff=None)
    motion = fourier(5).plan(hexaglide)
    first = round(s.t[0] / 1e-3)
    r = motion.sample(first, first + len(s.t), 1e-3)
    # a spline of fifth order through samples 1 ms apart; harmonics below 1 Hz
    inner = slice(20, -300)  # the end has a jump of the fourth derivative, where the rest begins
    assert np.abs(s.x - r.x)[inner].max() < 1e-9
    assert np.abs(s.xd - r.xd)[inner].max() < 1e-8
    assert np.abs(s.xdd - r.xdd)[inner].max() < 1e-5


def test_planted_parameters_come_back_through_filter_and_blocks(hexaglide, plain):
    """What is lost: the filter's gain at the harmonics (1e-10), and the mean of a product against that of its factors
    over blocks of 25 ms, (w dt)^2 / 24 = 1e-4 of the part that changes at 4 rad/s."""
    log, truth = plain
    found = estimate(rows_of_log(log, hexaglide))
    assert found.base.rank == 23
    assert np.abs((found.values - found.base.K @ truth) / usual(hexaglide, found)).max() < 2e-3
    assert found.residual_rms < 1e-3 * np.sqrt(np.mean(found.rows.u**2))


def test_a_force_that_is_held_acts_half_its_time_later(hexaglide):
    """Held over 4 ms and taken as of the row's time, f a (2 ms) of the viscous friction goes into the mass."""
    names = (*hexaglide.parameters.names, *(f"friction.{k}[{i}]" for k in ("coulomb", "viscous") for i in range(6)))
    truth = planted(hexaglide, names)
    log = log_of(hexaglide, fourier(5), truth, Ts=4e-3, hold=4e-3)
    right = estimate(rows_of_log(log, hexaglide, hold=4e-3))
    wrong = estimate(rows_of_log(log, hexaglide, hold=0.0))
    carriage = right.base.names.index("carriage.m")
    true = truth[names.index("carriage.m")]
    assert right.values[carriage] == pytest.approx(true, rel=1e-3)
    mean = np.mean([truth[names.index(f"friction.viscous[{i}]")] for i in range(6)])
    assert wrong.values[carriage] - true == pytest.approx(2e-3 * mean, rel=0.3)
    assert wrong.residual_rms > 3 * right.residual_rms


def test_a_log_of_gough_tells_for_how_long_its_forces_are_held(hexaglide):
    log = log_of(hexaglide, fourier(5), hexaglide.parameters.values, Ts=4e-3, hold=4e-3, friction=False,
                 run={"period": "0.004 s"})  # fmt: skip
    (s,) = signals_of(log, hexaglide)
    assert s.t[0] % 4e-3 == pytest.approx(2e-3)


def test_friction_that_the_log_knows_is_taken_off(hexaglide, plain):
    log, truth = plain
    friction = np.asarray(log["u"]) - machine_forces(hexaglide, truth)
    dataset = log.dataset.assign(friction=(("t", "joint"), friction))
    found = estimate(rows_of_log(Log(dataset), hexaglide, friction="known"))
    assert found.base.rank == 11
    assert np.abs((found.values - found.base.K @ truth[:11]) / usual(hexaglide, found)).max() < 2e-3
    with pytest.raises(LogError, match="friction: the log has no friction that is known; leave friction to be"):
        rows_of_log(log, hexaglide, friction="known")


def machine_forces(machine, truth):
    motion = fourier(5).plan(machine)
    r = motion.sample(0, motion.count(1e-3), 1e-3)
    return machine.regressor(r.x, r.xd, r.xdd) @ truth[:11]


def test_rows_at_a_reversal_and_at_a_drives_limit_take_no_part(hexaglide, plain):
    log, _ = plain
    rows = rows_of_log(log, hexaglide)
    assert 0.8 < rows.used.mean() < 0.99
    saturated = np.zeros((len(log), 6), np.int8)
    saturated[2000:3000, 2] = 1
    less = rows_of_log(Log(log.dataset.assign(saturated=(("t", "joint"), saturated))), hexaglide)
    lost = (rows.used & ~less.used).sum(0)
    assert lost[2] > 30 and lost.sum() == lost[2]


def test_a_gap_makes_two_stretches_and_a_gap_is_no_motion(hexaglide, plain):
    log, truth = plain
    kept = np.concatenate([np.arange(0, 2500), np.arange(2700, len(log))])
    cut = Log(log.dataset.isel(t=kept))
    assert len(signals_of(cut, hexaglide)) == 2
    found = estimate(rows_of_log(cut, hexaglide))
    assert np.abs((found.values - found.base.K @ truth) / usual(hexaglide, found)).max() < 2e-3


def changed(log, name, row, value):
    values = np.array(log[name])
    values[row] = value
    if name == "t":
        return Log(log.dataset.assign_coords(t=values))
    return Log(log.dataset.assign({name: (("t", "joint"), values)}))


def test_what_is_wrong_with_a_log_is_said_with_its_row(hexaglide, plain):
    log, _ = plain
    for bad, text in (
        (changed(log, "u", (7, 2), np.nan), "u: row 7, joint 3: must be finite, got nan"),
        (changed(log, "q_m", (9, 0), np.inf), "q_m: row 9, joint 1: must be finite, got inf"),
        (changed(log, "t", 50, 0.02), "t: row 50: time must rise, got 0.02 s after 0.049 s"),
        (changed(log, "t", 50, 0.0503), "t: row 49: rows are unevenly apart, got 0.0013 s (limit 0.001 s); resample "
         "the log evenly first"),
        (Log(log.dataset.drop_vars("u")), "u: the log lacks what identification needs; log it: signals must hold "
         "q_m, u"),
        (Log(log.dataset.isel(t=slice(100))), "no stretch of the log is long enough, got 100 rows of 0.001 s (limit "
         "264 rows without a gap); raise the cutoff, or log a longer motion"),
    ):  # fmt: skip
        with pytest.raises(LogError) as caught:
            signals_of(bad, hexaglide)
        assert str(caught.value) == text


def test_a_log_of_another_machine_is_refused(plain):
    log, _ = plain
    with pytest.raises(
        LogError, match="q_m: .*no pose of nist-octahedral has these joints: .*; name the machine that was"
    ):
        signals_of(log, machine_of("nist-octahedral"))


def test_a_machine_that_stands_still_is_refused(hexaglide):
    n = 2000
    q = np.tile(hexaglide.inverse_kinematics(hexaglide.home), (n, 1))
    log = Log.build(np.arange(n) * 1e-3, {"q_m": q, "u": 0 * q + 100.0}, task=hexaglide.task, joints=6, info={})
    with pytest.raises(LogError, match="no joint moves faster than friction sticks, got greatest speed"):
        rows_of_log(log, hexaglide)


def test_a_cutoff_beyond_the_rows_is_refused(hexaglide, plain):
    with pytest.raises(
        LogError, match="cutoff: the filter must be below half the sample rate, got 600 Hz .limit 450 Hz."
    ):
        signals_of(plain[0], hexaglide, cutoff=600.0)


def test_a_log_beyond_the_declared_workspace_is_told_how_it_can_be_read(hexaglide, plain):
    space = hexaglide.limits.workspace
    tight = hexaglide.replace(limits=hexaglide.limits.replace(workspace=space.replace(height=1e-3)))
    with pytest.raises(LogError, match="beyond the height of the workspace.*, or declare a larger limits.workspace$"):
        signals_of(plain[0], tight)
