"""RELIABILITY S8, S9: encoders that fail, and the following-error trip that ends a run."""

from __future__ import annotations

import numpy as np
import pytest

import gough as gk
from gough.errors import ExperimentError, FollowingError
from gough.simulate.faults import EncoderFault
from gough.simulate.plant import Plant

# a law that reads nonsense asks for all the drives have: what these tests are not about
pytestmark = pytest.mark.filterwarnings("ignore::gough.simulate.notes.EffortWarning")

CIRCLE = gk.Circle(radius=0.02, feed=0.05, settle=0.1)
SPEED = 0.3
FERROR, LEAST = 1e-3, 2e-4


@pytest.fixture(scope="module")
def nist():
    """Fine enough an encoder that its rounding hides nothing here, and a limit of the joints' speed."""
    return gk.load_machine("nist-octahedral").replace(**{"drive.encoder": 1e-9, "limits.speed": SPEED})


def plant(machine, *faults, **more):
    return Plant(machine=machine, faults=[EncoderFault(**fault) for fault in faults], **more)


def run(nist, *faults, law=None, **options):
    return gk.simulate(nist, law or gk.PID(bandwidth=8.0), CIRCLE, plant=plant(nist, *faults), **options)


def test_a_glitch_adds_its_size_to_one_joint_for_its_time_only(nist):
    log = run(nist, {"kind": "glitch", "joint": 3, "start": 0.5, "duration": 0.002, "size": 1e-5})
    off = log["q_m"] - log["q"]
    hit = np.zeros_like(off)
    hit[[500, 501], 2] = 1e-5
    np.testing.assert_allclose(off, hit, rtol=0, atol=0.5e-9 * (1 + 1e-6))  # half a count
    clean = gk.simulate(nist, gk.PID(bandwidth=8.0), CIRCLE)
    np.testing.assert_array_equal(log["q"][:501], clean["q"][:501])
    assert np.abs(log["q"][502:600] - clean["q"][502:600]).max() > 1e-8, "the law acts on what it reads"


def test_a_glitch_to_the_end_is_an_offset_the_tool_follows(nist):
    """Lost counts: the joint ends where the reading is right and the machine is wrong by the size."""
    log = run(nist, {"kind": "glitch", "joint": 1, "start": 0.2, "size": 2e-5})
    assert (np.abs((log["q_m"] - log["q"])[200:, 0] - 2e-5) < 1e-9).all()
    # the integral of a loop of 8 Hz has had two seconds; friction leaves some um of either sign
    assert log["q"][-1, 0] - log["q_r"][-1, 0] == pytest.approx(-2e-5, abs=5e-6)


def test_a_stuck_encoder_reads_the_sample_before_until_it_is_free_again(nist):
    log = run(nist, {"kind": "stuck", "joint": 2, "start": 0.4, "duration": 0.005})
    held = log["q_m"][399, 1]
    assert (log["q_m"][400:405, 1] == held).all()
    assert np.abs((log["q_m"] - log["q"])[405:, 1]).max() < 1e-9
    others = [0, 2, 3, 4, 5]
    assert np.abs((log["q_m"] - log["q"])[:, others]).max() < 1e-9


def test_a_stuck_encoder_from_the_first_sample_reads_that(nist):
    log = run(nist, {"kind": "stuck", "joint": 2, "start": 0.0, "duration": 0.003})
    assert (log["q_m"][:3, 1] == log["q_m"][0, 1]).all() and abs(log["q_m"][0, 1] - log["q"][0, 1]) < 1e-9


def test_a_fault_shorter_than_a_sample_lasts_for_one(nist):
    """What begins between two samples is seen at the next one, whatever its length."""
    log = run(nist, {"kind": "dropout", "joint": 6, "start": 0.2995, "duration": 1e-4})
    assert (log["q_m"][:, 5] == 0).nonzero()[0].tolist() == [300]


def test_a_dropout_reads_zero(nist):
    log = run(nist, {"kind": "dropout", "joint": 6, "start": 0.3, "duration": 0.001})
    assert log["q_m"][300, 5] == 0 and (log["q_m"][:300, 5] > 1).all()


def test_faults_act_one_after_the_other(nist):
    log = run(
        nist,
        {"kind": "glitch", "joint": 1, "start": 0.5, "duration": 0.003, "size": 1e-5},
        {"kind": "glitch", "joint": 1, "start": 0.501, "duration": 0.003, "size": 3e-5},
    )
    off = (log["q_m"] - log["q"])[499:505, 0]
    np.testing.assert_allclose(off, np.array([0, 1, 4, 4, 3, 0]) * 1e-5, rtol=0, atol=1e-9)


def test_a_batch_takes_runs_with_and_without_faults(nist):
    glitch = {"kind": "glitch", "joint": 3, "start": 0.5, "duration": 0.002, "size": 1e-5}
    runs = gk.simulate(nist, gk.PID(bandwidth=8.0), CIRCLE, plant=[nist, plant(nist, glitch)], lanes=1)
    alone = run(nist, glitch)
    np.testing.assert_array_equal(runs.run(1)["q_m"], alone["q_m"])
    np.testing.assert_array_equal(runs.run(0)["x"], gk.simulate(nist, gk.PID(bandwidth=8.0), CIRCLE)["x"])


# -- the trip ---------------------------------------------------------------------------------------------------------


def test_the_run_ends_at_the_first_sample_beyond_linuxcncs_limit(nist):
    """max(FERROR |v| / v_max, MIN_FERROR), computed here from the log of a run without a trip."""
    stuck = {"kind": "stuck", "joint": 4, "start": 0.5}
    free = run(nist, stuck)
    motion = CIRCLE.plan(nist)
    reference = motion.sample(0, len(free), 1e-3)
    allowed = np.maximum(FERROR * np.abs(reference.qd) / SPEED, LEAST)
    beyond = (np.abs(reference.q[: len(free)] - free["q_m"]) > allowed).any(1)
    first = int(np.argmax(beyond))
    assert beyond.any() and first > 500
    tripped = run(nist, stuck, ferror=FERROR, min_ferror=LEAST)
    assert tripped.failed and len(tripped) == first  # its rows are those before
    joint = int(np.argmax(np.abs(reference.q[first] - free["q_m"][first]) - allowed[first]))
    error = abs(reference.q[first, joint] - free["q_m"][first, joint])
    assert tripped.reason == (
        f"NC line 1: strut {joint + 1}: following error, the drives are off, got {error * 1e3:.6g} mm "
        f"(limit {allowed[first, joint] * 1e3:.6g} mm) at t = {first * 1e-3:.6g} s; look for what holds or moves the "
        "joint or its encoder, lower the feed, or allow a larger ferror"
    ).replace("NC line 1: ", "" if not motion.book(first, first + 1, 1e-3).line[0] else "NC line 1: ")
    np.testing.assert_array_equal(tripped["x"], free["x"][:first])


def test_a_trip_is_told_once_and_by_its_name(nist):
    with pytest.raises(FollowingError) as caught:
        run(nist, {"kind": "dropout", "joint": 5, "start": 0.3}, ferror=FERROR, on_fail="raise")
    assert len(caught.value.problems) == 1 and "strut 5: following error" in str(caught.value)
    assert len(caught.value.log) == 300, "the sample of the fault itself trips"
    assert caught.value.exit_status == 1


@pytest.mark.parametrize("kind", ["stuck", "dropout", "glitch"])
def test_every_fault_beyond_the_limit_trips(nist, kind):
    """A dropout and a glitch of more than the limit at once; a stuck joint as soon as its reference is that far on."""
    fault = {"kind": kind, "joint": 2, "start": 0.6} | ({"size": 2e-3} if kind == "glitch" else {})
    log = run(nist, fault, ferror=FERROR)
    assert log.failed and "strut 2: following error" in log.reason
    assert len(log) == 600 if kind != "stuck" else 600 < len(log) < 2000


def test_a_sound_machine_does_not_trip_and_is_not_changed_by_the_trip(nist):
    with_trip = gk.simulate(nist, gk.PID(bandwidth=8.0), CIRCLE, ferror=FERROR, min_ferror=LEAST)
    assert with_trip.status == "done"
    np.testing.assert_array_equal(with_trip["x"], gk.simulate(nist, gk.PID(bandwidth=8.0), CIRCLE)["x"])


def test_in_a_batch_only_the_faulty_run_trips(nist):
    plants = [nist, plant(nist, {"kind": "dropout", "joint": 1, "start": 0.3}), nist]
    runs = gk.simulate(nist, gk.PID(bandwidth=8.0), CIRCLE, plant=plants, ferror=FERROR)
    assert runs["failed"].tolist() == [0, 1, 0] and "following error" in runs.runs[1]["reason"]
    assert len(runs.run(1)) == 300 and len(runs.run(2)) == len(runs)


@pytest.mark.full
def test_a_slower_law_is_watched_every_sample(nist):
    log = run(nist, {"kind": "dropout", "joint": 5, "start": 0.3}, law=gk.PID(bandwidth=6.0, period=2e-3), ferror=1e-3)
    assert log.failed and len(log) == 300


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"min_ferror": 1e-3}, r"^run.min_ferror: min_ferror needs ferror, .* got 0.001 m"),
        ({"ferror": 1e-3, "min_ferror": 2e-3}, r"^run.min_ferror: .* must not be above ferror, got 0.002 m"),
        ({"ferror": 0.0}, r"ferror: must be above 0 m"),
    ],
)
def test_limits_that_make_no_sense_are_refused(nist, options, message):
    with pytest.raises(ExperimentError, match=message):
        gk.simulate(nist, gk.PID(bandwidth=8.0), CIRCLE, **options)


@pytest.mark.full
def test_both_limits_need_the_machines_greatest_speed(nist):
    slow = nist.replace(**{"limits.speed": None})
    with pytest.raises(ExperimentError, match=r"^run.min_ferror: .* needs the machine's limits.speed; write speed"):
        gk.simulate(slow, gk.PID(bandwidth=8.0), CIRCLE, ferror=1e-3, min_ferror=1e-4)


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ({"kind": "stuck", "joint": 0, "start": 0.0}, "joint"),
        ({"kind": "late", "joint": 1, "start": 0.0}, "kind"),
        ({"kind": "stuck", "joint": 1, "start": -1.0}, "start"),
        ({"kind": "glitch", "joint": 1, "start": 0.0}, r"size: a glitch needs a size; write e.g. size = \"0.1 mm\""),
        ({"kind": "stuck", "joint": 1, "start": 0.0, "size": 1.0}, "size: stuck has no size; leave it out"),
        ({"kind": "stuck", "joint": 1, "start": float("nan")}, "start"),
    ],
)
def test_faults_that_make_no_sense_are_refused(fault, message):
    with pytest.raises(ExperimentError, match=message):
        EncoderFault(**fault)


def test_a_fault_of_a_joint_the_machine_has_not_is_refused(nist):
    with pytest.raises(ExperimentError, match=r"^plant.faults.0.joint: .* no such joint, got 7 \(limit 6\)"):
        run(nist, {"kind": "stuck", "joint": 7, "start": 0.0})
    with pytest.raises(ExperimentError, match=r"^plant.1.faults.0.joint"):
        bad = plant(nist, {"kind": "stuck", "joint": 7, "start": 0.0})
        gk.simulate(nist, gk.PID(bandwidth=8.0), CIRCLE, plant=[nist, bad])


def test_faults_are_read_from_files_and_written_back(nist):
    made = plant(
        nist, {"kind": "glitch", "joint": 1, "start": 0.5, "size": 1e-4}, {"kind": "stuck", "joint": 2, "start": 1.0}
    )
    table = made.to_file()
    assert table["faults"][0] == {"kind": "glitch", "joint": 1, "start": "0.5 s", "size": "0.0001 m"}
    assert Plant.from_file({**table, "machine": nist}) == made
    assert "faults" not in Plant(machine=nist).to_file()
