"""What the tool says of itself: errors explained, machines drawn, a law to start from, completion."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from typer.testing import CliRunner

import gough as gk
from gough.cli.app import app
from gough.cli.explain import MORE, codes
from gough.report.sketch import BLANK, DOTS, machine_figure, oblique, sketch


def gough(*arguments):
    done = CliRunner().invoke(app, [str(a) for a in arguments], standalone_mode=False)
    return done.return_value, done.output


def test_every_error_is_explained_and_nothing_else():
    assert set(MORE) == set(codes())
    assert {"WorkspaceError", "UnitError", "GoughError"} <= set(MORE)


@pytest.mark.parametrize("code", sorted(codes()))
def test_an_explanation_says_what_comes_of_it(code):
    status, said = gough("explain", code)
    assert status == 0
    assert f"exit status {codes()[code].exit_status}" in said
    assert MORE[code].split()[0] in said


def test_a_code_that_is_none_gets_the_nearest():
    status, said = gough("explain", "WorkspaceEror")
    assert status == 2 and said.endswith("did you mean WorkspaceError?\n")


def test_without_a_code_all_are_listed():
    status, said = gough("explain")
    assert status == 0 and [line.split()[0] for line in said.splitlines()] == sorted(codes())


class Cross:
    """A machine that draws itself as a cross in the plane of x and z."""

    gravity = (0, 0, -9.81)
    home = None

    def drawing(self, _):
        return [
            {"name": "a", "points": [[0, 0, 0], [0, 0, 2]]},
            {"name": "b", "points": [[-1, 0, 1], [1, 0, 1]]},
        ]


def dots(text: str) -> set[tuple[int, int]]:
    """(column, row) of every dot of a drawing."""
    found = set()
    for r, row in enumerate(text.split("\n")):
        for c, sign in enumerate(row):
            bits = ord(sign) - BLANK
            found |= {(2 * c + i, 4 * r + j) for j in range(4) for i in range(2) if bits & DOTS[j][i]}
    return found


def test_a_sketch_has_its_dots_on_the_lines_and_nowhere_else():
    found = dots(sketch(Cross(), 20, 10))
    corners = oblique(np.array([[0, 0, 0], [0, 0, 2], [-1, 0, 1], [1, 0, 1.0]]))
    low, extent = corners.min(0), np.ptp(corners, axis=0)
    scale = min(39 / extent[0], 39 / extent[1])
    high = int(np.rint(scale * extent[1])) + 1
    ends = scale * (corners - low) * [1, -1] + [0, high - 1]
    for x, y in found:
        apart = []
        for start, end in (ends[:2], ends[2:]):
            along = np.clip(np.dot([x, y] - start, end - start) / np.dot(end - start, end - start), 0, 1)
            apart.append(np.linalg.norm([x, y] - start - along * (end - start)))
        assert min(apart) < 0.75  # half a dot each way, rounded
    for end in np.rint(ends).astype(int):
        assert tuple(end) in found


@pytest.mark.parametrize("name", gk.library())
def test_every_machine_of_the_library_fits_a_terminal(name):
    machine = gk.load_machine(name)
    lines = sketch(machine).split("\n")
    assert len(lines) <= 22 and max(map(len, lines)) <= 64
    assert len(dots("\n".join(lines))) > 30


def test_the_drawing_shows_every_joint_by_its_number():
    figure = machine_figure(gk.load_machine("eth-hexaglide"))
    for ax in figure.axes:
        assert [text.get_text() for text in ax.texts] == list("123456")


def test_a_machine_is_drawn_into_a_file_once(tmp_path):
    picture = tmp_path / "m.png"
    assert gough("show", "ccu-3prs", "-o", picture) == (0, f"drawing: {picture}\n")
    assert picture.read_bytes().startswith(b"\x89PNG")
    status, said = gough("show", "ccu-3prs", "-o", picture)
    assert status == 2 and "there is a file already" in said
    status, said = gough("show", "cone-frustum", "-o", tmp_path / "p.png")
    assert status == 2 and "only machines are drawn" in said and not (tmp_path / "p.png").exists()


@pytest.mark.full
def test_the_law_to_start_from_runs_as_it_stands_and_beats_a_pid(tmp_path):
    law = tmp_path / "law.py"
    assert gough("new", "controller", "-o", law) == (0, f"{law} is written; next: python {law}\n")
    done = subprocess.run([sys.executable, law], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    mine, pid = (float(line.split()[-4]) for line in done.stdout.splitlines())
    assert mine < pid


def test_the_shell_can_be_taught_to_complete():
    status, said = gough("--help")
    assert status == 0 and "--install-completion" in said
