"""A corner is rounded where that is sooner than to stop, and only there."""

import itertools

import numpy as np
import pytest

from gough.program import Polyline
from gough.program.blocks import CURVE

JERKS = {"trapezoid": None, "jerk_limited": 50.0}


def planned(machine, points, **options):
    return Polyline(points=np.array(points), feed=0.1, **options).plan(machine)


def corner(angle, length=0.04):
    """Two lines that turn by an angle, rad."""
    return [[0, 0, 0], [length, 0, 0], [length + length * np.cos(angle), length * np.sin(angle), 0]]


@pytest.mark.quick("trapezoid-*")
@pytest.mark.parametrize(
    "profile, angle, tolerance",
    list(itertools.product(JERKS, np.radians([5, 25, 60, 90, 140]), [5e-6, 50e-6, 500e-6, 2e-3])),
)
def test_a_tolerance_never_costs_time(machine, profile, angle, tolerance):
    points = corner(angle)
    stop = planned(machine, points, profile=profile, corner="stop")
    blend = planned(machine, points, profile=profile, corner="blend", tolerance=tolerance)
    # shallow corners are rounded whatever it costs: a stop there is nothing a machine should do
    assert blend.feed.duration <= stop.feed.duration + 1e-12


def test_a_corner_that_would_cost_time_keeps_its_stop_and_others_are_rounded(machine):
    """90 degrees within 50 um: 25 ms more than a stop for 4 corners at 50 m/s3; 30 degrees are worth it."""
    turn = np.radians(30)
    points = [[0, 0, 0], [0.04, 0, 0], [0.04, 0.04, 0], [0.04 - 0.04 * np.sin(turn), 0.04 + 0.04 * np.cos(turn), 0]]
    path = planned(machine, points, profile="jerk_limited", corner="blend", tolerance=50e-6).course.path
    blended = path.kind == CURVE
    assert blended.any()
    np.testing.assert_allclose(path.point(np.flatnonzero(blended)[:1], np.zeros(1))[0, 1], 0.04, atol=2e-3)
    np.testing.assert_array_equal(path.point(np.array([0]), path.length[:1])[0], [0.04, 0, 0])  # sharp as programmed


def test_without_a_jerk_every_corner_up_to_the_cusp_is_worth_it(machine):
    for degrees in (25, 90, 140):
        path = planned(machine, corner(np.radians(degrees)), corner="blend", tolerance=20e-6).course.path
        assert (path.kind == CURVE).any(), degrees
