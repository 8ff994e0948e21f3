"""Flexible parts of the study of Bouzgarrou et al., 2001: the static algorithm, feeds of one cycle time, rows."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gough.errors import KinematicsError
from gough.study import find
from gough.study.bouzgarrou2001 import beyond, flexible, statics
from gough.study.bouzgarrou2001.setup import END, LOW, START, computed_torque, machine
from gough.study.claims import MET


@pytest.fixture(scope="module")
def true():
    return machine().flexible()


@pytest.mark.full
def test_the_printed_algorithm_multiplies_an_error_a_hundredfold_and_is_refused_with_its_residual(true):
    assert statics.printed_gain(true, END) > 100
    with pytest.raises(KinematicsError, match=r"no convergence of the static compensation, got .* m left .*1e-13 m"):
        statics.algorithm(true, END, printed=True)


@pytest.mark.full
@pytest.mark.parametrize("x", [START, END, (START + END) / 2])
def test_the_repaired_algorithm_comes_to_the_joints_of_newtons_method(true, x):
    found = statics.algorithm(true, x)
    assert_allclose(found.s, true.targets(x), rtol=0, atol=1e-13)
    assert len(found.steps) < 10


@pytest.mark.full
def test_each_turn_leaves_what_the_slope_of_the_sag_and_gravitys_own_stiffness_leave(true):
    """On a machine of a tenth of the stiffness, where more than two turns can be seen."""
    soft = machine().flexible(stiffness=0.1)
    steps = statics.algorithm(soft, END).steps[1:]  # the first is of the unbent machine
    slope = statics.contraction(soft, END)
    assert slope == pytest.approx(10 * statics.contraction(true, END), rel=0.05)  # linear in the compliance
    ratio = steps[1:4] / steps[:3]
    assert ratio[0] < slope
    # d lags the place by a turn, so two turns together gain what two slopes allow
    assert steps[3] / steps[1] < slope


@pytest.mark.full
def test_two_thirds_of_the_way_to_no_stiffness_at_all_the_algorithm_still_converges(true):
    assert len(statics.algorithm(machine().flexible(stiffness=0.03), END).steps) < 15


def test_all_feeds_of_the_line_take_the_same_time():
    for program in beyond.feeds(28.0, 0.05).values():
        plain = program.replace(lead_in=0.0, settle=0.0)
        assert plain.plan(machine()).duration == pytest.approx(beyond.CYCLE, abs=1e-9)


def test_the_swing_of_a_run_is_that_behind_the_end_of_its_line():
    t = np.arange(0, flexible.LEAD + beyond.CYCLE + beyond.BEHIND, 1e-3)
    tip = np.zeros((len(t), 3))
    behind = t > flexible.LEAD + beyond.CYCLE
    tip[:, 0] = np.where(behind, 1e-3 * np.exp(-(t - t[behind][0]) / 0.02), 5e-3)
    course = flexible.Course(t, tip, tip, tip)
    one = beyond.moved(course)
    assert one.behind == pytest.approx(1e-3, rel=1e-3)
    assert one.largest == pytest.approx(5e-3, rel=1e-3)
    assert one.off < 1e-8


@pytest.mark.full
def test_computed_torque_errs_by_less_than_a_tenth_of_a_millimetre_on_the_flexible_machine():
    course = flexible.follow(computed_torque(LOW))
    assert course.largest[0] < 0.1e-3
    # the static error along y, 0.35 mm by calibration of the ram's mass
    assert flexible.at_rest(course)[1] == pytest.approx(0.352e-3, abs=2e-6)


@pytest.mark.slow
def test_of_all_rows_rigid_and_flexible_only_two_following_errors_are_not_met():
    study = find("bouzgarrou2001")
    rows = study.claims([experiment.work(None) for experiment in study.experiments])
    missed = [row.claim for row in rows if row.verdict != MET]
    assert missed == [
        "flexible, low gains, PID: error of s21", "flexible, high gains, computed torque: error of s21",
    ]  # fmt: skip
