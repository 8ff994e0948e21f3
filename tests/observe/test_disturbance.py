"""The disturbance observer: its answer to known forces, and what it must not take for one."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import gough as gk
from gough.errors import ExperimentError, InputError
from gough.kernel.tape import trace
from gough.mechanics.friction import LuGre
from gough.observe.recorded import Recorder
from gough.observe.tasks import function_of
from gough.simulate.plant import Plant
from observe.pushed import pushed

LIBRARY = ["okuma-pm600", *(pytest.param(m, marks=pytest.mark.full) for m in ("nist-octahedral", "eth-hexaglide"))]
PERIOD = 1e-3
HOLD = gk.PID(bandwidth=8.0)

pytestmark = pytest.mark.filterwarnings("ignore::gough.simulate.notes.EffortWarning")


@pytest.fixture(scope="module", params=LIBRARY)
def ideal(request):
    """A machine without friction, with encoders without steps and drives without limits."""
    return perfect(gk.load_machine(request.param))


def perfect(machine):
    quiet = machine.frictionless()
    return quiet.replace(drive=quiet.drive.perfect())


@pytest.fixture(scope="module")
def okuma():
    return gk.load_machine("okuma-pm600")


def expected_gain(f, bandwidth):
    """From a force held over each sample to w: the mean of the last two samples, then eq. (4).  Complex."""
    s = np.exp(-2j * np.pi * f * PERIOD)
    k = 1 - np.exp(-2 * np.pi * bandwidth * PERIOD)
    return (s + s * s) / 2 * k / (1 - (1 - k) * s)


@pytest.mark.quick("okuma-pm600-20.0")
@pytest.mark.parametrize("f", [pytest.param(3.0, marks=pytest.mark.full), 20.0, 60.0])
def test_a_swinging_force_comes_through_as_the_stated_low_pass(ideal, f):
    """RELIABILITY C1: gain within 1 %, phase within 2 deg, in all six components at once."""
    n, bandwidth = 2000, 20.0
    amplitude = np.array([300.0, -200.0, 150.0, 20.0, -15.0, 10.0])
    wave = np.exp(2j * np.pi * f * PERIOD * np.arange(n))
    rows = pushed(ideal, HOLD, gk.DisturbanceObserver(bandwidth=bandwidth), np.outer(wave.imag, amplitude))
    tail = slice(n // 2, None)  # whole periods
    found = 2 / (n // 2) * rows["wrench_hat"][tail].T @ (wave[tail].conj() * 1j) / amplitude
    ratio = found / expected_gain(f, bandwidth)
    assert np.abs(np.abs(ratio) - 1).max() < 0.01
    assert np.abs(np.angle(ratio)).max() < np.radians(2)


def test_a_steady_force_is_found_exactly_in_both_forms(ideal):
    wrench = np.array([300.0, -200.0, 150.0, 20.0, -15.0, 10.0])
    for form in ("momentum", "static"):
        rows = pushed(ideal, HOLD, gk.DisturbanceObserver(form=form), np.tile(wrench, (3000, 1)))
        # the loop of 8 Hz is at rest after 3 s to exp(-3 x 8 pi) of the force's jump
        assert_allclose(rows["wrench_hat"][-1], wrench, rtol=0, atol=1e-3)


@pytest.mark.full
def test_with_fewer_freedoms_the_force_at_the_tip_is_found_and_no_moment():
    """A 3-PRS tells three numbers; those of a force at the tip are its force."""
    force = np.array([120.0, -80.0, 200.0, 0.0, 0.0, 0.0])
    rows = pushed(perfect(gk.load_machine("ccu-3prs")), HOLD, gk.DisturbanceObserver(), np.tile(force, (3000, 1)))
    assert_allclose(rows["wrench_hat"][-1], force, rtol=0, atol=1e-3)


@pytest.mark.parametrize("name", sorted(gk.library()))
def test_the_step_is_short_on_every_machine_of_the_library(name):
    """Some 6 000 operations are 2 us of machine code: below 3 us a sample with room (docs/performance.md has times)."""
    machine = gk.load_machine(name)
    function = function_of(gk.DisturbanceObserver().on(machine, PERIOD))
    assert trace(function).operations < 7000


def test_a_step_has_risen_to_63_percent_after_the_time_constant(ideal):
    bandwidth = 10.0
    wrench = np.zeros((1000, 6))
    wrench[500:, 0] = 100.0
    hat = pushed(ideal, HOLD, gk.DisturbanceObserver(bandwidth=bandwidth), wrench)["wrench_hat"][:, 0]
    k = 1 - np.exp(-2 * np.pi * bandwidth * PERIOD)
    after = np.arange(480)  # w at 501 + j: half of the first sample's force, then all of it
    exact = 100 * (1 - (1 - k) ** after * (1 - k / 2))
    assert_allclose(hat[501:981], exact, rtol=0, atol=0.5)
    assert hat[500] == pytest.approx(0, abs=1e-6)


def followed(machine, form, feed, period=PERIOD):
    """Largest force that is read on a circle without any, after the start, N."""
    circle = gk.Circle(radius=0.05, feed=feed)
    observer = gk.DisturbanceObserver(form=form, bandwidth=20.0)
    log = gk.simulate(machine, gk.ComputedTorque(bandwidth=10.0), circle, observer=observer, period=period)
    assert not log.failed
    return np.abs(log["wrench_hat"][100:, :3]).max()


@pytest.mark.full
def test_the_momentum_form_reads_no_force_from_motion(ideal):
    """0.2 m/s on 50 mm is 0.8 m/s2, on some 200 kg 160 N of inertia; of it remain parts in a thousand."""
    assert followed(ideal, "momentum", 0.2) < 1.5
    assert followed(ideal, "static", 0.2) > 50


@pytest.mark.full
def test_what_the_momentum_form_leaves_is_of_second_order_in_the_period(okuma):
    """The mean values of eq. (1) are centred: half the period, a quarter of the error."""
    errors = [followed(perfect(okuma), "momentum", 0.2, period) for period in (2e-3, 1e-3)]
    assert 3.0 < errors[0] / errors[1] < 5.0


@pytest.mark.full
def test_a_believed_friction_is_taken_off(okuma):
    """90 N in each strut is 200 N and more at the tool; where the struts move, the belief explains it."""
    machine = perfect(okuma).replace(friction=okuma.friction)
    circle, law = gk.Circle(radius=0.05, feed=0.05), gk.ComputedTorque(bandwidth=16.0)
    found = {}
    for name, believed in (("known", machine), ("unknown", perfect(okuma))):
        log = gk.simulate(machine, law, circle, observer=gk.DisturbanceObserver(machine=believed, bandwidth=50.0))
        moving = (np.abs(log["xd"][:, :3]).max(-1) > 0.02) & (log["t"] > 0.3)
        found[name] = np.median(np.linalg.norm(log["wrench_hat"][moving, :3], axis=1))
    assert found["known"] < 5
    assert found["unknown"] > 100


def test_what_rest_hides_is_the_screws_friction_along_the_struts(okuma):
    """MACHINES.md 5.3: f0 sum |l| is 220-228 N in X and 242-265 N in Y where the circle tests are."""
    rows = pushed(okuma, HOLD, gk.DisturbanceObserver(), np.zeros((5, 6)))
    n = okuma.jacobian(okuma.home)[:, :3]
    hidden = rows["observer.hidden"][-1]
    assert_allclose(hidden[:3], 90.0 * np.abs(n).sum(0), rtol=1e-6)
    assert 220 <= hidden[0] <= 229 and 242 <= hidden[1] <= 265


@pytest.mark.full
@pytest.mark.parametrize("direction", [0, 1])
def test_at_rest_the_estimate_is_wrong_by_no_more_than_it_says(okuma, direction):
    """Loads up and down: screws that stick (LuGre) take up to f_0 each, in a direction nobody knows."""
    true = okuma.replace(friction=LuGre(coulomb=90.0, stiffness=1e7, damping=3e4))
    levels = np.concatenate([np.arange(0, 3501, 700), np.arange(2800, -1, -700)]).astype(float)
    wrench = np.zeros((len(levels) * 500, 6))
    wrench[:, direction] = np.repeat(levels, 500)
    rows = pushed(okuma, gk.PID(bandwidth=6.0), gk.DisturbanceObserver(bandwidth=5.0), wrench, plant=true)
    ends = np.arange(1, len(levels) + 1) * 500 - 1
    error = np.abs(rows["wrench_hat"] - wrench)[ends, direction]
    bound = 90.0 * np.abs(okuma.jacobian(okuma.home)[:, direction]).sum()
    assert error.max() <= bound + 15  # 15 N: three times what 1 um of encoder makes at 5 Hz
    assert error.max() > 20, "the screws do hide something"


def test_an_observer_changes_nothing_of_the_run(okuma):
    circle, law = gk.Circle(radius=0.02, feed=0.05), gk.PID(bandwidth=10.0)
    alone = gk.simulate(okuma, law, circle)
    beside = gk.simulate(okuma, law, circle, observer=gk.DisturbanceObserver())
    for name in alone:
        assert_array_equal(alone[name], beside[name])
    assert set(beside) - set(alone) == {"wrench_hat", "observer.hidden", "observer.held"}


def test_a_batch_gives_each_run_its_own_estimate(okuma):
    circle, law = gk.Circle(radius=0.02, feed=0.05), gk.PID(bandwidth=10.0)
    plants = [Plant(machine=okuma), Plant(machine=okuma, wrench=[500.0, 0, 0, 0, 0, 0])]
    many = gk.simulate(okuma, law, circle, plants, observer=gk.DisturbanceObserver())
    one = gk.simulate(okuma, law, circle, plants[1], observer=gk.DisturbanceObserver())
    assert many["wrench_hat"].shape == (len(many), 2, 6)
    # lanes round otherwise; a count of the encoder more or less is 1 um / 1 ms, some newtons
    assert np.median(np.abs(many["wrench_hat"][:, 1] - one["wrench_hat"])) < 1
    assert many["wrench_hat"][500:, 1, 0].mean() == pytest.approx(500, abs=30)


# -- what is no force ---------------------------------------------------------------------------------------------


def test_a_saturated_drive_is_not_read_as_force(okuma):
    """Drives of 8 N m cannot hold the machine: it sags, its integrals wind up, and no force is on the tool."""
    weak = okuma.replace(**{"drive.torque_limit": 4.0})
    fast = gk.Circle(radius=0.05, feed=0.5)
    log = gk.simulate(weak, gk.PID(bandwidth=8.0), fast, observer=gk.DisturbanceObserver(bandwidth=50.0))
    clipped = log["saturated"].any(-1)
    assert clipped.sum() > 20
    held = log["observer.held"] > 0
    assert held[1:][clipped[:-1]].all(), "a sample is held when a drive was at its limit in the sample before"
    lost = np.abs(log["u_c"] - log["u"])[clipped].max()
    assert np.abs(log["wrench_hat"][:, :3]).max() < 0.5 * lost


@pytest.mark.parametrize("kind", ["dropout", "glitch"])
def test_a_missing_or_impossible_reading_is_not_read_as_force(okuma, kind):
    """A reading of 0 m, or one 5 mm off, for three samples: the estimate is held until the pose is known again.

    On a recorded log, so that the law does not see it.
    """
    observer = gk.DisturbanceObserver()
    log = gk.simulate(okuma, gk.PID(bandwidth=10.0), gk.Circle(radius=0.02, feed=0.05))
    readings = log["q_m"].copy()
    readings[800:803, 2] = 0.0 if kind == "dropout" else readings[800:803, 2] + 5e-3
    clean, hurt = (
        Recorder(observer.on(okuma, PERIOD), log["x_r"][0]).rows(q, log["u"]) for q in (log["q_m"], readings)
    )
    assert hurt["held"][800:806].all() and not hurt["held"][812:].any()
    peaks = [np.abs(one["wrench_hat"][700:900, :3]).max() for one in (hurt, clean)]
    assert peaks[0] < 2 * peaks[1], "no more than its noise, from a held value and from now on"


def test_samples_that_are_not_there_are_held(okuma):
    log = gk.simulate(okuma, gk.PID(bandwidth=10.0), gk.Circle(radius=0.02, feed=0.05))
    q, good = log["q_m"].copy(), np.ones(len(log), bool)
    q[500:520], good[500:520] = np.nan, False
    found = Recorder(gk.DisturbanceObserver().on(okuma, PERIOD), log["x_r"][0]).rows(q, log["u"], good)
    assert found["held"][500:522].all()
    assert_array_equal(found["wrench_hat"][500:522], np.tile(found["wrench_hat"][499], (22, 1)))
    assert np.isfinite(found["wrench_hat"]).all()


def test_recorded_rows_give_the_bits_of_the_run(okuma):
    """The same step, in the tick and on the log's readings and forces of the sample before."""
    circle, observer = gk.Circle(radius=0.02, feed=0.05), gk.DisturbanceObserver()
    log = gk.simulate(okuma, gk.PID(bandwidth=10.0), circle, observer=observer)
    u_before = np.concatenate([log["u"][:1], log["u"][:-1]])
    found = Recorder(observer.on(okuma, PERIOD), log["x_r"][0]).rows(log["q_m"], u_before)
    # the run's first force is the one that held it at rest, not that of its first sample
    assert_allclose(found["wrench_hat"][50:], log["wrench_hat"][50:], rtol=0, atol=1e-3)


# -- what cannot be -----------------------------------------------------------------------------------------------


def test_a_base_torque_is_for_machines_of_struts(okuma):
    glide = gk.load_machine("eth-hexaglide")
    with pytest.raises(ExperimentError, match="only a machine of struts has base joints with a torque"):
        gk.DisturbanceObserver(base_torque=8.0).on(glide, PERIOD)
    with pytest.raises(ExperimentError, match="must be one value or six"):
        gk.DisturbanceObserver(base_torque=[8.0, 9.0]).on(okuma, PERIOD)


def test_an_observer_that_is_none_is_refused_by_name(okuma):
    with pytest.raises(InputError, match=r"must be a Observer.*gk.DisturbanceObserver"):
        gk.simulate(okuma, gk.PID(bandwidth=10.0), gk.Circle(radius=0.02, feed=0.05), observer="disturbance")


def test_an_observers_period_is_a_multiple_of_the_samples(okuma):
    with pytest.raises(InputError, match="multiple of the base tick"):
        gk.simulate(
            okuma, gk.PID(bandwidth=10.0), gk.Circle(radius=0.02, feed=0.05),
            observer=gk.DisturbanceObserver(period=1.5e-3),
        )  # fmt: skip
