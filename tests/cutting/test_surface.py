"""Walls of runs made by hand: marks of the feed, leaning tools, runout, arcs."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from cutting.mills import FEED, SHARP, cut, mill
from gough.cutting import Beam, Leaning
from gough.cutting.surface import CutWall, Ran, cut_wall
from gough.errors import LogError
from gough.frames import abc_of_rotation_np, rotation_of_abc_np, rotation_of_vector_np

R, F_T = 6e-3, 0.25e-3
MARK = F_T**2 / (8 * R)  # m: height of the marks of the feed on a straight wall
AT = {"places": [0.02, 0.08], "radial": [0.9e-3]}


@pytest.fixture(scope="module")
def machine():
    return gk.load_machine("okuma-pm600")


def ran_on(machine, program, moved=(0.0, 0.0, 0.0), turned=(0.0, 0.0, 0.0)):
    """A run exactly on a program, the tool moved by m and turned about its tip by a rotation vector, both in W."""
    motion = program.plan(machine)
    n = motion.count(1e-3)
    r = motion.sample(0, n, 1e-3)
    x = r.x.copy()
    x[:, :3] += moved
    x[:, 3:] = abc_of_rotation_np(rotation_of_vector_np(np.asarray(turned, float)) @ rotation_of_abc_np(x[:, 3:]))
    return motion.path, Ran(np.arange(n) * 1e-3, x, r.s[:, 0])


def line(machine, **how):
    return ran_on(machine, gk.Line(to=[0.0, -0.1, 0.0], feed=FEED), **how)


S = np.arange(0.04, 0.05, 7e-6)  # many places a mark


def test_a_rigid_tool_leaves_the_marks_of_its_feed(machine):
    wall = cut_wall(cut(mill(2, 30.0), **AT), *line(machine), S)
    assert wall.error.min() >= -1e-12
    # a chord instead of the tool's circle is off by f^4 / 128 R^3; a grid of 7 um sees the peak to 5 % of its width
    assert_allclose(wall.error.max(), MARK, rtol=1e-3)
    assert_allclose(wall.error.mean(), MARK / 3, rtol=0.01)  # of a parabola


def test_marks_run_up_the_wall_with_the_helix(machine):
    """The place of a mark moves along the feed by v k z / Omega."""
    cutting = cut(mill(2, 30.0), **AT)
    wall = cut_wall(cutting, *line(machine), S, [0.0, 3e-3])
    k = 2 * np.tan(np.radians(30)) / 12e-3
    shift = FEED * k * 3e-3 / cutting.spindle_speed
    shifted = cut_wall(cutting, *line(machine), S + shift, [0.0, 3e-3])
    assert_allclose(shifted.error[:, 1], wall.error[:, 0], rtol=0, atol=1e-10)


def test_outside_the_stock_there_is_no_wall(machine):
    wall = cut_wall(cut(mill(2, 30.0), **AT), *line(machine), [0.01, 0.05, 0.09])
    assert np.isnan(wall.error[[0, 2]]).all() and np.isfinite(wall.error[1]).all()
    with pytest.raises(LogError, match="no wall was cut there, got 0 m to 0.015 m of the path"):
        wall.along_z(0.0, 0.015)


def test_the_measured_law_leans_the_wall_by_its_angle(machine):
    cutting = cut(mill(2, 30.0), deflection=Leaning(), **AT)
    wall = cut_wall(cutting, *line(machine), S)
    theta = Leaning().inclination(cutting.mean_forces(FEED, 0.9e-3)[1])
    assert theta > 0  # climbing pushes the tool off: material stands proud at the tip
    assert_allclose(wall.slope(0.04, 0.05), theta, rtol=1e-3)
    assert_allclose(wall.inclination(0.04, 0.05), theta, rtol=1e-3)
    assert_allclose(wall.deviation(0.04, 0.05), 18e-3 * np.tan(theta), rtol=1e-3)


def test_the_correction_of_the_paper_stands_the_wall_up_again(machine):
    """Feed along -y: x -delta and +theta about +y, the signs of table 3, take away what the law does."""
    cutting = cut(mill(2, 30.0), deflection=Leaning(), **AT)
    theta = Leaning().inclination(cutting.mean_forces(FEED, 0.9e-3)[1])
    delta = 18e-3 * np.tan(theta)
    wall = cut_wall(cutting, *line(machine, moved=[-delta, 0, 0], turned=[0, theta, 0]), S)
    # 1 - cos(theta) of the height is left, 3e-6 of 18 mm, and of the radius
    assert abs(wall.slope(0.04, 0.05)) < 1e-3 * theta
    assert_allclose(wall.along_z(0.04, 0.05), MARK / 3, rtol=0, atol=0.05e-6)


def test_b_is_positive_as_table_3_prints_it(machine):
    """theta about +y of W is +b of the pose (R = Rz Ry Rx), at a = c = 0."""
    x = abc_of_rotation_np(rotation_of_vector_np(np.array([0.0, 0.083 * np.pi / 180, 0.0])))
    assert_allclose(x, [0, 0.083 * np.pi / 180, 0], rtol=0, atol=1e-15)


def test_a_beam_shows_the_force_of_the_instant(machine):
    """At height z the wall is made when a tooth stands at pi there: its profile is that force's deflection."""
    cutting = cut(mill(2, 30.0, extension=60e-3), deflection=Beam(), **AT)
    z = np.linspace(0, 18e-3, 10)
    wall = cut_wall(cutting, *line(machine), S, z)
    k = 2 * np.tan(np.radians(30)) / 12e-3
    force = cutting.forces(FEED, 0.9e-3, np.pi + k * z)[:, 1]
    bent = Beam().lateral(cutting.tool, force, 9e-3, z, 18e-3)
    assert_allclose(wall.along_z(0.04, 0.05), bent + MARK / 3, rtol=0, atol=0.02 * bent.max())
    assert bent[-1] < 0.01 * bent.max()  # the upper edge is made when the tooth leaves: nothing pushes then


def test_conventional_milling_pulls_the_tool_into_the_wall(machine):
    """Wall on the left: a force along +y digs, and what is proud when climbing is gouged here."""
    cutting = cut(mill(2, 30.0), SHARP, milling="up", deflection=Leaning(), **AT)
    F_y = cutting.mean_forces(FEED, 0.9e-3)[1]
    assert F_y > 0
    wall = cut_wall(cutting, *line(machine), S)
    assert_allclose(wall.slope(0.04, 0.05), -Leaning().inclination(F_y), rtol=1e-3)
    rigid = cut_wall(cutting.replace(deflection=None), *line(machine), S)
    assert_allclose(rigid.error.max(), MARK, rtol=1e-3)


def test_with_runout_the_longer_tooth_makes_the_wall(machine):
    r = 10e-6
    cutting = cut(mill(2, 0.0, runout=r, runout_angle=0.0), **AT)
    wall = cut_wall(cutting, *line(machine), S, [9e-3])
    assert_allclose(wall.error.min(), -r, rtol=1e-3)
    # marks two feeds apart are four times as high, 5.2 um; the shorter tooth, 20 um below, does not reach them
    assert_allclose(wall.error.max(), -r + 4 * MARK, rtol=0.01)


@pytest.mark.parametrize("direction, sign", [("cw", 1), ("ccw", -1)])
def test_on_arcs_marks_are_those_of_a_bent_wall(machine, direction, sign):
    """Wall on the right: clockwise it is within the circle (radius rho - R), counter-clockwise without (rho + R).

    Height of marks: chords of the two circles, (f_w^2 / 8) (1 / R +- 1 / R_w), f_w the feed as the wall sees it.
    """
    rho = 50e-3
    program = gk.Circle(radius=rho, feed=FEED, direction=direction)
    path, ran = ran_on(machine, program)
    cutting = cut(mill(2, 0.0), places=[0.02, 0.25], radial=[0.9e-3])
    s = np.arange(0.1, 0.11, 7e-6)
    wall = cut_wall(cutting, path, ran, s, [9e-3])
    wall_radius = rho - sign * R
    f_w = F_T * wall_radius / rho
    assert_allclose(wall.error.max(), f_w**2 / 8 * (1 / R + sign / wall_radius), rtol=0.02)
    # places between rows of 1 ms lie on chords of the path, 0.1 mm long
    assert wall.error.min() > -1.01 * (FEED * 1e-3) ** 2 / (8 * rho)


def test_the_inclination_is_of_the_line_through_the_extremes():
    s, z = np.array([0.0, 1.0]), np.array([0.0, 9e-3, 18e-3])
    leaning = CutWall(s, z, np.tile([30e-6, 20e-6, 0.0], (2, 1)))
    assert_allclose(leaning.inclination(0, 1), np.arctan(30e-6 / 18e-3), rtol=1e-12)
    bulged = CutWall(s, z, np.tile([0.0, -9e-6, 0.0], (2, 1)))
    assert_allclose(abs(bulged.inclination(0, 1)), np.arctan(9e-6 / 9e-3), rtol=1e-12)
    assert_allclose(bulged.slope(0, 1), 0, atol=1e-15)
    assert CutWall(s, z, np.zeros((2, 3))).inclination(0, 1) == 0


def test_a_wall_needs_a_pose():
    with pytest.raises(LogError, match="a wall is made by a tool with a pose of six numbers"):
        Ran.of({"t": np.zeros(3), "x": np.zeros((3, 3)), "s_r": np.zeros(3)})
