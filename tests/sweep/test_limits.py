"""Limits that runs hit, drives at their limits, loops that grow, and why runs failed: told by sorts, not run by run."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from gough.sweep import limits, summary
from gough.sweep.design import METRICS
from gough.sweep.run import Progress, sweep
from gough.sweep.table import Lines, lines_of, write_index

TOO_LONG = "too long, got {0} m (limit 1.9 m) at t = {1} s"


def lines(rows, controllers=1) -> Lines:
    """Lines of (reason, limit, spectral radius); an empty reason is a run that is done."""
    count = len(rows)
    status = np.array(["failed" if reason else "done" for reason, _, _ in rows])
    return Lines(
        np.arange(count), np.zeros(count, int), np.arange(count) % controllers, [f"{k:032x}" for k in range(count)],
        status, [reason for reason, _, _ in rows], [], [limit for _, limit, _ in rows],
        np.full(count, np.nan), np.array([radius for _, _, radius in rows], float), np.zeros((0, count)),
        {"contour_error.max": np.where(status == "done", 1e-5 * (1 + np.arange(count)), np.nan)},
    )  # fmt: skip


def test_runs_that_fail_alike_are_a_line_whatever_their_numbers_and_joints():
    rows = [
        (f"strut {k % 6 + 1}: {TOO_LONG.format(1.9 + k, k)}", f"strut {k % 6 + 1}: too long", 0.9) for k in range(9)
    ]
    rows += [(f"mass must be above 0 kg, got -{k}.5e-3 kg", "", np.nan) for k in range(3)] + [("", "", 0.9)]
    told = lines(rows)
    found = limits.failures(told)
    assert [(one.sort, one.count, one.first) for one in found] == [
        ("strut: too long", 9, 0), ("mass must be above # kg, got # kg", 3, 9),
    ]  # fmt: skip
    assert limits.told_of(found[0], told) == f"9 failed (strut: too long), such as: {rows[0][0]}"
    assert limits.told_of(found[1], told) == f"3 failed, such as: {rows[9][0]}"
    assert limits.hits(told, np.arange(5)) == {"strut: too long": 5} and limits.hits(told, np.array([9, 12])) == {}


def test_a_hundred_loops_that_grow_are_one_warning_a_controller():
    rows = [("", "", 1.5 + 0.01 * k) for k in range(98)] + [("", "", 1 + 1e-7), ("failed before it began", "", np.nan)]
    swept = SimpleNamespace(experiment=SimpleNamespace(labels=["pid", "computed_torque"]))
    assert limits.unstable(swept, lines(rows, controllers=2)) == [
        "pid: the loop is unstable at home in 49 of 50 runs, the most in 0000000000 (spectral radius 2.46 a sample); "
        "lower the bandwidth or shorten the period",
        "computed_torque: the loop is unstable at home in 49 of 50 runs, the most in 0000000000 (spectral radius 2.47 "
        "a sample); lower the bandwidth or shorten the period",
    ]


def test_a_case_that_all_but_failed_is_not_the_best_because_of_one_good_run():
    def case(failed, worst):
        return summary.Case(0, 0, 10, failed, worst, worst, worst, "", None, {})

    assert summary.rank(case(9, 1e-6)) > summary.rank(case(0, 1e-3)) > summary.rank(case(0, 1e-4))
    assert summary.rank(case(10, None)) > summary.rank(case(9, 1.0))


def test_the_command_of_a_run_that_broke_is_that_of_the_sweep_for_the_run_was_not_kept(tmp_path):
    told = lines([("ZeroDivisionError: a bug", "", np.nan), ("too long", "strut 1: too long", 0.9)])
    states = ("broken", "failed")
    swept = SimpleNamespace(
        experiment=SimpleNamespace(labels=["pid"], controllers=[None]),
        design=SimpleNamespace(metric="contour_error.max"),
        records={id: {"status": status} for id, status in zip(told.ids, states, strict=True)},
    )  # fmt: skip
    assert [run.command for run in summary.worst_runs(swept, told, tmp_path / "a b")] == [
        f"gough sweep '{tmp_path}/a b'", f"gough sweep '{tmp_path}/a b' --rerun 0000000000",
    ]  # fmt: skip


@pytest.mark.full
def test_limits_hit_and_drives_at_theirs_are_kept_told_and_in_the_index(experiment, tmp_path):
    """Drives of 0.6 N m cannot hold the platform: it falls until a strut ends it."""
    import pyarrow.parquet as pq

    base = experiment(
        '"plant.payload" = ["20 kg"], "plant.drive.torque_limit" = ["0.6 N m", "40 N m"]', '\nmetric = "overshoot.max"',
        turns=("turns = 0.2", "turns = 0.5"),
    )  # fmt: skip
    swept = sweep(base, tmp_path / "s", workers=1)
    found = lines_of(swept)
    weak = found.values[1] == 0.6
    assert (found.status[weak] == "failed").all() and (found.status[~weak] == "done").all()
    table = pq.read_table(write_index(swept, found, tmp_path / "index.parquet"))
    said, at = table["limit_hit"].to_pylist(), table["limit_hit.time"].to_numpy()
    for k, one in enumerate(weak):
        assert bool(said[k]) == one == bool(np.isfinite(at[k]))
        if one:  # as the reason has it: the same strut, at the same time
            assert found.reason[k].startswith(said[k]) and f"at t = {at[k]:.3g} s" in found.reason[k]
    assert (table["saturated"].to_numpy()[weak] > 0.9).all() and (table["saturated"].to_numpy()[~weak] < 0.1).all()
    assert (table["spectral_radius"].to_numpy() < limits.UNSTABLE).all()
    cases = summary.cases_of(swept, found)
    assert sum(sum(case.limits.values()) for case in cases) == weak.sum()
    assert {case.saturated > 0.9 for case in cases if case.limits} == {True}
    heads, rows = summary.case_rows(swept, found, cases)
    assert heads[-1] == "at drive limits" and any(row[-1] == "<= 100 %" for row in rows)
    assert np.isfinite(found.metric("overshoot.max")[~weak]).all()


def test_overshoot_and_drives_at_their_limits_can_be_what_a_sweep_is_about():
    assert {"overshoot.max", "saturated", "strut_force.peak", "contour_error.max"} <= set(METRICS)


def test_progress_says_the_time_to_go_the_failed_and_the_best_with_its_unit(capsys):
    from gough.cli import sweep as command

    with command.Bar(quiet=False) as bar:  # no terminal here: lines
        progress = Progress("contour_error.max", 1000, 100, 100)
        bar.show(progress)
        bar.begun -= 60.0  # s, in which 300 runs were done: 120 s for the other 600
        progress.done, progress.failed, progress.best = 400, 3, (2.5e-5, "0123456789abcdef")
        bar.told -= bar._PAUSE + 1
        bar.show(progress)
        bar.show(progress)  # too soon
        progress.done = 1000
        bar.show(progress)
    assert capsys.readouterr().err.splitlines() == [
        "100 of 1000 runs, 100 of them kept from before",
        "400 of 1000 runs, about 2 min to go, 3 failed, best contour_error.max 25 um (0123456789)",
        "1000 of 1000 runs, 3 failed, best contour_error.max 25 um (0123456789)",
    ]
