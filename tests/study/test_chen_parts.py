"""Parts of the study of Chen and Tsai, 2008: motion, averages, bound, and the claims that follow."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gough.study import find
from gough.study.chen2008 import checks, offsets
from gough.study.chen2008.beyond import effective
from gough.study.chen2008.harmonic import Harmonic
from gough.study.chen2008.setup import CENTER, CIRCLE, ELLIPSE, INERTIAS, SCREWS, Course, machine, program, scaled


@pytest.mark.parametrize("semi", [CIRCLE, ELLIPSE])
def test_the_reference_is_the_motion_of_the_paper(semi):
    m, Ts = machine(), 1e-3
    motion = program(semi).plan(m)
    row = motion.sample(0, motion.count(Ts), Ts)
    phi = 6.0 * np.arange(len(row.x)) * Ts
    a, b = semi
    inside = phi <= 12.0
    x = np.stack([a * np.cos(phi), b * np.sin(phi), 0 * phi], -1) + CENTER
    xd = 6.0 * np.stack([-a * np.sin(phi), b * np.cos(phi), 0 * phi], -1)
    assert_allclose(row.x[inside], x[inside], rtol=0, atol=1e-12)
    assert_allclose(row.xd[inside], xd[inside], rtol=0, atol=1e-11)
    assert_allclose(row.xdd[inside], -36.0 * (x - CENTER)[inside], rtol=0, atol=1e-10)


def test_the_motion_begins_at_full_speed_and_its_path_goes_on_behind_both_ends():
    m = machine()
    motion = Harmonic(semi=[0.05, 0.03], rate=6.0, time=0.5).plan(m)
    assert motion.sample(0, 1, 1e-3).sd[0, 0] == pytest.approx(0.18, rel=1e-12)
    assert motion.book(0, 1, 1e-3).s[0] > 2e-3


def test_scaling_is_of_all_that_is_uncertain_and_of_nothing_else():
    m = machine()
    M, heavier = m.mass_matrix(m.home), scaled(m, 1.5).mass_matrix(m.home)
    assert_allclose(heavier, 1.5 * M, rtol=0, atol=1e-12 * M.max())
    assert np.abs(scaled(m, 1.5, INERTIAS).mass_matrix(m.home) / M - 1).max() < 0.5
    assert scaled(m, 1.5, SCREWS).platform == m.platform


def test_the_bound_of_the_printed_ellipse_is_crossed_between_25_and_50_per_cent():
    """(s - 1) 72 = 26 at s = 1 + 26 / 72."""
    assert checks.disturbance(1 + 26 / 72) == pytest.approx(1, rel=1e-12)
    assert checks.disturbance(1.25) < 1 < checks.disturbance(1.5)


def test_effective_gains_are_the_printed_one_over_the_gradient():
    assert effective("area", CIRCLE) == pytest.approx((260, 260), rel=1e-9)
    assert effective("dimensionless", CIRCLE) == pytest.approx((0.65, 0.65), rel=1e-9)
    low, high = effective("dimensionless", ELLIPSE)
    assert (low, high) == pytest.approx((26 * 0.03 / 2, 26 * 0.05 / 2), rel=1e-3)


def test_a_course_settles_when_it_is_above_twice_its_steady_largest_for_the_last_time():
    t = np.arange(2001) * 1e-3
    course = Course(t, 1e-6 + 1e-4 * np.exp(-t / 0.05), np.zeros((2001, 3)), 0.0)
    assert course.steady == pytest.approx(1e-6, rel=1e-3)
    assert course.settled == pytest.approx(0.05 * np.log(100), abs=2e-3)


@pytest.mark.full
def test_the_linear_estimate_is_of_second_order():
    assert checks.order() == pytest.approx(4, abs=0.05)


@pytest.mark.full
def test_the_averages_of_an_offset_start_are_those_of_single_runs_and_the_claims_hold():
    found = offsets.averages([np.zeros(3)])[0]
    assert_allclose(found * 1e6, [0.083, 4.78, 9.58], rtol=0.01)  # MACHINES.md 3.3: 0.113 / 4.79 / 9.59 by another step
    study = find("chen2008")
    results = [experiment.work(None) for experiment in study.experiments]
    verdicts = {claim.claim: claim.verdict for claim in study.claims(results)}
    assert set(verdicts.values()) == {"met", "different by design"}
    different = [claim for claim, verdict in verdicts.items() if verdict == "different by design"]
    assert different == ["ellipse, printed equation and gains, 50 % on everything: steady contour error"]
