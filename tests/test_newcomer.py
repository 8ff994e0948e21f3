"""What somebody meets who describes a machine and a part for the first time."""

from __future__ import annotations

import inspect
import re

import pytest

import gough as gk
from gough.cli import app

NC = "G21 G90\nG1 X10 F3000\nG1 X0\nM2\n"


@pytest.fixture
def sheet(gough, tmp_path):
    """Writes the sheet that `gough new machine` gives, with changes; returns its name."""

    def file(name: str = "mine.toml", **changes: tuple[str, str]) -> str:
        gough("new", "machine", "-o", name)
        text = (tmp_path / name).read_text()
        for old, new in changes.values():
            assert text.count(old) == 1, old
            text = text.replace(old, new)
        (tmp_path / name).write_text(text)
        return name

    return file


def test_check_says_what_a_machine_is_at_home(gough, sheet):
    ended = gough("check", sheet())
    line = ended.out.split("\n")[1]
    assert re.fullmatch(
        r"at home: struts at 0\.\d+ m of 0\.7 to 1\.15 m, condition number [\d.]+, its weight takes [\d.]+ % of the "
        "drives' force", line,
    ), line  # fmt: skip
    assert not ended.err
    told = gough("check", "mine.toml", "--json").json["home"]
    assert len(told["joints"]) == 6 and told["remarks"] == [] and 0 < told["load"] < 1 < told["condition"]


EXCHANGED = """    [0.1262, 0.1802, 0.25],
    [-0.1262, 0.1802, 0.25],
"""


RUN = ("run", "part.ngc", "-m", "mine.toml", "-c", "pid")


@pytest.mark.parametrize("command", [("check", "mine.toml"), pytest.param(RUN, marks=pytest.mark.full)])
def test_rows_in_another_order_are_warned_of_by_check_and_by_run(gough, sheet, write, command):
    rows = EXCHANGED.splitlines(keepends=True)
    sheet(rows=("".join(rows[::-1]), EXCHANGED))
    write("part.ngc", NC)
    assert gough(*command).err.count("warning: struts 1 and 2 cross at home; ") == 1


def test_a_machine_that_its_drives_cannot_hold_is_warned_of(gough, sheet):
    ended = gough("check", sheet(mass=('"120 kg"', '"120e3 kg"')))
    assert ended.status == 0 and "cannot hold the machine at home" in ended.err


def test_the_mistakes_of_a_file_are_told_from_its_top(gough, sheet):
    sheet(
        a=('"120 kg"', "120"), b=('lead         = "20 mm"', "lead = 20"), c=('encoder      = "0.5 um"', "encoder = 1")
    )
    places = [line.split(":")[1] for line in gough("check", "mine.toml").err.splitlines()]
    assert len(places) == 3 and places == sorted(places, key=int)


def test_a_data_sheet_in_the_place_of_an_experiment_is_one_mistake(gough, sheet):
    ended = gough("run", sheet())
    assert ended.status == 2 and ended.err.count("\n") == 1
    assert ended.err.endswith("not an experiment; give it to a program: gough run part.ngc -m mine.toml\n")


def test_check_says_how_large_a_program_is(gough, write):
    write("part.ngc", "G21 G90\nG1 X30 Y-20 F600\nZ-2\nM2\n")
    assert gough("check", "part.ngc").out.endswith("from home X 0 to 30, Y -20 to 0, Z -2 to 0 mm\n")


def test_no_help_holds_a_word_in_brackets_that_its_printer_would_swallow():
    """rich takes [word] for markup; "[default: ...]" is none."""
    assert not re.findall(r'(?:help=|""").*\[[a-z_]+\]', inspect.getsource(app).partition("import typer")[2])


def test_a_payload_of_nothing_is_the_machine_without_payload():
    machine = gk.load_machine("okuma-pm600")
    assert gk.Plant(machine=machine, payload=0.0).true_machine == gk.Plant(machine=machine).true_machine
