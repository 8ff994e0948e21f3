"""gough preflight: exit status, JSON, files, and what it refuses."""

from __future__ import annotations

import csv
import json
import subprocess
import sys

import pytest

from gough.cli.end import Outcome
from gough.cli.preflight import Asked, preflight_file
from gough.errors import ExperimentError, SheetError, WorkspaceError

FAST = "G21 G90\nG1 X200 F40000\nX0\nM2\n"
GOOD = "G21 G90\nG1 X20 F500\nX0\nM2\n"
MACHINE = "nist-octahedral"


@pytest.fixture
def part(tmp_path):
    def write(text, name="part.ngc"):
        (tmp_path / name).write_text(text)
        return tmp_path / name

    return write


def ask(file, machine=MACHINE, **asked):
    outcome = Outcome("preflight", True)
    preflight_file(file, machine, Asked(**asked), True, outcome)
    return outcome.data


@pytest.mark.full
def test_exit_status_and_json_of_the_command(part, tmp_path):
    def run(*arguments):
        done = subprocess.run(
            [sys.executable, "-m", "gough", "preflight", *map(str, arguments)], capture_output=True, text=True
        )
        return done.returncode, done.stdout, done.stderr

    status, text, _ = run(part(GOOD), "-m", MACHINE)
    assert status == 0 and "no limit is exceeded; nearest to one:" in text
    status, text, _ = run(part(FAST), "-m", MACHINE, "--json")
    told = json.loads(text)
    assert status == 1 and told["schema"] == "gough-preflight-1" and told["status"] == "failed"
    assert told["error"]["problems"][0]["line"] in (2, 3) and told["exceeded"] == len(told["findings"])
    assert run(part(GOOD), "-m", "no-such-machine")[0] == 2
    status, text, error = run(part(GOOD))
    assert status == 2 and error.startswith("--machine: is missing; give one of")
    status, _, error = run(part(FAST), "-m", MACHINE, "--quiet")
    assert status == 1 and "limits exceeded" in error


def test_a_folder_gets_the_whole_verdict_and_every_line(part, tmp_path):
    data = ask(part(FAST), out=tmp_path / "out")
    assert data["status"] == "failed" and data["folder"] == str(tmp_path / "out")
    assert json.loads((tmp_path / "out" / "preflight.json").read_text())["passed"] is False
    rows = list(csv.DictReader((tmp_path / "out" / "lines.csv").open()))
    assert [row["line"] for row in rows] == ["2", "3"] and all(float(row["use"]) > 1 for row in rows)
    assert (tmp_path / "out" / "preflight.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(ExperimentError, match="holds files that gough did not make"):
        ask(part(FAST), out=tmp_path, fix=tmp_path / "fixed.ngc")
    assert not (tmp_path / "fixed.ngc").exists()


def test_a_fixed_program_is_written_and_the_original_is_as_it_was(part, tmp_path):
    file = part(FAST)
    data = ask(file, fix=tmp_path / "fixed.ngc")
    assert data["status"] == "done" and data["passed"] and data["fixed"]["lines"][0]["was"] == "G1 X200 F40000"
    assert file.read_text() == FAST and "; was: G1 X200 F40000" in (tmp_path / "fixed.ngc").read_text()
    assert ask(tmp_path / "fixed.ngc")["passed"]


@pytest.mark.full
def test_the_original_is_never_overwritten_whatever_it_is_called(part, tmp_path):
    file = part(FAST)
    (tmp_path / "link.ngc").symlink_to(file)
    (tmp_path / "hard.ngc").hardlink_to(file)
    (tmp_path / "sub").mkdir()
    for name in ("part.ngc", "sub/../part.ngc", "link.ngc", "hard.ngc"):
        for force in (False, True):
            with pytest.raises(ExperimentError, match="would overwrite the original program"):
                ask(file, fix=tmp_path / name, force=force)
    assert file.read_text() == FAST
    experiment = tmp_path / "part.toml"
    experiment.write_text(
        'schema = "gough-experiment-1"\n[machine]\nuse = "nist-octahedral"\n[program]\nfile = "part.ngc"\n'
        '[[controller]]\nkind = "computed_torque"\nbandwidth = "12 Hz"\n'
    )
    with pytest.raises(ExperimentError, match="would overwrite the original program"):
        ask(experiment, None, fix=file, force=True)
    assert ask(experiment, None)["status"] == "failed"


def test_a_file_that_is_there_is_kept_without_force(part, tmp_path):
    other = part("(mine)\n", "other.ngc")
    with pytest.raises(ExperimentError, match="there is a file already"):
        ask(part(FAST), fix=other)
    assert other.read_text() == "(mine)\n"
    assert ask(part(FAST), fix=other, force=True)["passed"] and other.read_text() != "(mine)\n"


def test_nothing_is_written_where_no_feed_helps(part, tmp_path):
    with pytest.raises(WorkspaceError, match="too long"):
        ask(part("G21 G90\nG1 X900 F40000\nM2\n"), fix=tmp_path / "fixed.ngc")
    bare = tmp_path / "bare.toml"
    from gough.machine.sheet import find

    text = find("emps").read_text().splitlines()
    bare.write_text("\n".join(
        line for line in text if not line.startswith(("speed ", "acceleration = \"3", '"limits.speed', '"limits.acc'))
    ))  # fmt: skip
    with pytest.raises(SheetError, match="has no limit of its joints' speed, acceleration or force"):
        ask(part("G21 G90\nG1 X200 F40000\nM2\n"), str(bare), fix=tmp_path / "fixed.ngc")
    assert not (tmp_path / "fixed.ngc").exists()


@pytest.mark.parametrize(
    "asked, rule",
    [
        ({"planner": "linuxcnc"}, "--planner: no such planner, got linuxcnc; write cartesian or joints"),
        ({"turn": True}, "--turn: is for --place; add --place"),
        ({"planner": "joints", "place": True}, "--place: is for the cartesian planner"),
    ],
)
def test_options_that_do_not_go_together_are_told(part, asked, rule):
    with pytest.raises(ExperimentError) as told:
        ask(part(GOOD), **asked)
    assert str(told.value).startswith(rule)


def test_what_is_no_program_is_told(part):
    with pytest.raises(ExperimentError, match="is no program; give an NC program"):
        ask(part("x", "part.txt"))


@pytest.mark.full
def test_place_and_feeds_together(part, tmp_path):
    """A program that fits nowhere at its feeds has a place, and feeds for that place."""
    data = ask(part(FAST), place=True, fix=tmp_path / "fixed.ngc")
    assert data["passed"] and data["place"]["margin"] > data["place"]["before"]
    assert data["place"]["table"].startswith("origin = [") and data["place"]["words"].startswith("G10 L2 P1 X")
    with pytest.raises(WorkspaceError, match="no place in the workspace"):
        ask(part(FAST), place=True)
