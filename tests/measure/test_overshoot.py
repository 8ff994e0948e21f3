"""Overshoot: what a joint runs past a reference that has come to rest, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from gough.measure.overshoot import OvershootMeter


def stop(times, q_r):
    """A reference that runs to q_r and rests, with its speed."""
    return np.where(times < 1.0, q_r * times, q_r), np.where(times < 1.0, q_r, 0.0)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_a_damped_swing_overshoots_by_its_first_peak_whatever_the_direction_and_the_chunks(direction):
    """e^(-a t) sin(w t) behind the stop: its first peak, at tan(w t) = w / a, by calculus."""
    t = np.arange(3000) * 1e-3
    q_r, qd_r = stop(t, 0.2 * direction)
    a, w = 3.0, 20.0
    after = np.maximum(t - 1.0, 0)
    q = q_r + direction * 1e-3 * np.exp(-a * after) * np.sin(w * after)
    q[t < 1.0] = q_r[t < 1.0] + 5e-3 * direction  # ahead while it moves: no overshoot
    peak = np.arctan(w / a) / w
    expected = 1e-3 * np.exp(-a * peak) * np.sin(w * peak)
    for size in (3000, 7, 999):
        meter = OvershootMeter()
        for k in range(0, 3000, size):
            part = slice(k, k + size)
            meter.update(q_r[part, None], qd_r[part, None], q[part, None])
        # between samples of 1 ms the peak is flat: w^2 dt^2 / 8 of it
        assert meter.largest == pytest.approx(expected, rel=(w * 1e-3) ** 2 / 8 * 1.1)


def test_a_joint_that_stays_short_does_not_overshoot_and_one_that_never_moved_tells_nothing():
    t = np.arange(2000) * 1e-3
    q_r, qd_r = stop(t, 0.2)
    meter = OvershootMeter()
    meter.update(q_r[:, None], qd_r[:, None], 0.99 * q_r[:, None])
    assert meter.largest == 0.0
    still = OvershootMeter()
    still.update(np.zeros((5, 2)), np.zeros((5, 2)), np.ones((5, 2)))
    still.update(np.zeros((0, 2)), np.zeros((0, 2)), np.ones((0, 2)))
    assert still.largest is None


def test_a_number_that_is_none_stays_in_sight():
    meter = OvershootMeter()
    meter.update([[0.0], [1.0], [1.0]], [[1.0], [0.0], [0.0]], [[0.0], [np.nan], [1.5]])
    meter.update([[1.0]], [[0.0]], [[1.0]])
    assert np.isnan(meter.largest)
