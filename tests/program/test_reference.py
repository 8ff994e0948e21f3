"""Motions: derivatives, chunks, the books, and the frame of the program."""

import numpy as np
import pytest

from gough.frames import abc_of_rotation_np, rotation_of_abc_np, rotation_vector_np
from gough.program import Circle, Ellipse, Polyline
from gough.program.blocks import CURVE, Arc, Block, Line, Rest
from gough.program.course import Course, Rules, course_of
from gough.program.feed import Feed, Limits
from gough.program.path import Path
from gough.program.reference import Motion
from gough.program.segments import norm

from .corners import chain_of, random_path, surface

LIMITS = Limits(rapid=0.3, acceleration=2.0, angular_rate=1.0, angular_acceleration=5.0)
HALF = (0.1, -0.05, 0.2)
BLOCKS = [
    Block(Line((0, 0, 0), (0.04, 0, 0.01)), (0, 0, 0), HALF, feed=0.05, line=11),
    Block(Arc((0.04, 0, 0.01), (0.04, 0.03, 0.01), (0, 0, 1), 4.0, 0.02), HALF, (0.3, 0.2, -0.1), feed=0.04, line=12),
]
_END = Path(BLOCKS).point(np.array([1]), Path(BLOCKS).length[1:])[0]
BLOCKS += [
    Block(Rest(tuple(_END)), (0.3, 0.2, -0.1), (0.1, 0.5, 0.2), feed=0.3, line=13),
    Block(Line(tuple(_END), (0, 0, 0)), (0.1, 0.5, 0.2), (0.1, 0.5, 0.2), rapid=True, line=14),
]
FRAME = rotation_of_abc_np(np.array([0.4, -0.7, 1.9]))


@pytest.fixture(params=["as programmed", "frame turned"])
def motion(request, machine):
    path = Path(BLOCKS)
    if request.param == "frame turned":
        path = path.placed([0.1, -0.2, 0.3], FRAME)
    return Motion(path, Course(path, path), Feed(path, LIMITS), machine)


def smooth(motion, Ts, k):
    """Samples with no change of phase within one sample of them: there the motion has all derivatives."""
    f = motion.feed
    ends = np.sort(np.concatenate([f.profile.phases.times, f.times])) + motion.lead_in
    near = np.clip(np.searchsorted(ends, k * Ts), 1, len(ends) - 1)
    return np.minimum(np.abs(ends[near] - k * Ts), np.abs(ends[near - 1] - k * Ts)) > 1.5 * Ts


def test_twist_is_the_rate_of_the_pose_and_its_rate_the_rate_of_the_twist(motion):
    Ts = 1e-4
    r = motion.sample(0, motion.count(Ts), Ts)
    k = np.arange(1, len(r.x) - 1)
    k = k[smooth(motion, Ts, k)]
    # central differences err by Ts^2 / 6 times the third derivative, at most 100 m/s3 and 1000 rad/s3 here
    v = (r.x[k + 1, :3] - r.x[k - 1, :3]) / (2 * Ts)
    np.testing.assert_allclose(v, r.xd[k, :3], atol=1e-7)
    R = rotation_of_abc_np(r.x[:, 3:])
    w = rotation_vector_np(R[k + 1] @ np.swapaxes(R[k - 1], -1, -2)) / (2 * Ts)
    np.testing.assert_allclose(w, r.xd[k, 3:], atol=1e-6)
    rate = (r.xd[k + 1] - r.xd[k - 1]) / (2 * Ts)
    np.testing.assert_allclose(rate, r.xdd[k], atol=1e-5)


def test_path_length_tangent_normal_and_axis_belong_to_the_pose(motion):
    Ts = 1e-3
    r = motion.sample(0, motion.count(Ts), Ts)
    speed = np.linalg.norm(r.xd[:, :3], axis=1)
    np.testing.assert_allclose(speed, r.sd[:, 0], atol=1e-15)
    np.testing.assert_allclose(r.tangent * r.sd, r.xd[:, :3], atol=1e-15)
    np.testing.assert_allclose(np.linalg.norm(r.tangent, axis=1), 1, rtol=1e-14)
    turning = r.curvature[:, 0] > 0
    np.testing.assert_allclose(np.linalg.norm(r.normal[turning], axis=1), 1, rtol=1e-14)
    np.testing.assert_array_equal(r.normal[~turning], 0)
    towards = (r.xdd[:, :3] * r.normal).sum(1)
    np.testing.assert_allclose(towards[turning], (r.curvature * r.sd**2)[turning, 0], atol=1e-14)
    np.testing.assert_allclose(r.axis, rotation_of_abc_np(r.x[:, 3:])[..., 2], atol=1e-15)
    assert (np.diff(r.s[:, 0]) >= 0).all()
    assert r.s[-1, 0] == motion.path.s0[-1]


def test_a_motion_sampled_in_chunks_is_the_motion_sampled_whole_bit_for_bit(motion):
    Ts = 1e-3
    n = motion.count(Ts)
    whole = motion.sample(0, n, Ts), motion.book(0, n, Ts)
    rng = np.random.default_rng(2)
    cuts = np.unique(np.concatenate([[0, 1, 2, 9, n], rng.integers(0, n, 25)]))
    parts = [(motion.sample(a, b, Ts), motion.book(a, b, Ts)) for a, b in zip(cuts[:-1], cuts[1:], strict=True)]
    for which in (0, 1):
        for name in whole[which]._fields:
            joined = np.concatenate([getattr(part[which], name) for part in parts])
            np.testing.assert_array_equal(joined, getattr(whole[which], name), err_msg=name)


@pytest.mark.full
def test_an_ellipse_sampled_in_chunks_is_the_ellipse_sampled_whole_bit_for_bit(machine):
    motion = Ellipse(first=0.1, second=0.02, feed=0.3, turns=1.7, plane=(0.3, 0.2, 0.1)).plan(machine)
    n = motion.count(1e-3)
    whole = motion.sample(0, n, 1e-3)
    parts = [motion.sample(a, min(a + 13, n), 1e-3) for a in range(0, n, 13)]
    for name in whole._fields:
        np.testing.assert_array_equal(np.concatenate([getattr(p, name) for p in parts]), getattr(whole, name))


def test_the_book_counts_feed_moves_only(motion):
    Ts = 1e-3
    n = motion.count(Ts)
    book = motion.book(0, n, Ts)
    t = np.arange(n) * Ts
    times = motion.feed.times
    assert set(book.line[t < times[-1]]) == {11, 12, 13, 14}
    np.testing.assert_array_equal(book.counted, t < times[3])  # the fourth block is a rapid
    np.testing.assert_array_equal(book.line[t >= times[-1]], 0)
    np.testing.assert_array_equal(book.s, motion.sample(0, n, Ts).s[:, 0])
    np.testing.assert_allclose(book.window[(t > times[0]) & (t < times[1])], 5e-3 + 0.1 * 0.05, rtol=1e-15)


def test_the_tool_rests_before_and_after(machine):
    program = Circle(radius=0.05, feed=0.05, lead_in=0.1, settle=0.2)
    r = program.sample(1e-3, machine)
    motion = program.plan(machine)
    assert motion.duration == pytest.approx(0.3 + 0.1 * np.pi / 0.05 + 0.05 / 2, rel=1e-14)
    assert len(r.x) == motion.count(1e-3)
    np.testing.assert_array_equal(r.x[:100], np.repeat(r.x[:1], 100, 0))
    np.testing.assert_array_equal(r.xd[:100], 0)
    np.testing.assert_array_equal(r.x[-200:], np.repeat(r.x[-1:], 200, 0))
    np.testing.assert_array_equal(r.xd[-200:], 0)
    np.testing.assert_array_equal(r.xdd[-200:], 0)
    assert not motion.book(0, 100, 1e-3).counted.any()


def test_the_origin_places_the_program_in_w(machine):
    origin = np.array([0.1, 0.2, -1.0, 0.2, -0.1, 0.5])
    own = Circle(radius=0.05, feed=0.05, abc=(0.1, 0.2, 0.3))
    placed = own.replace(origin=origin)
    a, b = own.sample(5e-3, machine), placed.sample(5e-3, machine)
    R = rotation_of_abc_np(origin[3:])
    np.testing.assert_allclose(b.x[:, :3], origin[:3] + a.x[:, :3] @ R.T, atol=1e-15)
    np.testing.assert_allclose(b.axis, a.axis @ R.T, atol=1e-15)
    own_R = rotation_of_abc_np(np.array([0.1, 0.2, 0.3]))
    np.testing.assert_allclose(rotation_of_abc_np(b.x[0, 3:]), R @ own_R, atol=1e-15)
    np.testing.assert_array_equal(a.s, b.s)


def test_home_is_the_origin_where_the_program_gives_none(machine):
    machine.home = np.array([0.0, 0.0, -1.008, 0.0, 0.0, 0.0])
    r = Polyline(points=[[0, 0, 0], [0.1, 0, 0]], feed=0.05).sample(1e-2, machine)
    np.testing.assert_array_equal(r.x[0], machine.home)
    np.testing.assert_allclose(r.x[-1], [0.1, 0, -1.008, 0, 0, 0], atol=1e-16)


def test_angles_pass_unchanged_where_the_frame_is_not_turned(machine):
    """No wrap: c may go beyond 180 degrees, as a machine with such an axis would."""
    path = Path([Block(Rest((0, 0, 0)), (0, 0, 3.0), (0, 0, 4.0), feed=0.5)])
    motion = Motion(path, Course(path, path), Feed(path, LIMITS), machine)
    c = motion.sample(0, motion.count(1e-3), 1e-3).x[:, 5]
    assert c[-1] == pytest.approx(4.0, rel=1e-15)
    assert np.abs(np.diff(c)).max() < 1e-3


def test_angles_in_a_turned_frame_have_no_jumps(machine):
    blocks = [Block(Rest((0, 0, 0)), (0, 0, -3.0), (0.3, 0.2, 4.0), feed=0.5)]
    for turn in ([0, 0, 2.5], [0.2, -0.1, -2.5]):
        path = Path(blocks).placed([0, 0, 0], rotation_of_abc_np(np.array(turn)))
        motion = Motion(path, Course(path, path), Feed(path, LIMITS), machine)
        x = motion.sample(0, motion.count(1e-3), 1e-3).x
        assert np.abs(np.diff(x[:, 3:], axis=0)).max() < 2e-3
        R = path.rotation(path.angles(np.zeros(1, int), path.extent))
        np.testing.assert_allclose(np.sin(x[-1, 3:]), np.sin(abc_of_rotation_np(R)[0]), atol=1e-12)


def test_an_ellipse_is_run_at_its_feed(machine):
    program = Ellipse(first=0.1, second=0.03, feed=0.05)
    r = program.sample(1e-3, machine)
    middle = slice(200, -500)
    np.testing.assert_allclose(np.linalg.norm(r.xd[middle, :3], axis=1), 0.05, rtol=1e-14)
    on = (r.x[:, 0] / 0.1) ** 2 + (r.x[:, 1] / 0.03) ** 2
    np.testing.assert_allclose(on, 1, atol=1e-14)


TOOL = (0.01, -0.02, 0.15)


def with_tools(path_blocks):
    """The same blocks with a tool offset from the second on: its tip stands elsewhere, so the rest of the path does."""
    out, shift = list(path_blocks[:1]), None
    R = rotation_of_abc_np(np.array(path_blocks[0].abc1))
    shift = -R @ np.array(TOOL)
    for block in path_blocks[1:]:
        start, end = (np.array(p) + shift for p in block.segment)
        out.append(block._replace(segment=Line(tuple(start), tuple(end)), tool=TOOL))
    return out


def short_lines(points, abc):
    return Path(chain_of(points, abc=abc))


CORNERS = {
    "lines": (random_path(3, 14, kinds=("line",), turn=1.5), Rules("blend", 1e-4)),
    "arcs and helices": (random_path(4, 14, turn=1.5, straight=0.3), Rules("blend", 1e-4, smooth=True)),
    "tilting": (random_path(5, 14, turn=1.5, tilt=0.05), Rules("blend", 1e-4, axis_tolerance=5e-3, smooth=True)),
    "splines": (short_lines(*surface(120, tilt=0.1)), Rules("blend", 1e-4, spline=True)),
    "tool": (
        Path(with_tools(chain_of(np.cumsum([[0, 0, 0], [9, 0, 0], [0, 9, 0], [3, 3, 3]], 0) * 1e-3,
                                 abc=np.array([[0, 0, 0], [0, 0, 0], [0.1, 0, 0.1], [0.1, 0.2, 0]])))),
        Rules("blend", 1e-4, axis_tolerance=5e-3),
    ),
}  # fmt: skip


@pytest.mark.quick("*-tool", "as programmed-lines")
@pytest.mark.parametrize("name", CORNERS)
@pytest.mark.parametrize("frame", [None, FRAME], ids=["as programmed", "frame turned"])
def test_along_blends_splines_and_tools_every_derivative_is_that_of_the_one_before(name, frame, machine):
    path, rules = CORNERS[name]
    path = path if frame is None else path.placed([0.1, -0.2, 0.3], frame)
    course = course_of(path, rules)
    assert (course.path.kind == CURVE).sum() > 1
    limits = LIMITS._replace(jerk=50.0)
    motion = Motion(path, course, Feed(course.path, limits, "blend", "jerk_limited"), machine)
    Ts = 2e-5
    n = min(motion.count(Ts), 120_000)
    r = motion.sample(0, n, Ts)
    k = np.arange(1, n - 1)
    k = k[smooth(motion, Ts, k)]
    assert len(k) > 0.8 * n
    # central differences err by Ts^2 / 6 times the next but one derivative: jerk 50 m/s3 on an arm of 0.15 m, and its
    # rate, for which a change within 0.2 ms is allowed for; the rest is rounding, 1e-16 / Ts
    v = (r.x[k + 1, :3] - r.x[k - 1, :3]) / (2 * Ts)
    np.testing.assert_allclose(v, r.xd[k, :3], atol=1e-7)
    R = rotation_of_abc_np(r.x[:, 3:])
    w = rotation_vector_np(R[k + 1] @ np.swapaxes(R[k - 1], -1, -2)) / (2 * Ts)
    np.testing.assert_allclose(w, r.xd[k, 3:], atol=1e-6)
    rate = (r.xd[k + 1] - r.xd[k - 1]) / (2 * Ts)
    np.testing.assert_allclose(rate, r.xdd[k], atol=1e-3)
    # and at the junctions nothing jumps: the velocity changes by what the acceleration allows
    most = np.abs(r.xdd).max(0)
    assert (np.abs(np.diff(r.xd, axis=0)) <= most * Ts * 1.1 + 1e-12).all()
    parts = [motion.sample(a, min(a + 977, 5000), Ts) for a in range(0, 5000, 977)]
    for field in r._fields:
        np.testing.assert_array_equal(np.concatenate([getattr(p, field) for p in parts]), getattr(r, field)[:5000])


def test_with_a_tool_offset_t_stands_beside_the_tip_and_the_tip_is_on_the_path(machine):
    path = CORNERS["tool"][0]
    motion = Motion(path, Course(path, path), Feed(path, LIMITS), machine)
    n = motion.count(1e-3)
    r, book = motion.sample(0, n, 1e-3), motion.book(0, n, 1e-3)
    tip = path.point(book.block.astype(int), book.u)
    arm = rotation_of_abc_np(r.x[:, 3:]) @ np.array(TOOL)
    known = np.where((book.block > 0)[:, None], arm, 0.0)
    np.testing.assert_allclose(r.x[:, :3] - tip, known, atol=1e-15)
    # where the tool changes the machine stays where it is
    change = np.flatnonzero(np.diff(book.block))[0]
    assert norm(np.diff(r.x[change - 1 : change + 3, :3], axis=0)).max() < 1e-4
    assert norm(np.diff(tip[change : change + 2], axis=0))[0] > 0.1


def test_the_log_s_path_length_is_that_of_the_programmed_path(machine):
    path, rules = CORNERS["lines"]
    course = course_of(path, rules)
    motion = Motion(path, course, Feed(course.path, LIMITS), machine)
    n = motion.count(1e-3)
    r, book = motion.sample(0, n, 1e-3), motion.book(0, n, 1e-3)
    assert book.s[-1] == path.s0[-1]
    assert r.s[-1, 0] == course.path.s0[-1] < path.s0[-1]
    assert (np.diff(book.s) >= 0).all()
    assert set(book.line) == {0, *range(1, 15)}
