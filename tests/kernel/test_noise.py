"""Noise: standard normal, uncorrelated, and a function of (seed, run, signal, tick) alone."""

import numpy as np
import pytest

from gough.errors import InputError
from gough.kernel import Schedule, Signal, compile, noise


def draw(size=6, lanes=8, native=True, runs=8, ticks=2000, seed=0, first_run=0, name="w", others=()):
    schedule = Schedule([*others, Signal(name, size, "noise")], log=(name,))
    return compile(schedule, lanes, native=native).start(seed=seed, runs=runs, first_run=first_run).advance(ticks)


def test_the_moments_are_those_of_a_normal_distribution():
    x = draw(ticks=20_000).ravel()
    n = x.size  # 960 000 numbers; each moment within 5 of its own standard deviations, a chance of 6e-7 to fail
    assert abs(x.mean()) < 5 / np.sqrt(n)
    assert abs(x.var() - 1) < 5 * np.sqrt(2 / n)
    assert abs((x**3).mean()) < 5 * np.sqrt(15 / n)
    assert abs((x**4).mean() - 3) < 5 * np.sqrt(96 / n)
    inside = np.mean(np.abs(x) < 1)
    assert abs(inside - 0.682689492) < 5 * np.sqrt(0.2166 / n)


def test_neighbouring_entries_runs_ticks_and_seeds_are_uncorrelated():
    x = draw(size=4, runs=16, ticks=20_000)
    other = draw(size=4, runs=16, ticks=20_000, seed=1)
    n = x.size
    for a, b in ((x[:-1], x[1:]), (x[:, :-1], x[:, 1:]), (x[..., :-1], x[..., 1:]), (x, other), (x[:-2], x[2:])):
        assert abs((a * b).mean()) < 5 / np.sqrt(n)
        assert abs(((a**2 - 1) * (b**2 - 1)).mean()) < 5 * 2 / np.sqrt(
            n
        )  # the pairs of Box and Muller share a radius hash


def test_no_number_comes_twice():
    x = draw(ticks=5000).ravel()
    assert np.unique(x).size == x.size


@pytest.mark.quick("1-*", "8-*")
@pytest.mark.parametrize("size", [1, 2, 5])
@pytest.mark.parametrize("lanes", [1, 2, 4, 8])
def test_machine_code_and_numpy_agree(lanes, size):
    got = draw(size=size, lanes=lanes, runs=3, ticks=50, seed=9)
    expected = draw(size=size, native=False, runs=3, ticks=50, seed=9)
    np.testing.assert_allclose(got, expected, rtol=1e-12)  # log, cos and sin within 4 ulp
    direct = np.array(
        [[noise.normals("w", size, noise.run_key(9, run), tick) for run in range(3)] for tick in range(50)]
    )
    assert np.array_equal(expected, direct)


def test_a_run_keeps_its_noise_in_whatever_batch_it_is():
    together = draw(runs=11, ticks=100)
    for run in range(11):
        assert np.array_equal(draw(runs=1, ticks=100, first_run=run)[:, 0], together[:, run])


def test_a_signal_keeps_its_noise_when_others_join():
    alone = draw(ticks=50)
    assert np.array_equal(draw(ticks=50, others=(Signal("a", 3, "noise"), Signal("z", 1, "noise"))), alone)
    assert not np.array_equal(draw(ticks=50, name="v"), alone)


def test_the_numbers_are_pinned():
    """A golden file of the format: a seed means the same noise in every version."""
    got = noise.normals("w", 3, noise.run_key(0, 0), 0)
    np.testing.assert_allclose(got, PINNED, rtol=1e-14)


PINNED = [2.0951356547074553, -1.0490932102631834, -0.48936978866250447]


def test_a_seed_must_be_a_whole_number():
    for seed in (-1, 1.5, 1 << 63, "x", None):
        with pytest.raises(InputError):
            noise.run_key(seed, 0)
