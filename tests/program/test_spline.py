"""Splines through short lines and through points: no jumps, tolerances, what stays a corner, a surface program."""

import time

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from gough.errors import ExperimentError
from gough.frames import rotation_of_abc_np
from gough.program.blocks import CURVE, LINE, Block, Line, Rest
from gough.program.course import Rules, course_of
from gough.program.feed import Feed, Limits
from gough.program.path import Path
from gough.program.segments import norm
from gough.program.spline import splined, through
from gough.program.standard.spline import Spline

from .corners import chain_of, distance_to_chain, surface

LIMITS = Limits(rapid=0.3, acceleration=2.0, angular_rate=1.0, angular_acceleration=5.0)
P, AXIS = 20e-6, 2e-4


def splined_of(path, tolerance=P, axis=AXIS):
    return splined(path, np.full(len(path), tolerance), np.full(len(path), axis))


def wave(n=200, h=5e-4):
    x = np.arange(n) * h
    return np.stack([x, 3e-3 * np.sin(60 * x), 1e-3 * np.cos(90 * x)], 1)


def tilted(n=200):
    k = np.arange(n)
    return np.stack([0.05 * np.sin(k / 30), 0.04 * np.cos(k / 25), 0 * k], 1)


def jumps(path, what, by_block=True):
    """Jumps of a quantity at the junctions between curves."""
    every = np.arange(len(path))
    ends, starts = getattr(path, what)(every, path.extent), getattr(path, what)(every, 0 * path.extent)
    both = (path.kind[:-1] == CURVE) & (path.kind[1:] == CURVE)
    return norm(starts[1:] - ends[:-1])[both]


def test_a_run_is_the_natural_spline_of_its_points():
    points = wave()
    path = splined_of(Path(chain_of(points)))
    assert (path.kind == CURVE).all()
    known = CubicSpline(np.concatenate([[0], np.cumsum(norm(np.diff(points, axis=0)))]), points, bc_type="natural")
    every = np.arange(len(path))
    for x in (0.0, 0.3, 1.0):
        own = path.batches[CURVE].at(every, np.full(len(path), x))
        np.testing.assert_allclose(own, known(known.x[:-1] + x * np.diff(known.x)), atol=1e-15)


def test_direction_curvature_and_turning_have_no_jump_inside_a_run():
    path = splined_of(Path(chain_of(wave(), abc=tilted())))
    assert (path.kind == CURVE).all()
    assert jumps(path, "tangent").max() < 1e-12
    assert jumps(path, "bend").max() < 1e-9 * path.sharpest().max()
    assert jumps(path, "angle_rate").max() < 1e-12 * 60
    assert jumps(path, "angle_bend").max() < 1e-9 * 1e4
    every = np.arange(len(path))
    np.testing.assert_allclose(path.angles(every, 0 * path.length), tilted()[:-1], atol=1e-16)


@pytest.mark.parametrize("tolerance", [6e-8, 1e-7, 2e-7])
def test_no_piece_leaves_its_line_by_more_than_the_tolerance(tolerance):
    rng = np.random.default_rng(0)
    points = wave(400, 2e-4)
    points += rng.normal(size=points.shape) * 2e-7  # shaken, so that some runs must break
    sharp = Path(chain_of(points))
    path = splined_of(sharp, tolerance)
    curved = np.flatnonzero(path.kind == CURVE)
    assert 20 < len(curved) < 399
    most = 0.0
    for i in curved:
        p = path.point(np.full(21, i), np.linspace(0, 1, 21) * path.length[i])
        most = max(most, distance_to_chain(p, points[i : i + 2]).max())
    assert most <= tolerance
    assert most > 0.2 * tolerance


def test_the_axis_of_a_run_stays_within_its_tolerance():
    abc = tilted(400) + 2e-4 * np.random.default_rng(1).normal(size=(400, 3))
    path = splined_of(Path(chain_of(wave(400), abc=abc)), 1e-4, 2e-4)
    curved = np.flatnonzero(path.kind == CURVE)
    assert len(curved) > 50
    x = np.linspace(0, 1, 21)
    for i in curved[::7]:
        on = rotation_of_abc_np(path.angles(np.full(21, i), x * path.length[i]))[..., 2]
        sharp = rotation_of_abc_np(abc[i] + x[:, None] * (abc[i + 1] - abc[i]))[..., 2]
        assert norm(on - sharp).max() <= 2e-4


def test_sharp_corners_long_lines_rapids_rests_and_other_tolerances_end_a_run():
    points = wave(60)
    corner = points.copy()
    corner[30:, 1] += np.arange(30) * 5e-4  # 45 degrees at point 29
    path = splined_of(Path(chain_of(corner)))
    assert jumps(path, "tangent").max() > 0.5
    blocks = chain_of(points)
    for change in (
        blocks[30]._replace(rapid=True),
        [Block(Rest(blocks[30].segment.start), dwell=0.1, line=99), blocks[30]],
    ):
        new = blocks[:30] + (change if isinstance(change, list) else [change]) + blocks[31:]
        path = splined_of(Path(new))
        assert (path.kind == CURVE).sum() >= 58
        assert path.kind[30] != CURVE
    tolerance = np.full(59, P)
    tolerance[29] = 0.0
    path = splined(Path(blocks), tolerance, np.full(59, AXIS))
    bend = path.bend(np.array([29]), path.length[29:30])
    assert norm(bend)[0] < 1e-9  # the natural end of a run
    assert splined_of(Path(chain_of(points[:3]))).kind.max() == LINE
    # one line ten times as long as the others between two bends leaves its chord and stays a line
    far = np.concatenate([points[:30], points[30:] + [5e-2, 2e-2, 0]])
    path = splined_of(Path(chain_of(far)))
    assert path.kind[29] == LINE
    assert (path.kind == CURVE).sum() > 50


@pytest.mark.full
def test_a_surface_of_fifty_thousand_lines_is_planned_in_seconds_and_runs_without_a_stop():
    points, abc = surface(50_000, tilt=0.1)
    blocks = chain_of(points, abc=abc)
    sharp = Path(blocks)
    start = time.process_time()
    course = course_of(sharp, Rules("blend", P, spline=True))
    feed = Feed(course.path, LIMITS)
    seconds = time.process_time() - start
    assert seconds < 5  # 15 s are what the issue gives to 100 000 lines, reading included
    path = course.path
    every = np.arange(len(path))
    turn = norm(path.tangent(every[1:], 0 * path.length[1:]) - path.tangent(every[:-1], path.length[:-1]))
    bend = norm(path.bend(every[1:], 0 * path.length[1:]) - path.bend(every[:-1], path.length[:-1]))
    rate = norm(path.angle_rate(every[1:], 0 * path.length[1:]) - path.angle_rate(every[:-1], path.length[:-1]))
    assert turn.max() < 1e-9
    assert bend.max() < 1e-6 * path.sharpest().max()
    assert rate.max() < 1e-6 * path.turning()[0].max()
    assert feed.duration < 1.05 * sharp.s0[-1] / 0.05  # it hardly ever slows down
    moments = feed.at(np.linspace(0.1, feed.duration - 0.1, 200_000))
    assert moments.ud.min() > 1e-3


def test_a_curve_through_points_of_a_circle_is_the_circle():
    angle = np.linspace(0, 2 * np.pi, 37)[:-1]
    points = 0.05 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], 1)
    curves, _ = through(points, closed=True)
    i, t = np.repeat(np.arange(36), 20), np.tile(np.linspace(0, 1, 20), 36)
    # the cubic spline of a circle errs by r h^4 / 384, h = 10 degrees
    np.testing.assert_allclose(norm(curves.at(i, t)), 0.05, atol=0.05 * (np.pi / 18) ** 4 / 384 * 1.1)
    np.testing.assert_allclose(curves.length, 0.05 * np.pi / 18, rtol=1e-5)


def test_a_closed_spline_has_no_jump_where_it_closes():
    rng = np.random.default_rng(3)
    angle = np.sort(rng.uniform(0, 2 * np.pi, 25))
    points = (0.05 + 0.01 * rng.uniform(size=(25, 1))) * np.stack([np.cos(angle), np.sin(angle), 0 * angle], 1)
    path = Spline(points=points, feed=0.05, closed=True, angles=points).path()
    every = np.arange(25)
    for what in ("point", "tangent", "bend", "angles", "angle_rate", "angle_bend"):
        ends, starts = getattr(path, what)(every, path.extent), getattr(path, what)(every, 0 * path.extent)
        scale = max(1e-3, np.abs(ends).max())
        np.testing.assert_allclose(np.roll(starts, -1, 0), ends, atol=1e-9 * scale, err_msg=what)
    np.testing.assert_allclose(path.point(every, 0 * path.length), points, atol=1e-16)
    np.testing.assert_allclose(path.angles(every, 0 * path.length), points, atol=1e-16)


def test_a_spline_runs_by_arc_length_and_is_measured(machine):
    from gough.measure import ContourMeter

    points = wave(12, 4e-3)
    motion = Spline(points=points, feed=0.05).plan(machine)
    assert motion.feed.duration < 1.1 * motion.path.s0[-1] / 0.05
    r = motion.sample(0, motion.count(1e-3), 1e-3)
    np.testing.assert_allclose(norm(r.xd[:, :3]), r.sd[:, 0], atol=1e-15)
    n = len(r.x)
    x = np.concatenate([r.x[:, :3], np.tile([1.0, 0, 0, 0], (n, 1))], 1)
    found = ContourMeter(motion)(0, n, 1e-3, x)
    assert found.contour_error.max() < 1e-15
    assert np.abs(found.lag).max() < 1e-9


@pytest.mark.parametrize(
    "options, message",
    [
        ({"points": [[0, 0, 0]]}, "points: must be two or more points of x y z, got 1 x 3"),
        ({"points": [[0, 0], [1, 1]]}, "points: must be two or more points of x y z, got 2 x 2"),
        (
            {"points": [[0, 0, 0], [1, 0, 0], [1, 0, 0]]},
            "points: points that follow each other must differ, got points 2 and 3 are the same; leave one of them out",
        ),
        (
            {"points": [[0, 0, 0], [1, 0, 0], [0, 0, 0]], "closed": True},
            "points: points that follow each other must differ, got points 3 and 1 are the same; leave one of them out",
        ),
        ({"points": [[0, 0, 0], [1, 0, 0]], "closed": True}, "points: a closed curve has three points at least, got 2"),
        (
            {"points": [[0, 0, 0], [1, 0, 0]], "angles": [[0, 0, 0]] * 3},
            "angles: there must be as many angles as points, got 3 (limit 2)",
        ),
        ({"points": [[0, 0, 0], [np.nan, 0, 0]]}, "points: must be finite"),
    ],
)
def test_a_spline_that_cannot_be_is_refused(options, message):
    with pytest.raises(ExperimentError) as caught:
        Spline(feed=0.05, **options)
    assert str(caught.value) == message


@pytest.mark.full
def test_any_points_give_a_curve_or_an_error_but_no_nan():
    rng = np.random.default_rng(4)
    for _ in range(60):
        n = rng.integers(2, 12)
        points = rng.normal(size=(n, 3)) * 10.0 ** rng.uniform(-4, -1, (n, 1))
        path = Spline(points=points, feed=0.05, closed=bool(n > 2 and rng.random() < 0.5)).path()
        assert np.isfinite(path.sharpest()).all()
        assert (path.length >= norm(np.diff(points, axis=0, append=points[:1]))[: len(path)] * (1 - 1e-9)).all()


def test_lines_through_a_straight_path_stay_straight():
    points = np.linspace([0, 0, 0], [0.1, 0.05, 0], 50)
    path = splined_of(Path(chain_of(points)))
    assert path.sharpest().max() < 1e-6
    assert path.s0[-1] == pytest.approx(norm(points[-1]), rel=1e-14)


def test_a_line_on_its_own_is_no_run():
    path = Path([Block(Line((0, 0, 0), (0.1, 0, 0)), feed=0.1)])
    assert splined_of(path) is path
