"""Maps: units, signs, torques and currents; every mistake with its line."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from gough.errors import LogError
from gough.log.outside import load_map
from outside.conftest import MAP


def forces(unit, factor=None):
    told = f'unit = "{unit}"' + (f'\nfactor = "{factor}"' if factor else "")
    return MAP.replace('unit = "N"', told)


LEAD = 0.025  # of the sheet


@pytest.mark.parametrize(
    ("unit", "factor", "newtons"),
    [
        ("kN", None, 1000.0),
        ("N m", None, 2 * np.pi / LEAD),
        ("A", "0.6 N m", 0.6 * 2 * np.pi / LEAD),
        ("V", "35.15 N", 35.15),
        ("counts", "-2 mN", -2e-3),
    ],
)
def test_a_unit_of_force_torque_or_current_becomes_newtons(record, truth, unit, factor, newtons):
    table = truth.table.copy()
    table[:, 7:] /= newtons
    _, rows, _ = record(table, forces(unit, factor))
    assert_allclose(rows.u[1:], truth.u[:-1], rtol=1e-12)


def test_signs_and_offsets_are_the_machines(record, truth):
    table = truth.table.copy()
    table[:, 2] *= -1
    table[:, 1:7] -= 100.0 * np.array([1, -1, 1, 1, 1, 1])
    table[:, 9] *= -1
    text = MAP.replace('unit = "mm"', 'unit = "mm"\nsign = [1, -1, 1, 1, 1, 1]\noffset = "100 mm"').replace(
        'unit = "N"', 'unit = "N"\nsign = [1, 1, -1, 1, 1, 1]'
    )
    _, rows, _ = record(table, text)
    assert_allclose(rows.q, truth.q, rtol=0, atol=1e-15)
    assert_allclose(rows.u[1:], truth.u[:-1], rtol=1e-15)


def test_a_force_that_acted_before_its_row_stays_with_it(record, truth):
    table = truth.table.copy()
    table[1:, 7:] = truth.table[:-1, 7:]
    _, rows, _ = record(table, MAP + 'acts = "before"\n')
    assert_allclose(rows.u[1:], truth.u[:-1], rtol=0, atol=0)


def test_a_torque_on_a_machine_without_screws_is_refused(record, truth):
    glide = gk.load_machine("eth-hexaglide")
    with pytest.raises(LogError, match="a torque is no force on a machine without screws"):
        record(truth.table, forces("N m"), machine=glide)


def test_a_map_with_fewer_columns_than_joints_is_refused(record, truth):
    text = MAP.replace(', "q6"', "").replace(', "u6"', "")
    with pytest.raises(LogError, match="joints.columns: okuma-pm600 has 6 joints, got 5 columns"):
        record(truth.table, text)


WRONG = [
    ('schema = "gough-log-map-1"', 'schema = "gough-log-map-2"', "map.toml:1: schema: no such schema"),
    ('unit = "mm"', 'unit = "N"', "map.toml:7: joints.unit: is not a length, got 'N'"),
    ('unit = "N"', 'unit = "A"', "map.toml:10: forces.unit: is not a force or a torque, got 'A'; give factor = "),
    ('unit = "N"', 'unit = "V"', "map.toml:10: forces.unit: is no unit that gough knows, got 'V'; give factor = "),
    ('unit = "N"', 'unit = "A"\nfactor = "3 s"', "forces.factor: is not a force or a torque, got '3 s'"),
    ('unit = "N"', 'unit = "A"\nfactor = "0 N"', "forces.factor: must not be 0"),
    ('period = "1 ms"', 'period = "1 mm"', "map.toml:4: time.period: '1 mm' is not a quantity in s"),
    ('period = "1 ms"', 'period = "0 ms"', "map.toml:4: time.period: must be above 0 s"),
    ('period = "1 ms"', 'period = "1 ms"\njitter = "0.6 ms"', "time.jitter: must be below half the period"),
    ('column = "t"', 'column = "t"\nunit = "mm"', "time.unit: is not a unit of time, got 'mm'"),
    ('"q6"', '"q5"', "joints.columns: a column is named twice, got 'q5'"),
    ('"u6"', '"q6"', "forces.columns: one column is given two meanings, got 'q6'"),
    (', "u6"', "", "forces.columns: as many forces as readings are needed, got 5 (limit 6)"),
    ('unit = "mm"', 'unit = "mm"\nsign = 2', "joints.sign: must be 1 or -1"),
    ("[forces]", '[text]\ndecimal = ","\n[forces]', "text.decimal: delimiter and decimal must differ"),
    ("[forces]", "[gaps]\nmost = 1.5\n[forces]", "gaps.most: must be below 1"),
    ("[forces]", "[force]", "no such key; did you mean forces?"),
]


@pytest.mark.parametrize(("old", "new", "message"), WRONG)
def test_a_wrong_map_is_told_with_line_and_cure(tmp_path, old, new, message):
    path = tmp_path / "map.toml"
    path.write_text(MAP.replace(old, new, 1))
    with pytest.raises(LogError) as caught:
        load_map(path)
    assert message in str(caught.value)


def test_the_template_is_a_map_as_it_stands_and_with_every_line_of_it(gough, tmp_path):
    from gough.cli.new import MAP as TEMPLATE

    done = gough("new", "map", "-o", "map.toml")
    assert done.status == 0
    found = gough("check", "map.toml", "-m", "okuma-pm600").out
    assert "map of a log, no mistakes; joints 6, period 0.001 s" in found
    told = "\n".join(
        line[2:] if line.startswith("# ") and ("=" in line or "[" in line) else line
        for line in TEMPLATE.split("\n")[1:]
    )
    (tmp_path / "all.toml").write_text(told)
    assert gough("check", "all.toml").status == 0


def test_a_wrong_map_fails_its_check_with_its_line(gough, write):
    write("map.toml", MAP.replace('unit = "mm"', 'unit = "N"'))
    done = gough("check", "map.toml")
    assert (done.status, done.err.strip()) == (
        2, "map.toml:7: joints.unit: is not a length, got 'N'; give factor = \"... mm\", what 1 N stands for",
    )  # fmt: skip
