"""Garagic and Srinivasan, ACC 2004: friction reversals under CCTPID on the circle of 0.2 m.

Published: twelve glitches a revolution, two a strut, "six of the glitches in the range of 10 um, the other six in the
range of 3 um", because of the three parallel strut pairs.  The friction coefficients and the guide's lengths are
calibrated to these sizes (MACHINES.md 1.3), so they validate nothing of the paper.  What was not tuned: that there are
twelve, that the large ones are those at long struts, when they come, and that all six of a kind are alike.
"""

from __future__ import annotations

import numpy as np
import pytest

import gough as gk
from gough.measure.reversal import STUDIES, reversals

PERIOD = 2.5e-4  # with the sheet's encoder of 0.1 um: the case of MACHINES.md 1.3


pytestmark = pytest.mark.full  # one turn of 25 s at 4 kHz


@pytest.fixture(scope="module")
def turn():
    machine = gk.load_machine("nist-octahedral")
    circle = gk.Circle(radius=0.2, feed=0.05, start=np.radians(240.0))
    law = gk.ComputedTorque(poles=[100.0, 100.0, 200.0])
    log = gk.simulate(machine, law, circle, period=PERIOD)
    motion = circle.plan(machine)
    row = motion.sample(0, motion.count(PERIOD), PERIOD)
    error, counted = log["contour_error"], log["counted"].astype(bool)
    return log, row, reversals(PERIOD, row.qd, error, counted, STUDIES)


def test_a_turn_takes_25_s_and_shows_twelve_glitches_two_a_strut(turn):
    log, _, found = turn
    moving = log["counted"].sum() * PERIOD
    assert moving == pytest.approx(2 * np.pi * 0.2 / 0.05 + 0.05 / 2.0, abs=2 * PERIOD)  # and v/a to start and stop
    assert sorted(r.joint for r in found) == sorted([*range(6), *range(6)])
    # every glitch is a peak: the error between them is a fiftieth of the smallest
    assert np.median(log["contour_error"]) < min(r.glitch for r in found) / 50


def test_six_glitches_are_large_at_long_struts_and_six_small_at_short_ones(turn):
    _, row, found = turn
    length = np.array([row.q[round(r.time / PERIOD), r.joint] for r in found])
    glitch = np.array([r.glitch for r in found])
    large = length > row.q.mean()
    assert large.sum() == 6
    assert glitch[large].min() > 2.5 * glitch[~large].max()
    # published: "in the range of 10 um" and "of 3 um"; the calibration with tanh(v / 2e-5 m/s) peaks at 9.7 and 3.4 um,
    # bristles of 1e9 N/m at 4 % less; from a peak the judgement takes what was there before, 0.1 to 0.3 um
    assert glitch[large] == pytest.approx(np.full(6, 9.7e-6), rel=0.1)
    assert glitch[~large] == pytest.approx(np.full(6, 3.4e-6), rel=0.1)
    assert np.ptp(glitch[large]) < 0.03 * 9.7e-6 and np.ptp(glitch[~large]) < 0.03 * 3.4e-6


def test_glitches_stand_where_geometry_puts_the_reversals(turn):
    """MACHINES.md 1.3: longest at 25.4, 34.6 deg (struts 4, 3) and 120 deg on, shortest 60 deg behind them."""
    _, row, found = turn
    angle = [np.degrees(np.arctan2(*row.x[round(r.time / PERIOD), 1::-1])) % 360 for r in found]
    wanted = [265.3, 274.6, 325.3, 334.6, 25.4, 34.6, 85.3, 94.6, 145.4, 154.6, 205.4, 214.6]
    apart = np.abs((np.sort(angle) - np.sort(wanted) + 180) % 360 - 180)
    assert apart.max() < 0.2


def test_glitches_peak_40_to_70_ms_behind_the_reversal_and_turn_the_tool_by_a_tenth_of_a_minute_of_arc(turn):
    log, row, found = turn
    error, t = log["contour_error"], log.dataset["t"].values
    delay = np.array(
        [t[near := np.flatnonzero(np.abs(t - r.time - 0.05) < 0.07)][error[near].argmax()] - r.time for r in found]
    )
    long = np.array([row.q[round(r.time / PERIOD), r.joint] for r in found]) > row.q.mean()
    assert delay[long] == pytest.approx(np.full(6, 0.066), abs=0.008)  # bristles take longer than the tanh of 1.3
    assert delay[~long] == pytest.approx(np.full(6, 0.040), abs=0.006)
    assert np.degrees(log["orientation_error"].max()) * 60 == pytest.approx(0.137, rel=0.1)
