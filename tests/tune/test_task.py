"""[tune] tables: what they ask for, and what is said of those that are wrong."""

from __future__ import annotations

import math

import pytest

from gough.errors import ExperimentError
from gough.tune.gains import Gain, settings
from gough.tune.table import task_of

from .conftest import SWEEP, TEXT, TUNE


def test_a_gain_between_two_positive_ends_is_searched_on_a_logarithmic_scale():
    gain = Gain("controller.bandwidth", 4.0, 40.0, "Hz")
    assert [gain.value(u) for u in (-0.1, 0.0, 0.5, 1.0, 2.0)] == [
        "4.0 Hz",
        "4.0 Hz",
        "12.6491 Hz",
        "40.0 Hz",
        "40.0 Hz",
    ]
    assert gain.place("12.649110640673518 Hz") == pytest.approx(0.5) and gain.place(4.0) == 0.0
    assert gain.place("3.9 Hz") is None and gain.place("fast") is None


def test_a_gain_that_may_be_zero_is_searched_on_a_linear_scale():
    gain = Gain("controller.feedforward", 0.0, 2.0, "")
    assert settings([gain, gain], [0.25, 1.0]) == {"controller.feedforward": 2.0}
    assert gain.value(0.25) == 0.5 and gain.place(1.5) == 0.75


def test_a_gain_in_another_unit_than_si_is_placed_by_its_si_number():
    gain = Gain("controller.takeover", 10.0, 1000.0, "ms")
    assert gain.value(0.5) == "100.0 ms" and gain.place(0.1) == pytest.approx(0.5)


def test_machines_tuned_on_and_held_out_are_draws_of_one_row(written):
    task = task_of(written(TUNE + "machines = 3\nheld_out = 2\n"))
    more = task_of(written(TUNE + "machines = 5\nheld_out = 0\n"))
    assert task.machines + task.held_out == more.machines and len(task.machines) == 3
    payloads = [float(one["plant.payload"].split()[0]) for one in more.machines]
    assert len(set(payloads)) == 5 and all(1 <= kg <= 4 for kg in payloads)


def test_lists_of_the_sweep_are_machines_too(written):
    sweep = '[sweep]\nvary = { "plant.payload" = ["1 kg", "5 kg"], "plant.platform.mass" = ["1 x", "1.2 x"] }\n'
    task = task_of(written(sweep=sweep))
    assert len(task.machines) == 4 and task.held_out == []


def test_without_a_sweep_the_plant_is_the_one_machine(written):
    task = task_of(written(sweep=""))
    assert task.machines == [{}] and task.held_out == []


@pytest.mark.parametrize(
    ("tune", "said"),
    [
        ("", "tune: the table is missing; write [tune] and vary = "),
        ("[tune]\nbudget = 5\n", "tune.vary: must be a table of gains, each with its two ends"),
        (
            TUNE.replace("bandwidth", "bandwith"),
            "vary.controller.bandwith: names nothing of this experiment; did you mean controller.bandwidth?",
        ),
        (
            TUNE.replace("controller.bandwidth", "plant.payload"),
            "tune.vary.plant.payload: is no gain: only what a controller has is tuned",
        ),
        (TUNE.replace('"4 Hz"', '"50 Hz"'), "the first end must lie below the second, got '50 Hz' and '40 Hz'"),
        (TUNE.replace('"4 Hz"', '"4 1/s"'), "both ends must have one unit, got '4 1/s' and '40 Hz'"),
        (TUNE.replace('"4 Hz"', '"-4 Hz"'), "tune.vary.controller.bandwidth: controller.0.bandwidth "),
        (TUNE.replace('"4 Hz", ', ""), "must be two ends"),
        (TUNE + "budget_ = 3\n", "tune.budget_: no such key; did you mean budget?"),
        (TUNE + 'metric = "lag.max"\n', "tune.metric: "),
        (TUNE + "held_out = -1\n", "tune.held_out: "),
        (TUNE + 'force = "-3 N"\n', "tune.force: "),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_table_is_said_at_its_key(written, tune, said):
    with pytest.raises(ExperimentError) as caught:
        task_of(written(tune))
    assert said in str(caught.value) and "tripod.toml" in str(caught.value)


def test_what_is_tuned_cannot_be_drawn_too(written):
    sweep = '[sweep]\nvary = { "controller.0.bandwidth" = "uniform(5, 6) Hz" }\n'
    with pytest.raises(ExperimentError, match="is tuned, so it cannot be drawn too"):
        task_of(written(sweep=sweep))


def test_machines_are_counted_only_where_they_are_drawn(written):
    with pytest.raises(
        ExperimentError, match="tune.machines: counts machines that .sweep. draws, and there is no such"
    ):
        task_of(written(TUNE + "machines = 4\n", sweep=""))


def test_one_controller_is_tuned_at_a_time(written):
    two = TEXT + '[[controller]]\nkind = "axis_pd"\nstiffness = "4 N/um"\n'
    with pytest.raises(
        ExperimentError, match="one controller is tuned at a time, got pid, axis_pd; give --controller pid"
    ):
        task_of(written(text=two))


def test_budget_and_seed_of_the_command_line_come_before_those_of_the_file(written):
    table = task_of(written(TUNE + "seed = 4\n"), budget=7, seed=9).table
    assert (table.budget, table.seed) == (7, 9) and math.isclose(table.saturated, 0.0)
    assert SWEEP.count("seed") == 1
