"""Monitoring: forces, events and flags in logs whose truth is known."""

from __future__ import annotations

import json
import threading
import time

import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from gough.errors import LogError
from gough.monitor.events import Events
from gough.monitor.thin import Thin
from gough.observe.disturbance import DisturbanceObserver
from outside.conftest import MAP, circle, csv_text

PERIOD = 1e-3


@pytest.fixture(scope="module")
def okuma():
    return gk.load_machine("okuma-pm600")


@pytest.fixture(scope="module")
def ideal(okuma):
    """Without friction, so that the forces of inverse dynamics are the truth."""
    return okuma.frictionless()


def cut(n, rise=0.05, level=800.0, start=1.0, end=2.0):
    """A cutting force along x that comes within `rise` s and goes at once."""
    t = np.arange(n) * PERIOD
    f = np.zeros((n, 6))
    f[:, 0] = level * np.clip((t - start) / rise, 0, 1) * (t < end)
    return f


def as_log(machine, truth):
    """A Log of known readings and forces; rounded readings, as an encoder gives them."""
    from gough.log.build import LogBuilder

    builder = LogBuilder(truth.t, machine.task, machine.joints_count)
    grain = machine.drive.encoder
    builder.add("q_m", np.round(truth.q / grain) * grain)
    builder.add("u", truth.u)
    return builder.build({})


@pytest.fixture(scope="module")
def cutting(ideal):
    """4 s of a circle, cutting from 1 s to 2 s."""
    return as_log(ideal, circle(ideal, 4000, 0.05, 1.0, cut(4000)))


@pytest.mark.full
def test_the_force_over_time_is_the_one_that_acted(ideal, cutting):
    watch = gk.monitor(cutting, ideal)
    t, hat = watch.rows["t"], watch.rows["wrench_hat"]
    steady = (t > 1.2) & (t < 2.0)
    noise = watch.noise
    assert_allclose(hat[steady].mean(0), [800, 0, 0, 0, 0, 0], rtol=0, atol=0.5 * noise.max())
    # as noisy as the encoders' steps say: (2) of levels.py; half as much again: steps are no random numbers
    assert (hat[steady].std(0) < 1.5 * noise).all()
    assert (hat[steady].std(0) > 0.5 * noise).all()
    assert watch.sums.peak == pytest.approx(800, abs=6 * noise[:3].max())


def test_an_alarm_lasts_as_long_as_the_force(ideal, cutting):
    watch = gk.monitor(cutting, ideal, alarm=500.0)
    (alarm,) = watch.of("alarm")
    assert alarm.start == pytest.approx(1.05, abs=0.03)
    assert alarm.end == pytest.approx(2.0, abs=0.03)
    assert alarm.peak == pytest.approx(800, abs=120)


def test_a_force_that_goes_while_the_feed_goes_on_is_told_as_breakage(ideal, cutting):
    watch = gk.monitor(cutting, ideal, breakage=400.0)
    (broken,) = watch.of("breakage")
    assert 2.0 < broken.start < 2.03
    assert broken.before == pytest.approx(800, abs=60)


def test_a_force_that_goes_because_the_machine_stops_is_none(ideal):
    n = 4000
    truth = circle(ideal, n, 0.05, 1.0, cut(n))
    stopped = circle(ideal, n, 0.05, 0.0)
    half = 2000
    q = np.concatenate([truth.q[:half], np.repeat(truth.q[half : half + 1], n - half, 0)])
    u = np.concatenate(
        [truth.u[:half], ideal.inverse_dynamics(_pose(ideal, half), np.zeros(6), np.zeros(6))[None].repeat(n - half, 0)]
    )
    watch = gk.monitor(as_log(ideal, stopped._replace(q=q, u=u)), ideal, breakage=400.0)
    assert watch.of("breakage") == []


def _pose(machine, k):
    angle = k * PERIOD
    return machine.home + 0.05 * np.array([np.cos(angle), np.sin(angle), 0, 0, 0, 0])


def test_a_blow_is_a_collision_within_10_ms_and_a_cut_is_none(ideal):
    n = 3000
    force = cut(n, rise=0.1, level=600.0, start=0.5, end=10.0)
    force[2000:2200, 2] += 3000.0
    watch = gk.monitor(as_log(ideal, circle(ideal, n, 0.05, 1.0, force)), ideal, collision=700.0, breakage=1e6)
    (blow,) = watch.of("collision")
    assert 0 < blow.start - 2.0 <= 0.010, "and its end is no other one"
    assert blow.end == pytest.approx(2.2, abs=0.03)
    assert blow.peak == pytest.approx(3000, abs=150)


def test_a_record_that_begins_under_a_load_does_not_begin_with_a_collision(ideal):
    n = 2000
    force = np.zeros((n, 6))
    force[:, 0], force[1000:, 2] = 2000.0, 3000.0
    watch = gk.monitor(as_log(ideal, circle(ideal, n, 0.05, 1.0, force)), ideal, collision=700.0, alarm=1000.0)
    (blow,) = watch.of("collision")
    assert 0 < blow.start - 1.0 <= 0.010
    (alarm,) = watch.of("alarm")
    assert alarm.start == pytest.approx(0.043, abs=0.002), "from the first sample that is looked at"


@pytest.mark.full
@pytest.mark.parametrize("name", ["okuma-pm600", "eth-hexaglide"])
def test_a_sound_machine_in_air_gives_no_event(name):
    """Reversals of joints, friction at rest and encoders stay below the machine's own level."""
    machine = gk.load_machine(name)
    log = gk.simulate(machine, gk.PID(bandwidth=8.0), gk.Circle(radius=0.05, feed=0.05))
    watch = gk.monitor(log, machine)
    assert watch.counts == {"alarm": 0, "collision": 0, "breakage": 0}
    assert watch.thresholds["collision"] > 100


def test_held_samples_are_no_part_of_the_numbers(ideal):
    truth = circle(ideal, 2000, 0.05, 1.0)
    log = as_log(ideal, truth)
    q = log["q_m"].copy()
    q[1000:1010, 2] = 0.0
    builder = as_log(ideal, truth._replace(q=q))
    watch = gk.monitor(builder, ideal)
    assert watch.sums.held >= 10 + 3
    assert watch.sums.peak < 6 * np.linalg.norm(watch.noise[:3])
    assert watch.counts == {"alarm": 0, "collision": 0, "breakage": 0}


def test_a_file_gives_what_the_log_gives(tmp_path, ideal, cutting):
    cutting.to_csv(tmp_path / "log.csv")
    one, other = gk.monitor(cutting, ideal), gk.monitor(tmp_path / "log.csv", ideal)
    assert_allclose(one.rows["wrench_hat"], other.rows["wrench_hat"], rtol=0, atol=1e-9)


def test_chunks_do_not_matter(ideal, cutting, monkeypatch):
    whole = gk.monitor(cutting, ideal, alarm=500.0)
    monkeypatch.setattr("gough.monitor.run.STEP", 97)
    pieces = gk.monitor(cutting, ideal, alarm=500.0)
    assert_allclose(whole.rows["wrench_hat"], pieces.rows["wrench_hat"], rtol=0, atol=0)
    assert [(e.kind, e.start, e.end) for e in whole.events] == [(e.kind, e.start, e.end) for e in pieces.events]
    for one, other in zip(whole.events, pieces.events, strict=True):  # a mean is summed in another order
        assert_allclose([one.peak, *one.force], [other.peak, *other.force], rtol=1e-12)
    assert json.dumps(whole.to_json()["peak"]) == json.dumps(pieces.to_json()["peak"])


def test_a_log_for_another_number_of_joints_is_refused(okuma):
    from gough.log.build import LogBuilder

    builder = LogBuilder(np.arange(3) * 1e-3, okuma.task, 3)
    builder.add("q_m", np.ones((3, 3)))
    builder.add("u", np.ones((3, 3)))
    with pytest.raises(LogError, match="okuma-pm600 has 6 joints, got 3"):
        gk.monitor(builder.build({}), okuma)


# -- parts --------------------------------------------------------------------------------------------------------


def test_thinned_rows_keep_every_peak():
    rng = np.random.default_rng(0)
    size = rng.random(10_000)
    size[[17, 4242, 9999]] = 7, 8, 9
    thin = Thin(most=500)
    for part in np.array_split(np.arange(10_000), 37):
        thin.take({"size": size[part], "row": part})
    kept = thin.rows()
    assert len(kept["row"]) <= 501
    assert {17, 4242, 9999} <= set(kept["row"].tolist())
    assert (np.diff(kept["row"]) > 0).all(), "in order"


def test_an_alarm_that_flickers_is_one():
    events = Events(PERIOD, 100.0, None, None)
    t = np.arange(1000) * PERIOD
    f = np.zeros((1000, 3))
    f[200:600, 0] = 100 + 40 * np.sin(np.arange(400) / 5)
    f[900:950, 1] = 150
    for part in np.array_split(np.arange(1000), 7):
        events.look(t[part], f[part], np.ones(len(part)))
    events.finish()
    assert [(e.start, e.end) for e in events.found] == [
        (pytest.approx(0.2, abs=0.01), pytest.approx(0.6, abs=0.02)),
        (pytest.approx(0.9), pytest.approx(0.949)),
    ]
    assert events.counts["alarm"] == 2


def test_a_blow_on_top_of_a_blow_is_another_one():
    events = Events(PERIOD, None, 100.0, None)
    f = np.zeros((2000, 3))
    f[500:1500, 0] = 200
    f[1000:1200, 2] = -300
    t = np.arange(2000) * PERIOD
    for part in np.array_split(np.arange(2000), 13):
        events.look(t[part], f[part], np.ones(len(part)))
    events.finish()
    assert [event.start for event in events.found] == [pytest.approx(0.5), pytest.approx(1.0)]
    assert events.found[1].end == pytest.approx(1.499), "back at what was before the first"


def test_a_jump_back_that_hangs_at_the_threshold_is_no_other_collision():
    """Found on a pulse of 176 N: a row of the jump back was below the threshold, the next one above it again."""
    events = Events(PERIOD, None, 100.0, None)
    f = np.zeros((1000, 3))
    f[300:500, 0] = 800
    f[500:, 0] = 45 * np.exp(-np.arange(500) / 100)  # back within half of 100 at once
    f[509:511, 0] = 760.0 - 700  # 10 ms before it was 800: calm in between, by noise
    t = np.arange(1000) * PERIOD
    for part in np.array_split(np.arange(1000), 9):
        events.look(t[part], f[part], np.ones(len(part)))
    assert [event.start for event in events.found] == [pytest.approx(0.3)]


def test_a_blow_that_does_not_come_quite_back_ends_and_is_no_breakage():
    """Found on a pulse of 176 N at a reversal, where friction had feigned 16 N before it: never back to within 11 N."""
    events = Events(PERIOD, None, 22.0, 22.0)
    f = np.zeros((1000, 3))
    f[280:310, 0], f[310:600, 0] = 16.0, -176.0
    t = np.arange(1000) * PERIOD
    for part in np.array_split(np.arange(1000), 9):
        events.look(t[part], f[part], np.ones(len(part)))
    assert [(e.kind, e.start, e.end) for e in events.found] == [
        ("collision", pytest.approx(0.310), pytest.approx(0.599)),
    ]


def test_a_blow_while_the_last_one_settles_is_another_one():
    events = Events(PERIOD, None, 100.0, None)
    f = np.zeros((1000, 3))
    f[300:500, 0] = 800
    f[504:700, 1] = 300
    t = np.arange(1000) * PERIOD
    for part in np.array_split(np.arange(1000), 9):
        events.look(t[part], f[part], np.ones(len(part)))
    assert [event.start for event in events.found] == [pytest.approx(0.3), pytest.approx(0.504)]
    assert events.found[1].end == pytest.approx(0.699)


# -- the command --------------------------------------------------------------------------------------------------


@pytest.fixture
def files(tmp_path, ideal, cutting):
    """A CSV in a foreign dress, and its map."""
    grain = ideal.drive.encoder
    table = np.column_stack([cutting.t, np.round(cutting["q_m"] / grain) * grain * 1e3, cutting["u"]])
    (tmp_path / "log.csv").write_text(csv_text(table))
    (tmp_path / "map.toml").write_text(MAP)
    return tmp_path


@pytest.mark.full
def test_the_command_says_peaks_and_events_and_writes_them(gough, files):
    done = gough("monitor", files / "log.csv", "-m", "okuma-pm600", "--map", files / "map.toml", "--alarm", "2 kN")
    assert done.status == 0
    assert "<Watch> okuma-pm600: 4000 samples, 3.998 s at 1000 Hz" in done.out
    assert "alarms      0, at 2 kN" in done.out
    assert "figure: results/log-force/force.png" in done.out
    folder = files / "results" / "log-force"
    assert {"force.nc", "force.png", "monitor.json"} <= {path.name for path in folder.iterdir()}
    kept = gk.Log.load(folder / "force.nc")
    assert kept["wrench_hat"].shape == (len(kept), 6)
    assert json.loads((folder / "monitor.json").read_text())["samples"] == 4000


def test_its_json_has_numbers_events_and_findings(gough, files):
    done = gough(
        "monitor", files / "log.csv", "-m", "okuma-pm600", "--map", files / "map.toml", "--json", "--alarm", "100 N"
    )
    data = done.json
    assert (data["schema"], data["status"], data["error"]) == ("gough-monitor-1", "done", None)
    assert set(data["components"]) == {"fx", "fy", "fz", "mx", "my", "mz"}
    assert data["thresholds"]["alarm"] == 100
    assert data["counts"]["alarm"] == len([e for e in data["events"] if e["kind"] == "alarm"])
    assert data["period"] == 1e-3 and data["findings"] == []


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ([], "--machine: is missing; say which machine"),
        (["-m", "okuma"], "no machine of the library has this name"),
        (["-m", "okuma-pm600", "--alarm", "500"], "--alarm: '500' has no unit; write e.g. \"500 N\""),
        (["-m", "okuma-pm600", "--alarm", "0 N"], "--alarm: must be above 0 N"),
        (["-m", "okuma-pm600", "--form", "magic"], "--form: there is momentum and static, got 'magic'"),
        (["-m", "okuma-pm600", "--map", "none.toml"], "none.toml: no such file"),
        (["-m", "okuma-pm600"], "nobody says what its columns are"),
    ],
)
def test_what_is_wrong_ends_with_status_2_and_a_line(gough, files, options, message):
    done = gough("monitor", files / "log.csv", *options)
    assert done.status == 2
    assert message in done.err
    assert not (files / "results" / "log-force").exists()


@pytest.mark.full
def test_a_file_that_is_still_written_is_followed_to_its_end(gough, files):
    text = (files / "log.csv").read_text()
    grown = files / "grown.csv"
    half = text[: len(text) // 2]
    grown.write_text(half)

    def write():
        time.sleep(0.3)
        with grown.open("a") as file:
            for start in range(len(half), len(text), 100_000):
                file.write(text[start : start + 100_000])
                file.flush()
                time.sleep(0.02)

    writer = threading.Thread(target=write)
    writer.start()
    done = gough(
        "monitor", grown, "-m", "okuma-pm600", "--map", files / "map.toml", "--follow", "--until", "1 s",
        "--alarm", "400 N",
    )  # fmt: skip
    writer.join()
    assert done.status == 0
    assert "4000 samples" in done.out
    assert done.out.startswith("alarm  t = "), "told when it was found, before the table"


def test_only_text_can_be_followed(gough, files, cutting):
    cutting.save(files / "log.nc")
    done = gough("monitor", files / "log.nc", "-m", "okuma-pm600", "--follow")
    assert done.status == 2
    assert "only a text file can be followed while it is written" in done.err


def test_the_figure_shows_every_peak(cutting, ideal):
    from gough.monitor.figure import _envelope, draw

    t = np.arange(100_000) * 1e-3
    y = np.zeros(100_000)
    y[77_777] = 5.0
    at, both = _envelope(t, y)
    assert both.max() == 5.0 and len(at) < 10_000
    ax = draw(gk.monitor(cutting, ideal, observer=DisturbanceObserver(bandwidth=10.0)))
    assert [line.get_label() for line in ax.lines[:3]] == ["fx", "fy", "fz"]
