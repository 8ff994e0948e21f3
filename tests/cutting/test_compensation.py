"""Leaning against the cut: signs as printed, motions that fit their derivatives, and a loop that settles."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from cutting.mills import FEED, cut, mill
from gough.cutting import Leaning
from gough.cutting.compensation import Corrected, command
from gough.cutting.surface import Ran, cut_wall
from gough.errors import ExperimentError
from gough.frames import rotation_of_abc_np, rotation_vector_np
from gough.simulate.leaning import Compensation

TS = 1e-3
DEG = np.pi / 180


@pytest.fixture(scope="module")
def machine():
    return gk.load_machine("okuma-pm600").frictionless().replace(**{"limits.cone": 70 * DEG})


def straight(**options):
    return gk.Line(to=[0.0, -0.1, 0.0], feed=FEED, **options)


def table(program, tilt=(0.06 * DEG, 0.083 * DEG), places=(0.02, 0.05, 0.08)):
    return Corrected(program=program, places=list(places), tilt=list(tilt), height=18e-3)


def test_commands_are_those_of_table_3():
    """Okuda et al. 2006, table 3: its estimated forces give its commands to the printed digits."""
    theta, delta = command(Leaning(), np.array([38.0, 58.0, 76.0]), 18e-3)
    assert_allclose(np.round(theta / DEG, 3), [0.038, 0.060, 0.083], rtol=0, atol=1e-12)
    assert_allclose(np.round(delta * 1e3, 3), [0.012, 0.019, 0.026], rtol=0, atol=1e-12)


def test_a_feed_along_minus_y_gives_minus_x_and_plus_b(machine):
    """Okuda et al. 2006, table 3: X -0.019, B +0.060; a and c, y and z stay."""
    r = table(straight()).plan(machine).sample(0, 1300, TS)
    plain = straight().plan(machine).sample(0, 1300, TS)
    k = int(np.argmin(np.abs(r.s[:, 0] - 0.035)))
    moved = r.x[k] - plain.x[k]
    assert_allclose(moved, [-18e-3 * np.tan(0.06 * DEG), 0, 0, 0, 0.06 * DEG, 0], rtol=0, atol=1e-12)


def test_the_upper_edge_of_the_wall_stays_where_it_was(machine):
    """dp and rho together move no point at the height R_a across the feed, to theta^2 of it."""
    r, plain = (p.plan(machine).sample(0, 1300, TS) for p in (table(straight()), straight()))
    upper = [one.x[:, :3] + 18e-3 * one.axis for one in (r, plain)]
    assert_allclose(upper[0][:, 0], upper[1][:, 0], rtol=0, atol=18e-3 * (0.083 * DEG) ** 2)


@pytest.mark.parametrize("program", ["line", "circle"])
def test_twist_and_its_rate_are_the_derivatives_of_the_corrected_pose(machine, program):
    base = straight() if program == "line" else gk.Circle(radius=0.05, feed=FEED)
    motion = table(base).plan(machine)
    h = 1e-4
    n = int(motion.duration / h) - 1
    r = motion.sample(0, n, h)
    R = rotation_of_abc_np(r.x[:, 3:])
    turned = rotation_vector_np(R[2:] @ np.swapaxes(R[:-2], -1, -2)) / (2 * h)
    rate = np.concatenate([(r.x[2:, :3] - r.x[:-2, :3]) / (2 * h), turned], 1)
    acc = (r.xd[2:] - r.xd[:-2]) / (2 * h)
    # without starts and stops, where the feed's acceleration jumps
    on = (r.s[1:-1, 0] > 0.01) & (r.s[1:-1, 0] < 0.09)
    jerk = 60 * 0.083 * DEG * (FEED / 4e-3) ** 3  # rad/s3, of the quintic at its ends; of the circle v^3 / rho^2, less
    # central differences: h^2 / 6 of the jerk; of the rates, where the jerk jumps, h / 4 of that
    assert_allclose(r.xd[1:-1][on], rate[on], rtol=0, atol=1.1 * h * h / 6 * jerk)
    assert_allclose(r.xdd[1:-1][on], acc[on], rtol=0, atol=1.1 * h / 4 * jerk)
    q = (r.q[2:] - r.q[:-2]) / (2 * h)
    assert_allclose(r.qd[1:-1][on], q[on], rtol=0, atol=1e-6)


def test_the_tilt_has_no_jump_nor_has_its_rate():
    s = np.linspace(0, 0.1, 100_001)
    value, rate, bend = table(straight()).theta(s)
    assert_allclose(np.gradient(value, s), rate, rtol=0, atol=1e-6 * np.abs(rate).max())
    assert np.abs(np.diff(rate)).max() < 2e-3 * np.abs(rate).max()
    assert np.abs(np.diff(bend)).max() < 5e-3 * np.abs(bend).max()
    assert_allclose(value[[0, 35_000, 65_000, -1]] / DEG, [0, 0.06, 0.083, 0], rtol=0, atol=1e-12)


def test_the_error_is_still_measured_against_the_program(machine):
    plan = table(straight()).plan(machine)
    assert_allclose(
        plan.path.point(np.array([0]), np.array([0.05])),
        straight().plan(machine).path.point(np.array([0]), np.array([0.05])),
    )


@pytest.mark.parametrize(
    "changes, text",
    [
        ({"tilt": [0.001]}, "tilt: 3 places have 2 tilts between them, got 1"),
        ({"places": [0.02, 0.021, 0.08]}, "places: places must rise by `blend` at least, got 0.001 m; a shorter blend"),
        ({"tilt": [0.06, 0.0]}, "tilt: must be below 0.05 rad"),
    ],
)
def test_a_correction_that_cannot_be_is_refused(changes, text):
    with pytest.raises(ExperimentError) as caught:
        table(straight()).replace(**changes)
    assert text in str(caught.value)


def test_a_machine_that_cannot_tilt_is_told_so():
    with pytest.raises(ExperimentError, match="only a machine with six freedoms can lean its tool, got ccu-3prs"):
        table(gk.Line(to=[0.01, 0.0, 0.0], feed=FEED), places=(0.0, 0.004, 0.009)).plan(gk.load_machine("ccu-3prs"))


# -- in the loop ----------------------------------------------------------------------------------------------------


def loop(machine, cutting, **options):
    plant = gk.Plant(machine=machine, cutting=cutting)
    given = {
        "observer": gk.DisturbanceObserver(bandwidth=10.0),
        "compensation": Compensation(height=18e-3, air=[0.005, 0.018]),
    }
    return gk.simulate(machine, gk.PID(bandwidth=20.0), straight(), plant, **(given | options))


AIR = Compensation(height=18e-3, air=[0.005, 0.018])
CUT = cut(mill(2, 30.0), "A5052", places=[0.02, 0.08], radial=[0.9e-3], deflection=Leaning())


@pytest.fixture(scope="module")
def log(machine):
    return loop(machine, CUT)


@pytest.mark.full
def test_in_the_loop_the_tool_leans_by_the_law_of_the_force(log):
    on = (log["s_r"] > 0.05) & (log["s_r"] < 0.078)
    theta = Leaning().inclination(CUT.mean_forces(FEED, 0.9e-3)[1])
    assert_allclose(log["controller.tilt"][on].mean(), theta, rtol=0.02)  # 1 N of 91 is 1.3 % of theta
    assert_allclose(log["controller.shift"][on].mean(), 18e-3 * np.tan(theta), rtol=0.02)
    assert not log["controller.tilt"][log["s_r"] < 0.018].any()


def test_in_the_loop_the_wall_stands_up(log, machine):
    wall, free = (
        cut_wall(CUT, straight().plan(machine).path, Ran(one.t, one["x"], one["s_r"]), np.arange(0.05, 0.078, 1e-4))
        for one in (log, loop(machine, CUT, compensation=None))
    )
    assert abs(wall.slope(0.05, 0.078)) < 0.05 * free.slope(0.05, 0.078)
    assert wall.deviation(0.05, 0.078) < 0.05 * free.deviation(0.05, 0.078)


def test_in_the_loop_the_tilt_changes_smoothly_and_the_feed_goes_on(log):
    """The rate of the tilt changes by w^2 theta Ts a sample at most, w = 2 pi 8 Hz; the tool never stops."""
    tilt = log["controller.tilt"]
    most = (2 * np.pi * 8) ** 2 * 0.11 * DEG * TS**2 * 1.5  # a force read higher by its ripple: 1.5
    assert np.abs(np.diff(tilt, 2)).max() < most
    speed = np.hypot(*log["xd"][(log["s_r"] > 0.01) & (log["s_r"] < 0.09), :2].T)
    assert speed.min() > 0.98 * FEED


def test_without_an_observer_there_is_nothing_to_go_by(machine):
    with pytest.raises(ExperimentError) as caught:
        loop(machine, CUT, observer=None)
    assert "compensation: needs an observer of the force on the tool, got none; give observer=" in str(caught.value)


def test_an_air_cut_that_goes_nowhere_is_refused():
    with pytest.raises(ExperimentError, match="air: must go from a place to one behind it, got .0.02, 0.01."):
        Compensation(height=18e-3, air=[0.02, 0.01])


@pytest.mark.full
def test_a_batch_leans_as_its_single_runs(machine, log):
    plants = [gk.Plant(machine=machine, cutting=CUT), gk.Plant(machine=machine, cutting=CUT.replace(start_angle=1.0))]
    many = gk.simulate(
        machine, gk.PID(bandwidth=20.0), straight(), plants, observer=gk.DisturbanceObserver(bandwidth=10.0),
        compensation=AIR,
    )  # fmt: skip
    # encoders of 1 um: a count that falls otherwise by rounding is read as some N for a sample
    assert_allclose(many.run(0)["controller.tilt"], log["controller.tilt"], rtol=0, atol=1e-3 * DEG)
