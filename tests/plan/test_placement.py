"""The place of the work, against a search by brute force and against what the whole preflight says there."""

from __future__ import annotations

import numpy as np
import pytest

import gough as gk
from gough.errors import ExperimentError, WorkspaceError
from gough.plan import place, preflight
from gough.program.nc import NCProgram

PART = "G21 G90\nG1 X120 F5000\nG3 X120 Y0 I-60 J0\nG1 Z-60\nX0 Y80\nM2\n"


def nc(text: str, **more) -> NCProgram:
    return NCProgram(text=text, name="part.ngc", **more)


@pytest.fixture(scope="module")
def machine():
    return gk.load_machine("nist-octahedral")


@pytest.fixture(scope="module")
def placed(machine):
    return place(machine, nc(PART))


@pytest.mark.full
def test_no_place_of_a_grid_is_better(machine, placed):
    best = max(
        preflight(machine, nc(PART, origin=[x, y, z, 0, 0, 0])).least
        for x in np.linspace(-0.12, 0.12, 5)
        for y in np.linspace(-0.12, 0.12, 5)
        for z in np.linspace(-0.06, 0.06, 5)
    )
    assert placed.margin >= best
    assert placed.margin > placed.before


@pytest.mark.full
def test_no_small_step_from_the_place_is_better(machine, placed):
    """0.2 mm any way gains less than a ten-thousandth of a margin: it is a maximum, to what the search resolves."""
    rng = np.random.default_rng(0)
    for step in rng.normal(size=(20, 3)):
        moved = placed.origin.copy()
        moved[:3] += 2e-4 * step / np.linalg.norm(step)
        assert preflight(machine, nc(PART, origin=moved)).least <= placed.margin + 1e-4


@pytest.mark.full
def test_the_preflight_at_the_place_finds_the_margin_that_was_told(machine, placed):
    found = preflight(machine, nc(PART, origin=placed.origin))
    assert found.passed and found.least == pytest.approx(placed.margin, abs=1e-5)
    # several limits bind alike at the best place: the one that was told is among them
    binding = [(one.joint, one.what) for one in found.peaks if one.use > found.peaks[0].use - 1e-4]
    assert (placed.joint, placed.what) in binding and len(binding) == 4


@pytest.mark.full
def test_origin_and_g10_say_the_same_place(machine):
    """A program whose G54 is set by the words is where the origin puts it, turned about Z as well."""
    found = place(machine, nc(PART), turn=True)
    words = found.words(machine)
    assert words.startswith("G10 L2 P1 X")
    by_words = nc(f"{words}\nG54 G0 X0 Y0 Z0\n{PART}").plan(machine).path
    by_origin = nc(PART, origin=found.origin).plan(machine).path
    k, n = np.arange(len(by_origin)), len(by_words) - len(by_origin)
    np.testing.assert_allclose(
        by_words.point(k + n, by_words.length[k + n]), by_origin.point(k, by_origin.length), atol=2e-6
    )  # words are micrometres and 1e-4 deg
    assert found.table.startswith('origin = ["') and found.table.count('"') == 12


@pytest.mark.full
def test_a_part_that_fits_nowhere_is_told_with_the_limit_that_binds(machine):
    with pytest.raises(WorkspaceError) as told:
        place(machine, nc("G21 G90\nG1 X900 F3000\nX0\nM2\n"))
    (problem,) = told.value.problems
    assert problem.rule.startswith(
        "no place in the workspace keeps the program within the limits; at the best one strut"
    )
    low, high = machine.limits.length
    assert problem.line == 2 and not low <= float(problem.value.split()[0]) <= high


@pytest.mark.full
def test_a_program_that_leaves_the_workspace_is_put_back_into_it(machine):
    program = nc("G21 G90\nG1 X650 F3000\nX500 Y30\nM2\n", origin=[0.35, 0.35, 0, 0, 0, 0])
    assert not preflight(machine, program).passed
    found = place(machine, program)
    assert found.margin > 0 > found.before and found.preflight.passed


@pytest.mark.full
def test_one_axis_has_a_place_and_no_angle():
    machine = gk.load_machine("emps")
    program = nc("G21 G90\nG1 X200 F5000\nX0\nM2\n")
    found = place(machine, program)
    # equally far from both ends, each by its margin at home: (o + 0.05) / 0.05 = (0.35 - o - 0.2) / 0.35 or its speed
    assert found.margin > found.before - 1e-9 and np.abs(found.origin[1:]).max() == 0
    with pytest.raises(ExperimentError, match="one axis cannot be turned"):
        place(machine, program, turn=True)
