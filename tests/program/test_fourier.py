"""The Fourier motion: rest at both ends, derivatives, the path it leaves, the file it is written to."""

from __future__ import annotations

import numpy as np
import pytest

import gough as gk
from gough.errors import ExperimentError, ProgramError
from gough.program import Fourier, program_from_table


@pytest.fixture(scope="module")
def nist():
    return gk.load_machine("nist-octahedral")


def series(size, power, seed, K=4):
    k = np.arange(1.0, K + 1)[:, None]
    rows = size * np.random.default_rng(seed).uniform(-1, 1, (K, 3)) / k
    rows[-1] -= (k**power * rows).sum(0) / K**power
    return rows


@pytest.fixture
def whole():
    return Fourier(period=5.0, cycles=2, sine=series(0.04, 1, 0), cosine=series(0.04, 2, 1),
                   turn_sine=series(0.05, 1, 2), turn_cosine=series(0.05, 2, 3))  # fmt: skip


def test_the_motion_begins_and_ends_at_home_at_rest(nist, whole):
    motion = whole.plan(nist)
    for k in (0, 10_000, 10_200):
        r = motion.sample(k, k + 1, 1e-3)
        assert r.x[0] == pytest.approx(nist.home, abs=1e-12)
        assert np.abs(r.xd).max() < 1e-12 and np.abs(r.xdd).max() < 1e-11
    assert motion.duration == pytest.approx(10.25)


@pytest.mark.full
def test_twist_and_acceleration_are_the_derivatives_of_the_pose(nist, whole):
    h = 1e-4
    r = whole.plan(nist).sample(10_000, 40_000, h)
    assert np.abs((r.x[2:, :3] - r.x[:-2, :3]) / (2 * h) - r.xd[1:-1, :3]).max() < 1e-6
    assert np.abs((r.xd[2:] - r.xd[:-2]) / (2 * h) - r.xdd[1:-1]).max() < 1e-5
    assert np.abs((r.q[2:] - r.q[:-2]) / (2 * h) - r.qd[1:-1]).max() < 1e-6


def test_samples_in_chunks_are_the_samples_of_the_whole(nist, whole):
    motion = whole.plan(nist)
    full, part = motion.sample(0, 3000, 1e-3), motion.sample(1000, 2000, 1e-3)
    for a, b in zip(full, part, strict=True):
        assert np.array_equal(a[1000:2000], b)


@pytest.mark.parametrize("kind", ["tip", "line", "turn"])
def test_the_path_lies_where_the_motion_goes(nist, kind):
    """A curve through 128 points of the shortest period is some 1e-9 of the amplitude from it; turns are straight."""
    tip = series(0.04, 1, 0)
    given = {"tip": {"sine": tip}, "line": {"sine": tip * [1, 0, 0]}, "turn": {"turn_sine": series(0.05, 1, 2)}}[kind]
    motion = Fourier(period=5.0, **given).plan(nist)
    r, book = motion.sample(0, 5001, 1e-3), motion.book(0, 5001, 1e-3)
    resting = motion.path.kind[book.block] == 3
    off = np.linalg.norm(motion.path.point(book.block, np.where(resting, 0, book.u)) - r.x[:, :3], axis=1)
    assert off.max() < 2e-7
    assert np.abs(motion.path.angles(book.block, book.u) - r.x[:, 3:]).max() < 2e-5
    assert (np.diff(book.s) >= -1e-12).all(), "path length never runs back"


@pytest.mark.full
def test_it_runs_and_its_contour_error_is_that_of_the_loop(nist, whole):
    log = gk.simulate(nist, gk.ComputedTorque(bandwidth=20.0), whole, log_every=10)
    assert not log.failed
    off = np.linalg.norm((log["x"] - log["x_r"])[:, :3], axis=1)
    assert log.metrics["contour_error"]["max"] < 3e-5
    assert (log["contour_error"] <= off + 1e-6).all(), "the path is no farther than the point of it that was asked for"


def test_a_table_of_a_file_is_the_same_program(nist, whole):
    assert program_from_table({"kind": "fourier", **whole.to_file()}) == whole


def test_a_motion_that_would_begin_with_a_jump_is_refused():
    with pytest.raises(
        ExperimentError, match="sine: the motion must begin without speed: the sum of k sine_k must be 0"
    ):
        Fourier(period=5.0, sine=[[0.1, 0, 0], [0.1, 0, 0]])
    with pytest.raises(
        ExperimentError, match="turn_cosine: the motion must begin without acceleration: the sum of k.2"
    ):
        Fourier(period=5.0, turn_cosine=[[0.1, 0, 0], [0.1, 0, 0]])


def test_series_of_different_lengths_or_none_are_refused():
    with pytest.raises(ExperimentError, match="cosine: all series must have equally many harmonics, got 3 .limit 2."):
        Fourier(period=5.0, sine=np.zeros((2, 3)), cosine=np.zeros((3, 3)))
    with pytest.raises(ExperimentError, match="a motion needs a coefficient"):
        Fourier(period=5.0)
    with pytest.raises(ExperimentError, match="a row of three numbers for each harmonic, got 2 x 2"):
        Fourier(period=5.0, sine=np.zeros((2, 2)))


def test_a_motion_that_does_not_move_is_refused(nist):
    with pytest.raises(ProgramError, match="neither the tip nor the angles move"):
        Fourier(period=5.0, sine=np.zeros((2, 3))).plan(nist)
