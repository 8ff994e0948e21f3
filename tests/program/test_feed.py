"""Feed profiles: closed forms, limits, look-ahead."""

import numpy as np
import pytest

from gough.program.blocks import Arc, Block, Line, Rest
from gough.program.course import Course
from gough.program.feed import Feed, Limits
from gough.program.junctions import stops
from gough.program.path import Path
from gough.program.profiles.trapezoid import trapezoids
from gough.program.segments import norm

LIMITS = Limits(rapid=0.3, acceleration=2.0, angular_rate=1.0, angular_acceleration=5.0)


def chain(points, feed=0.05, **more):
    pairs = zip(points[:-1], points[1:], strict=True)
    return Path([Block(Line(tuple(a), tuple(b)), feed=feed, **more) for a, b in pairs])


def random_path(seed, count=40):
    """Lines and tangent arcs, turns of the tool, rapids, rests: whatever a program can hold."""
    rng = np.random.default_rng(seed)
    blocks, at, abc = [], np.zeros(3), np.zeros(3)
    for k in range(count):
        to = abc + rng.choice([0, 0.05], 3) * rng.normal(size=3)
        feed, rapid, choice = float(rng.uniform(0.01, 0.3)), bool(rng.random() < 0.15), rng.integers(4)
        if choice == 0:
            to = abc + 0.2 * rng.normal(size=3)
            blocks.append(Block(Rest(tuple(at)), tuple(abc), tuple(to), feed, rapid, k))
        elif choice == 1:
            center = at + np.append(rng.normal(size=2) * 0.03, 0)
            sweep = float(rng.uniform(0.1, 6) * rng.choice([-1, 1]))
            d, c, s = at - center, np.cos(sweep), np.sin(sweep)
            end = center + [c * d[0] - s * d[1], s * d[0] + c * d[1], 0]
            blocks.append(Block(Arc(tuple(at), tuple(center), (0, 0, 1), sweep), tuple(abc), tuple(to), feed, rapid, k))
            at = end
        else:
            end = at + rng.normal(size=3) * 10 ** rng.uniform(-4, -1)
            blocks.append(Block(Line(tuple(at), tuple(end)), tuple(abc), tuple(to), feed, rapid, k))
            at = end
        abc = to
    return Path(blocks)


def test_time_of_one_line_is_the_closed_form():
    L, F, a = 0.1, 0.05, 2.0
    assert Feed(chain([(0, 0, 0), (L, 0, 0)]), LIMITS).duration == pytest.approx(L / F + F / a, rel=1e-15)


def test_time_of_a_line_too_short_for_its_feed_is_the_closed_form():
    L, a = 1e-4, 2.0  # F^2 / a = 1.25 mm are needed
    assert Feed(chain([(0, 0, 0), (L, 0, 0)]), LIMITS).duration == pytest.approx(2 * np.sqrt(L / a), rel=1e-14)


def test_straight_lines_in_a_row_take_the_time_of_one():
    points = [(x, 0, 0) for x in (0, 0.01, 0.0105, 0.04, 0.1)]
    assert Feed(chain(points), LIMITS).duration == pytest.approx(0.1 / 0.05 + 0.05 / 2, rel=1e-14)


def test_short_lines_are_looked_ahead_through():
    """1000 lines of 1 um: one ramp up and one down, as if they were one line."""
    points = [(x, 0, 0) for x in np.linspace(0, 1e-3, 1001)]
    assert Feed(chain(points, feed=0.3), LIMITS).duration == pytest.approx(2 * np.sqrt(1e-3 / 2), rel=1e-12)


def test_a_square_stops_at_its_corners():
    square = chain([(0, 0, 0), (0.1, 0, 0), (0.1, 0.1, 0), (0, 0.1, 0), (0, 0, 0)])
    assert Feed(square, LIMITS, "stop").duration == pytest.approx(4 * (0.1 / 0.05 + 0.05 / 2), rel=1e-14)


def test_constant_corners_keep_the_speed():
    square = chain([(0, 0, 0), (0.1, 0, 0), (0.1, 0.1, 0), (0, 0.1, 0), (0, 0, 0)])
    feed = Feed(square, LIMITS, "constant")
    assert feed.duration == pytest.approx(0.4 / 0.05 + 0.05 / 2, rel=1e-14)
    t = np.linspace(0.03, feed.duration - 0.03, 5000)
    np.testing.assert_array_equal(feed.at(t).ud, 0.05)


@pytest.mark.parametrize("angle, halts", [(0.0099, False), (0.0101, True)])
def test_a_bend_above_a_hundredth_of_a_degree_is_a_corner(angle, halts):
    a = np.radians(angle)
    bent = chain([(0, 0, 0), (0.1, 0, 0), (0.1 + 0.1 * np.cos(a), 0.1 * np.sin(a), 0)])
    assert (trapezoids(Feed(bent, LIMITS).cells).v0[1] == 0) == halts


def test_a_line_runs_into_its_tangent_arc_without_a_stop_at_the_lower_feed():
    path = Path(
        [
            Block(Line((0, 0, 0), (0.1, 0, 0)), feed=0.05),
            Block(Arc((0.1, 0, 0), (0.1, 0.05, 0), (0, 0, 1), np.pi / 2), feed=0.03),
        ]
    )
    assert trapezoids(Feed(path, LIMITS).cells).v0[1] == 0.03


@pytest.mark.parametrize("corner", ["stop", "constant"])
def test_a_rapid_a_rest_and_the_end_of_a_turn_stop_the_feed(corner):
    straight = [Line((0.1 * k, 0, 0), (0.1 * k + 0.1, 0, 0)) for k in range(4)]
    blocks = [
        Block(straight[0], feed=0.05), Block(straight[1], rapid=True), Block(straight[2], feed=0.05),
        Block(Rest((0.3, 0, 0)), dwell=0.5), Block(straight[3], feed=0.05),
    ]  # fmt: skip
    feed = Feed(Path(blocks), LIMITS, corner)
    np.testing.assert_array_equal(trapezoids(feed.cells).v0, 0)
    one = 0.1 / 0.05 + 0.05 / 2
    assert feed.duration == pytest.approx(3 * one + 0.5 + 0.1 / 0.3 + 0.3 / 2, rel=1e-14)


def test_a_tool_that_begins_to_turn_stops_unless_corners_are_constant():
    blocks = [
        Block(Line((0, 0, 0), (0.1, 0, 0)), feed=0.05),
        Block(Line((0.1, 0, 0), (0.2, 0, 0)), (0, 0, 0), (0.1, 0, 0), feed=0.05),
    ]
    assert trapezoids(Feed(Path(blocks), LIMITS, "stop").cells).v0[1] == 0
    assert trapezoids(Feed(Path(blocks), LIMITS, "constant").cells).v0[1] == 0.05


def test_a_turn_at_rest_is_a_trapezoid_of_its_angle():
    path = Path([Block(Rest((0, 0, 0)), (0, 0, 0), (0.3, 0, 0), feed=0.1)])
    assert Feed(path, LIMITS).duration == pytest.approx(0.3 / 0.1 + 0.1 / 5.0, rel=1e-14)


def test_the_angular_rate_bounds_the_feed():
    path = Path([Block(Line((0, 0, 0), (0.1, 0, 0)), (0, 0, 0), (1.0, 0, 0), feed=0.3)])  # 10 rad/m
    feed = Feed(path, LIMITS)
    assert feed.speed[0] == pytest.approx(0.1, rel=1e-14)
    assert feed.acceleration[0] == pytest.approx(0.5, rel=1e-14)


def test_the_feed_on_a_small_arc_is_bounded_by_the_acceleration_towards_its_centre():
    path = Path([Block(Arc((0.005, 0, 0), (0, 0, 0), (0, 0, 1), 6.0), feed=0.3)])
    assert Feed(path, LIMITS).speed[0] == pytest.approx(np.sqrt(2.0 * 0.005), rel=1e-14)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("corner", ["stop", "constant"])
def test_limits_hold_and_position_is_the_integral_of_speed(seed, corner):
    path = random_path(seed)
    feed = Feed(path, LIMITS, corner)
    t = np.linspace(0, feed.duration, 40_001)
    i, u, ud, udd = feed.at(t)[:4]
    assert (ud >= -1e-12).all()
    assert (ud <= feed.speed[i] * (1 + 1e-9)).all()
    assert (np.abs(udd) <= feed.acceleration[i] * (1 + 1e-9)).all()
    whole = np.concatenate([[0], np.cumsum(path.extent)])[i] + u
    # the trapezoidal rule is exact inside a ramp; where the speed bends it errs by a dt^2 / 8, and more where it jumps
    step = t[1] - t[0]
    within = (i[1:] == i[:-1]) & (udd[1:] == udd[:-1])
    np.testing.assert_allclose(np.diff(whole)[within], ((ud[1:] + ud[:-1]) / 2 * step)[within], atol=1e-13)
    assert within.mean() > 0.9
    # speeds at the junctions fit: the rule v1^2 <= v0^2 + 2 a L, both ways
    part = trapezoids(feed.cells)
    rise = part.v1**2 - part.v0**2
    assert (np.abs(rise) <= 2 * feed.acceleration * path.extent * (1 + 1e-9) + 1e-15).all()
    # trapezoid by block: the area under the speed is the block's extent, exactly
    area = (
        part.t_up * (part.v0 + part.peak) / 2
        + part.t_down * (part.v1 + part.peak) / 2
        + np.where(path.extent > 0, part.t_cruise * part.peak, 0)
    )
    np.testing.assert_allclose(area, path.extent, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("seed", range(6))
def test_twist_stays_within_the_angular_limits(seed, machine):
    from gough.program.reference import Motion

    path = random_path(seed)
    motion = Motion(path, Course(path, path), Feed(path, LIMITS, "stop"), machine)
    r = motion.sample(0, motion.count(2e-3), 2e-3)
    assert norm(r.xd[:, 3:]).max() <= LIMITS.angular_rate * (1 + 1e-9)
    assert norm(r.xdd[:, 3:]).max() <= LIMITS.angular_acceleration * (1 + 1e-9)


def test_the_profile_ends_exactly_at_the_end_and_rests_there():
    feed = Feed(random_path(3), LIMITS)
    last = len(feed.extent) - 1
    for t in (feed.duration, feed.duration + 1.0):
        i, u, ud, udd = feed.at(np.array([t]))[:4]
        assert (i[0], u[0], ud[0], udd[0]) == (last, feed.extent[last], 0.0, 0.0)
    i, u, ud, udd = feed.at(np.array([-0.1]))[:4]
    assert (i[0], u[0], ud[0], udd[0]) == (0, 0.0, 0.0, 0.0)


def test_speed_is_continuous_except_at_constant_corners():
    feed = Feed(random_path(7), LIMITS)
    t = np.linspace(0, feed.duration, 200_001)
    step = t[1] - t[0]
    _, _, ud, _ = feed.at(t)[:4]
    assert np.abs(np.diff(ud)).max() <= 5.0 * step * (1 + 1e-6)  # the largest of all accelerations


def test_no_slower_profile_than_needed_every_block_reaches_a_limit():
    """Look-ahead is greedy: at each junction the speed is its cap, or a full ramp leads to it or from it."""
    feed, path = Feed(random_path(11), LIMITS), random_path(11)
    cap = np.where(~stops(path), np.minimum(feed.speed[:-1], feed.speed[1:]), 0.0)
    part = trapezoids(feed.cells)
    v = part.v0[1:]
    gain = 2 * feed.acceleration * path.extent
    ramp_in = np.isclose(v**2, part.v0[:-1] ** 2 + gain[:-1], rtol=1e-9)
    ramp_out = np.isclose(v**2, part.v1[1:] ** 2 + gain[1:], rtol=1e-9)
    assert (np.isclose(v, cap) | ramp_in | ramp_out).all()
