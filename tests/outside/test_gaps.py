"""RELIABILITY L1, L2, L4, L5, L9: what is missing, twice, late, cut off, or in another unit."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gough.errors import LogError
from outside.conftest import MAP, circle, csv_text

GAPS = MAP + '[gaps]\nlongest = "5 ms"\nmost = "5 %"\n'


def told(found):
    return [str(one) for one in found.findings.kept]


def with_cells(table, rows, text="nan"):
    lines = csv_text(table).split("\n")
    for row in rows:
        cells = lines[row + 1].split(",")
        cells[2] = text
        lines[row + 1] = ",".join(cells)
    return "\n".join(lines)


def test_short_runs_of_bad_cells_are_missing_samples_where_the_map_allows(record, truth):
    found, rows, parts = record(with_cells(truth.table, [100, 101, 102], "-"), GAPS)
    good = np.concatenate([p.good for p in parts])
    # a row's force is that of the row before, so the row behind the gap is not whole either, nor is the first
    assert np.flatnonzero(~good).tolist() == [0, 100, 101, 102, 103]
    assert told(found) == ["q2: '-' where a number should be at line 102, t = 0.1 s to 0.102 s, 3 samples"]
    assert found.missing == 3
    assert_allclose(rows.q[good], truth.q[good], rtol=0, atol=1e-15)


def test_a_run_longer_than_the_map_allows_is_refused_where_it_begins(record, truth):
    with pytest.raises(LogError) as caught:
        record(with_cells(truth.table, range(100, 106)), GAPS)
    assert "log.csv:102: q2: no numbers for longer than gaps.longest, 0.005 s" in str(caught.value)


def test_dropped_samples_are_put_in_as_missing(record, truth):
    keep = np.r_[0:200, 203:400]
    found, rows, parts = record(truth.table[keep])
    good = np.concatenate([p.good for p in parts])
    assert len(rows.t) == 400
    assert_allclose(rows.t, truth.t, rtol=0, atol=1e-12)
    assert np.flatnonzero(~good).tolist() == [0, 200, 201, 202, 203]
    assert told(found) == ["samples are missing at line 202, t = 0.2 s to 0.202 s, 3 samples"]
    assert_allclose(rows.q[good], truth.q[good], rtol=0, atol=1e-15)


def test_a_long_break_begins_a_new_part(record, okuma):
    long = circle(okuma, 9000)
    found, _, parts = record(long.table[np.r_[0:4000, 4500:9000]])
    assert [p.anew for p in parts] == [True, True]
    assert [len(p.t) for p in parts] == [4000, 4500]
    assert told(found) == ["the record breaks off and begins anew at line 4002, t = 4 s to 4.499 s, 500 samples"]
    assert not parts[1].good[0], "nobody knows the force before it"


@pytest.mark.full
def test_a_break_at_the_begin_of_a_block_is_one_too(record, okuma):
    """Blocks of text have 32768 rows."""
    long = circle(okuma, 33500)
    found, rows, parts = record(long.table[np.r_[0:32768, 32771:33500]])
    assert len(rows.t) == 33500
    good = np.concatenate([p.good for p in parts])
    assert np.flatnonzero(~good).tolist() == [0, 32768, 32769, 32770, 32771]
    assert found.findings.counts == {"missing": 3}


def test_too_much_missing_is_refused(record, truth):
    with pytest.raises(LogError, match=r"too many samples are missing or wrong, got 10 of 400 \(limit 1 %\)"):
        record(truth.table[np.r_[0:200, 210:400]])


def test_a_row_that_is_there_twice_counts_once(record, truth):
    found, rows, _ = record(truth.table[np.r_[0:200, 199:400]])
    assert len(rows.t) == 400
    assert told(found) == ["a row is there twice at line 202, t = 0.199 s"]


def test_two_rows_of_one_time_that_differ_are_refused(record, truth):
    table = truth.table.copy()
    table[200, 0] = table[199, 0]
    with pytest.raises(LogError, match=r"log.csv:202: two rows of one time differ, got 0.199 s"):
        record(table)


def test_time_that_goes_backwards_is_refused(record, truth):
    table = truth.table.copy()
    table[200:, 0] -= 0.05
    with pytest.raises(LogError, match=r"log.csv:202: time goes backwards, got 0.15 s"):
        record(table)


def test_a_row_without_a_time_is_refused_whatever_the_gaps(record, truth):
    text = csv_text(truth.table).replace("\n0.3,", "\n,", 1)
    with pytest.raises(LogError, match=r"log.csv:302: t: a row needs its time, got nothing"):
        record(text, GAPS)


def test_a_row_at_the_wrong_time_is_told_and_not_used(record, truth):
    table = truth.table.copy()
    table[200, 0] += 0.0004
    found, _, parts = record(table)
    good = np.concatenate([p.good for p in parts])
    assert not good[200]
    assert told(found) == ["a row lies at the wrong time at line 202, t = 0.2004 s to 0.201 s, 2 samples"]


def test_a_clock_that_runs_slow_by_a_thousandth_is_no_matter(record, truth):
    table = truth.table.copy()
    table[:, 0] *= 1.001
    found, rows, _ = record(table)
    assert not told(found)
    assert len(rows.t) == 400


def test_another_period_than_the_maps_is_refused_with_the_right_one(record, truth):
    table = truth.table.copy()
    table[:, 0] *= 2
    with pytest.raises(LogError) as caught:
        record(table)
    assert "time.period: rows are as far apart as the period says, got 0.002 s (limit 0.001 s)" in str(caught.value)
    assert 'write period = "0.002 s"' in str(caught.value)


def test_a_counter_of_samples_is_a_time(record, truth):
    table = truth.table.copy()
    table[:, 0] = 1000 + np.arange(400)
    _, rows, _ = record(table, MAP.replace('column = "t"', 'column = "t"\nunit = "samples"'))
    assert_allclose(rows.t - 1.0, truth.t, rtol=0, atol=1e-12)


def test_a_number_of_samples_that_jumps_is_a_gap(record, truth):
    table = truth.table.copy()
    table[:, 0] = np.arange(400) + 2 * (np.arange(400) >= 300)
    found, rows, _ = record(table, MAP.replace('column = "t"', 'column = "t"\nunit = "samples"'))
    assert len(rows.t) == 402
    assert found.findings.counts == {"missing": 2}


def test_without_a_time_every_row_is_a_sample(record, truth):
    _, rows, _ = record(truth.table, MAP.replace('column = "t"\n', ""))
    assert_allclose(rows.t, truth.t, rtol=0, atol=1e-12)


def test_clipped_forces_are_marked_left_out_and_counted(record, truth):
    table = truth.table.copy()
    table[150:153, 8] = 5000.0
    found, _, parts = record(table, MAP + "clip = 5000.0\n")
    good = np.concatenate([p.good for p in parts])
    assert np.flatnonzero(~good).tolist() == [0, 150, 151, 152, 153]
    assert (found.clipped, found.missing) == (3, 3)
    assert told(found) == ["forces are cut off at line 152, t = 0.15 s to 0.152 s, 3 samples"]


def test_forces_that_no_drive_gives_are_marked_left_out_and_told(record, truth, okuma):
    """60 N m on a screw of 25 mm are 15.08 kN."""
    table = truth.table.copy()
    table[150:152, 8], table[300, 9] = 15.2e3, -15.0e3
    found, _, parts = record(table)
    good = np.concatenate([p.good for p in parts])
    assert np.flatnonzero(~good).tolist() == [0, 150, 151, 152]
    assert told(found) == ["no drive gives such a force at line 152, t = 0.15 s to 0.151 s, 2 samples"]


@pytest.mark.parametrize(("unit", "meant"), [("m", "mm"), ("um", "mm"), ("cm", "mm"), ("in", "mm")])
def test_readings_in_another_unit_are_refused_with_the_right_one(record, truth, unit, meant):
    with pytest.raises(LogError) as caught:
        record(truth.table, MAP.replace('unit = "mm"', f'unit = "{unit}"'))
    text = str(caught.value)
    assert "joints: the first readings are no pose of okuma-pm600" in text
    assert text.endswith(f'did you mean unit = "{meant}"?')


def test_readings_too_fast_for_the_machine_betray_the_period(record, okuma):
    """A circle at 2 rad/s told at a period of 20 us moves at 5 m/s."""
    rows = circle(okuma, 400)
    text = MAP.replace('column = "t"\n', "").replace("1 ms", "20 us")
    with pytest.raises(LogError, match=r"joints move faster than the machine's can, got .* m/s \(limit 1.667 m/s\)"):
        record(rows.table, text)


def test_a_map_of_another_machine_is_told(record, truth):
    """RELIABILITY L9."""
    found, _, _ = record(truth.table, MAP.replace("[time]", 'machine = "nist-octahedral"\n[time]'))
    assert told(found) == ["the map is for nist-octahedral, not for okuma-pm600"]
