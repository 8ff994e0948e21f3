"""Distributions: each against SciPy's, impossible ones by their rule, and a grammar that evaluates nothing."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from gough.errors import InputError
from gough.sweep.distributions import KINDS, distribution_of

U = np.linspace(0.001, 0.999, 333)
OTHERS = {
    "normal(1.0, 0.2) x": stats.norm(1.0, 0.2),
    "normal(1.0, 0.2, 0.7, 1.1) x": stats.truncnorm(-1.5, 0.5, 1.0, 0.2),
    "lognormal(3, 0.4) Hz": stats.lognorm(0.4, scale=3),
    "uniform(10, 20) Hz": stats.uniform(10, 10),
    "loguniform(0.1, 100) N": stats.loguniform(0.1, 100),
    "triangular(1, 2, 5) kg": stats.triang(0.25, 1, 4),
    "triangular(1, 1, 5) kg": stats.triang(0.0, 1, 4),
    "integers(-2, 4)": stats.randint(-2, 5),
}


@pytest.mark.parametrize("text", OTHERS)
def test_quantiles_are_those_of_scipy(text):
    # rounding of the two ways through logarithms and error functions
    assert distribution_of(text).quantile(U) == pytest.approx(OTHERS[text].ppf(U), rel=1e-12, abs=1e-12)


def test_every_kind_of_distribution_is_held_against_scipy_or_counted():
    held = {text.partition("(")[0] for text in OTHERS}
    assert held | {"choice"} == set(KINDS)
    values, counts = np.unique(distribution_of("choice(3, 1, 2) mm").quantile(U), return_counts=True)
    assert values.tolist() == [1, 2, 3] and counts.tolist() == [111, 111, 111]


def test_a_drawn_value_is_written_to_its_last_bit():
    found = distribution_of("normal(1.0, 0.2) x")
    for value in found.quantile(U):
        assert float(found.written(value).removesuffix(" x")) == value
    assert distribution_of("integers(0, 9)").written(3.0) == 3
    assert distribution_of("uniform(0, 1)").written(0.25) == 0.25


@pytest.mark.parametrize(
    ("text", "told"),
    {
        "normal(1, -0.2) x": "impossible distribution: the deviation must be above 0",
        "normal(1, 0) x": "impossible distribution: the deviation must be above 0",
        "normal(1, 0.1, 3, 2) x": "impossible distribution: the low end must be below the high one",
        "normal(0, 1, 8, 9) x": "impossible distribution: less than a millionth of it lies between its ends",
        "lognormal(0, 1) x": "impossible distribution: the median must be above 0",
        "uniform(2, 1) x": "impossible distribution: the low end must be below the high one",
        "loguniform(0, 1) x": "impossible distribution: the low end must be above 0",
        "triangular(1, 9, 2) x": "impossible distribution: the peak must lie between its ends",
        "integers(0.5, 2)": "impossible distribution: both ends must be whole numbers",
        "uniform(1) x": "uniform takes 2 numbers",
        "unifrom(1, 2) x": "no such distribution",
        "uniform(1, nan) x": "is not a number",
        "uniform(1 Hz, 2 Hz)": "is not a number",
        "uniform(1, 1e999)": "must be finite",
        "uniform(1, 2) furlong": "no unit 'furlong'",
        "__import__('os').system('x')": "is not a distribution",
        "uniform(9**9**9, 1)": "is not a number",
        "normal(" + "1," * 300 + "1)": "a distribution has at most 200 ASCII characters",
    }.items(),
)
def test_what_is_wrong_with_a_distribution_is_said(text, told):
    with pytest.raises(InputError) as caught:
        distribution_of(text)
    assert caught.value.problems[0].rule == told


def test_the_nearest_distribution_is_offered():
    with pytest.raises(InputError, match="did you mean uniform"):
        distribution_of("unifrom(1, 2)")


def test_all_quantiles_between_the_ends_are_finite_and_rise():
    u = np.array([2.0**-54, 0.3, 0.5, 0.7, 1 - 2.0**-53])
    for text in OTHERS:
        found = distribution_of(text).quantile(u)
        assert np.isfinite(found).all() and (np.diff(found) >= 0).all() and math.isfinite(found.sum())


@pytest.mark.parametrize("text", ["lognormal(5, 1000) kg", "uniform(-1e308, 1e308)", "normal(0, 1e308) x"])
def test_a_distribution_with_values_beyond_all_numbers_is_impossible(text):
    with pytest.raises(InputError, match="impossible distribution: some of its values are beyond all numbers, got"):
        distribution_of(text)
