"""Courses: what belongs to what, which rules apply, and that a tool that follows its course stays in the tolerance."""

import numpy as np
import pytest

from gough.errors import ProgramError
from gough.frames import quaternion_of_abc_np, rotation_of_abc_np
from gough.measure import ContourMeter
from gough.program import NCProgram, Polyline
from gough.program.blocks import CURVE, LINE, Arc, Block, Line, Rest
from gough.program.course import Course, Rules, course_of
from gough.program.feed import Feed, Limits
from gough.program.path import Path
from gough.program.reference import Motion
from gough.program.segments import norm

from .corners import chain_of, random_path, surface

LIMITS = Limits(rapid=0.3, acceleration=2.0, angular_rate=1.0, angular_acceleration=5.0, jerk=50.0)
BLEND = Rules("blend", 20e-6, smooth=True)
SQUARE = [(0, 0, 0), (0.05, 0, 0), (0.05, 0.05, 0), (0, 0.05, 0), (0, 0, 0)]
FRAME = (np.array([0.2, -0.1, -1.0]), rotation_of_abc_np(np.array([0.3, 0.2, -1.0])))


def motion_of(path, rules, machine, profile="trapezoid"):
    course = course_of(path, rules)
    return Motion(path, course, Feed(course.path, LIMITS, rules.corner, profile), machine)


def test_where_nothing_is_blended_the_course_is_the_path():
    path = random_path(0, 30)
    for rules in (Rules(), Rules("stop"), Rules("constant")):
        course = course_of(path, rules)
        assert course.path is path
        assert course.stretches is None
    straight = Path([Block(Line((0, 0, 0), (0.1, 0, 0)), feed=0.1)])
    assert course_of(straight, Rules("blend", 20e-6)).stretches is None


@pytest.mark.quick("True-0.0")
@pytest.mark.parametrize("tilt", [0.0, 0.02])
@pytest.mark.parametrize("placed", [False, True])
def test_the_place_on_the_path_is_continuous_grows_and_belongs_to_its_block(tilt, placed):
    path = random_path(1, 80, tilt=tilt)
    path = path.placed(*FRAME) if placed else path
    course = course_of(path, BLEND)
    j = np.repeat(np.arange(len(course.path)), 33)
    u = np.tile(np.linspace(0, 1, 33), len(course.path)) * course.path.extent[j]
    block, inside, s = course.place(j, u)
    assert (np.diff(s) >= -1e-15).all()
    # no jump between blocks, and none at the knot inside a blend: a step of a 32nd goes about as far
    ends = np.arange(len(j)) % 33 == 0
    assert np.abs(np.diff(s)[ends[1:]]).max() < 1e-12
    assert s[0] == 0
    assert s[-1] == path.s0[-1]
    np.testing.assert_allclose(path.s0[block] + inside, s, atol=1e-14)
    assert (inside <= path.length[block]).all()
    # what is driven is near what was asked for, place by place: a blend cuts its corner by some of its size
    away = norm(course.path.point(j, u) - path.point(block, inside))
    assert away.max() < 3 * 20e-6
    np.testing.assert_array_equal(np.unique(block), np.arange(80))


def test_rests_keep_their_blocks_and_turns_their_extent():
    path = Path(
        [
            *chain_of([(0, 0, 0), (0.05, 0, 0), (0.05, 0.05, 0)]),
            Block(Rest((0.05, 0.05, 0)), (0, 0, 0), (0.2, 0, 0), 0.2, line=8),
            Block(Rest((0.05, 0.05, 0)), (0.2, 0, 0), (0.2, 0, 0), dwell=0.3, line=9),
            *chain_of([(0.05, 0.05, 0), (0, 0.05, 0), (0, 0, 0)], abc=np.tile([0.2, 0, 0], (3, 1))),
        ]
    )
    course = course_of(path, BLEND)
    turn = int(np.flatnonzero(course.path.line == 8)[0])
    j = np.array([turn, turn, turn + 1])
    block, u, s = course.place(j, np.array([0.0, 0.15, 0.0]))
    np.testing.assert_array_equal(block, [2, 2, 3])
    np.testing.assert_array_equal(u, [0.0, 0.15, 0.0])
    np.testing.assert_allclose(s, 0.1, rtol=1e-15)
    assert (course.path.kind == CURVE).sum() == 64  # two right angles, 32 pieces each; none beside the rests


CASES = {
    "lines": ({"kinds": ("line",)}, BLEND),
    "lines, arcs and helices": ({}, BLEND),
    "tangent": ({"straight": 0.8}, BLEND),
    "tilting": ({"tilt": 0.03, "straight": 0.2}, BLEND),
    "wide": ({"kinds": ("line", "arc")}, Rules("blend", 1e-3)),
    "axis of its own": ({"tilt": 0.03}, Rules("blend", 50e-6, axis_tolerance=1e-3)),
}


@pytest.mark.quick("lines-*", "wide-*", "lines, arcs and helices-jerk_limited")
@pytest.mark.parametrize("profile", ["trapezoid", "jerk_limited"])
@pytest.mark.parametrize("name", CASES)
def test_a_tool_that_follows_its_course_stays_within_the_tolerances_of_the_path(name, profile, machine):
    options, rules = CASES[name]
    path = random_path(6, 40, turn=2.0, **options).placed(*FRAME)
    motion = motion_of(path, rules, machine, profile)
    Ts = motion.duration / 6000
    n = motion.count(Ts)
    r = motion.sample(0, n, Ts)
    R = path.rotation(np.zeros((1, 3)))[0]
    x = np.concatenate([r.x[:, :3], quaternion_of_abc_np(r.x[:, 3:])], 1)
    found = ContourMeter(motion)(0, n, Ts, x)
    assert R.shape == (3, 3)
    assert found.contour_error.max() <= rules.tolerance + 1e-12
    assert found.contour_error.max() > 0.6 * rules.tolerance  # a right angle leaves its legs by 0.7 of it
    axis = rules.axis_tolerance or rules.tolerance / 0.1
    # the meter's closest point is where the search for the blend found it, but for places equally near
    assert found.orientation_error.max() <= axis * 1.01
    assert np.abs(found.lag).max() < 3 * rules.tolerance


def test_a_square_is_run_without_a_stop_and_within_the_tolerance(machine):
    sharp, round_ = (Polyline(points=SQUARE, feed=0.05, corner=corner) for corner in ("stop", "blend"))
    a, b = sharp.plan(machine), round_.plan(machine)
    assert b.feed.duration < a.feed.duration
    state = b.feed.at(np.linspace(0.1, b.feed.duration - 0.1, 20_000))
    assert state.ud.min() > 5e-3
    assert a.path.s0[-1] == b.path.s0[-1]
    assert b.course.path.s0[-1] < a.path.s0[-1]


def test_the_words_of_an_nc_program_hold_unless_the_option_says_otherwise():
    blocks = chain_of(SQUARE)
    path = Path([b._replace(tolerance=t) for b, t in zip(blocks, (-1.0, 0.0, np.inf, 3e-5), strict=True)])
    course = course_of(path, Rules(None, 1e-5))
    assert set(course.path.line[course.path.kind == CURVE]) == {3}  # the last block has no junction behind it
    np.testing.assert_array_equal(np.unique(course.path.tolerance), [-1.0, 0.0, 1e-5, 3e-5])
    size = {}
    for tolerance in (1e-5, 2e-5):
        course = course_of(path, Rules(None, tolerance))
        size[tolerance] = course.path.length[course.path.kind == CURVE].sum()
    assert size[2e-5] == pytest.approx(2 * size[1e-5], rel=1e-6)
    stopped = course_of(path, Rules("stop"))
    np.testing.assert_array_equal(stopped.path.tolerance, 0)
    assert stopped.path.kind.max() == LINE
    every = course_of(path, Rules("blend", 1e-5))
    assert set(every.path.line[every.path.kind == CURVE]) == {1, 2, 3}
    np.testing.assert_array_equal(path.tolerance, [-1.0, 0.0, np.inf, 3e-5])  # the programmed path is as it was


def test_a_rapid_runs_into_a_feed_move_at_its_feed():
    blocks = chain_of(SQUARE[:3])
    path = Path([blocks[0]._replace(rapid=True, feed=0.0), blocks[1]])
    course = course_of(path, BLEND)
    blended = course.path.kind == CURVE
    assert not course.path.rapid[blended].any()
    np.testing.assert_array_equal(course.path.feed[blended], 0.05)
    slow = course_of(Path([blocks[0]._replace(feed=0.02), blocks[1]]), BLEND).path
    np.testing.assert_array_equal(slow.feed[slow.kind == CURVE], 0.02)
    both = course_of(Path([b._replace(rapid=True) for b in blocks]), BLEND).path
    assert both.rapid.all()


def test_a_spline_without_a_tolerance_is_an_error_with_its_cure():
    with pytest.raises(ProgramError) as caught:
        course_of(Path(chain_of(SQUARE)), Rules(spline=True))
    assert str(caught.value) == (
        'no corner has a tolerance, so no lines can run as a spline; write corner = "blend", or G64 in the program'
    )


@pytest.mark.parametrize("tilt", [0.0, 0.1])
def test_a_surface_of_short_lines_runs_as_splines_within_the_tolerance(tilt, machine):
    points, abc = surface(3000, tilt=tilt)
    path = Path(chain_of(points, abc=abc)).placed(*FRAME)
    motion = motion_of(path, Rules("blend", 20e-6, spline=True), machine)
    n, Ts = 8000, motion.feed.duration / 8000
    r = motion.sample(0, n, Ts)
    x = np.concatenate([r.x[:, :3], quaternion_of_abc_np(r.x[:, 3:])], 1)
    found = ContourMeter(motion)(0, n, Ts, x)
    assert found.contour_error.max() <= 20e-6
    assert found.orientation_error.max() <= 2e-4
    assert found.contour_error.max() > 1e-6
    assert (np.diff(r.s[:, 0]) > 0).all()
    assert (motion.course.path.kind == CURVE).mean() > 0.9


def test_circles_of_the_course_are_those_of_the_path(machine):
    text = "G21 G90 G1 X10 F600\nG3 X10 Y0 I-10 J0\nG1 X20\nM2"
    motion = NCProgram(text=text, corner="blend").plan(machine)
    assert len(motion.course.path) > len(motion.path)
    (circle,) = motion.path.circles
    n = motion.count(1e-3)
    r, book = motion.sample(0, n, 1e-3), motion.book(0, n, 1e-3)
    x = np.concatenate([r.x[:, :3], np.tile([1.0, 0, 0, 0], (n, 1))], 1)
    found = ContourMeter(motion)(0, n, 1e-3, x)
    np.testing.assert_array_equal(found.circle[book.block == 1], 1)
    assert np.abs(found.radial_error).max() <= 20e-6
    assert circle.radius == pytest.approx(0.01)


def test_parts_of_every_kind_of_segment_are_those_parts():
    """Trimmed at both ends: a line, an arc, a helix and an ellipse keep their points, tangents and bends."""
    from gough.program.blocks import Ellipse
    from gough.program.cut import cut

    path = Path(
        [
            Block(Line((0, 0, 0), (0.05, 0, 0)), feed=1.0),
            Block(Arc((0.05, 0, 0), (0.05, 0.02, 0), (0, 0, 1), 1.5), feed=1.0),
        ]
    )
    helix = Path([Block(Arc((0.05, 0, 0), (0.0, 0, 0), (0, 0, -1), 5.0, 0.02), feed=1.0)])
    tall = Path([Block(Ellipse((0, 0, 0), (0.02, 0, 0), (0, 0.05, 0), 0.3, 4.0), feed=1.0)])
    for one in (path, helix, tall):
        i = np.arange(len(one))
        lo, hi = 0.2 * one.length, 0.7 * one.length
        batches, index = cut(one, i, lo, hi)
        for k in i:
            batch, at = batches[one.kind[k]], index[k : k + 1]
            assert batch.length[index[k]] == pytest.approx(0.5 * one.length[k], rel=1e-12)
            for x in (0.0, 0.4, 1.0):
                s = x * batch.length[at]
                u = lo[k : k + 1] + x * (hi - lo)[k : k + 1]
                for what in ("point", "tangent", "bend"):
                    own, known = getattr(batch, what)(at, s), getattr(one, what)(i[k : k + 1], u)
                    np.testing.assert_allclose(own, known, atol=1e-10 * max(1, np.abs(known).max()), err_msg=what)


@pytest.mark.full
def test_a_course_is_made_of_a_course_no_worse():
    """Blending what is smooth changes nothing: the blends of a course have no corners."""
    course = course_of(random_path(9, 60, tilt=0.02), BLEND)
    again = course_of(course.path, BLEND)
    assert isinstance(again, Course)
    left = np.flatnonzero(again.path.kind == CURVE).size - np.flatnonzero(course.path.kind == CURVE).size
    assert left == 0


def any_path(seed):
    """A path of any scale: blocks of micrometres to metres, kinks of 1e-8 rad to cusps, somewhere in space."""
    rng = np.random.default_rng(seed)
    if seed % 3:
        kinds = (("line", "arc"), ("line", "arc", "helix"))[seed % 3 - 1]
        path = random_path(
            seed, int(rng.integers(2, 40)), kinds, rng.choice([0, 1e-6, 1e-2, 1.0]), size=10.0 ** rng.uniform(-6, 0),
            turn=rng.choice([1e-8, 1e-3, 0.3, 3.1]), straight=rng.choice([0, 0.5]),
        )  # fmt: skip
    else:
        points = np.cumsum(rng.normal(size=(30, 3)) * 10.0 ** rng.uniform(-7, -1, (30, 1)), 0)
        points = points[np.append(True, norm(np.diff(points, axis=0)) > 2e-9)]
        path = Path(chain_of(points, abc=rng.normal(size=points.shape) * rng.choice([0, 1e-3, 0.1])))
    R_WO = rotation_of_abc_np(rng.normal(size=3) * rng.integers(0, 2))
    rules = Rules(
        "blend", 10.0 ** rng.uniform(-8, -1), rng.choice([None, 1e-6, 1e-2, 1.0]), bool(rng.integers(2)),
        bool(rng.integers(2)),
    )  # fmt: skip
    return path.placed(rng.normal(size=3) * 10.0 ** rng.uniform(-3, 1), R_WO), rules


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 400, 50))
@pytest.mark.filterwarnings("error")
def test_any_path_has_a_course_within_its_tolerance(first, machine):
    for seed in range(first, first + 50):
        path, rules = any_path(seed)
        motion = motion_of(path, rules, machine, ("trapezoid", "jerk_limited")[seed % 2])
        driven = motion.course.path
        j = np.repeat(np.arange(len(driven)), 17)
        u = np.tile(np.linspace(0, 1, 17), len(driven)) * driven.extent[j]
        block, _, s = motion.course.place(j, u)
        assert (np.diff(s) >= -1e-12).all(), seed
        frame = np.concatenate(driven.frame(j, u), 1)
        assert np.isfinite(frame).all(), seed
        assert np.isfinite([driven.third(), driven.sharpest(), *driven.turning()]).all(), seed
        window = np.full(len(j), 5e-3 + 10 * rules.tolerance)
        distance, _, _ = ContourMeter(motion).closest(frame[:, :3], s, window, block)
        # 1e-13 m: rounding of positions of 10 m, many times over
        assert distance.max() <= rules.tolerance * (1 + 1e-9) + 1e-13, (seed, distance.max() / rules.tolerance)
