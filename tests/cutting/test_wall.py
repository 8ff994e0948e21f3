"""Walls and cuts that cannot be, in words; depths along a path."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from cutting.mills import MATERIAL, cut, mill
from gough.cutting import Beam, Cutting, Wall
from gough.errors import ExperimentError

STAIRS = Wall(axial_depth=18e-3, places=[0.01, 0.05, 0.09], radial=[0.3e-3, 0.9e-3])


def test_stairs_hold_their_depth_up_to_the_next_place():
    s = [0.0, 0.00999, 0.01, 0.03, 0.05, 0.0899, 0.09, 1.0]
    assert_allclose(STAIRS.depth(s), np.array([0, 0, 0.3, 0.3, 0.9, 0.9, 0, 0]) * 1e-3, rtol=1e-15)


def test_a_linear_wall_runs_straight_between_its_places():
    wall = Wall(axial_depth=18e-3, places=[0.01, 0.05, 0.09], radial=[0.0, 1e-3, 0.5e-3], form="linear")
    assert_allclose(wall.depth([0.0, 0.02, 0.05, 0.07, 0.09]), [0, 0.25e-3, 1e-3, 0.75e-3, 0], rtol=1e-12)


@pytest.mark.parametrize(
    "changes, text",
    [
        ({"places": [0.0]}, "places: needs 2 to 256 places, got 1"),
        ({"places": [0.0, 0.2, 0.1]}, "places: places must rise along the path, got 0.2 m, then 0.1 m"),
        ({"radial": [1e-3]}, "radial: stairs with 3 places have 2 depths, got 1"),
        (
            {"radial": [0.0, 0.0]},
            "radial: no radial depth is above 0: there is no chip, got 0 m everywhere; give a depth",
        ),
        ({"radial": [-1e-3, 0.0]}, "radial: must be at least 0 m"),
        ({"axial_depth": 0.0}, "axial_depth: must be above 0 m, got 0 m"),
        ({"axial_depth": float("nan")}, "axial_depth: must be finite"),
        ({"places": 0.1}, "places: must be an array, got 0.1"),
    ],
)
def test_a_wall_that_cannot_be_is_refused(changes, text):
    with pytest.raises(ExperimentError) as caught:
        STAIRS.replace(**changes)
    assert text in str(caught.value)


@pytest.mark.parametrize(
    "changes, text",
    [
        ({"spindle_speed": 0.0}, "spindle_speed: must be above 0 rad/s, got 0 rad/s"),
        ({"tool.teeth": 0}, "tool.teeth: must be at least 1, got 0"),
        (
            {"wall.radial": [13e-3]},
            "wall.radial: deeper than the diameter of the tool, got 0.013 m; give at most 0.012 m",
        ),
        (
            {"wall.axial_depth": 0.1},
            "wall.axial_depth: the flutes wind more than once around the tool within this height",
        ),
        (
            {"wall.axial_depth": 0.05, "tool.extension": 0.04},
            "wall.axial_depth: higher than the tool is long, got 0.05 m",
        ),
        ({"deflection": Beam()}, "tool.extension: a beam needs its length"),
        (
            {"regenerative": True, "tool.runout": 1e-6},
            "regenerative: a chip that knows the tool's motion knows no runout",
        ),
        ({"coefficients": "A5053"}, "coefficients: no such material, got 'A5053'; there is Al6082-T6"),
    ],
)
def test_a_cut_that_cannot_be_is_refused(changes, text):
    with pytest.raises(ExperimentError) as caught:
        cut().replace(**changes)
    assert text in str(caught.value)


def test_a_wall_behind_the_end_of_the_path_is_refused():
    cutting = cut(places=[0.2, 0.3])
    with pytest.raises(ExperimentError, match="the wall begins behind the end of the path, got 0.2 m .limit 0.15 m"):
        cutting.check_path(0.15, 0.1)
    with pytest.raises(ExperimentError, match="the feed makes no chip at this spindle speed, got 0 m a tooth"):
        cutting.check_path(0.5, 0.0)


def test_a_wall_before_the_beginning_of_the_path_is_refused():
    for wall in (
        {"places": [-0.06, -0.03], "radial": [1e-3]},
        {"places": [-0.06, -0.03, 0.1], "radial": [1e-3, 0.0]},
        {"places": [-0.06, 0.0], "radial": [0.0, 1e-3], "form": "linear"},
    ):
        cutting = cut().replace(wall=Wall(axial_depth=18e-3, **wall))
        with pytest.raises(ExperimentError, match="the wall ends before the path begins"):
            cutting.check_path(0.15, 0.1)
    cut(places=[-0.06, 0.03]).check_path(0.15, 0.1)


def test_a_cut_goes_to_a_file_and_comes_back():
    cutting = cut(mill(runout=5e-6, extension=75e-3), deflection=Beam(), start_angle=0.3)
    assert Cutting.from_file(cutting.to_file()) == cutting
    assert cutting.coefficients == MATERIAL
