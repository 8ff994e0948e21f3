"""Tunings: candidates are judged as single runs tell it, ranked whatever becomes of them, and the best is a file."""

from __future__ import annotations

import json
import math
import re
import tomllib

import numpy as np
import pytest

import gough as gk
from gough.cli import main
from gough.errors import ExperimentError, RunError
from gough.experiment import load_experiment
from gough.simulate.run import simulate
from gough.tune.judge import Judge
from gough.tune.table import task_of
from gough.tune.tuning import tune

from .conftest import TEXT, TUNE

FEW = TUNE + "machines = 3\nheld_out = 2\n"


def alone(task, machine, settings):
    """The metric of one candidate on one machine, by a single run."""
    one = task.setter({**machine, **settings})
    log = simulate(
        one.machine, one.controllers[0].law, one.program, one.plant, seed=one.run.seed, period=one.run.period
    )
    return log.metrics


@pytest.mark.full
def test_a_candidate_is_worth_what_single_runs_say(written):
    """To rounding: encoders count 0.1 um, and a count may fall otherwise in a lane."""
    for goal, of in (("worst", np.max), ("mean", np.mean)):
        task = task_of(written(FEW + f'goal = "{goal}"\nmetric = "contour_error.rms"\n'))
        candidate = {"controller.bandwidth": "12.0 Hz"}
        (score,) = Judge(task, task.machines)([candidate])
        runs = [alone(task, machine, candidate) for machine in task.machines]
        expected = np.array([run["contour_error"]["rms"] for run in runs])
        np.testing.assert_allclose(score.values, expected, rtol=0, atol=0.1e-6)
        assert score.status == "held" and score.goal == pytest.approx(of(expected), abs=0.1e-6)
        assert score.force == pytest.approx(max(run["strut_force"]["peak"] for run in runs), rel=1e-3)
        assert score.overshoot == pytest.approx(max(run["overshoot"]["max"] for run in runs), abs=0.1e-6)


@pytest.mark.full
def test_no_candidate_changes_a_bit_of_another_and_each_ranks_where_it_belongs(written):
    """400 Hz is unstable at 1 kHz; a bandwidth below 0 is none that a controller can have."""
    task = task_of(written(FEW + 'force = "10 N"\n'))
    judge = Judge(task, task.machines)
    good, wild, none = ({"controller.bandwidth": value} for value in ("20.0 Hz", "400.0 Hz", "-3.0 Hz"))
    free = task_of(written(FEW))
    held = Judge(free, free.machines)([good])[0]
    beyond, unstable, refused = judge([good, wild, none])
    assert beyond == judge([good])[0]
    assert [one.status for one in (held, beyond, unstable, refused)][:2] == ["held", "beyond"]
    assert unstable.status in ("unstable", "failed") and refused.status == "refused"
    assert held.cost < beyond.cost < unstable.cost < refused.cost and held.goal == beyond.goal
    assert re.fullmatch(r"force [\d.]+, limit 10", beyond.reason) and "bandwidth" in refused.reason


@pytest.mark.full("cma")
@pytest.mark.parametrize("method", ["cma", "evolution"])
def test_one_seed_is_one_tuning_and_the_best_is_the_best_of_all_tried(written, method):
    table = FEW.replace("}", ', "controller.speed_ratio" = [2, 8] }') + f'method = "{method}"\n'
    first, again = (tune(written(table.replace("budget = 12", "budget = 30"))) for _ in range(2))
    assert first.history == again.history and first.aside == again.aside
    assert first.before.settings == {} and len(first.history) <= 30
    assert first.best.goal == min(one.goal for one in first.history if one.status == "held") < first.before.goal
    assert len({json.dumps(one.settings) for one in first.history}) > 20, "it searches"
    assert first.aside[1].goal < first.aside[0].goal, "what is gained is gained on machines it has not seen, too"


@pytest.mark.full
def test_the_file_of_a_tuning_runs_the_very_candidate(written, tmp_path):
    tuned = tune(written(sweep=""))
    for name, text in tuned.files().items():
        (tmp_path / name).write_text(text)
    again = load_experiment(tmp_path / "experiment.toml")
    law = again.controllers[0].law
    assert law == tuned.experiment.controllers[0].law and law.bandwidth != 8.0
    log = gk.simulate(again.machine, law, again.program, [again.plant], keep="metrics", lanes="auto")
    assert log.metrics["contour_error"]["max"][0] == tuned.best.goal
    assert tomllib.loads(tuned.files()["experiment.toml"])["tune"]["budget"] == 12


@pytest.mark.full
def test_where_nothing_holds_the_limits_the_closest_is_told(written):
    with pytest.raises(RunError, match=r"none of 12 candidates holds the limits of .tune., got the closest: .* force"):
        tune(written(TUNE + 'force = "1 N"\n'))


@pytest.mark.full
def test_an_experiment_that_cannot_run_is_said_as_gough_run_says_it(written, tmp_path):

    with pytest.raises(ExperimentError, match="the believed machine has no friction|no "):
        text = TEXT.replace(
            'kind = "pid"\nbandwidth = "8 Hz"', 'kind = "robust_adaptive"\nslope = "60 1/s"\ndamping = "120 1/s"'
        )
        tune(
            written(
                TUNE.replace('bandwidth" = ["4 Hz", "40 Hz"]', 'slope" = ["40 1/s", "80 1/s"]'), sweep="", text=text
            )
        )


@pytest.mark.full
def test_the_command_writes_a_file_that_runs_a_figure_and_all_that_was_tried(written, tmp_path, capsys):
    path, out = written(FEW).document.path, tmp_path / "out"
    with pytest.raises(SystemExit) as ended:
        main(["tune", str(path), "-o", str(out), "--json", "--budget", "8"])
    told = json.loads(capsys.readouterr().out)
    assert ended.value.code == 0 and told["schema"] == "gough-tune-1" and told["status"] == "done"
    kept = json.loads((out / "tuning.json").read_text())
    assert told["tried"] == 8 == len(kept["history"]) and math.isclose(told["tuned"]["goal"], kept["tuned"]["goal"])
    assert told["held_out"]["machines"] == 2 and (out / "progress.svg").stat().st_size > 5000
    with pytest.raises(SystemExit) as ended:
        main(["run", str(out / "experiment.toml"), "-o", str(tmp_path / "run"), "--quiet"])
    assert ended.value.code == 0
    with pytest.raises(SystemExit) as ended:
        main(["tune", str(path), "-o", str(tmp_path / "none"), "--json", "--budget", "0"])
    assert ended.value.code == 2 and "--budget" in capsys.readouterr().out


SMOOTH = TUNE.replace("}", ', "controller.acceleration_feedforward" = [0, 2] }')
SMOOTH += 'goal = "mean"\nmetric = "contour_error.rms"\nmachines = 3\nheld_out = 0\n'
PERFECT = '[plant]\n"drive.encoder" = "none"\n'


@pytest.mark.full
def test_slopes_are_differences_of_the_goal_along_the_search_s_own_scale(written):
    """Central differences of 1e-3 of the cube, whose candidates are written with six digits: 5e-6 / 1e-3 of a slope."""
    from gough.tune.gains import settings
    from gough.tune.slopes import slopes

    task = task_of(written(SMOOTH, text=TEXT + PERFECT))
    judge, u = Judge(task, task.machines), np.array([0.5, 0.4])
    found = slopes(task, u)
    for i in range(2):
        h = np.eye(2)[i] * 1e-3
        up, down = (one.goal for one in judge([settings(task.gains, u + h), settings(task.gains, u - h)]))
        assert found[i] == pytest.approx((up - down) / 2e-3, rel=1e-2)


@pytest.mark.slow
def test_the_gradient_comes_as_far_as_evolution_with_fewer_candidates(written):
    blind = SMOOTH.replace("budget = 12", 'method = "evolution"\nbudget = 60')
    blind = tune(written(blind, text=TEXT + PERFECT))
    smooth = tune(written(SMOOTH.replace("budget = 12", 'method = "gradient"\nbudget = 30'), text=TEXT + PERFECT))
    assert smooth.method == "gradient" and len(smooth.history) <= 30 < len(blind.history)
    assert smooth.best.goal <= blind.best.goal * 1.001


@pytest.mark.full
def test_a_gradient_of_what_is_not_smooth_is_refused_by_name(written):
    with pytest.raises(
        ExperimentError, match="tune.method: a gradient needs a smooth goal, got worst contour_error.max"
    ):
        tune(written(TUNE + 'method = "gradient"\n'))
    with pytest.raises(ExperimentError, match="plant.drive.encoder: has no gradient: the run is not smooth"):
        tune(written(SMOOTH + 'method = "gradient"\n'))
