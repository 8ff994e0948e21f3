"""The NC subset: what programs do, and every error with its text."""

import math
from pathlib import Path as FilePath

import numpy as np
import pytest

from gough.errors import ProgramError
from gough.program import CircleDiamondSquare, NCProgram, load_program
from gough.program.blocks import ARC, REST
from gough.program.gcode import _GROUPS, MOST_PROBLEMS, read_gcode
from gough.program.lexer import words
from gough.program.path import Path
from gough.program.write import to_gcode

EXAMPLE = FilePath(__file__).parents[2] / "examples" / "circle_diamond_square.ngc"
KNOWN = "this reader knows G0-G3, G17, G20, G21, G90, G91, M2, M30 and X Y Z A B C I J R F N"


def path_of(*lines):
    return Path(read_gcode("\n".join([*lines, "M2"])))


def ends(path):
    """x y z in mm and a b c in degrees at the end of each block."""
    i = np.arange(len(path))
    return np.column_stack([1e3 * path.point(i, path.length), np.degrees(path.angles(i, path.extent))])


@pytest.mark.parametrize(
    "lines, last",
    [
        (["G0 X10 Y20 Z30"], (10, 20, 30, 0, 0, 0)),
        (["G1 X10 F100", "Y20", "Z30"], (10, 20, 30, 0, 0, 0)),  # G1 goes on
        (["G91", "G0 X10", "X10 Y5"], (20, 5, 0, 0, 0, 0)),
        (["G91 G0 X10", "G90 X3"], (3, 0, 0, 0, 0, 0)),
        (["G20", "G0 X1 Y2"], (25.4, 50.8, 0, 0, 0, 0)),
        (["G20", "G0 X1", "G21", "Y1"], (25.4, 1, 0, 0, 0, 0)),
        (["G0 X1 A10 B-20 C30"], (1, 0, 0, 10, -20, 30)),
        (["G0 A10", "G91 A10 C5"], (0, 0, 0, 20, 0, 5)),
        (["G20", "G0 X1 A10"], (25.4, 0, 0, 10, 0, 0)),  # degrees are degrees in inch programs
        (["g0x10y20"], (10, 20, 0, 0, 0, 0)),
        (["N10 G00 X +.5 Y-1. (to the left) Z2 ; done"], (0.5, -1, 2, 0, 0, 0)),
        (["G17 G21 G90 G0 X1"], (1, 0, 0, 0, 0, 0)),
        (["G1 X10 F100", "X10"], (10, 0, 0, 0, 0, 0)),  # it is there already
        (["(MSG, load the stock)", "(print this first)", "G0 X1"], (1, 0, 0, 0, 0, 0)),
        (["G0 X1\r", "\tY2\r"], (1, 2, 0, 0, 0, 0)),
        (["G0 X1 (Fr\u00e4sen)"], (1, 0, 0, 0, 0, 0)),
        (["G2 X20 Y0 I10 J0 F100"], (20, 0, 0, 0, 0, 0)),
        (["G2 X20 R10 Z3 B5 F100"], (20, 0, 3, 0, 5, 0)),
    ],
)
def test_a_program_ends_where_its_words_say(lines, last):
    np.testing.assert_allclose(ends(path_of(*lines))[-1], last, atol=1e-12)


@pytest.mark.parametrize(
    "lines, center, sweep",
    [
        (["G2 X20 I10 J0 F9"], (10, 0), -180),
        (["G3 X20 I10 J0 F9"], (10, 0), 180),
        (["G3 X10 Y10 I0 J10 F9"], (0, 10), 90),
        (["G2 X10 Y10 I0 J10 F9"], (0, 10), -270),
        (["G2 X0 Y0 I0 J10 F9"], (0, 10), -360),
        (["G3 X10 Y10 R10 F9"], (0, 10), 90),
        (["G2 X10 Y10 R10 F9"], (10, 0), -90),
        (["G3 X10 Y10 R-10 F9"], (10, 0), 270),
        (["G2 X10 Y10 R-10 F9"], (0, 10), -270),
        (["G3 X20 R10 F9"], (10, 0), 180),
        (["G3 X20 R9.999 F9"], (10, 0), 180),  # 1 um too small, LinuxCNC allows 1.27
        (["G20", "G3 X1 Y1 J1 F9"], (0, 25.4), 90),
        (["G0 X5 Y5", "G91 G3 X10 Y10 J10 F9"], (5, 15), 90),
    ],
)
def test_an_arc_has_the_centre_and_the_sense_of_its_words(lines, center, sweep):
    path = path_of(*lines)
    arcs = path.batches[ARC]
    np.testing.assert_allclose(1e3 * arcs.center[-1][:2], center, atol=1e-9)
    assert np.degrees(arcs.sweep[-1]) * arcs.normal[-1][2] == pytest.approx(sweep, abs=1e-9)


def test_a_helix_rises_in_proportion_to_its_angle():
    path = path_of("G0 X10", "G2 X10 Y0 Z-4 I-10 J0 F600")
    quarter = path.point(np.array([1]), path.length[1:] / 4)[0]
    np.testing.assert_allclose(1e3 * quarter, [0, -10, -1], atol=1e-12)  # clockwise seen from above


def test_an_arc_rounded_by_the_cam_system_ends_on_its_end():
    """The centre is 5 um off, as three decimals leave it; the arc is a true one through both ends."""
    path = path_of("G0 X20", "G3 X14.142 Y14.142 I-20.005 J0 F100", "G1 X0 Y0")
    np.testing.assert_array_equal(path.kind, [0, ARC, 0])
    np.testing.assert_allclose(ends(path)[1, :2], [14.142, 14.142], atol=1e-12)
    np.testing.assert_allclose(1e3 * path.batches[ARC].center[0], [0, 0, 0], atol=0.01)


def test_a_full_circle_that_misses_its_start_by_rounding_keeps_its_centre():
    path = path_of("G0 X10", "G3 X10.001 Y0 I-10 J0 F100", "G1 X0")
    np.testing.assert_allclose(1e3 * path.batches[ARC].center[0], 0, atol=1e-12)
    np.testing.assert_allclose(ends(path)[1:3], [[10, 0, 0, 0, 0, 0], [10.001, 0, 0, 0, 0, 0]], atol=1e-12)
    assert np.degrees(path.batches[ARC].sweep[0]) == pytest.approx(360, abs=1e-9)


@pytest.mark.parametrize(
    "lines, feed",
    [
        (["G1 X10 F600"], 0.01),
        (["G20", "G1 X10 F60"], 0.0254),
        (["G1 A10 F600"], np.radians(10)),
        (["G20", "G1 A10 F600"], np.radians(10)),  # degrees a minute, whatever the unit of length
        (["G1 X10 A10 F600"], 0.01),  # along the path of the tip
        (["F600", "G20", "G1 X1"], 0.01),  # F is a speed; it stays when the unit changes
        (["G21 G1 X10 F600"], 0.01),  # no change of unit
    ],
)
def test_feed_is_read_in_the_unit_in_force(lines, feed):
    path = path_of(*lines)
    assert path.feed[-1] == pytest.approx(feed, rel=1e-14)


def test_rapids_and_turns_at_rest_are_known_as_such():
    path = path_of("G0 X10", "G1 A5 F100", "G1 X20", "G0 B5")
    np.testing.assert_array_equal(path.rapid, [True, False, False, True])
    np.testing.assert_array_equal(path.kind == REST, [False, True, False, True])
    np.testing.assert_array_equal(path.line, [1, 2, 3, 4])


def test_percent_ends_what_percent_began():
    assert len(Path(read_gcode("%\nG0 X1\n%\n"))) == 1
    assert len(Path(read_gcode("\n %\nG0 X1\nM30\n%\n"))) == 1


ERRORS = [
    ("G1 X10", "1: G1 without a feed; write F, in mm/min, before it or with it"),
    ("G2 X10 R5", "1: G2 without a feed; write F, in mm/min, before it or with it"),
    ("F0", "1: the feed must be above 0, got F0; write F in mm/min, e.g. F1000"),
    ("G0 X1\nF-100", "2: the feed must be above 0, got F-100; write F in mm/min, e.g. F1000"),
    ("X10", "1: an axis word before any G0, G1, G2 or G3, got X10; write e.g. G0 or G1"),
    ("I10", "1: an axis word before any G0, G1, G2 or G3, got I10; write e.g. G0 or G1"),
    ("G1 X10 I5 F100", "1: I belongs to an arc, got I5; write G2 or G3"),
    ("G0 X10 R5", "1: R belongs to an arc, got R5; write G2 or G3"),
    ("G2 X10 F100", "1: an arc without a centre; write I and J, or R"),
    ("G2 F100", "1: an arc without an end; write X and Y, and I and J or R"),
    ("G2 Z5 R10 F100", "1: an arc without an end; write X or Y"),
    ("G2 X10 I5 R5 F100", "1: an arc has R, or I and J, not both, got R5; remove one"),
    ("G2 X10 I0 J0 F100", "1: an arc of radius zero, got 0.0000 mm; check I and J"),
    ("G2 X5 I5 F100", "1: an arc of radius zero, got 0.0000 mm; check I and J"),
    (
        "G2 X21 I10 F100",
        "1: the ends of an arc must lie on one circle, got radius 10.0000 mm at the start, 11.0000 mm at the end; "
        "check X, Y, I and J; I and J count from the start of the arc",
    ),
    ("G2 X10 R4 F100", "1: the radius is too small to reach the end, got 4.0000 mm; at least 5.0000 mm"),
    ("G2 X10 R0 F100", "1: the radius is too small to reach the end, got 0.0000 mm; at least 5.0000 mm"),
    ("G2 X0 Y0 R4 F100", "1: an arc with R cannot end where it starts; write a full circle with I and J"),
    ("G2 X10 I5 K1 F100", "1: not in the subset, got K1; remove it: arcs take I and J, helices Z as well"),
    ("G2 X10 I5 P2 F100", "1: not in the subset, got P2; write one block for each turn"),
    ("G0 G1 X10 F100", "1: two words of one kind in a block, got G0 G1; write them in two blocks"),
    ("G20 G21", "1: two words of one kind in a block, got G20 G21; write them in two blocks"),
    ("G90 G91", "1: two words of one kind in a block, got G90 G91; write them in two blocks"),
    ("G1 G1 X1 F1", "1: two words of one kind in a block, got G1 G1; write them in two blocks"),
    ("G0 X10 X20", "1: X twice in a block, got X10 X20; write it once"),
    ("G1 X10 F100 F200", "1: F twice in a block, got F100 F200; write it once"),
    ("G20 G1 X1 F10", "1: F in the block that changes the unit can be read in either, got G20 F10; "
                      "write G20 in a block before it"),
    ("G18", "1: not in the subset, got G18; arcs run in the XY plane"),
    ("G19", "1: not in the subset, got G19; arcs run in the XY plane"),
    ("G4", "1: not in the subset, got G4; remove it: a program does not dwell"),
    ("G28", "1: not in the subset, got G28; write the move: G0 and where it goes in X Y Z A B C"),
    ("G30.1", "1: not in the subset, got G30.1; remove it: no place is stored"),
    ("G41", "1: not in the subset, got G41; offset the path in CAM"),
    ("G42.1", "1: not in the subset, got G42.1; offset the path in CAM"),
    ("G53 G0 X1", "1: not in the subset, got G53; remove it, and write the place in the program's frame"),
    ("G95", "1: not in the subset, got G95; write F in mm/min: the feed times the turns a minute"),
    ("G83", "1: not in the subset, got G83; write the moves of the cycle: G0 and G1"),
    ("M7", "1: not in the subset, got M7; remove it: coolant is not simulated"),
    ("M98", "1: not in the subset, got M98; write out the blocks of the subprogram"),
    ("M99", "1: not in the subset, got M99; remove it, or write M2 if the program ends here"),
    ("H1", "1: not in the subset, got H1; remove it: the tool is that of the data sheet"),
    ("D1", "1: not in the subset, got D1; remove it: offset the path in CAM"),
    ("L3", "1: not in the subset, got L3; remove it, and write the block as often as it runs"),
    ("Q1", "1: not in the subset, got Q1; remove it, with the cycle it belongs to"),
    ("G0 X1 E2", "1: not in the subset, got E2; remove it: nothing is extruded"),
    ("G54", "1: not in the subset, got G54; remove it: zero is the machine's home, or `origin` of the experiment"),
    ("G43", "1: not in the subset, got G43; remove it: the tool is that of the data sheet"),
    ("G61", '1: not in the subset, got G61; remove it: the option corner = "stop" is this'),
    ("G64", '1: not in the subset, got G64; remove it: see the option corner = "constant"'),
    ("G90.1", "1: not in the subset, got G90.1; write I and J from the start of the arc"),
    ("G91.1", "1: not in the subset, got G91.1; remove it: I and J count from the start of the arc"),
    ("G93", "1: not in the subset, got G93; write F in mm/min"),
    ("G94", "1: not in the subset, got G94; remove it: F is mm/min"),
    ("G1.5 X1", f"1: not in the subset, got G1.5; {KNOWN}"),
    ("G-1", f"1: not in the subset, got G-1; {KNOWN}"),
    ("M3", "1: not in the subset, got M3; remove it: the spindle is not simulated"),
    ("M6", "1: not in the subset, got M6; remove it: the tool is that of the data sheet"),
    ("M8", "1: not in the subset, got M8; remove it: coolant is not simulated"),
    ("M0", "1: not in the subset, got M0; remove it: a program does not wait"),
    ("S8000", "1: not in the subset, got S8000; remove it: the spindle is not simulated"),
    ("T1", "1: not in the subset, got T1; remove it: the tool is that of the data sheet"),
    ("G0 U1", f"1: not in the subset, got U1; {KNOWN}"),
    ("/G0 X1", "1: block delete is not in the subset, got '/G0 X1'; remove the \"/\", or the line"),
    ("o100 sub", "1: O words (subroutines, conditions, loops) are not in the subset, got 'o100 sub'; "
                 "write out the blocks that it runs"),
    ("O1001 (PART)", "1: a program number is not in the subset, got 'O1001'; remove it: programs have no number"),
    (" o 7 ; PART", "1: a program number is not in the subset, got 'o 7'; remove it: programs have no number"),
    ("G0 X1O", "1: a letter O in a number, got 'X1O'; did you mean zero?"),
    ("GO X1", "1: a letter O in a number, got 'GO X1'; did you mean zero?"),
    ("G0 Xo.5", "1: a letter O in a number, got 'Xo.5'; did you mean zero?"),
    ("G1 X1 F2000000", "1: F is beyond 1000000, got '2000000'; F is mm/min: write at most 1000000"),
    ("G0 X#1", "1: parameters and expressions are not in the subset, got 'X#1'; write the number"),
    ("G0 X[1+2]", "1: parameters and expressions are not in the subset, got 'X[1+2]'; write the number"),
    ("#1=5", "1: parameters and expressions are not in the subset, got '#1=5'; write the number"),
    ("G0 X", "1: X has no number, got 'X'; write e.g. X10"),
    ("G0 XNAN", "1: X has no number, got 'XNAN'; write e.g. X10"),
    ("G0 Xinf", "1: X has no number, got 'Xinf'; write e.g. X10"),
    ("G0 X1E400", "1: a number has no exponent, got 'X1E400'; write all its digits"),
    ("G0 X1e-3", "1: a number has no exponent, got 'X1e-3'; write all its digits"),
    ("G0 X1.2.3", "1: a number has one point at most, got 'X1.2.3'; remove one"),
    ("G0 X1,5", "1: a number has a point, not a comma, got 'X1,5'; write a point"),
    ("G0 X1 5", "1: a number without a letter, got '5'"),
    ("G0 X--1", "1: X has no number, got 'X--1'; write e.g. X10"),
    ("G0 X1000001", "1: X is beyond 1000000, got '1000001'; write at most 1000000"),
    ("G0 X" + "9" * 200, "1: X is beyond 1000000, got '" + "9" * 27 + "...'; write at most 1000000"),
    ("G0 X10 N5", "1: N is not the first word of its block, got N5; remove it"),
    ("N1.5 G0 X1", "1: a line number is a whole number, got N1.5; write e.g. N10"),
    ("N-1 G0 X1", "1: a line number is a whole number, got N-1; write e.g. N10"),
    ("G0 X1 (open", "1: a comment is not closed, got '(open'; write \")\" at its end"),
    ("G0 X1 (a (b))", "1: a comment inside a comment, got '(a (b)'; remove the second \"(\""),
    ("G0 X1 )", "1: \")\" without \"(\", got ')'"),
    ("(PY,import os)", "1: a comment that asks for an action is not in the subset, got '(PY,import os)'; remove it"),
    ("(LOGOPEN,x)", "1: a comment that asks for an action is not in the subset, got '(LOGOPEN,x)'; remove it"),
    ("G0 X1 %", "1: \"%\" stands alone on its line, got '%'"),
    ("G0 X1\n%", '2: "%" ends a program only if its first line is "%"; write M2'),
    ("G0 X1 \u00e9", "1: a character that is not ASCII, outside a comment, got '\u00e9'"),
    ("G0 X\u0661", "1: X has no number, got 'X\u0661'; write e.g. X10"),  # an Arabic digit is a digit for float()
    ("G0 X1\x07", "1: a control character in the line, got \\x07; remove it"),
    ("G0 X1\x00", "1: a control character in the line, got \\x00; remove it"),
    ("G0 X1 (" + "x" * 250 + ")", "1: a line has at most 255 characters, got 258; split the line"),
    ("G0 X1 = 3", "1: not a word, got '= 3'"),
]  # fmt: skip


@pytest.mark.parametrize("text, message", ERRORS, ids=[repr(text[:20]) for text, _ in ERRORS])
def test_what_is_not_in_the_subset_is_an_error_with_its_line(text, message):
    with pytest.raises(ProgramError) as caught:
        read_gcode(text + "\nM2\n", "part.ngc")
    assert str(caught.value) == f"part.ngc:{message}"


@pytest.mark.parametrize(
    "text, message",
    [
        ("", "1: the program has no end; write M2 or M30 as its last line"),
        ("G0 X1\n\n", "1: the program has no end; write M2 or M30 as its last line"),
        ("%\nG0 X1\n", "2: the program has no end; write M2 or M30 as its last line"),
        ("%", "1: the program has no end; write M2 or M30 as its last line"),
        ("M2", "1: the program moves nothing; write a G0 or G1 with an axis word"),
        ("%\n%", "2: the program moves nothing; write a G0 or G1 with an axis word"),
        ("G0 X1\nM2\nG0 X2", "3: a block behind the end of the program, got G0; remove it"),
    ],
)
def test_a_program_has_an_end_and_moves(text, message):
    with pytest.raises(ProgramError) as caught:
        read_gcode(text, "part.ngc")
    assert str(caught.value) == f"part.ngc:{message}"


def test_every_problem_of_a_file_is_told_at_once_and_none_that_follows_from_another():
    text = "G1 X10\nG1 Y10\nG5 X3\nX1,5\nG2 X3\nM2\n"
    with pytest.raises(ProgramError) as caught:
        read_gcode(text, "part.ngc")
    assert [p.line for p in caught.value.problems] == [1, 3, 4]


@pytest.mark.parametrize(
    "block, told",
    [
        ("G94 G40 G49 G80", ["G94; remove it: F is mm/min", "G40; remove it: nothing to cancel",
                             "G49; remove it: the tool is that of the data sheet",
                             "G80; remove it: nothing to cancel"]),
        ("G4 P1", ["G4; remove it: a program does not dwell", "P1; remove it, with G4"]),
        ("G41 D1", ["G41; offset the path in CAM", "D1; remove it, with G41"]),
        ("G64 P0.01 M7", ['G64; remove it: see the option corner = "constant"', "P0.01; remove it, with G64 and M7",
                          "M7; remove it: coolant is not simulated"]),
        ("T1 M6 S8000 M3", ["T1; remove it: the tool is that of the data sheet",
                            "M6; remove it: the tool is that of the data sheet",
                            "S8000; remove it: the spindle is not simulated",
                            "M3; remove it: the spindle is not simulated"]),
    ],
)  # fmt: skip
def test_every_word_of_a_block_that_is_not_in_the_subset_is_told(block, told):
    with pytest.raises(ProgramError) as caught:
        read_gcode(f"G0 X1\n{block}\nM2\n", "part.ngc")
    assert str(caught.value).split("\n") == [f"part.ngc:2: not in the subset, got {text}" for text in told]


@pytest.mark.parametrize(
    "text, last",
    [
        ("S1\n" * 50 + "M2", None),
        ("S1\n" * 51 + "M2", "part.ngc:51: from here on 1 line more is wrong"),
        ("S1\nG0 X1\n" * 1000 + "M2", "part.ngc:101: from here on 950 lines more are wrong"),
        ("S1\n" * 49 + "G40 G80\nM2", "part.ngc:50: from here on 1 line more is wrong"),  # of two words one is told
        (
            "S1\n" * 10**6,
            "part.ngc:51: from here on 10000 lines more are wrong, and there may be more; "
            "check that this is an NC program",
        ),
    ],
    ids=["fifty", "one more", "many", "in a block", "no end"],
)
def test_fifty_problems_are_told_and_the_other_lines_counted(text, last):
    with pytest.raises(ProgramError) as caught:
        read_gcode(text, "part.ngc")
    found = caught.value.problems
    assert all(p.value in ("S1", "G40") for p in found[:MOST_PROBLEMS])
    assert [str(p) for p in found[MOST_PROBLEMS:]] == ([last] if last else [])


@pytest.mark.parametrize(
    "data, message",
    [
        (b"G0 X1\nG0 \x00\nM2", "{}:2: a NUL byte: this is no text"),
        (b"G0 X1\n(\xff)\nM2", "{}:2: the text is not UTF-8; save it as ASCII or UTF-8"),
    ],
)
def test_a_file_that_is_no_text_is_refused(tmp_path, data, message):
    file = tmp_path / "part.ngc"
    file.write_bytes(data)
    with pytest.raises(ProgramError) as caught:
        load_program(file)
    assert str(caught.value) == message.format(file)


def test_a_missing_file_a_folder_and_a_pipe_are_refused(tmp_path):
    import os

    os.mkfifo(tmp_path / "pipe")  # opening it would wait for ever
    cases = (("none.ngc", "cannot be read: No such file or directory"), ("", "not a file"), ("pipe", "not a file"))
    for name, message in cases:
        with pytest.raises(ProgramError, match=message):
            load_program(tmp_path / name)


def test_a_file_beyond_64_mb_is_refused_without_being_read_on(tmp_path):
    file = tmp_path / "part.ngc"
    with open(file, "wb") as f:
        f.truncate(65 * 1024 * 1024)  # sparse
    with pytest.raises(ProgramError, match="at most 64 MB"):
        load_program(file)


def test_a_damaged_program_is_read_or_refused_and_nothing_else():
    """Bytes of the example changed, dropped and doubled, seed 0: a path, or a ProgramError with lines."""
    rng, text = np.random.default_rng(0), EXAMPLE.read_text()
    alphabet = "GXYZABCFIJRNM0123456789.-+ ()%;/#[]\n\t\x00\u00e9eE"
    refused = 0
    for _ in range(300):
        chars = list(text)
        for _ in range(rng.integers(1, 8)):
            at = int(rng.integers(len(chars)))
            put = [alphabet[k] for k in rng.integers(len(alphabet), size=rng.integers(0, 3))]
            chars[at : at + int(rng.integers(0, 3))] = put
        try:
            path = Path(read_gcode("".join(chars), "part.ngc"))
            assert np.isfinite(path.s0).all()
        except ProgramError as error:
            refused += 1
            assert all(p.file == "part.ngc" and p.line for p in error.problems), str(error)
    assert 0.5 < refused / 300 < 1


def test_what_is_written_reads_back_as_it_was():
    path = CircleDiamondSquare(feed=0.04).path()
    back = Path(read_gcode(to_gcode(path)))
    np.testing.assert_allclose(ends(back), ends(path), atol=1e-9)  # ten decimals of a mm
    np.testing.assert_allclose(back.feed[~back.rapid], path.feed[~path.rapid], rtol=1e-12)
    np.testing.assert_array_equal(back.kind, path.kind)
    example = load_program(EXAMPLE).path()
    again = Path(read_gcode(to_gcode(example)))
    np.testing.assert_allclose(ends(again), ends(example), atol=1e-9)
    np.testing.assert_allclose(again.length, example.length, rtol=1e-9)


def test_the_example_uses_the_whole_subset_and_takes_a_minute(machine):
    found = [word for line in EXAMPLE.read_text().splitlines() for word in words(line)]
    assert {word.letter for word in found} == set("ABCFGIJMNRXYZ")
    assert {word.text for word in found if word.letter in "GM"} == set(_GROUPS) - {"M30"}
    motion = load_program(EXAMPLE).plan(machine)
    assert 60 < motion.duration < 120
    assert [c.ccw for c in motion.path.circles] == [False, True]
    r = motion.sample(0, motion.count(5e-3), 5e-3)
    assert np.hypot(r.x[:, 0], r.x[:, 1]).max() < 0.2
    assert r.x[:, 2].min() > -0.02
    assert r.x[:, 2].max() < 0.06
    assert 5 < np.degrees(np.arccos(r.axis[:, 2].min())) < 10.5


def test_options_are_checked_with_the_program():
    with pytest.raises(ProgramError, match="cornr: no such key; did you mean corner"):
        NCProgram(text="G0 X1\nM2", cornr="stop")
    assert NCProgram(text="G0 X1\nM2", corner="constant", acceleration=1.0).acceleration == 1.0


def test_equal_programs_are_equal_and_hash_alike():
    a, b = (NCProgram(text="G0 X1\nM2") for _ in range(2))
    assert a == b
    assert a.digest() == b.digest()
    assert a != NCProgram(text="G0 X2\nM2")


def test_an_arc_with_a_centre_only_is_a_full_circle():
    """As LinuxCNC reads it: G2 I10 comes back to its start, G2 Z5 I10 to above it."""
    flat, rising = read_gcode("G2 I10 F100\nG2 Z5 I10\nM2\n")
    for block, height in ((flat, 0.0), (rising, 5e-3)):
        assert block.segment.sweep == pytest.approx(-2 * math.pi, abs=1e-12)
        np.testing.assert_allclose(block.segment.center, (0.01, 0, 0), atol=1e-15)
        assert block.segment.rise == pytest.approx(height, abs=1e-15)
