"""The whole way from text to blocks: what is told of a wrong program, budgets, progress, speed."""

import subprocess
import sys

import numpy as np
import pytest

from gough.errors import ExperimentError, ProgramError
from gough.program.blocks import Blocks
from gough.program.ngc import tip
from gough.program.ngc.read import MOST_PROBLEMS, read_program
from gough.program.ngc.tools import Tools
from gough.program.path import Path
from growth import growth

from .machine import ends, read, refused


def test_a_program_becomes_a_table_of_blocks_that_know_their_lines():
    blocks = read_program("%\n(part)\nN10 G0 X1\n\nG1 Y2 F60 ; up\n/G1 Y9\nM2\n%\n", "part.ngc")
    assert isinstance(blocks, Blocks)
    assert [b.line for b in blocks] == [3, 5]


def test_loops_conditions_and_subroutines_become_blocks():
    square = ["O<side> sub", "G91 G1 X[#1] Y[#2]", "G90", "O<side> endsub", "F600", "#5=0"]
    square += ["O10 while [#5 LT 4]", "O<side> call [COS[90*#5]*10] [SIN[90*#5]*10]", "#5=[#5+1]", "O10 endwhile"]
    assert [e[:2] for e in ends(read(*square))] == [
        pytest.approx(v, abs=1e-12) for v in [(10, 0), (10, 10), (0, 10), (0, 0)]
    ]


def test_lines_for_another_day_are_left_out_unless_asked_for():
    assert len(read("G0 X1", "/X2", "X3")) == 2
    assert len(read("G0 X1", "/X2", "X3", block_delete=False)) == 3


def test_a_path_is_made_of_any_program():
    path = Path(read("G0 X1 Z5", "M3 S9", "G18 F99 G2 X11 I5 P2 Y3", "G4 P1", "G43.1 Z3", "G1 A3", "X0", "M9"))
    assert np.isfinite(path.extent).all()


# -- what is told -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "text, message",
    [
        ("", "1: the program has no end; write M2 or M30 as its last line"),
        ("G0 X1\n\n", "1: the program has no end; write M2 or M30 as its last line"),
        ("%\nG0 X1\n", '2: the program has no end; write "%" or M2 as its last line'),
        ("%", '1: the program has no end; write "%" or M2 as its last line'),
        ("M2", "1: the program moves nothing; write a G0 or G1 with an axis word"),
        ("%\n%", "2: the program moves nothing; write a G0 or G1 with an axis word"),
        ("M3 S9\nG0\nM30\n", "3: the program moves nothing; write a G0 or G1 with an axis word"),
        ("G0 X1\nM2\nG0 X2", "3: a block behind the end of the program, got 'G0 X2'; remove it"),
    ],
)
def test_a_program_has_an_end_and_moves(text, message):
    with pytest.raises(ProgramError) as caught:
        read_program(text, "part.ngc")
    assert str(caught.value) == f"part.ngc:{message}"


def test_every_problem_of_a_file_is_told_at_once_and_none_that_follows_from_another():
    with pytest.raises(ProgramError) as caught:
        read_program("G1 X10\nG1 Y10\nG5 X3\nX1,5\nG2 X3\nG0 X[1\nG1 G[#7] X[0/0]\nM2\nG41\n", "part.ngc")
    assert [p.line for p in caught.value.problems] == [1, 3, 4, 6]
    assert {p.file for p in caught.value.problems} == {"part.ngc"}


def test_what_stands_before_the_first_mistake_is_not_told_again():
    assert refused("O<a> sub", "G1 X1", "O<a> endsub", "G0 X2", "O<a> call", "G88").split("\n") == [
        "2: G1 without a feed; write F, in mm/min, before it or with it",
        "6: not supported, got G88; write the moves of the cycle: G0 and G1",
    ]


@pytest.mark.parametrize(
    "text, last",
    [
        ("G41\n" * 50 + "M2", None),
        ("G41\n" * 51 + "M2", "part.ngc:51: from here on 1 line more is wrong"),
        ("G41\nG0 X1\n" * 1000 + "M2", "part.ngc:101: from here on 950 lines more are wrong"),
        ("G41\n" * 49 + "G42 G88\nM2", "part.ngc:50: from here on 1 line more is wrong"),  # of two words one is told
        (
            "G41\n" * 20_000,
            "part.ngc:51: from here on 10000 lines more are wrong, and there may be more; "
            "check that this is an NC program",
        ),
    ],
    ids=["fifty", "one more", "many", "in a block", "no end"],
)
def test_fifty_problems_are_told_and_the_other_lines_counted(text, last):
    with pytest.raises(ProgramError) as caught:
        read_program(text, "part.ngc")
    found = caught.value.problems
    assert len(found) == MOST_PROBLEMS + (last is not None)
    assert [str(p) for p in found[MOST_PROBLEMS:]] == ([last] if last else [])


def test_a_wrong_tool_table_is_the_experiment_s_mistake():
    with pytest.raises(ExperimentError, match="1.lenght: no such key"):
        read_program("G0 X1\nM2", tools={1: {"lenght": 0.1}})
    assert len(read_program("G0 X1\nM2", tools=Tools())) == 1


# -- budgets ----------------------------------------------------------------------------------------------------------


def test_a_program_has_a_largest_number_of_moves(monkeypatch):
    monkeypatch.setattr(tip, "MOST_MOVES", 100)
    loop = ["G91", "O1 repeat [{}]", "G0 X1", "O1 endrepeat"]
    assert len(read(*(line.format(100) for line in loop))) == 100
    assert refused(*(line.format(101) for line in loop)) == "3: a program has at most 100 moves; split it"
    assert (
        refused("G0 X1", "O1 repeat [100]", "G4 P1", "O1 endrepeat") == "3: a program has at most 100 moves; split it"
    )


@pytest.mark.parametrize(
    "lines, line",
    [
        (["G0 X1", "O1 while [1]", "O1 endwhile"], 2),
        (["G0 X1", "O1 while [1]", "G91 X1", "O1 endwhile"], 2),
        (["G0 X1", "O1 do", "O1 while [1]"], 2),
        (["G0 X1", "O1 repeat [1000000000]", "O1 endrepeat"], 2),
    ],
)
def test_a_loop_without_end_ends_with_its_budget(lines, line):
    assert refused(*lines, steps=2000).startswith(f"{line}: possible endless loop")


def test_progress_is_told():
    told = []
    read_program("G91 G0 X1\n" * 5000 + "M2\n", tell=lambda done, count: told.append((done, count)))
    assert [done for done, _ in told] == sorted(done for done, _ in told)
    assert len(told) >= 4 and all(0 < done <= count for done, count in told)


# -- speed and memory -------------------------------------------------------------------------------------------------


def surface(lines):
    return "F1000 G1\n" + "\n".join(
        f"N{i} G1 X{i % 97 * 0.125:.3f} Y-{i % 89 * 0.2:.1f} Z.{i % 10}" for i in range(lines - 2)
    ) + "\nM2\n"  # fmt: skip


@pytest.mark.full
def test_the_time_of_reading_grows_with_the_lines():
    assert (
        growth(surface, read_program, 2000) < 2
    )  # 2: caches and the garbage collector's passes; anything quadratic would be 8


@pytest.mark.slow
def test_100_000_lines_take_little_memory(tmp_path):
    file = tmp_path / "surface.ngc"
    file.write_text(surface(100_000))
    script = (
        "import sys\nfrom gough.program.ngc.read import read_program\n"
        "def peak():\n"
        "    return next(int(line.split()[1]) for line in open('/proc/self/status') if line.startswith('VmHWM'))\n"
        "read_program('G0 X1\\nM2')\nbefore = peak()\n"
        "text = open(sys.argv[1]).read()\nblocks = read_program(text)\nassert len(blocks) == 99_997, len(blocks)\n"
        "print(peak() - before)\n"
    )
    out = subprocess.run([sys.executable, "-c", script, file], capture_output=True, text=True, timeout=60, check=True)
    assert int(out.stdout) < 100_000  # kB


@pytest.mark.slow
def test_a_million_blocks_are_refused():
    text = refused("G91", "O1 repeat [2000000]", "G0 X0.001", "O1 endrepeat", steps=10_000_000)
    assert text == "3: a program has at most 1000000 moves; split it"
