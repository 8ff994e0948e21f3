"""How large a program is, against the box of a construction; and a program in inches."""

from __future__ import annotations

import numpy as np
import pytest

import gough as gk
from gough.plan import preflight
from gough.program.nc import NCProgram
from gough.program.size import box, sides, too_large


@pytest.fixture(scope="module")
def okuma():
    return gk.load_machine("okuma-pm600")


def nc(text: str) -> NCProgram:
    return NCProgram(text=text, name="part.ngc")


def test_the_box_of_lines_and_of_a_circle_is_that_of_their_ends_and_quarters():
    program = nc("G21 G90\nG0 X10 Y5 Z5\nG1 Z-2 F300\nG3 X10 Y5 I-30 J0\nG0 Z5\nG0 X0 Y0\nM2\n")
    assert box(program.path()) == pytest.approx(np.array([[-0.05, -0.025, -0.002], [0.01, 0.035, 0.005]]), abs=1e-12)


def test_the_box_of_an_arc_that_ends_between_quarters_is_found_within_a_part_in_ten_thousand():
    """From 30 to 150 degrees the highest place is at 90, a height of R sin 30 above both ends."""
    program = nc("G21 G90\nG0 X43.30127 Y25\nG3 X-43.30127 Y25 I-43.30127 J-25 F300\nM2\n")
    assert box(program.path())[1, 1] == pytest.approx(0.05, rel=1e-4)


def test_a_program_that_fits_is_not_called_too_large(okuma):
    assert too_large(nc("G21 G90\nG1 X100 F600\nM2\n").path(), okuma) is None


PART = "G20 G90\nG1 X-60 F60\nG1 X60 Y40\nM2\n"


def test_a_part_in_mm_read_in_inches_is_told_with_the_line_of_g20(okuma):
    space = sides(okuma.limits.workspace)
    found = preflight(okuma, nc(PART))
    assert found.size.startswith("the program is 3048 x 1016 x 0 mm large, more than the workspace of okuma-pm600, ")
    assert found.size.endswith("; line 1 says G20, inches: in mm (G21) it would fit")
    assert 0.12 < space[0] < 3.048 and str(found).split("\n")[1] == found.size
    assert found.to_json()["warnings"][0] == found.size
    assert found.findings[0].advice == "are its numbers mm? then write G21"


def test_a_part_too_large_in_mm_too_is_not_blamed_on_inches(okuma):
    large = PART.replace("X60", "X9000")
    assert too_large(nc(large).path(), okuma, large).endswith(" mm")
    assert "G20" not in preflight(okuma, nc(PART.replace("G20", "G21").replace("60", "1600"))).size
