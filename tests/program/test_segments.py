"""Segments: parametrised by arc length, consistent derivatives, closest points against dense search."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize_scalar

from gough.program.blocks import Arc, Block, Blocks, Ellipse, Line, Rest
from gough.program.segments import norm


def batches(segments):
    return Blocks(Block(segment) for segment in segments).batches()


TURNED = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
X, Y, Z = (tuple(v) for v in TURNED)

SEGMENTS = {
    "line": Line((0.1, -0.2, 0.3), (0.15, 0.1, 0.2)),
    "arc": Arc((0.1, 0, 0), (0, 0, 0.02), (0, 0, 1), 1.9),
    "arc backwards": Arc((0.1, 0, 0), (0, 0.05, 0), (0, 0, 1), -2.5),
    "two turns": Arc((0.02, 0.01, 0), (0, 0, 0), (0, 0, 1), 4 * np.pi),
    "arc in space": Arc(tuple(0.07 * TURNED[0]), (0, 0, 0), Z, 3.0),
    "helix": Arc((0.05, 0, 0), (0, 0, 0), (0, 0, 1), 5.5 * np.pi, 0.03),
    "helix backwards": Arc((0.05, 0, 0.1), (0, 0, 0), (0, 0, 1), -3.0, -0.02),
    "ellipse": Ellipse((0.01, 0, 0.02), (0.1, 0, 0), (0, 0.03, 0), 0.4, 5.0),
    "tall ellipse": Ellipse((0, 0, 0), (0.02, 0, 0), (0, 0.09, 0), -1.0, 4.0 * np.pi),
    "ellipse in space": Ellipse((0.1, 0.2, 0), tuple(0.08 * TURNED[0]), tuple(0.05 * TURNED[1]), 2.0, 1.5),
    "round ellipse": Ellipse((0, 0, 0), (0.05, 0, 0), (0, 0.05, 0), 0.0, 2 * np.pi),
}


@pytest.fixture(params=SEGMENTS, ids=lambda name: name.replace(" ", "-"))
def segment(request):
    """The batch that holds one segment of each of two, so that the numbers i matter; the second is asked."""
    other = SEGMENTS["helix"] if isinstance(SEGMENTS[request.param], Arc) else SEGMENTS[request.param]
    kind = {Line: 0, Arc: 1, Ellipse: 2}[type(SEGMENTS[request.param])]
    return batches([other, SEGMENTS[request.param]])[kind]


def ask(batch, what, s, *rows):
    s = np.atleast_1d(np.asarray(s, float))
    return getattr(batch, what)(np.ones(len(s), int), s, *rows)


def test_speed_along_arc_length_is_one(segment):
    s = np.linspace(1e-3, segment.length[1] - 1e-3, 97)
    h = 1e-6  # central differences: h^2 p''' / 6 is below 1e-10 for radii above 1 cm, rounding 1e-16 / h
    rate = (ask(segment, "point", s + h) - ask(segment, "point", s - h)) / (2 * h)
    np.testing.assert_allclose(rate, ask(segment, "tangent", s), atol=1e-8)
    np.testing.assert_allclose(norm(ask(segment, "tangent", s)), 1, rtol=1e-14)


def test_bend_is_the_derivative_of_the_tangent(segment):
    s = np.linspace(1e-3, segment.length[1] - 1e-3, 97)
    h = 1e-6  # rounding 1e-16 / h, times curvature up to 100 / m
    rate = (ask(segment, "tangent", s + h) - ask(segment, "tangent", s - h)) / (2 * h)
    bend = ask(segment, "bend", s)
    np.testing.assert_allclose(rate, bend, atol=1e-6)
    # the tangent of the sharpest point is never exceeded
    assert norm(bend).max() <= segment.sharpest()[1] * (1 + 1e-12)
    np.testing.assert_allclose((bend * ask(segment, "tangent", s)).sum(1), 0, atol=1e-12)


def test_third_is_the_largest_rate_of_the_bend(segment):
    s, h = np.linspace(1e-3, segment.length[1] - 1e-3, 9001), 1e-6
    rate = norm((ask(segment, "bend", s + h) - ask(segment, "bend", s - h)) / (2 * h))
    # 1e-4: the samples stand 50 um apart at radii of 8 mm and more; 1e-6: rounding 1e-16 / h times the curvature
    assert segment.third()[1] * (1 - 1e-4) - 1e-6 <= rate.max() <= segment.third()[1] * (1 + 1e-5) + 1e-6


def test_length_is_the_integral_of_the_chords(segment):
    s = np.linspace(0, segment.length[1], 20_001)
    chords = norm(np.diff(ask(segment, "point", s), axis=0)).sum()
    # a chord of length d on radius r is short by d^3 / 24 r^2
    assert chords == pytest.approx(segment.length[1], rel=1e-6)
    assert chords <= segment.length[1] * (1 + 1e-12)


def test_ellipse_arc_length_is_right_to_a_picometre():
    batch = batches([SEGMENTS["ellipse"]])[2]
    i = np.zeros(1, int)
    for share in (0.1, 0.37, 0.8, 1.0):
        s = share * batch.length
        p = batch.point(i, s)[0] - [0.01, 0, 0.02]
        phi = np.arctan2(p[1] / 0.03, p[0] / 0.1)
        phi += 2 * np.pi * np.round((0.4 + 5.0 * share - phi) / (2 * np.pi))
        # the parameter differs from share * 5 by less than a turn; take the branch that integrates to s
        known = min(
            (
                quad(lambda u: np.hypot(0.1 * np.sin(u), 0.03 * np.cos(u)), 0.4, phi + k * 2 * np.pi, epsabs=1e-14)[0]
                for k in (-1, 0, 1)
            ),
            key=lambda value: abs(value - s[0]),
        )
        assert abs(known - s[0]) < 1e-12


def test_arc_ends_where_the_angle_says():
    batch = batches([SEGMENTS["helix"]])[1]
    end = batch.point(np.zeros(1, int), batch.length)[0]
    np.testing.assert_allclose(end, [0.05 * np.cos(5.5 * np.pi), 0.05 * np.sin(5.5 * np.pi), 0.03], atol=1e-15)
    assert batch.length[0] == pytest.approx(np.hypot(0.05 * 5.5 * np.pi, 0.03), rel=1e-15)


def test_line_ends_at_its_end_bit_for_bit():
    rng = np.random.default_rng(0)
    ends = rng.normal(size=(200, 2, 3))
    batch = batches([Line(tuple(a), tuple(b)) for a, b in ends])[0]
    np.testing.assert_array_equal(batch.point(np.arange(200), batch.length), ends[:, 1])


@pytest.mark.quick("line", "arc*", "helix*", "two-turns", "round-ellipse")
def test_closest_point_agrees_with_a_dense_search(segment):
    """Also for points far off the curve, where there are several minima, and for windows that cut it short."""
    rng = np.random.default_rng(1)
    length = segment.length[1]
    n = 60
    cut = np.sort(rng.uniform(0, length, (n, 2)), axis=1)
    cut[::3] = [0, length]
    near = rng.uniform(cut[:, 0], cut[:, 1])
    far = np.where(np.arange(n) % 2 == 0, 1e-4, 0.03)[:, None]
    p = ask(segment, "point", near) + far * rng.normal(size=(n, 3))
    s = segment.closest(np.ones(n, int), p, cut[:, 0], cut[:, 1], near)
    assert (s >= cut[:, 0]).all()
    assert (s <= cut[:, 1]).all()
    found = norm(p - ask(segment, "point", s))
    for k in range(n):
        grid = np.linspace(*cut[k], 4001)
        distance = norm(p[k] - ask(segment, "point", grid))
        j = int(np.argmin(distance))
        step = (cut[k, 1] - cut[k, 0]) / 4000
        bounds = max(cut[k, 0], grid[j] - step), min(cut[k, 1], grid[j] + step)
        best = minimize_scalar(
            lambda u, k=k: norm(p[k] - ask(segment, "point", u))[0],
            bounds=bounds,
            method="bounded",
            options={"xatol": 1e-12},
        )
        known = min(best.fun, distance[0], distance[-1])
        assert found[k] <= known + 1e-14, (k, found[k] - known)  # rounding
        assert found[k] >= known - 1e-12, k  # the search itself stops at sqrt(eps) of its argument


def test_on_a_circle_of_several_turns_the_nearest_turn_is_taken():
    batch = batches([SEGMENTS["two turns"]])[1]
    i, turn = np.zeros(3, int), np.hypot(0.02, 0.01) * 2 * np.pi
    s = np.array([0.2, 0.9, 1.4]) * turn
    p = batch.point(i, s) * 1.01
    lo, hi = np.zeros(3), np.full(3, 2 * turn)
    np.testing.assert_allclose(batch.closest(i, p, lo, hi, s + 0.3 * turn), s, atol=1e-13)
    # half a turn and more away the other turn is nearer
    away = np.array([1, 1, -1]) * 0.7 * turn
    np.testing.assert_allclose(batch.closest(i, p, lo, hi, s + away), s + np.array([1, 1, -1]) * turn, atol=1e-13)


def test_at_the_end_of_a_full_circle_the_closest_point_may_be_at_its_start():
    """The turn nearest to `near` would lie behind the end; the circle has the point one turn before."""
    batch = batches([Arc((0.01, 0, 0), (0, 0, 0), (0, 0, 1), 2 * np.pi)])[1]
    i, lo, hi = np.zeros(2, int), np.zeros(2), np.full(2, batch.length[0])
    p = 0.011 * np.array([[np.cos(0.1), np.sin(0.1), 0], [np.cos(-0.1), np.sin(-0.1), 0]])
    s = batch.closest(i, p, lo, hi, np.array([hi[0], 0.0]))
    np.testing.assert_allclose(s, [0.001, hi[0] - 0.001], atol=1e-15)


@pytest.mark.parametrize("name", [name for name in SEGMENTS if "ellipse" in name])
def test_an_ellipse_begins_and_ends_where_its_angles_say(name):
    e = SEGMENTS[name]
    batch = batches([e])[2]
    for s, phi in ((np.zeros(1), e.begin), (batch.length, e.begin + e.sweep)):
        known = np.array(e.center) + np.cos(phi) * np.array(e.first) + np.sin(phi) * np.array(e.second)
        np.testing.assert_allclose(batch.point(np.zeros(1, int), s)[0], known, atol=1e-15)


def test_a_point_that_is_nan_has_a_closest_point_that_is_nan(segment):
    p = np.array([[np.nan, 0, 0]])
    s = segment.closest(np.ones(1, int), p, np.zeros(1), segment.length[1:], np.zeros(1))
    assert np.isnan(s).all()


def test_a_moved_segment_is_the_segment_moved(segment):
    shift = np.array([0.3, -1.0, 0.2])
    moved = segment.placed(shift, TURNED)
    s = np.linspace(0, segment.length[1], 17)
    np.testing.assert_allclose(ask(moved, "point", s), shift + ask(segment, "point", s) @ TURNED.T, atol=1e-15)
    np.testing.assert_allclose(ask(moved, "bend", s), ask(segment, "bend", s) @ TURNED.T, atol=1e-13)


def test_a_resting_point_has_no_length():
    batch = batches([Rest((1.0, 2.0, 3.0))])[3]
    assert batch.length[0] == 0
    np.testing.assert_array_equal(batch.point(np.zeros(1, int), np.zeros(1)), [[1, 2, 3]])
