"""The [compensation] table: checked with its line, part of the run, and in what repeats it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gough.cli.run import _simulate
from gough.errors import ExperimentError
from gough.experiment import load_experiment
from gough.experiment.resolve import resolved

TABLE = '[compensation]\nheight = "18 mm"\nair = ["5 mm", "20 mm"]\n'
FILE = f"""schema = "gough-experiment-1"

{TABLE}
[machine]
use = "okuma-pm600"
"limits.cone" = "70 deg"

[plant.cutting]
coefficients  = "A5052"
spindle_speed = "12000 rpm"
tool = {{ diameter = "12 mm", teeth = 2, helix = "30 deg" }}
wall = {{ axial_depth = "18 mm", places = ["30 mm", "70 mm"], radial = ["0.9 mm"] }}

[program]
kind = "line"
to   = {{ unit = "mm", value = [0, -80, 0] }}
feed = "6 m/min"

[[controller]]
kind = "pid"
bandwidth = "20 Hz"

[observer]
kind = "disturbance"
bandwidth = "10 Hz"
"""
LINE = 3  # of [compensation]


def changed(tmp_path: Path, *pairs: tuple[str, str]) -> Path:
    text = FILE
    for old, new in pairs:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    path = tmp_path / "f.toml"
    path.write_text(text)
    return path


def test_air_behind_the_end_of_the_path_is_found_by_check_and_by_a_run(tmp_path, gough):
    path = changed(tmp_path, ('["5 mm", "20 mm"]', '["1 m", "2 m"]'))
    done = gough("check", path)
    assert done.status == 2
    assert "f.toml:5: compensation.air: the air cut ends behind the end of the path: the tool would" in done.err
    assert "got 2 m (limit 0.08 m); places count metres along the path" in done.err
    done = gough("run", path)
    assert done.status == 2 and "compensation.air: the air cut ends behind the end of the path" in done.err
    assert ", compensation, duration" in gough("check", changed(tmp_path)).out


def test_the_table_becomes_the_compensation_of_the_run(tmp_path):
    found = load_experiment(changed(tmp_path)).compensation
    assert found.height == pytest.approx(0.018) and found.bandwidth == 8.0
    assert found.air.tolist() == pytest.approx([0.005, 0.02])
    assert load_experiment(changed(tmp_path, (TABLE, ""))).compensation is None


@pytest.mark.parametrize(
    ("old", "new", "line", "told"),
    [
        ('height = "18 mm"', 'hight = "18 mm"', LINE + 1, "compensation.hight: no such key; did you mean height?"),
        ('height = "18 mm"', 'height = "0 mm"', LINE + 1, "compensation.height: must be above 0 m"),
        ('"20 mm"]\n', '"4 mm"]\n', LINE + 2, "compensation.air: must go from a place to one behind it"),
        ('"20 mm"]\n', '"20 N"]\n', LINE + 2, "compensation.air"),
        ('"okuma-pm600"\n"limits.cone" = "70 deg"', '"ccu-3prs"', LINE + 4, "machine: only a machine with six"),
        ('\n[observer]\nkind = "disturbance"\nbandwidth = "10 Hz"\n', "", LINE, "compensation: needs an observer of"),
    ],
)
def test_what_is_wrong_in_the_table_is_said_with_its_line(tmp_path, old, new, line, told):
    path = changed(tmp_path, (old, new))
    with pytest.raises(ExperimentError) as caught:
        load_experiment(path)
    assert any(one.startswith(f"{path}:{line}: {told}") for one in str(caught.value).splitlines()), caught.value


@pytest.mark.full
def test_a_run_leans_and_the_written_experiment_leans_alike(tmp_path):
    experiment = load_experiment(changed(tmp_path))
    (ended,) = _simulate(experiment, quiet=True, strict=False)
    tilt = ended.log["controller.tilt"]
    # 0.9 mm: the published command of this depth is 0.060 deg for 60 N; this material's force is of that size
    assert 0.02 < np.degrees(tilt.max()) < 0.2 and not tilt[ended.log["s_r"] < 0.02].any()
    folder = tmp_path / "again"
    folder.mkdir()
    for name, text in resolved(experiment).items():
        (folder / name).write_text(text)
    again = load_experiment(folder / "experiment.toml")
    assert again.compensation == experiment.compensation
    (second,) = _simulate(again, quiet=True, strict=False)
    np.testing.assert_array_equal(second.log["controller.tilt"], tilt)
