"""Reversals and their glitches, on made-up signals whose answer is known."""

import numpy as np
import pytest

from gough.measure import CONTRACT, STUDIES, reversals
from gough.measure.reversal import ReversalMeter

TS = 1e-3
T = np.arange(4000) * TS


def signal(peaks, level=1e-6):
    """A steady error with peaks (time, height above it), each 1 ms wide."""
    error = np.full(len(T), level)
    for at, height in peaks:
        error[round(at / TS)] += height
    return error


def speed(*zeros):
    """A velocity that changes sign at the given times, +0.01 m/s at first."""
    sign = np.where(np.searchsorted(zeros, T, "right") % 2 == 0, 1.0, -1.0)
    return (0.01 * sign)[:, None]


COUNTED = np.ones(len(T), bool)


def test_a_glitch_is_the_largest_error_after_less_the_median_before():
    (found,) = reversals(TS, speed(1.0), signal([(1.05, 9e-6), (1.15, 4e-6), (0.9, 50e-6)]), COUNTED)
    assert found.joint == 0
    assert found.time == pytest.approx(1.0, abs=TS)
    assert found.glitch == pytest.approx(9e-6, rel=1e-9)  # one peak before does not move the median


def test_what_comes_later_than_200_ms_is_another_glitch():
    (found,) = reversals(TS, speed(1.0), signal([(1.2, 3e-6), (1.202, 9e-6)]), COUNTED)
    assert found.glitch == pytest.approx(3e-6, rel=1e-9)


@pytest.mark.parametrize(
    "peaks, glitch",
    [
        ([(1.06, 9e-6)], 9e-6),
        ([(0.985, 9e-6)], 9e-6),  # 20 ms before are looked at
        ([(0.97, 9e-6)], 0.0),  # neither before nor after
        ([(1.11, 9e-6)], 0.0),
        ([(1.06, 9e-6), (0.9, 2e-6)], 7e-6),  # the largest before counts
        ([(1.06, 9e-6), (0.74, 2e-6)], 9e-6),  # more than 250 ms before
    ],
)
def test_the_studies_look_from_20_ms_before_to_100_ms_after(peaks, glitch):
    (found,) = reversals(TS, speed(1.0), signal(peaks), COUNTED, STUDIES)
    assert found.glitch == pytest.approx(glitch, abs=1e-15)


def test_the_time_lies_where_the_velocity_is_zero():
    v = (0.3 * (T - 1.0004))[:, None]
    (found,) = reversals(TS, v, signal([]), COUNTED)
    assert found.time == pytest.approx(1.0004, abs=1e-9)


def test_a_stop_without_turning_back_is_no_reversal_and_with_it_is_one():
    v = speed(2.0)
    v[900:1200] = 0  # stops and goes on
    v[1900:2100] = 0  # stops and comes back
    (found,) = reversals(TS, v, signal([]), COUNTED)
    assert found.time == pytest.approx(2.1, abs=TS)


def test_rounding_at_rest_is_no_reversal():
    v = 1e-9 * np.random.default_rng(0).normal(size=(len(T), 6))
    assert reversals(TS, v, signal([]), COUNTED) == []


def test_reversals_in_rapids_are_not_told_and_their_errors_not_looked_at():
    counted = COUNTED.copy()
    counted[1500:2500] = False
    found = reversals(TS, speed(1.45, 2.0, 3.0), signal([(1.6, 1e-3)]), counted)
    assert [r.time for r in found] == pytest.approx([1.45, 3.0], abs=TS)  # the one at 2.0 is in the rapid
    assert max(r.glitch for r in found) < 1e-9


@pytest.mark.parametrize("glitch", [CONTRACT, STUDIES], ids=["contract", "studies"])
def test_chunks_of_any_size_find_what_the_whole_finds(glitch):
    rng = np.random.default_rng(1)
    v = np.stack([np.sin(T * f + p) for f, p in rng.uniform(1, 8, (6, 2))], 1) * 0.02
    error = np.abs(rng.normal(size=len(T))) * 1e-6
    counted = rng.random(len(T)) < 0.9
    whole = reversals(TS, v, error, counted, glitch)
    assert len(whole) > 20
    for size in (1, 37, 500):
        meter = ReversalMeter(TS, glitch)
        for k in range(0, len(T), size):
            part = slice(k, k + size)
            meter.update(v[part], error[part], counted[part])
            assert len(meter._error) < 600 + size  # memory does not grow with the run
        assert meter.close() == whole


def test_a_velocity_that_is_nan_is_no_reversal_and_an_error_that_is_nan_is_a_glitch_that_is_nan():
    v, error = speed(1.0), signal([])
    v[500] = np.nan
    error[1100] = np.nan
    (found,) = reversals(TS, v, error, COUNTED)
    assert np.isnan(found.glitch)
