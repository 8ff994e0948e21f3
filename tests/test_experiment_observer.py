"""The [observer] table: checked with its line, part of the run, in its log, on its page and in what repeats it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view

import gough as gk
from gough.errors import ExperimentError
from gough.experiment import load_experiment
from gough.experiment.resolve import resolved
from gough.monitor.levels import noise_level
from sample_files import EXPERIMENT

TABLE = '[observer]\nkind = "disturbance"\nbandwidth = "10 Hz"\n\n[run]'
LINE = 20  # of the table's own first key


def test_the_observer_is_what_the_table_says(write):
    found = load_experiment(write("f.toml", EXPERIMENT, {"[run]": TABLE})).observer
    assert found == gk.DisturbanceObserver(bandwidth=10.0)
    assert load_experiment(write("g.toml", EXPERIMENT)).observer is None


@pytest.mark.parametrize(
    ("table", "line", "told"),
    [
        ('kind = "disturbence"', LINE, "kind: no such observer, got 'disturbence'; did you mean disturbance?"),
        ("kind = 3", LINE, "kind: no such observer, got 3; one of disturbance"),
        ('bandwidth = "3 Hz"', LINE - 1, "kind: is missing; one of disturbance"),
        ('kind = "disturbance"\nbandwith = "3 Hz"', LINE + 1, "bandwith: no such key; did you mean bandwidth?"),
        ('kind = "disturbance"\nbandwidth = "0 Hz"', LINE + 1, "bandwidth: must be above 0 Hz, got '0 Hz'"),
        ('kind = "disturbance"\nbandwidth = "3 N"', LINE + 1, "bandwidth: '3 N' is not a quantity in Hz"),
        ('kind = "disturbance"\nform = "magic"', LINE + 1, "form: "),
        ('kind = "disturbance"\nmachine = {}', LINE + 1, "machine: no such key; an observer believes the machine"),
        (
            'kind = "disturbance"\nperiod = "1.5 ms"', LINE + 1,
            "period: must be a multiple of run.period, got 0.0015 s (limit 0.001 s); leave it out: then it is run.per",
        ),
        (
            'kind = "disturbance"\nbase_torque = { unit = "N m", value = [1, 2] }', LINE + 1,
            "base_torque: must be one value or six, got 2",
        ),
    ],
)  # fmt: skip
def test_what_is_wrong_in_the_table_is_said_with_its_line(write, table, line, told):
    path = write("f.toml", EXPERIMENT, {"[run]": f"[observer]\n{table}\n\n[run]"})
    with pytest.raises(ExperimentError) as caught:
        load_experiment(path)
    (message,) = str(caught.value).splitlines()
    assert message.startswith(f"{path}:{line}: observer.{told}")


def test_a_torque_of_base_joints_needs_a_machine_that_has_them(write):
    table = '[observer]\nkind = "disturbance"\nbase_torque = "8 N m"\n\n[run]'
    path = write("f.toml", EXPERIMENT, {"[run]": table, "nist-octahedral": "eth-hexaglide"})
    with pytest.raises(ExperimentError, match="observer.base_torque: only a machine of struts has base joints"):
        load_experiment(path)


@pytest.mark.parametrize("name", ["wrench_hat", "observer.hidden", "observer.held"])
def test_a_variable_that_only_an_observer_finds_is_refused_without_one(write, name):
    asked = {'period = "1 ms"': f'period = "1 ms"\nsignals = ["x", "{name}"]'}
    with pytest.raises(ExperimentError) as caught:
        load_experiment(write("f.toml", EXPERIMENT, asked))
    told = f"run.signals.1: only an observer finds this variable, got '{name}'; write [observer] and kind = "
    assert told in str(caught.value)
    assert load_experiment(write("g.toml", EXPERIMENT, asked | {"[run]": TABLE})).run.signals == ["x", name]


def test_a_law_with_an_observer_of_its_own_keeps_its_variables(write):
    asked = {'period = "1 ms"': 'period = "1 ms"\nsignals = ["observer.pose"]'}
    assert load_experiment(write("f.toml", EXPERIMENT, asked)).run.signals == ["observer.pose"]


def test_the_resolved_file_has_the_table_with_nothing_left_open(write, tmp_path):
    files = resolved(load_experiment(write("f.toml", EXPERIMENT, {"[run]": TABLE})))
    assert '[observer]\nkind = "disturbance"\nbandwidth = "10.0 Hz"\nform = "momentum"\n' in files["experiment.toml"]
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    again = load_experiment(tmp_path / "experiment.toml")
    assert again.observer == gk.DisturbanceObserver(bandwidth=10.0)


def bound():
    """The observer of TABLE on the machine of EXPERIMENT."""
    return gk.DisturbanceObserver(bandwidth=10.0).on(gk.load_machine("nist-octahedral"), 1e-3)


@pytest.mark.full
def test_every_log_of_the_file_has_the_force_that_acts_and_the_page_shows_it(gough, write):
    """300 N on a machine whose friction is known, low-passed at 10 Hz: within what hides at the circle's reversals."""
    force = 'wrench = ["300 N", "0 N", "-200 N", "0 N m", "0 N m", "0 N m"]'
    changes = {"[run]": TABLE, "[program]": f"[plant]\n{force}\n\n[program]", "20 mm": "10 mm"}
    write("f.toml", EXPERIMENT, changes)
    done = gough("run", "f.toml")
    assert done.status == 0
    for kind in ("pid", "computed_torque"):
        log = gk.Log.load(f"results/f/{kind}.nc")
        noise = noise_level(bound(), log["x"][0])[:3]  # of the encoders' steps alone
        # the low pass remembers for three of its time constants, 48 ms, what friction hid
        hidden = sliding_window_view(log["observer.hidden"][:, :3], 48, axis=0).max(-1)
        off = np.abs(log["wrench_hat"] - [300, 0, -200, 0, 0, 0])[47:, :3]
        assert (log["observer.held"][47:] == 0).all()
        assert (off[60:] < hidden[60:] + 6 * noise).all(), "from 0.1 s on: at first it has no force yet"
        assert np.median(off[60:]) < 6 * noise.max()
        assert log.info["observer"]["bandwidth"] == "10.0 Hz" and "observer" in log.info["hashes"]
    page = Path("results/f/report.html").read_text()
    assert "Force on the tool, as observed" in page and "<summary>Observer" in page
