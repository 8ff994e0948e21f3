"""First exits and balls where the answer is known."""

from __future__ import annotations

import numpy as np
import pytest

from gough.plan.ball import largest_ball, sphere
from gough.plan.first_exit import first_exits

STEP = 1e-3


def exits(*curves):
    """First exits of ways of one margin each."""
    found, behind = first_exits(
        lambda way, s: np.stack([curves[w](t) for w, t in zip(way, s, strict=True)])[:, None], len(curves), STEP, 1.0
    )
    return found


def test_a_limit_that_is_left_and_entered_again_ends_the_way_where_it_is_left():
    assert exits(lambda s: np.cos(10 * s) + 0.5) == pytest.approx(2 * np.pi / 30, abs=1e-15)


@pytest.mark.parametrize("middle", [0.3, 0.30037, 0.3005])
def test_a_dip_that_is_over_before_the_next_sample_is_found(middle):
    width = 1e-5  # a hundredth of a step
    found = exits(lambda s: (s - middle) ** 2 - width**2)
    assert found == pytest.approx(middle - width, abs=1e-12)


def test_a_dip_that_stays_above_is_none_and_what_ends_beyond_the_longest_is_none():
    assert np.isinf(exits(lambda s: (s - 0.3) ** 2 + 1e-12, lambda s: 1.2 - s)).all()


def test_a_pose_on_a_limit_has_no_way_beyond_it_and_all_the_way_back():
    found = exits(lambda s: -s, lambda s: s * (0.5 - s), lambda s: 0.25 - s)
    np.testing.assert_allclose(found, [0, 0.5, 0.25], atol=1e-15)


def test_what_is_no_number_is_outside():
    with np.errstate(invalid="ignore"):
        assert exits(lambda s: np.sqrt(0.3 - s)) == pytest.approx(0.3, abs=1e-15)


def test_the_first_of_several_limits_counts_and_the_margins_behind_tell_which():
    found, behind = first_exits(lambda way, s: np.stack([0.7 - s, 0.2 - s, 0.9 - s], -1), 1, STEP, 1.0)
    assert found[0] == pytest.approx(0.2, abs=1e-15)
    assert behind.argmin() == 1 and behind[0, 1] < 0


def test_directions_lie_evenly_on_the_sphere():
    d = sphere(600)
    np.testing.assert_allclose(np.linalg.norm(d, axis=1), 1)
    nearest = np.sort(np.arccos(np.clip(d @ d.T, -1, 1)), 1)[:, 1]
    assert np.degrees(nearest).min() > 5 and np.degrees(nearest).max() < 9


def ball(field):
    return largest_ball(lambda d, r: field(r[:, None] * d), 1.0, STEP)


def test_the_ball_between_planes_touches_the_nearest():
    normal = sphere(7)
    offset = np.array([0.9, 0.8, 0.61, 0.7, 0.75, 0.6, 0.65])
    r, d, behind = ball(lambda p: offset - p @ normal.T)
    assert r == pytest.approx(0.6, rel=1e-12) and behind.argmin() == 5
    np.testing.assert_allclose(d, normal[5], atol=1e-6)


def test_the_ball_in_an_ellipsoid_is_its_least_half_axis():
    turn = np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))[0]
    halves = np.array([0.5, 0.55, 0.9])
    r, d, _ = ball(lambda p: 1 - ((p @ turn / halves) ** 2).sum(-1, keepdims=True))
    assert r == pytest.approx(0.5, rel=1e-12) and abs(d @ turn[:, 0]) == pytest.approx(1, rel=1e-10)


def test_the_ball_between_struts_is_what_the_shortest_way_to_their_ends_leaves():
    """Lengths |s + p| change fastest along the strut: the ball is min of longest - l and l - shortest."""
    A = np.random.default_rng(5).standard_normal((6, 3))
    l = np.linalg.norm(A, axis=1)
    low, high = l - np.array([0.9, 0.6, 0.45, 0.7, 0.8, 0.47]), l + np.array([0.46, 0.7, 0.9, 0.6, 0.5, 0.8])

    def field(p):
        now = np.linalg.norm(A + p[:, None], axis=-1)
        return np.concatenate([now - low, high - now], 1)

    assert ball(field)[0] == pytest.approx(0.45, rel=1e-12)
