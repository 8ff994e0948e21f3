"""docs/nc-differences.md says what is so: every program of its tables does on both sides what the table says."""

import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from gough.errors import ProgramError
from gough.program.ngc.read import read_program

from .oracle.cases import cases
from .oracle.compare import of_blocks
from .oracle.generate import TOOLS
from .oracle.linuxcnc import missing, read_printed

PAGE = Path(__file__).parents[2] / "docs" / "nc-differences.md"
TABLE = {n: {"x": x / 1e3, "y": y / 1e3, "length": z / 1e3} for n, x, y, z in TOOLS}


def rows():
    """name: program, what LinuxCNC does, what gough does."""
    out = {}
    for line in PAGE.read_text().splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) == 5 and "`" in cells[1]:
            name, program, theirs, ours, why = cells
            assert name not in out
            assert why
            out[name] = ("\n".join(re.findall(r"`([^`]*)`", program)) + "\nM2\n", theirs, ours)
    return out


ROWS = rows()


def does(said: str, moves) -> str:
    """What a program did, in the words of `said`: the kind of answer asked for."""
    last = next((m for m in reversed(moves) if m.kind not in ("stop", "dwell")), None)
    kind = said.rpartition(" it")[0] or re.match(r"[a-z ]*?(?= -?\d|$)", said)[0]
    told = {
        "ends at": lambda: last.end[:3],
        "center": lambda: last.center,
        "feeds at": lambda: [last.feed],
    }.get(kind)
    return f"{kind} " + " ".join(f"{np.round(v, 6) + 0.0:g}" for v in told()) if told else "reads it"


@pytest.mark.parametrize("name", ROWS)
def test_gough_does_what_the_page_says(name):
    text, _, said = ROWS[name]
    try:
        done = does(said, of_blocks(read_program(text, tools=TABLE, steps=1000)))
    except ProgramError:
        done = "refuses it"
    assert done == said


@pytest.mark.parametrize("name", ROWS)
def test_linuxcnc_does_what_the_page_says(name, tmp_path):
    if missing():
        pytest.skip(missing())
    text, said, _ = ROWS[name]
    try:
        read = read_printed(text, tmp_path, TOOLS, timeout=1)
        done = "refuses it" if read.error else does(said, read.moves)
    except subprocess.TimeoutExpired:
        done = "never ends"
    assert done == said


def test_every_row_is_a_difference():
    assert not [name for name, (_, theirs, ours) in ROWS.items() if theirs == ours]


def test_every_difference_of_the_bad_programs_has_its_row():
    assert {case.difference for case in cases()} - {None} <= set(ROWS)
