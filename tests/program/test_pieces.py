"""The shipped NC programs are what their kinds make, machines take them, and each is what its header says."""

import re
import shutil
import subprocess
import warnings

import numpy as np
import pytest

from gough.errors import ProgramError, WorkspaceError
from gough.machine.sheet import library, load_machine
from gough.program import load_program, program_from_table
from gough.program.blocks import ARC
from gough.program.load import pieces
from gough.program.ngc.read import read_program
from gough.program.path import Path
from gough.simulate.notes import ReachWarning
from gough.simulate.reach import check_motion

from .make_pieces import RECIPES, text
from .tables import PAGE

RS274 = shutil.which("rs274")
EACH = pytest.mark.parametrize("name", RECIPES)


def test_every_recipe_is_shipped_and_nothing_else():
    assert set(pieces()) == set(RECIPES)


@EACH
def test_the_file_is_what_the_kind_makes(name):
    shipped = pieces()[name].read_text()
    assert shipped == text(name), "python -m tests.program.make_pieces writes it anew"
    assert len(shipped) < 300_000


@EACH
def test_reading_the_file_gives_the_path_of_the_kind(name):
    path, back = RECIPES[name].program.path(), Path(read_program(pieces()[name].read_text()))
    skip = len(back) - len(path)
    assert skip in (0, 1)  # the rapid to the start
    i = np.arange(len(path))
    for share in (0.0, 0.4, 1.0):
        off = back.point(i + skip, share * back.length[skip:]) - path.point(i, share * path.length)
        # six decimals of a mm: half a nm in each coordinate, twice that where an arc's centre is rounded as well
        assert np.abs(off).max() < (1e-9 if (path.kind == ARC).any() else 0.51e-9)
        turned = back.angles(i + skip, share * back.extent[skip:]) - path.angles(i, share * path.extent)
        assert np.abs(turned).max() < np.radians(0.51e-6)
    for what in ("kind", "rapid", "dwell"):
        np.testing.assert_array_equal(getattr(back, what)[skip:], getattr(path, what))
    np.testing.assert_allclose(back.tolerance[skip:], path.tolerance, atol=1e-13)
    moves = ~path.rapid & (path.length > 0)
    np.testing.assert_allclose(back.feed[skip:][moves], path.feed[moves], rtol=1e-12)
    for ours, theirs in zip(back.circles, path.circles, strict=True):
        np.testing.assert_allclose(ours.normal, theirs.normal, atol=1e-15)


@EACH
@pytest.mark.skipif(RS274 is None, reason="LinuxCNC's interpreter rs274 is not installed")
def test_linuxcnc_makes_as_many_moves_of_it(name, tmp_path):
    done = subprocess.run([RS274, "-g", pieces()[name]], cwd=tmp_path, capture_output=True, text=True, timeout=20)
    assert done.returncode == 0, done.stderr
    moves = re.findall(r"STRAIGHT_\w+\(|ARC_FEED\(", done.stdout)
    back = Path(read_program(pieces()[name].read_text()))
    assert len(moves) == (back.length > 0).sum()


@pytest.mark.quick("*-circle-diamond-square", "*-zigzag", "*-cone-frustum")
@EACH
@pytest.mark.parametrize("machine", sorted(library()))
def test_it_stays_in_the_workspace_of_the_machines_it_names_and_of_no_other(name, machine):
    believed = load_machine(machine)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ReachWarning)
        try:
            check_motion(believed, RECIPES[name].program.plan(believed), 10e-3)
            fits = not [w for w in caught if w.category is ReachWarning]
        except (ProgramError, WorkspaceError):  # it turns a tool that cannot turn, or leaves the machine
            fits = False
    assert fits == (machine in RECIPES[name].machines)
    assert fits == (
        machine
        in re.search(r"workspace of (.*)\.", pieces()[name].read_text())[1].replace(", ", " and ").split(" and ")
    )


def test_the_page_names_each_with_its_machines():
    page = PAGE.read_text()
    section = page[page.index("| name | what | fits |") : page.index("They are made of the kinds above")]
    rows = dict(re.findall(r"^\| `([\w-]+)` \| .* \| (.*) \|$", section, re.M))
    assert rows == {name: ", ".join(recipe.machines) for name, recipe in RECIPES.items()}


def test_a_piece_is_found_by_its_name_and_a_file_by_its_path(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "zigzag").write_text("G1 X10 F600\nM2\n")
    shipped = load_program("zigzag", corner="constant")
    assert shipped.text == text("zigzag")
    assert shipped.name == "zigzag.ngc"
    assert program_from_table({"file": "zigzag", "corner": "constant"}, tmp_path) == shipped
    for own in (load_program("./zigzag"), load_program(tmp_path / "zigzag"), program_from_table({"file": "./zigzag"})):
        assert own.text == "G1 X10 F600\nM2\n"


@pytest.mark.parametrize(
    "name, message",
    [
        ("zigzak", "no program of the library has this name, got 'zigzak'; did you mean zigzag?"),
        ("mine", "no program of the library has this name, got 'mine'; write ./mine for the file"),
        ("", "no program of the library has this name, got ''; there is " + ", ".join(sorted(RECIPES))),
        ("zigzag.ngc", "zigzag.ngc: cannot be read: No such file or directory"),
    ],
)
def test_a_wrong_name_is_told(name, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine").write_text("M2\n")
    with pytest.raises(ProgramError) as caught:
        load_program(name)
    assert str(caught.value) == message
