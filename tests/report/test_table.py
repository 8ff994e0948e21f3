"""The table says the metrics, and the verdict says what the table says."""

import json
import re

import pytest

from conftest import make_log
from gough.log.build import plain
from gough.report.table import LINES, NONE, heads, number, report_table, verdict

SI = {
    "nm": 1e-9,
    "µm": 1e-6,
    "mm": 1e-3,
    "m": 1,
    "nrad": 1e-9,
    "µrad": 1e-6,
    "mrad": 1e-3,
    "rad": 1,
    "N": 1,
    "kN": 1e3,
    "mm/s": 1e-3,
    "m/s": 1,
    "%": 1e-2,
    "s": 1,
    "": 1,
}


def changed(log, radius=0.97, failed="", **metrics):
    """A short log with other metrics and another spectral radius."""
    new = make_log(log, seconds=0.1, rate=100, failed=failed)
    info = new.info | {"metrics": metrics, "run": {"spectral_radius": radius}, "simulated_time": 13.25}
    new.dataset.attrs["gough"] = json.dumps(plain(info))
    return new


def rated(kind, rms, top, **others):
    return changed(kind, contour_error={"rms": rms, "max": top, "mean": rms}, **others)


def test_every_number_of_the_table_is_that_of_the_metrics(logs):
    rows = report_table(logs)
    assert [row.label for row in rows] == [line.label.format(joint="strut") for line in LINES]
    for row, line in zip(rows, LINES, strict=True):
        for log, text in zip(logs, row.values, strict=True):
            digits, _, unit = text.partition(" ")
            decimals = len(digits.partition(".")[2])
            half = 0.51 * SI[unit] * 10**-decimals  # of the last digit shown, and rounding
            assert float(digits) * SI[unit] == pytest.approx(number(log, line.path), abs=half)


def test_columns_of_a_row_share_a_unit_and_the_best_is_marked(logs):
    for row in report_table(logs):
        assert len({value.partition(" ")[2] for value in row.values}) == 1
    best = {row.label: row.best for row in report_table(logs)}
    assert best["contour error, max"] == (1,)
    assert best["strut force, peak"] == ()  # more force is not worse


def test_what_is_not_known_is_a_dash_and_never_best():
    rows = {row.label: row for row in report_table([rated("pid", None, float("nan")), rated("b", 1e-6, 2e-6)])}
    assert rows["contour error, rms"].values == (NONE, "1.00 µm")
    assert rows["contour error, rms"].best == ()
    assert rows["lag, max"].values == (NONE, NONE)


def test_a_failed_run_is_told_first_and_is_never_best():
    rows = report_table([make_log("pid", 1e-6, failed="bang"), make_log("b", 4e-6), make_log("c", 5e-6)])
    assert rows[0].label == "status" and rows[0].values == ("FAILED at 60.00 s", "done", "done")
    assert all(0 not in row.best for row in rows)
    assert rows[1].best == (1,)


def test_the_verdict_names_the_better_and_by_how_much(logs):
    text = verdict(logs)
    ratio = number(logs[0], ("contour_error", "rms")) / number(logs[1], ("contour_error", "rms"))
    assert text.startswith(f"Computed torque follows the path {ratio:.2g} times as closely as PID: contour error ")
    table = {row.label: row.values for row in report_table(logs)}
    for label in ("contour error, rms", "contour error, max"):
        for value in table[label]:
            assert value in text
    assert verdict(logs[::-1]) == text


def test_the_verdict_admits_a_larger_peak_and_a_tie():
    assert "but its largest error is the larger one" in verdict([rated("a", 1e-6, 9e-6), rated("b", 2e-6, 3e-6)])
    assert "equally well" in verdict([rated("a", 1e-6, 9e-6), rated("b", 1.01e-6, 3e-6)])
    assert "c is behind both" in verdict([rated("a", 1e-6, 9e-6), rated("c", 9e-6, 3e-6), rated("b", 2e-6, 3e-6)])


def test_the_verdict_of_one_log_and_of_failures():
    assert verdict(rated("a", 1e-6, 9e-6)) == "A kept the tool within 9.00 µm of the programmed path, 1.00 µm rms."
    failed = make_log("pid", failed="bang")
    assert verdict([failed]) == "PID: the run failed at 60.00 s."
    both = verdict([failed, rated("a", 1e-6, 9e-6)])
    assert both.startswith("PID: the run failed at 60.00 s; no comparison. A kept the tool within 9.00 µm")
    assert "no contour error" in verdict(rated("a", None, None))


FLAWED = {
    "failed": ({"failed": "bang"}, "A: the run failed at 13.25 s; no comparison."),
    "unstable": ({"radius": 1.2}, "A: the loop is unstable (spectral radius 1.2 a sample); no comparison."),
    "hardly unstable": (
        {"radius": 1.00002},
        "A: the loop is unstable (spectral radius 1.00002 a sample); no comparison.",
    ),
    "saturated": ({"saturated": 0.99}, "A: a drive is at its limit in 99 % of the samples; no comparison."),
}


@pytest.mark.parametrize("changes, told", FLAWED.values(), ids=FLAWED)
def test_a_flawed_run_with_smaller_errors_is_not_praised_nor_compared(changes, told):
    bad, good, worse = rated("a", 1e-6, 2e-6, **changes), rated("b", 4e-6, 9e-6), rated("c", 8e-6, 12e-6)
    # with one sound log left there is nobody to be better than, and no best
    assert verdict([bad, good]) == f"{told} B kept the tool within 9.00 µm of the programmed path, 4.00 µm rms."
    assert all(row.best == () for row in report_table([bad, good]))
    # with two, these alone are compared
    assert verdict([bad, good, worse]).startswith(f"{told} B follows the path 2 times as closely as c: ")
    best = {row.label: row.best for row in report_table([bad, good, worse])}
    assert best["contour error, rms"] == (1,)
    assert verdict(bad) == told.replace("; no comparison", "")


def test_two_flawed_runs_are_each_told_and_every_flaw_too():
    bad = rated("pid", 1e-6, 2e-6, radius=1.2, failed="bang", saturated=0.5)
    text = verdict([bad, rated("b", 4e-6, 9e-6, saturated=0.051)])
    assert text == (
        "PID: the run failed at 13.25 s, the loop is unstable (spectral radius 1.2 a sample) and a drive is at its "
        "limit in 50 % of the samples; no comparison. B: a drive is at its limit in 5.1 % of the samples; no "
        "comparison."
    )


def test_a_loop_at_the_border_and_a_drive_seldom_at_its_limit_are_compared():
    """An integrator has the radius 1, give or take the error of the differences it was found by."""
    logs = [rated("a", 1e-6, 2e-6, radius=1 + 1e-6, saturated=0.05), rated("b", 4e-6, 9e-6, radius=None)]
    assert verdict(logs).startswith("A follows the path 4 times as closely as b: ")


def test_the_head_and_the_status_of_a_failed_run_say_until_when():
    logs = [rated("pid", 1e-6, 2e-6, failed="bang"), rated("b", 4e-6, 9e-6)]
    assert heads(logs) == ["PID, FAILED at 13.25 s", "b"]
    assert report_table(logs)[0].values == ("FAILED at 13.25 s", "done")
    # a log that does not tell its time
    logs[0].dataset.attrs["gough"] = json.dumps({"controller_kind": "pid"})
    assert heads(logs)[0] == "PID, FAILED"


def test_three_digits_are_shown_without_powers_of_ten():
    for rms in (1e-9, 1.234e-8, 9.99e-7, 1e-6, 123e-6, 0.0123, 1.5):
        (text,) = report_table(rated("a", rms, rms))[1].values
        assert re.fullmatch(r"\d+(\.\d+)? (nm|µm|mm|m)", text), text
