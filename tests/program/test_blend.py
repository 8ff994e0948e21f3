"""Blends: eq. (3) by derivation, curvature without jumps, and deviations against a dense search, both ways."""

import numpy as np
import pytest

from gough.frames import rotation_of_abc_np
from gough.program.blend import CUSP, blend
from gough.program.blocks import Arc, Block, Line, Rest
from gough.program.path import Path
from gough.program.segments import norm
from growth import growth

from .corners import chain_of, distance_to_chain, random_path

P, AXIS = 20e-6, 2e-4

PATHS = {
    "lines": {"kinds": ("line",)},
    "lines, arcs and helices": {},
    "tangent junctions": {"straight": 0.7},
    "tilting lines": {"kinds": ("line",), "tilt": 0.02},
    "tilting": {"tilt": 0.02, "straight": 0.2},
}


def blends_of(path, smooth=True, tolerance=P):
    m = len(path)
    return blend(path, path, np.full(m, tolerance), np.full(m, AXIS), smooth)


def deviation(path, found, n):
    """Of blend n the greatest distance to the path and of the path to it, less what a chain of chords may differ."""
    i, d = int(found.after[n]), max(found.back[n], found.ahead[n])
    before = np.linspace(max(path.length[i] - d, 0), path.length[i], 200)
    behind = np.linspace(0, min(d, path.length[i + 1]), 200)
    sharp = np.concatenate([path.point(np.full(200, i), before), path.point(np.full(200, i + 1), behind)[1:]])
    blended = found.curves.at(np.full(81, n), np.linspace(0, 1, 81))
    # a chord of length h is beside an arc by h^2 / 8 times the curvature at most
    bend = path.sharpest()[i : i + 2].max()
    sagitta = max(bend * (d / 199) ** 2, found.curves.sharpest()[n] * (2 * d / 80) ** 2) / 8
    out = max(distance_to_chain(blended, sharp).max(), distance_to_chain(sharp, blended).max())
    return out, sagitta


@pytest.mark.full
@pytest.mark.parametrize("name", PATHS)
def test_blend_and_path_stay_within_the_tolerance_of_each_other(name):
    path = random_path(1, 90, **PATHS[name])
    found = blends_of(path)
    assert len(found.after) > 50
    worst, sagitta = np.array([deviation(path, found, n) for n in range(len(found.after))]).T
    assert (worst <= P + sagitta).all()
    # and the tolerance is used where no block is too short and no angle in the way
    half = np.minimum(path.length[found.after], path.length[found.after + 1]) / 2
    free = (found.back < 0.99 * half) & (found.turn > 0.05)
    if "tilting" not in name:
        assert free.sum() > 10
        assert worst[free].min() > 0.9 * P


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", PATHS)
def test_blend_and_path_stay_within_the_tolerance_of_each_other_thousands_of_times(name, seed):
    path = random_path(100 + seed, 150, size=10.0 ** (-2 - seed % 3), **PATHS[name])
    for tolerance in (1e-6, 5e-5, 1e-3):
        found = blends_of(path, tolerance=tolerance)
        for n in range(len(found.after)):
            away, sagitta = deviation(path, found, n)
            assert away <= tolerance + sagitta, (n, tolerance)


@pytest.mark.parametrize("degrees", [1, 30, 90, 140])
def test_between_lines_the_tolerance_gives_the_size_in_closed_form(degrees):
    """g = 1 - 2t + 2t^3 - t^4, g(1/2) = 3/16; below 0.2 degrees a longer blend would be no use."""
    phi = np.radians(degrees)
    legs = np.array([[-1.0, 0, 0], [0, 0, 0], [np.cos(phi), np.sin(phi), 0]])
    found = blends_of(Path(chain_of(legs)))
    d = min(P / (0.375 * np.sin(phi / 2)), 7.5 * phi)
    assert found.back[0] == pytest.approx(d, rel=1e-8)
    assert found.ahead[0] == found.back[0]
    g = np.array([1, -2, 0, 2, -1, 0.0])
    t = np.polynomial.Polynomial([1, -1])
    mirrored = np.append((1 - 2 * t + 2 * t**3 - t**4).coef, 0.0)  # g(1 - t)
    known = -d * np.array([1.0, 0, 0]) * g[:, None] + d * legs[2] * mirrored[:, None]
    np.testing.assert_allclose(found.curves.c[0], known, atol=1e-7 * d)
    middle = found.curves.at(np.zeros(1, int), np.full(1, 0.5))
    assert norm(middle)[0] == pytest.approx(0.375 * d * np.sin(phi / 2), rel=1e-7)


@pytest.mark.quick("lines", "tilting lines")
@pytest.mark.parametrize("name", PATHS)
def test_position_tangent_and_curvature_have_no_jump_where_a_blend_begins_and_ends(name):
    path = random_path(2, 150, **PATHS[name])
    found = blends_of(path)
    n = np.arange(len(found.after))
    i = found.after
    for own, other in (
        (found.curves.frame(n, 0.0 * n), path.frame(i, path.length[i] - found.back)),
        (found.curves.frame(n, found.curves.length), path.frame(i + 1, found.ahead)),
    ):
        np.testing.assert_allclose(own[0], other[0], atol=1e-14)
        # rounding of positions of a metre over twice the size of the blend, and over its square
        assert (norm(own[1] - other[1]) <= 1e-15 / found.back).all()
        assert (norm(own[2] - other[2]) <= 1e-14 / found.back**2 + 1e-12 * norm(other[2])).all()


@pytest.mark.full
def test_angles_have_no_jump_of_value_or_rate_and_rest_in_their_bend():
    path = random_path(3, 120, tilt=0.02)
    found = blends_of(path)
    L = found.curves.length[:, None]
    i, k = found.after, found.angles
    for value, rate, bend, block, u in (
        (k[:, 0], k[:, 1] / L, 2 * k[:, 2] / L**2, i, path.length[i] - found.back),
        (
            k.sum(1),
            (k * np.arange(6)[:, None]).sum(1) / L,
            (k * np.array([0, 0, 2, 6, 12, 20.0])[:, None]).sum(1) / L**2,
            i + 1,
            found.ahead,
        ),
    ):
        np.testing.assert_allclose(value, path.angles(block, u), atol=1e-15)
        np.testing.assert_allclose(rate, path.angle_rate(block, u), atol=1e-9)
        assert np.abs(bend).max() < 1e-14 / found.back.min() ** 2


@pytest.mark.full
def test_the_tool_axis_stays_within_its_tolerance_of_the_axis_at_the_closest_point():
    path = random_path(4, 80, tilt=0.05)
    found = blends_of(path)
    used = []
    for n in range(len(found.after)):
        i = int(found.after[n])
        x = np.linspace(0, 1, 41)
        t = found.curves.parameter(np.full(41, n), x * found.curves.length[n])
        p = found.curves.at(np.full(41, n), t)
        abc = sum(found.angles[n, k] * x[:, None] ** k for k in range(6))
        axis = rotation_of_abc_np(abc)[..., 2]
        before = np.linspace(max(path.length[i] - 1.5 * found.back[n], 0), path.length[i], 400)
        behind = np.linspace(0, min(1.5 * found.back[n], path.length[i + 1]), 400)
        block = np.repeat([i, i + 1], 400)
        u = np.concatenate([before, behind])
        there = path.point(block, u)
        nearest = np.linalg.norm(p[:, None] - there[None], axis=-1).argmin(1)
        known = rotation_of_abc_np(path.angles(block[nearest], u[nearest]))[..., 2]
        used.append(norm(axis - known).max())
    # the dense search finds the place to 1/400 of the blend, which turns it by some 1e-6 rad
    assert max(used) <= AXIS * 1.01
    assert max(used) > 0.8 * AXIS


def test_where_only_the_angles_have_a_corner_they_are_blended_on_a_straight_line():
    path = Path(chain_of([(0, 0, 0), (0.1, 0, 0), (0.2, 0, 0)], abc=np.array([[0, 0, 0], [0, 0, 0], [0.1, 0, 0]])))
    found = blends_of(path)
    assert len(found.after) == 1
    # the middle is 0.1875 d times the jump of the rate, 1 rad/m, away from the path's angle
    assert found.back[0] == pytest.approx(AXIS / 0.1875, rel=0.02)
    np.testing.assert_array_equal(found.curves.sharpest(), 0)


def test_a_jump_of_the_curvature_alone_is_a_corner_only_if_asked_for():
    arc = Arc((0.05, 0, 0), (0.05, 0.02, 0), (0, 0, 1), 1.5)
    path = Path([Block(Line((0, 0, 0), (0.05, 0, 0)), feed=1.0), Block(arc, feed=1.0)])
    assert len(blends_of(path, smooth=False).after) == 0
    found = blends_of(path, smooth=True)
    assert len(found.after) == 1
    assert deviation(path, found, 0)[0] == pytest.approx(P, rel=0.03)


def test_what_cannot_be_blended_is_left_alone():
    back = [(0, 0, 0), (0.1, 0, 0), (0.0, 1e-3, 0)]  # a cusp
    assert len(blends_of(Path(chain_of(back))).after) == 0
    for turn, count in ((0.99 * CUSP, 1), (1.01 * CUSP, 0)):
        legs = [(0, 0, 0), (0.1, 0, 0), (0.1 + 0.1 * np.cos(turn), 0.1 * np.sin(turn), 0)]
        assert len(blends_of(Path(chain_of(legs))).after) == count
    short = [(0, 0, 0), (0.1, 0, 0), (0.1, 1e-6, 0), (0.2, 1e-6, 0)]  # no room
    assert len(blends_of(Path(chain_of(short))).after) == 0
    corner = chain_of([(0, 0, 0), (0.1, 0, 0), (0.1, 0.1, 0)])
    rest = [corner[0], Block(Rest((0.1, 0, 0)), dwell=1.0), corner[1]]
    assert len(blends_of(Path(rest)).after) == 0
    path = Path(corner)
    none = blend(path, path, np.array([0.0, P]), np.full(2, AXIS))  # the tolerance is that of the block before
    assert len(none.after) == 0
    stop = blend(path, path, np.array([-1.0, P]), np.full(2, AXIS))
    assert len(stop.after) == 0
    with_tool = [corner[0], corner[1]._replace(segment=Line((0.1, 0, -0.05), (0.1, 0.1, -0.05)), tool=(0, 0, 0.05))]
    assert len(blends_of(Path(with_tool)).after) == 0


def test_a_block_too_short_for_both_its_blends_gives_to_the_smaller_first():
    """A right angle wants 75 um, a turn of 143 degrees 56 um."""
    d90, d2 = P / (0.375 * np.sin(np.pi / 4)), P / (0.375 * np.sin(1.25))
    assert d2 < d90 < 0.1e-3 < d90 + d2
    end = np.array([0.1, 0.1e-3, 0]) + 0.1 * np.array([-np.sin(2.5), np.cos(2.5), 0])
    found = blends_of(Path(chain_of([(0, 0, 0), (0.1, 0, 0), (0.1, 0.1e-3, 0), end])))
    # both want more than half: each gets half, and the two curves meet in the middle exactly
    np.testing.assert_allclose([found.back[0], found.ahead[0], found.back[1]], 0.05e-3, rtol=1e-12)
    assert found.ahead[0] + found.back[1] == 0.1e-3
    # with 160 um between them the right angle, which wants less than half, gets its 75 um
    path = Path(chain_of([(0, 0, 0), (0.1, 0, 0), (0.1, 0.16e-3, 0), [0.1 - np.sin(0.5), 0.16e-3 + np.cos(0.5), 0]]))
    found = blends_of(path)
    assert found.back[0] == pytest.approx(d90, rel=1e-8)
    assert found.back[1] == pytest.approx(0.16e-3 - d90, rel=1e-8)


@pytest.mark.full
def test_the_time_of_blends_grows_with_the_corners():
    def path(n):
        return Path(chain_of(np.cumsum(np.random.default_rng(0).normal(size=(n + 1, 3)) * 1e-3, axis=0)))

    assert len(blends_of(path(2000), smooth=False).after) > 1800
    assert (
        growth(path, lambda path: blends_of(path, smooth=False), 4000) < 2
    )  # 2: caches and the garbage collector's passes; anything quadratic would be 8
