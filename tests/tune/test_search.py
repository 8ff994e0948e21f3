"""Searches: they find a minimum that is known, draw from a generator of their own, and end with the budget."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from gough.errors import ExperimentError
from gough.tune.search import Spent, cma_es, evolution

CENTRE = np.array([0.3, 0.7, 0.55])


def searched(method, seed: int, budget: int, cost):
    """All points tried, and what they cost."""
    points, costs = [], []

    def judge(asked):
        if len(points) + len(asked) > budget:
            raise Spent
        points.extend(asked)
        costs.extend(cost(one) for one in asked)
        return np.array(costs[-len(asked) :])

    method(judge, np.full(3, 0.5), 1.0, seed)
    return np.array(points), np.array(costs)


def bowl(u):
    """Of condition 100, as gains are: some matter, some hardly do."""
    return float(((u - CENTRE) ** 2 * [1.0, 10.0, 100.0]).sum())


@pytest.mark.parametrize("method", [cma_es, evolution])
def test_a_search_finds_the_minimum_of_a_bowl_and_stays_in_the_cube(method):
    points, costs = searched(method, 1, 600, bowl)
    assert (points >= 0).all() and (points <= 1).all() and len(points) <= 600
    # 1e-3 of the cube is where gains count as one (CLOSE); the flattest axis of the bowl is ten times as wide
    assert np.abs(points[np.argmin(costs)] - CENTRE).max() < 1e-2


@pytest.mark.parametrize("method", [cma_es, evolution])
def test_one_seed_is_one_search_to_the_last_bit_and_nobody_elses_numbers_are_touched(method):
    np.random.seed(5)
    state = np.random.get_state()[1].copy()
    first, again, other = (searched(method, seed, 100, bowl)[0] for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, other)
    np.testing.assert_array_equal(np.random.get_state()[1], state)


@pytest.mark.parametrize("method", [cma_es, evolution])
def test_points_that_cost_far_more_than_others_are_ranked_and_nothing_else(method):
    """A cliff of 1e9, as of candidates that are refused, in half of the cube."""
    points, costs = searched(method, 1, 600, lambda u: 1e9 if u[1] < 0.5 else bowl(u))
    assert np.abs(points[np.argmin(costs)] - CENTRE).max() < 1e-2


def test_without_its_package_cma_is_refused_with_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "cma", None)
    with pytest.raises(ExperimentError, match=r"tune.method: CMA-ES needs the package cma; pip install .gough\[tune\]"):
        searched(cma_es, 1, 10, bowl)
