"""Chatter on a machine that gives way: responses from two sides, limit cases, the loop that shakes or does not."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from cutting.mills import SHARP, cut, mill
from gough.cutting import Cutting, Wall
from gough.cutting.lobes import multiplier
from gough.cutting.posed import across, depth_map, engaged, lobes_at, tip_modes, tip_response, tool_mode
from gough.errors import ExperimentError
from gough.simulate.receptance import receptance

FEED = [0.0, -1.0, 0.0]


@pytest.fixture(scope="module")
def machine():
    return gk.load_machine("nist-octahedral").frictionless().with_perfect_drives()


@pytest.fixture(scope="module")
def flexible(machine):
    return machine.flexible()


def slot(depth, speed, teeth=4):
    """A full slot by even straight flutes: constant coefficients, of which the zeroth order leaves nothing out."""
    wall = Wall(axial_depth=depth, places=[2e-3, 0.2], radial=[12e-3])
    return Cutting(tool=mill(teeth, 0.0), coefficients=SHARP, wall=wall, spindle_speed=speed, regenerative=True)


def test_held_joints_answer_as_the_sum_of_their_modes(flexible):
    """Damping in proportion to stiffness: modes are all there is.  1e-6: what the turn of K against K' leaves."""
    x, f = flexible.home + [0.05, 0.02, 0.03, 0, 0, 0], np.linspace(5, 300, 40)
    H = tip_response(flexible, x, f, FEED).response
    assert_allclose(tip_modes(flexible, x, FEED).response(f), H, rtol=0, atol=1e-6 * np.abs(H).max())


def test_slow_forces_find_the_static_compliance(flexible):
    e = across(flexible, flexible.home, FEED)
    H = tip_response(flexible, flexible.home, [1e-3], FEED).response[0]
    C = e.T @ flexible.tool_compliance(flexible.home)[:3, :3] @ e
    assert_allclose(H, C, rtol=0, atol=1e-6 * np.abs(C).max())


def test_the_frame_of_a_feed_is_that_of_the_cut(flexible):
    """Feed along -y of an upright tool: x of C is -y of W, y of C is +x."""
    assert_allclose(across(flexible, flexible.home, [0, -2, 0.7]), [[0, 1], [-1, 0], [0, 0]], atol=1e-12)
    with pytest.raises(ExperimentError, match="feed: the feed must go across the tool"):
        across(flexible, flexible.home, [0, 0, 1])


def test_a_bar_in_series_bends_by_its_length_cubed():
    """Statically 12 / 1.8751^4 = 0.9707 of the cantilever's L^3 / 3 E I: the first of its modes."""
    tool = mill(4, 0.0, extension=75e-3)
    bending = 600e9 * np.pi * (0.8 * 12e-3) ** 4 / 64
    found = tool_mode(tool).response([1e-3])[0]
    assert_allclose(found, 0.97068 * np.eye(2) * 75e-3**3 / (3 * bending), rtol=1e-4, atol=1e-20)
    with pytest.raises(ExperimentError, match="tool.extension: a tool that bends needs its length"):
        tool_mode(mill(4, 0.0))


def test_a_slender_tool_sets_the_border_at_its_own_frequency(flexible):
    tool = mill(4, 0.0, extension=75e-3)
    own = tool_mode(tool).frequency[0]
    alone, bare = (lobes_at(flexible, flexible.home, cut(one, radial=(6e-3,)), FEED) for one in (tool, mill(4, 0.0)))
    assert alone.least < bare.least
    assert 1 < alone.frequency[alone.depth.argmin()] / own < 1.1
    assert 1 < bare.frequency[bare.depth.argmin()] / flexible.modes(flexible.home).frequency[0] < 1.1


@pytest.mark.full
@pytest.mark.parametrize("rpm", [600, 3000])
def test_step_by_step_the_held_machine_shakes_above_the_border_and_not_below(flexible, rpm):
    speed = rpm * 2 * np.pi / 60
    limit = float(lobes_at(flexible, flexible.home, slot(1e-3, speed), FEED).limit(speed))
    modes = tip_modes(flexible, flexible.home, FEED)
    low, high = (multiplier(modes, SHARP, 4, 0.0, np.pi, speed, k * limit) for k in (0.85, 1.15))
    assert low < 1 < high


@pytest.mark.full
@pytest.mark.parametrize("rpm", [600, 1500, 3000])
def test_a_simulated_cut_under_a_law_shakes_above_the_border_of_its_loop_and_not_below(machine, flexible, rpm):
    """The whole loop in time, servo and regenerative chip: at 0.7 of the depth it rests in its wall, at 1.4 it grows.

    0.7 and 1.4: far enough for growth or decay by tens within the wall.
    """
    speed, law = rpm * 2 * np.pi / 60, gk.PID(bandwidth=5.0)
    f = np.linspace(1, 450, 4_000)
    border = lobes_at(
        flexible, flexible.home, slot(1e-3, speed), FEED, f, joints=lambda m, x, at: receptance(m, law, at, x)
    )
    limit = float(border.limit(speed))
    spread = []
    for k in (0.7, 1.4):
        program = gk.Line(begin=[0, 0.02, 0], to=[0, 0, 0], feed=0.01, settle=0.05)
        log = gk.simulate(
            machine, law, program, gk.Plant(machine=machine, flexible=True, cutting=slot(k * limit, speed))
        )
        assert not log.failed, log.reason
        x, early, late = (
            log["x"][:, 0],
            *((log["s_r"] > a) & (log["s_r"] < b) for a, b in ((4e-3, 7e-3), (15e-3, 18e-3))),
        )
        spread.append((np.std(x[early]), np.std(x[late])))
    (stable_early, stable_late), (early, late) = spread
    assert stable_late < stable_early / 2
    assert late > 2 * early and late > 20 * stable_late


def test_below_its_bandwidth_a_servo_is_stiff_and_above_it_is_not_there(flexible):
    """The static compliance with the motors held (the law integrates); far above, the free machine's."""
    x, law = flexible.home, gk.PID(bandwidth=20.0)
    slow, fast = receptance(flexible, law, [0.01, 380.0], x)
    # 3e-3: at 0.01 Hz the integral is 2.4 mrad from done
    C = flexible.tool_compliance(x)
    assert_allclose(slow.real, C, rtol=0, atol=3e-3 * np.abs(C).max())
    free = flexible.frequency_response(x, [380.0], source="tool", to="tool")[0]
    assert_allclose(fast[0, 0], free[0, 0], rtol=0.03)
    weak = receptance(flexible, gk.PID(bandwidth=0.05), [50.0, 200.0], x)
    # (0.05 Hz / 50 Hz) of a velocity loop 10 times as fast: 1 %
    assert_allclose(weak[:, 0, 0], flexible.frequency_response(x, [50.0, 200.0], source="tool")[:, 0, 0], rtol=0.01)


@pytest.mark.full
def test_the_map_is_the_border_at_each_pose_and_knows_the_turn_of_the_machine(flexible):
    """nist-octahedral looks the same after a third of a turn: so does the depth, with the feed turned along."""
    third = 2 * np.pi / 3
    R = np.array([[np.cos(third), -np.sin(third), 0], [np.sin(third), np.cos(third), 0], [0, 0, 1]])
    off = np.array([0.08, 0.03, 0.02])
    poses = [np.r_[flexible.home[:3] + way, flexible.home[3:]] for way in (off, R @ off)]
    cutting = cut(mill(4, 0.0), radial=(6e-3,))
    here, there = depth_map(flexible, poses[:1], cutting, FEED), depth_map(flexible, poses[1:], cutting, R @ FEED)
    assert here["least"][0] == lobes_at(flexible, poses[0], cutting, FEED).least
    for name in ("least", "limit", "frequency"):
        assert_allclose(there[name], here[name], rtol=1e-5)
    assert not np.isclose(here["least"][0], lobes_at(flexible, flexible.home, cutting, FEED).least, rtol=1e-3)
    beyond = depth_map(flexible, [flexible.home + [5.0, 0, 0, 0, 0, 0]], cutting, FEED)
    assert all(np.isnan(value[0]) for value in beyond.values())


def test_depths_that_make_no_chip_are_refused(flexible):
    for depth in (0.0, -1e-3, 13e-3, np.nan):
        with pytest.raises(ExperimentError, match="radial: no chip, or more than a full slot"):
            engaged(cut(mill(4, 0.0)), depth)
    with pytest.raises(ExperimentError, match='joints: must be "held", "free" or a function, got'):
        tip_response(flexible, flexible.home, [10.0], FEED, joints="loose")
