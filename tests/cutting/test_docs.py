"""The table of docs/cutting.md is right, and what makes no chip is found.  Its Python runs in tests/text."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

PAGE = (Path(__file__).parents[2] / "docs" / "cutting.md").read_text()
EXPERIMENT = """schema = "gough-experiment-1"
[machine]
use = "okuma-pm600"
{cutting}
[program]
kind = "line"
begin = ["0 mm", "60 mm", "0 mm"]
to = ["0 mm", "-80 mm", "0 mm"]
feed = "6 m/min"
[[controller]]
kind = "pid"
bandwidth = "20 Hz"
"""


def toml() -> str:
    return EXPERIMENT.format(cutting=re.search(r"```toml\n(.*?)```", PAGE, re.S)[1])


def test_the_table_of_the_page_is_found_right(gough, write):
    done = gough("check", write("cut.toml", toml()))
    assert done.status == 0, done.err


@pytest.mark.parametrize(
    "change, message",
    [
        (('"12000 rpm"', '"0 rpm"'), "cut.toml:6: plant.cutting.spindle_speed: must be above 0 rad/s, got '0 rpm'"),
        (
            ('"6 m/min"', '"1e-7 m/min"'),
            "plant.cutting.spindle_speed: the feed makes no chip at this spindle speed, got",
        ),
        (('"18 mm"', '"0 mm"'), "cut.toml:8: plant.cutting.wall.axial_depth: must be above 0 m, got '0 mm'"),
        (("teeth = 2", "teeth = 0"), "cut.toml:7: plant.cutting.tool.teeth: must be at least 1, got 0"),
        (('"0.3 mm", "0.9 mm"', '"0 mm", "0 mm"'), "plant.cutting.wall.radial: no radial depth is above 0"),
        (('"6 m/min"', '"0 m/min"'), "program.feed: must be above 0 m/s"),
        (
            ('"40 mm", "80 mm", "120 mm"', '"1 m", "2 m", "3 m"'),
            "cut.toml:8: plant.cutting.wall.places: the wall",
        ),
        (('"A5052"', '"A5053"'), "cut.toml:5: plant.cutting.coefficients: no such material, got 'A5053'"),
    ],
)
def test_a_cut_without_a_chip_is_found_by_check(gough, write, change, message):
    done = gough("check", write("cut.toml", toml(), dict([change])))
    assert done.status == 2
    assert message in done.err
