"""The table says the metrics, and the verdict says what the table says."""

import json
import re

import pytest

from conftest import make_log
from gough.log.build import plain
from gough.report.table import LINES, NONE, number, report_table, verdict

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


def changed(log, **metrics):
    """A log of 3 s with other metrics."""
    new = make_log(log, seconds=0.1, rate=100)
    info = new.info | {"metrics": metrics}
    new.dataset.attrs["gough"] = json.dumps(plain(info))
    return new


def rated(kind, rms, top):
    return changed(kind, contour_error={"rms": rms, "max": top, "mean": rms})


def test_every_number_of_the_table_is_that_of_the_metrics(logs):
    rows = report_table(logs)
    assert [row.label for row in rows] == [line.label for line in LINES]
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
    assert rows[0].label == "status" and rows[0].values == ("FAILED", "done", "done")
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
    assert verdict([failed]) == "The run with PID failed."
    both = verdict([failed, rated("a", 1e-6, 9e-6)])
    assert both.startswith("The run with PID failed; a kept the tool within 9.00 µm")
    assert "no contour error" in verdict(rated("a", None, None))


def test_three_digits_are_shown_without_powers_of_ten():
    for rms in (1e-9, 1.234e-8, 9.99e-7, 1e-6, 123e-6, 0.0123, 1.5):
        (text,) = report_table(rated("a", rms, rms))[1].values
        assert re.fullmatch(r"\d+(\.\d+)? (nm|µm|mm|m)", text), text
