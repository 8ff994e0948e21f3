"""Milling force: closed forms against slices, published averages and energy."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

from cutting.mills import FEED, MATERIAL, SHARP, SPEED, cut, mill, sliced
from gough.cutting import EndMill, force
from gough.cutting.coefficients import SETS
from gough.cutting.numeric import ARRAYS, sinc

ANGLES = np.linspace(0.1, 6.2, 7)


def over_a_turn(f, kinks):
    """Integral of f (4,) over the spindle's angle from 0 to 2 pi by Gauss between its kinks."""
    nodes, weights = np.polynomial.legendre.leggauss(12)
    edges = np.unique(np.concatenate([[0, 2 * np.pi], np.asarray(kinks) % (2 * np.pi)]))
    total = 0.0
    for a, b in zip(edges[:-1], edges[1:], strict=True):
        total = total + (b - a) / 2 * np.einsum("i,i...", weights, f((a + b) / 2 + (b - a) / 2 * nodes))
    return total


def kinks_of(cutting, depth):
    """Angles of the spindle at which a tooth enters or leaves the stock at the tip or at the upper edge."""
    tool = cutting.tool
    first, last = force.window(ARRAYS, tool, depth, cutting.wall.side)
    top = 2 * np.tan(tool.helix) / tool.diameter * cutting.wall.axial_depth
    each = np.array([first, last, first + top, last + top])
    return np.concatenate([each - j * 2 * np.pi / tool.teeth for j in range(tool.teeth)])


@pytest.mark.parametrize("helix", [0.0, 1e-5, 12.0, 45.0])
@pytest.mark.parametrize("milling", ["down", "up"])
@pytest.mark.parametrize("depth", [0.3e-3, 5e-3, 12e-3])
def test_the_closed_form_is_what_thin_slices_add_up_to(helix, milling, depth):
    cutting = cut(mill(3, helix), milling=milling)
    for angle in ANGLES:
        found = cutting.forces(FEED, depth, angle)
        # a slice that begins or ends within the stock is off by half of it: 2 ends a tooth
        slice_force = 3 * 18e-3 / 20_000 * (700e6 * 0.25e-3 + 17e3)
        assert_allclose(found, sliced(cutting, FEED, depth, angle), rtol=0, atol=slice_force)


@pytest.mark.parametrize("teeth", [3, 4, 6])
def test_a_full_slot_gives_the_published_average_forces(teeth):
    """Altintas, Manufacturing Automation, sect. 2.8.1, identification of coefficients: F_x, F_y, F_z of a full slot."""
    cutting = cut(mill(teeth, 0.0))
    f, a, K = cutting.feed_per_tooth(FEED), 18e-3, MATERIAL
    published = [
        -teeth * a / 4 * K.radial * f - teeth * a / np.pi * K.radial_edge,
        teeth * a / 4 * K.tangential * f + teeth * a / np.pi * K.tangential_edge,
        teeth * a / np.pi * K.axial * f + teeth * a / 2 * K.axial_edge,
    ]
    kinks = kinks_of(cutting, 12e-3)
    mean = over_a_turn(lambda angle: cutting.forces(FEED, 12e-3, angle), kinks) / (2 * np.pi)
    assert_allclose(mean[:3], published, rtol=1e-6)
    assert_allclose(cutting.mean_forces(FEED, 12e-3)[:3], published, rtol=1e-12)


@pytest.mark.parametrize("teeth, helix, depth", [(1, 30, 0.9e-3), (2, 30, 4e-3), (2, 0, 2e-3), (5, 40, 7e-3)])
@pytest.mark.parametrize("milling", ["down", "up"])
def test_the_mean_over_a_turn_knows_nothing_of_the_helix(teeth, helix, depth, milling):
    cutting = cut(mill(teeth, helix), milling=milling)
    mean = over_a_turn(lambda angle: cutting.forces(FEED, depth, angle), kinks_of(cutting, depth)) / (2 * np.pi)
    assert_allclose(mean, cutting.mean_forces(FEED, depth), rtol=1e-6)


def test_power_is_the_specific_force_times_the_volume_cut():
    for depth in (0.2e-3, 3e-3, 12e-3):
        torque = cut(material=SHARP).mean_forces(FEED, depth)[3]
        assert_allclose(torque * SPEED, SHARP.tangential * depth * 18e-3 * FEED, rtol=1e-12)


def test_straight_flutes_are_the_limit_of_small_helix():
    straight, nearly = (cut(mill(2, helix)).forces(FEED, 2e-3, ANGLES) for helix in (0.0, 1e-4))
    assert_allclose(nearly, straight, rtol=0, atol=1e-3 * np.abs(straight).max())  # 1e-4 deg over 18 mm: 5e-6 rad


def test_a_tool_whose_flutes_span_a_pitch_feels_an_even_force():
    """height = pitch / k: whatever leaves at the top enters at the tip."""
    tool = mill(2, 45.0)
    height = np.pi / (2 * np.tan(tool.helix) / tool.diameter)
    found = cut(tool, height=height).forces(FEED, 3e-3, np.linspace(0, 2 * np.pi, 50))
    assert_allclose(found, np.broadcast_to(found[0], found.shape), rtol=0, atol=1e-9 * np.abs(found).max())


def test_climbing_pulls_the_tool_along_and_off_the_wall():
    """Conventional milling holds it back; both take the same power."""
    down, up = (cut(material=SHARP, milling=way).mean_forces(FEED, 2e-3) for way in ("down", "up"))
    assert_allclose(down[3], up[3], rtol=1e-12)
    assert down[0] > 0 > up[0]
    assert down[1] > 0


def test_runout_takes_the_same_volume_with_uneven_teeth():
    tool = mill(2, runout=20e-6, runout_angle=0.4)
    depth, angles = 0.9e-3, np.linspace(0, 2 * np.pi, 20_000, endpoint=False)
    sharp = cut(tool, SHARP)
    assert_allclose(
        sharp.forces(FEED, depth, angles).mean(0)[2:], cut(material=SHARP).mean_forces(FEED, depth)[2:], rtol=2e-6
    )
    half = sharp.forces(FEED, depth, angles)[:, 3].reshape(2, -1).sum(1)
    assert abs(half[0] / half[1] - 1) > 0.2


@pytest.mark.parametrize("runout", [5e-6, 300e-6])
def test_the_mean_with_runout_is_that_of_many_angles(runout):
    cutting = cut(mill(3, 30.0, runout=runout, runout_angle=0.3))
    angles = np.linspace(0, 2 * np.pi, 20_000, endpoint=False)
    found = cutting.mean_forces(FEED, np.array([0.9e-3, 5e-3]))
    for mean, depth in zip(found, (0.9e-3, 5e-3), strict=True):
        # a kink seen from 20 000 places: 1e-4 of a step of the force's rate
        assert_allclose(mean, cutting.forces(FEED, depth, angles).mean(0), rtol=1e-6)


@pytest.mark.parametrize("teeth", [2, 3, 4])
def test_runout_is_what_slices_meet_that_remember_all_teeth(teeth):
    for runout in (8e-6, 200e-6):  # the second is so large that a tooth misses for whole turns
        cutting = cut(mill(teeth, 25.0, runout=runout, runout_angle=0.7))
        for angle in ANGLES:
            expected = sliced(cutting, FEED, 2e-3, angle)
            atol = 2 * teeth**2 * 18e-3 / 20_000 * (700e6 * teeth * 0.25e-3 + 17e3)
            assert_allclose(cutting.forces(FEED, 2e-3, angle), expected, rtol=0, atol=atol)


def test_no_runout_is_the_limit_of_a_small_one():
    assert_allclose(
        cut(mill(runout=1e-12)).forces(FEED, 2e-3, ANGLES), cut().forces(FEED, 2e-3, ANGLES), rtol=1e-6, atol=1e-6
    )


def test_without_stock_there_is_no_force():
    assert not cut().forces(FEED, 0.0, ANGLES).any()
    assert not cut(mill(runout=1e-5)).forces(FEED, 0.0, ANGLES).any()
    assert not cut().mean_forces(FEED, 0.0).any()


def test_symbols_and_arrays_give_the_same_force():
    cutting = cut(mill(2, runout=9e-6))
    theta, depth, feed, angle = ca.SX.sym("t", len(cutting.theta)), *(ca.SX.sym(n) for n in ("d", "f", "a"))
    c = cutting.at(theta)
    cuts = force.pieces(ca, c.tool, 2, feed, *force.window(ca, c.tool, depth, -1.0))
    F = ca.Function(
        "F", [theta, depth, feed, angle], force.force(ca, c.tool, c.coefficients, 2, c.wall.axial_depth, cuts, angle)
    )
    for at in ANGLES:
        found = np.array([float(x) for x in F(cutting.theta, 1.5e-3, cutting.feed_per_tooth(FEED), at)])
        assert_allclose(found, cutting.forces(FEED, 1.5e-3, at), rtol=1e-12, atol=1e-9)


def test_a_chip_knows_a_step_sideways():
    """Eq. (3) with b: slices of h = a sin phi + b cos phi, of sharp edges."""
    tool, (a, b), k = mill(1, 20.0), (0.2e-3, 0.07e-3), 2 * np.tan(np.radians(20.0)) / 12e-3
    first, last = 0.5, 2.6
    z = (np.arange(20_000) + 0.5) * 18e-3 / 20_000
    for angle in ANGLES:
        phi = (angle - k * z) % (2 * np.pi)
        h = (a * np.sin(phi) + b * np.cos(phi)) * ((phi >= first) & (phi <= last)) * 18e-3 / 20_000
        x = -SHARP.tangential * h * np.cos(phi) - SHARP.radial * h * np.sin(phi)
        y = SHARP.tangential * h * np.sin(phi) - SHARP.radial * h * np.cos(phi)
        expected = [x.sum(), y.sum(), SHARP.axial * h.sum(), 6e-3 * SHARP.tangential * h.sum()]
        found = force.force(ARRAYS, tool, SHARP, 1, 18e-3, [[(a, 0.0, first, last)]], angle, b)
        assert_allclose(found, expected, rtol=0, atol=2 * 700e6 * 0.3e-3 * 18e-3 / 20_000)


def test_sinc_is_smooth_where_its_series_takes_over():
    x = np.array([0.0, 0.99999e-4, 1.00001e-4])
    assert_allclose(sinc(ARRAYS, x), [1, 1 - x[1] ** 2 / 6, 1 - x[2] ** 2 / 6], rtol=1e-15)


def test_every_material_says_where_it_is_from():
    assert all(len(K.source) > 20 and K.tangential > K.radial > 0 for K in SETS.values())


def test_the_calibrated_set_comes_near_the_printed_means():
    """Okuda et al. 2006, table 3: 37, 63, 91 N; one factor cannot meet three numbers, 5 % is what it leaves."""
    found = cut(material=SETS["A5052"]).mean_forces(FEED, np.array([0.3, 0.6, 0.9]) * 1e-3)[:, 1]
    assert_allclose(found, [37, 63, 91], rtol=0.05)


def test_a_tool_with_more_runout_than_radius_is_refused():
    with pytest.raises(
        ValueError, match="runout: must be below the radius of the tool, got 0.006 m; give less than 0.006"
    ):
        EndMill(diameter=12e-3, teeth=2, runout=6e-3)
