"""Every bad program has its message, word for word; LinuxCNC refuses it too, or docs/nc-differences.md says why not."""

import subprocess

import pytest

from gough.errors import ProgramError
from gough.program.ngc.read import read_program
from gough.program.path import Path

from .oracle.cases import FILE, cases
from .oracle.generate import TOOLS
from .oracle.linuxcnc import missing, read_printed

CASES = cases()
TABLE = {n: {"x": x / 1e3, "y": y / 1e3, "length": z / 1e3} for n, x, y, z in TOOLS}
STEPS = 20_000  # the budget the messages of endless loops name


def message(case) -> str:
    """What we say to it; nothing if we accept it."""
    try:
        Path(read_program(case.text, FILE, tools=TABLE, steps=STEPS))
    except ProgramError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("case", CASES, ids=str)
def test_a_bad_program_is_refused_with_this_message(case):
    assert case.message, "a bad program has a message"
    assert message(case) == case.message


def test_there_are_enough_bad_programs_and_no_two_are_the_same():
    assert len(CASES) >= 150
    assert len({case.text for case in CASES}) == len(CASES)
    assert len({str(case) for case in CASES}) == len(CASES)


@pytest.mark.full
def test_linuxcnc_refuses_the_bad_programs_too_or_the_difference_is_listed(tmp_path):
    if missing():
        pytest.skip(missing())
    other = []
    for case in CASES:
        try:
            refused = read_printed(case.text, tmp_path, TOOLS, timeout=1).error is not None
        except subprocess.TimeoutExpired:
            refused = False
        if refused != (case.difference is None):
            other.append(f"{case}: LinuxCNC {'refuses' if refused else 'accepts'} it, listed as {case.difference}")
    assert not other, "\n".join(other)
