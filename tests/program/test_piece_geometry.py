"""The geometry of the standard test pieces, each by a second derivation."""

import numpy as np
import pytest

from gough.frames import rotation_of_abc_np
from gough.program import CircularTest, ConeFrustum, SPiece, SquareCorners, Zigzag
from gough.program.blocks import ARC, REST
from gough.program.standard.flank import angles_of_axis, axis_of_angles

from .make_pieces import RECIPES


def along(path, blocks, count=7):
    """Tips and tool axes at some places of each block, ends included.  (k, 3), (k, 3)."""
    i = np.repeat(blocks, count)
    share = np.tile(np.linspace(0, 1, count), len(blocks))
    abc = path.angles(i, share * path.extent[i])
    return path.point(i, share * path.length[i]), rotation_of_abc_np(abc)[:, :, 2]


def surface(path):
    """The blocks along the surface: all but three to get there, a pause among them, and two to leave."""
    return np.arange(3, len(path) - 2)


# -- angles of an axis ------------------------------------------------------------------------------------------------


def test_the_angles_of_an_axis_give_that_axis_and_do_not_turn_about_z():
    n = np.random.default_rng(0).normal(size=(500, 3))
    n /= np.linalg.norm(n, axis=1)[:, None]
    abc = angles_of_axis(n)
    # near n_y = +-1 the arcsine loses half of the digits
    np.testing.assert_allclose(rotation_of_abc_np(abc)[:, :, 2], n, atol=3e-14)
    np.testing.assert_allclose(axis_of_angles(abc), n, atol=3e-14)
    assert (abc[:, 2] == 0).all()


# -- cone frustum -----------------------------------------------------------------------------------------------------

FRUSTA = {
    "default": {},
    "cw": {"direction": "cw", "start": 1.0, "toward": 2.0},
    "steep": {"half_angle": np.radians(40), "tilt": np.radians(5), "radius": 0.05, "height": 0.03},
    "upright": {"tilt": 0.0},
    "cylinder": {"half_angle": 0.0},
}


def cone(program):
    """Apex (3,) m, or None, and unit axis (3,) of the cone."""
    R = rotation_of_abc_np((0.0, program.tilt, program.toward))
    if program.half_angle == 0:
        return None, R[:, 2]
    return program.center + program.radius / np.tan(program.half_angle) * R[:, 2], R[:, 2]


@pytest.mark.parametrize("name", FRUSTA)
def test_the_tool_lies_in_the_surface_of_the_cone(name):
    """At the ends of the lines its axis goes through the apex; between them within the chord error of the surface."""
    program = ConeFrustum(feed=0.02, **FRUSTA[name])
    path, (apex, m) = program.path(), cone(program)
    tips, axes = along(path, surface(path), 2)
    radial = tips - program.center
    np.testing.assert_allclose(np.linalg.norm(radial, axis=1), program.radius, rtol=1e-13)
    np.testing.assert_allclose(radial @ m, 0, atol=1e-15)
    if apex is None:
        np.testing.assert_allclose(axes, np.tile(m, (len(axes), 1)), atol=1e-14)
    else:
        np.testing.assert_allclose(np.cross(apex - tips, axes), 0, atol=1e-13)
    tips, axes = along(path, surface(path))
    for height in (0.0, program.height):
        p = tips + height * axes - program.center
        up = p @ m
        out = np.linalg.norm(p - up[:, None] * m, axis=1)
        gap = (out - program.radius) * np.cos(program.half_angle) + up * np.sin(program.half_angle)
        off = np.abs(gap) if height else np.hypot(out - program.radius, up)
        assert off.max() <= program.chord * (1 + 1e-9)


@pytest.mark.quick("steep", "cylinder", "cw", "default")
@pytest.mark.parametrize("name", FRUSTA)
def test_the_tool_leans_over_between_the_difference_and_the_sum_of_the_two_angles(name):
    program = ConeFrustum(feed=0.02, chord=1e-7, **FRUSTA[name])
    lean = np.arccos(along(program.path(), np.arange(len(program.path())))[1][:, 2])
    # the lines need not begin or end at the extremes; half a step of 0.1 um chords misses them by less than this
    assert lean.max() == pytest.approx(program.tilt + program.half_angle, abs=1e-5)
    assert lean.min() == pytest.approx(abs(program.tilt - program.half_angle), abs=1e-5)
    assert lean.max() <= program.tilt + program.half_angle + 1e-12


@pytest.mark.parametrize("kind", [ConeFrustum, SPiece])
def test_a_line_less_in_a_hundred_would_leave_the_surface(kind):
    """The lines are as few as the chord error allows, spread evenly in error."""
    program = kind(feed=0.02, chord=2e-6)
    flank = program.flank()
    knots = flank.knots(program.chord)
    assert flank.deviation(knots) <= program.chord
    fewer = np.interp(np.linspace(0, 1, round(0.98 * len(knots))), np.linspace(0, 1, len(knots)), knots)
    assert flank.deviation(fewer) > program.chord


@pytest.mark.parametrize("kind", [ConeFrustum, SPiece])
def test_the_tool_comes_and_goes_along_the_tangent_and_along_itself(kind):
    program = kind(feed=0.02, approach=0.012, clearance=0.03)
    path = program.path()
    i = np.arange(len(path))
    t, axis = path.tangent(i, 0 * path.length), along(path, i, 2)[1][::2]
    assert path.dwell[1] == 0.5  # behind the rapid
    np.testing.assert_allclose(path.length[[0, 2, -2, -1]], [0.03, 0.012, 0.012, 0.03], rtol=1e-12)
    np.testing.assert_allclose([t[0], t[-1]], [-axis[0], axis[-1]], atol=1e-12)
    np.testing.assert_allclose([t[2], t[-2]], [t[3], t[-3]], atol=1e-11)
    assert list(np.flatnonzero(path.rapid)) == [0, len(path) - 1]
    np.testing.assert_array_equal(path.abc0[:, 2], 0)
    # the short lines and the tangents may be blended into one another; the rapids are no part of that
    np.testing.assert_array_equal(path.tolerance, [0, 0] + [program.tolerance] * (len(path) - 4) + [0, 0])


def test_a_frustum_comes_back_to_where_it_began_with_the_same_angles():
    path = ConeFrustum(feed=0.02).path()
    first, last = surface(path)[[0, -1]]
    np.testing.assert_allclose(along(path, [first])[0][0], along(path, [last])[0][-1], atol=1e-15)
    np.testing.assert_allclose(path.abc0[first], path.angles(np.array([last]), path.extent[[last]])[0], atol=1e-14)


def test_clockwise_is_the_same_frustum_the_other_way():
    left, right = (ConeFrustum(feed=0.02, direction=way).path() for way in ("ccw", "cw"))
    i = surface(left)
    a, b = along(left, i, 2)[0], along(right, i, 2)[0]
    np.testing.assert_allclose(a, b[::-1], atol=1e-12)
    assert np.cross(a[0] - [0.05, 0, -0.04], a[20] - [0.05, 0, -0.04])[2] > 0


# -- S piece ----------------------------------------------------------------------------------------------------------


def test_the_tool_joins_the_two_s_curves():
    program = SPiece(feed=0.02, chord=1e-6)
    path = program.path()
    tips, axes = along(path, surface(path), 2)
    top = tips + program.height / axes[:, 2:] * axes
    x, y, z = (tips - program.center).T
    np.testing.assert_allclose(z, 0, atol=1e-15)
    # the parameter from y alone, by bisection on the monotone part would do; here from x and the tool's own lean
    h = program.height * np.tan(program.lean)
    cosine, sine = (top - tips)[:, 1] / h, 2 * (top - tips)[:, 0] / h
    np.testing.assert_allclose(cosine**2 + sine**2, 1, atol=1e-12)
    np.testing.assert_allclose(x, program.width / 2 * sine, atol=1e-14)
    u = np.unwrap(np.arctan2(sine, cosine)) / (2 * np.pi)
    np.testing.assert_allclose(y, program.length * (u - 0.5) - program.bow * 2 * sine * cosine, atol=1e-13)
    np.testing.assert_allclose([u[0], u[-1]], [0, 1], atol=1e-12)


def test_the_s_is_the_same_seen_from_its_other_end_and_leans_as_far_as_it_says():
    program = SPiece(feed=0.02)
    path = program.path()
    tips, axes = along(path, surface(path), 2)
    a, b, other = tips[::2], tips[1::2], 2 * program.center - tips[::2, None]
    along_line = np.clip(((other - a) * (b - a)).sum(-1) / ((b - a) ** 2).sum(-1), 0, 1)
    off = np.linalg.norm(other - a - along_line[..., None] * (b - a), axis=-1).min(1)
    assert off.max() < program.chord
    lean = np.arccos(axes[:, 2])
    assert lean.max() == pytest.approx(program.lean, abs=1e-12)
    # the ends of the lines need not meet the bends: the least lean is quadratic about them
    assert np.tan(lean.min()) == pytest.approx(np.tan(program.lean) / 2, abs=1e-3)
    bend = path.point(surface(path), 0 * surface(path))
    assert np.ptp(bend[:, 0]) == pytest.approx(program.width, abs=1e-4)


# -- circles ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("overlap", [0.0, 1.0, np.pi])
def test_a_circular_test_runs_the_circle_both_ways_with_its_overlap(overlap):
    program = CircularTest(radius=0.1, feed=0.05, center=(0.01, 0.02, 0.03), plane=(0.5, 0.3, 0.2), start=0.7,
                           overlap=overlap)  # fmt: skip
    path = program.path()
    assert list(path.kind) == [ARC, REST, ARC]
    np.testing.assert_allclose(path.length[[0, 2]], 0.1 * (2 * np.pi + 2 * overlap), rtol=1e-13)
    assert [c.ccw for c in path.circles] == [True, False]
    R = rotation_of_abc_np(program.plane)
    here = path.point(np.array([0, 2]), 0.1 * overlap * np.ones(2))  # where the circle proper begins
    want = program.center + R @ [0.1 * np.cos(0.7), 0.1 * np.sin(0.7), 0]
    np.testing.assert_allclose(here, [want, want], atol=1e-15)
    t = path.tangent(np.array([0, 2]), 0.1 * overlap * np.ones(2))
    np.testing.assert_allclose(t[0], R @ [-np.sin(0.7), np.cos(0.7), 0], atol=1e-14)
    np.testing.assert_allclose(t[1], -t[0], atol=1e-14)
    assert path.dwell[1] == 0.5


def test_one_way_alone_has_no_pause():
    for way, ccw in (("ccw", True), ("cw", False)):
        path = CircularTest(radius=0.1, feed=0.05, direction=way).path()
        assert [c.ccw for c in path.circles] == [ccw]
        assert len(path) == 1
    assert list(CircularTest(radius=0.1, feed=0.05, pause=0.0).path().kind) == [ARC, ARC]


@pytest.mark.parametrize("name, axis", [("circles-xy", 2), ("circles-yz", 0), ("circles-zx", 1)])
def test_the_shipped_circles_turn_about_their_axis(name, axis):
    first = RECIPES[name].program.path().circles[0]
    np.testing.assert_allclose(first.normal, np.eye(3)[axis], atol=1e-15)


# -- corners ----------------------------------------------------------------------------------------------------------


def corners(path):
    """Signed changes of direction, rad, about +z, between the moves that are no rapids."""
    i = np.flatnonzero(~path.rapid & (path.length > 0))
    t = path.tangent(i, 0 * path.length[i])
    return np.arctan2(np.cross(t[:-1], t[1:])[:, 2], (t[:-1] * t[1:]).sum(1))


def test_a_square_has_four_corners_of_90_degrees_each_way():
    path = SquareCorners(feed=0.05, side=0.06).path()
    right = np.pi / 2
    np.testing.assert_allclose(np.abs(corners(path)), [right] * 4 + [np.pi] + [right] * 4, atol=1e-14)
    np.testing.assert_allclose(corners(path)[[0, -1]], [right, -right], atol=1e-14)
    np.testing.assert_allclose(path.s0[-1], 8 * 0.06, rtol=1e-14)
    p = np.abs(path.point(np.arange(len(path)), path.length))
    np.testing.assert_allclose(p[:, :2].max(0), 0.03, rtol=1e-15)
    for way, sign in (("ccw", 1), ("cw", -1)):
        one = SquareCorners(feed=0.05, side=0.06, direction=way).path()
        np.testing.assert_allclose(corners(one), [sign * right] * 4, atol=1e-14)


def test_squares_of_several_sides_are_joined_by_rapids_and_may_rest_in_their_corners():
    path = SquareCorners(feed=0.05, side=(0.02, 0.06), pause=0.2, direction="ccw", plane=(np.pi / 2, 0, 0)).path()
    assert list(path.length[path.rapid]) == pytest.approx([0.02])
    rests = path.kind == REST
    np.testing.assert_array_equal(path.dwell[rests], [0.2] * 8)
    places = path.point(np.flatnonzero(rests), np.zeros(8))
    np.testing.assert_allclose(np.abs(places), [[0.01, 0, 0.01]] * 4 + [[0.03, 0, 0.03]] * 4, atol=1e-17)


def test_a_zigzag_turns_by_its_angles_to_the_left_and_to_the_right():
    angles = np.radians([30, 60, 90, 120, 150])
    path = Zigzag(feed=0.05, center=(0.0, 0.0, 0.01)).path()
    np.testing.assert_allclose(corners(path), angles * [1, -1, 1, -1, 1], atol=1e-14)
    np.testing.assert_allclose(path.length, 0.03, rtol=1e-13)
    p = np.vstack([path.point(np.arange(6), np.zeros(6)), path.point(np.array([5]), path.length[-1:])])
    np.testing.assert_allclose(p.min(0) + p.max(0), [0, 0, 0.02], atol=1e-17)
    back = Zigzag(feed=0.05, back=True, pause=0.1, angles=1.0).path()
    moves = back.kind != REST
    turns = corners(back)
    np.testing.assert_allclose(np.abs(turns), [1.0, np.pi, 1.0], atol=1e-14)
    np.testing.assert_allclose([turns[0], turns[2]], [1.0, -1.0], atol=1e-14)
    assert (~moves).sum() == 3
