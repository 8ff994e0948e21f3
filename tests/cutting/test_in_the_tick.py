"""The cut on a machine in closed loop: the force that acts is the one that is logged, told and balanced."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from cutting.mills import FEED, SPEED, cut, mill
from gough.cutting import force
from gough.cutting.numeric import ARRAYS
from gough.errors import ExperimentError
from gough.simulate import cut as tick_cut
from gough.simulate.faults import EncoderFault
from gough.simulate.notes import EncoderWarning

WAY = 0.1  # m
AT = {"places": [0.02, 0.08], "radial": [1.5e-3]}


@pytest.fixture(scope="module")
def machine():
    """Without friction and with exact encoders: what is left is the cut."""
    free = gk.load_machine("okuma-pm600").frictionless()
    return free.replace(**{"limits.cone": np.radians(70), "drive": free.drive.perfect()})


def run(machine, cutting, way=(0.0, -WAY, 0.0), **options):
    program = gk.Line(begin=[0.0, 0.0, 0.0], to=list(way), feed=FEED, settle=0.05)
    return gk.simulate(machine, gk.PID(bandwidth=20.0), program, gk.Plant(machine=machine, cutting=cutting), **options)


@pytest.fixture(scope="module")
def log(machine):
    return run(machine, cut(mill(2, 30.0), **AT), observer=gk.DisturbanceObserver(bandwidth=40.0))


def within(log, first, last):
    return (log["s_r"] > first) & (log["s_r"] < last)


def test_the_dynamometer_reads_the_closed_form_mean(log):
    on = np.flatnonzero(within(log, 0.03, 0.07))
    on = on[: len(on) // 5 * 5]  # whole teeth: 2.5 ms each
    f_x, f_y, f_z, moment = cut(**AT).mean_forces(FEED, 1.5e-3)
    found = log["cutting_force"][on].mean(0)
    # feed along -y: x of C is -y of W, y of C is +x.  Simpson at 20 places a tooth, kinks 2 a tooth: below a percent
    assert_allclose(found[:3], [f_y, -f_x, f_z], rtol=0.01)
    half = 9e-3
    assert_allclose(found[3:], [half * f_x, half * f_y, moment], rtol=0.01)


def test_the_observer_tells_the_cut_from_the_drives(log):
    """No friction and a true model: what is left is the low pass."""
    on = within(log, 0.04, 0.078)
    assert_allclose(log["wrench_hat"][on].mean(0)[:3], log["cutting_force"][on].mean(0)[:3], rtol=0, atol=1.5)


def test_in_air_nothing_pushes(log):
    assert not log["cutting_force"][within(log, 0.0, 0.0198)].any()
    assert not log["cutting_force"][-5:].any()
    assert_allclose(log["wrench"], log["cutting_force"], rtol=0, atol=0)


def test_the_force_turns_with_the_feed(machine):
    """Along +x the normal force is along +y, whatever the axes are called."""
    log = run(machine, cut(mill(2, 30.0), **AT), (WAY, 0.0, 0.0))
    on = within(log, 0.03, 0.07)
    f_x, f_y, f_z, _ = cut(**AT).mean_forces(FEED, 1.5e-3)
    assert_allclose(log["cutting_force"][on].mean(0)[:3], [f_x, f_y, f_z], rtol=0.02)


def test_the_spindle_stands_where_time_says(log):
    k = np.arange(len(log.t))
    assert_allclose(np.exp(1j * log["plant.spindle_angle"]), np.exp(1j * SPEED * 1e-3 * k), rtol=0, atol=1e-9)


@pytest.mark.full
def test_twice_the_sub_steps_give_the_same_mean(machine):
    coarse, fine = (run(machine, cut(mill(2, 30.0), **AT), substeps=n) for n in (4, 16))
    on = within(coarse, 0.03, 0.07)
    a, b = (one["cutting_force"][on].mean(0) for one in (coarse, fine))
    assert_allclose(a[:3], b[:3], rtol=0.01)
    assert_allclose(coarse["x"][on], fine["x"][on], rtol=0, atol=1e-7)  # a tenth of what the cut moves the machine


def test_a_regenerative_chip_takes_the_same_mean_on_a_stiff_machine(machine, log):
    """The tool moves on by f in a tooth period; what the loop gives is some um of 250."""
    found = run(machine, cut(mill(2, 30.0), regenerative=True, **AT))
    on = within(found, 0.03, 0.07)
    a, b = found["cutting_force"][on].mean(0), log["cutting_force"][on].mean(0)
    assert_allclose(a[:3], b[:3], rtol=0.02)
    assert np.abs(a - b).max() > 1e-6  # and it is another chip


def test_a_batch_is_its_single_runs(machine):
    cuts = [cut(mill(2, 30.0), places=[0.01, 0.03], radial=[depth]) for depth in (0.5e-3, 2e-3)]
    program = gk.Line(to=[0.0, -0.04, 0.0], feed=FEED, settle=0.02)
    plants = [gk.Plant(machine=machine, cutting=one) for one in cuts]
    many = gk.simulate(machine, gk.PID(bandwidth=20.0), program, plants)
    for i, plant in enumerate(plants):
        one = gk.simulate(machine, gk.PID(bandwidth=20.0), program, plant)
        # rounding of lanes, through the loop: 1e-9 N of 100
        assert_allclose(many.run(i)["cutting_force"], one["cutting_force"], rtol=0, atol=1e-7)


def test_sub_steps_that_miss_teeth_are_refused(machine):
    with pytest.raises(ExperimentError) as caught:
        run(machine, cut(mill(6), **AT), substeps=4)
    assert "run.substeps: 4 sub-steps a sample miss the teeth of the cut, one every 0.8333 ms" in str(caught.value)
    assert "give at least 10" in str(caught.value)


def test_runs_that_cut_and_runs_that_do_not_are_no_batch(machine):
    plants = [gk.Plant(machine=machine, cutting=cut(**AT)), gk.Plant(machine=machine)]
    with pytest.raises(ExperimentError, match="plant.1.cutting: of a batch all runs cut, or none"):
        gk.simulate(machine, gk.PID(bandwidth=20.0), gk.Line(to=[0.0, -WAY, 0.0], feed=FEED), plants)


def test_a_plunge_is_no_milling_of_a_wall(machine):
    log = run(machine, cut(mill(2, 30.0), **AT), (0.0, 0.0, 0.1))
    assert not log["cutting_force"].any()


@pytest.mark.full
def test_reactions_know_the_cut(machine):
    """Forces of the platform on its struts: without the tool's weight they carry the cut; here the sum of all."""
    names = ["plant.reaction", "cutting_force", "s_r", "x", "xd"]
    cutting = cut(mill(2, 30.0), **AT)
    logs = [run(machine, one, signals=names, period=0.25e-3) for one in (cutting, None)]
    at = [one.t for one in logs]
    n = min(map(len, at))
    on = (logs[0]["s_r"][:n] > 0.04) & (logs[0]["s_r"][:n] < 0.07)
    more = (logs[0]["plant.reaction"][:n] - logs[1]["plant.reaction"][:n])[on].sum(1).mean(0)
    # the platform hands what acts on it to its struts: the cut; the machine moves evenly, so no inertia is between
    assert_allclose(more, logs[0]["cutting_force"][:n, :3][on].mean(0), rtol=0.02, atol=1.0)


@pytest.mark.full
def test_a_safe_stop_within_the_wall_stops_the_chip(machine):
    """An encoder is lost in the wall; the tool brakes along its path, and a tool that stands cuts nothing."""
    plant = gk.Plant(
        machine=machine, cutting=cut(mill(2, 30.0), **AT),
        faults=[EncoderFault(kind="glitch", joint=2, start=0.5, size=1e-4)],
    )  # fmt: skip
    program = gk.Line(begin=[0.0, 0.0, 0.0], to=[0.0, -WAY, 0.0], feed=FEED, settle=0.05)
    with pytest.warns(EncoderWarning):
        log = gk.simulate(machine, gk.PID(bandwidth=20.0), program, plant, encoder_check=2000.0, stop_ramp=2.0)
    assert "safe stop" in log.reason or "encoder" in log.reason
    stopped = log["stopping"] > 0
    assert stopped.any() and log["cutting_force"][~stopped].any()
    assert not log["cutting_force"][-3:].any()


@pytest.mark.full
def test_friction_that_drifts_and_a_cut_go_together():
    machine = gk.load_machine("okuma-pm600").replace(**{"limits.cone": np.radians(70)})
    plant = gk.Plant(machine=machine, cutting=cut(mill(2, 30.0), **AT), friction_drift=0.1)
    log = gk.simulate(machine, gk.PID(bandwidth=20.0), gk.Line(to=[0.0, -WAY, 0.0], feed=FEED), plant)
    assert not log.failed
    assert_allclose(log["plant.friction_scale"][-1], 1 + 0.1 * log.t[-1], rtol=1e-9)
    assert np.abs(log["cutting_force"]).max() > 50


@pytest.mark.full
def test_a_head_of_three_freedoms_cuts_with_its_own_tilt():
    """The tool of a 3-PRS leans as it must; the force is across that tool."""
    head = gk.load_machine("ccu-3prs")
    program = gk.Line(begin=[0.02, 0.0, 0.0], to=[0.02, 0.06, 0.0], feed=0.05, settle=0.05)
    cutting = cut(mill(2, 30.0), places=[0.02, 0.05], radial=[1e-3])
    log = gk.simulate(head, gk.PID(bandwidth=10.0), program, gk.Plant(machine=head, cutting=cutting))
    assert not log.failed, log.reason
    on = within(log, 0.03, 0.048)
    f_x, f_y, f_z, _ = cutting.mean_forces(0.05, 1e-3)
    force = log["cutting_force"][on].mean(0)[:3]
    assert_allclose(np.linalg.norm(force), np.linalg.norm([f_x, f_y, f_z]), rtol=0.02)
    assert force[0] < -0.9 * f_y < 0  # along +y the wall is on +x: the tool is pushed to -x


def test_a_regenerative_chip_is_what_the_tool_did_a_tooth_ago(machine):
    """Trails made by hand: even feed gives the chip of the feed; a step off the wall since then thins it by itself."""
    cutting = cut(mill(2, 30.0), regenerative=True, **AT)
    step = 0.25e-3
    look_back = tick_cut.kept(cutting, step)
    now = tick_cut._now(machine, cutting, step, look_back)
    z = machine.coordinates(machine.home)
    f = float(cutting.feed_per_tooth(FEED))
    along, depth, angle = np.array([0.0, -1.0, 0.0]), 1.5e-3, 2.9
    ago = np.arange(1, look_back + 1) * step / cutting.tooth_period
    place = machine.home[:3]

    def wrench(trail, place=place):
        given = [machine.theta, cutting.theta, f, depth, angle, along, place, angle, z, np.zeros(6), np.zeros(6)]
        return np.array(now(*given, np.ravel(trail)))[:, 0]

    even = place - f * ago[:, None] * along
    F = cutting.forces(FEED, depth, angle)
    assert_allclose(wrench(even)[:3], [F[1], -F[0], F[2]], rtol=1e-9)  # y of C is +x of W
    b = 20e-6  # it stood so much nearer to the wall, at -x, a tooth ago
    beside = even - [b, 0, 0]
    window = force.window(ARRAYS, cutting.tool, np.array(depth), -1.0)
    tool, K = cutting.tool, cutting.coefficients
    cuts = [[(f, 0.0, *window)]] * 2
    G = force.force(ARRAYS, tool, K, 2, 18e-3, cuts, angle, b)
    assert_allclose(wrench(beside)[:3], [G[1], -G[0], G[2]], rtol=1e-9)
    assert G[1] < F[1]
    # and the reference stands beside the tool: the tool is nearer to the wall than meant, and cuts deeper
    nearer = wrench(even, place + [0.5e-3, 0, 0])
    D = cutting.forces(FEED, depth + 0.5e-3, angle)
    assert_allclose(nearer[:3], [D[1], -D[0], D[2]], rtol=1e-9)
