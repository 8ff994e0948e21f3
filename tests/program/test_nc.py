"""NC programs as users meet them: where they end, files that are none, and what makes a program repeatable.

The language itself is tested in ngc/, its errors in bad/, its agreement with LinuxCNC in oracle/.
"""

import math
from pathlib import Path as FilePath

import numpy as np
import pytest

from gough.errors import InputError, ProgramError
from gough.program import CircleDiamondSquare, NCProgram, load_program
from gough.program.blocks import ARC, REST
from gough.program.ngc.read import MOST_PROBLEMS, read_program
from gough.program.path import Path
from gough.program.write import to_gcode

EXAMPLE = FilePath(__file__).parents[2] / "examples" / "circle_diamond_square.ngc"


def path_of(*lines):
    return Path(read_program("\n".join([*lines, "M2"])))


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
    assert len(Path(read_program("%\nG0 X1\n%\n"))) == 1
    assert len(Path(read_program("\n %\nG0 X1\nM30\n%\n"))) == 1


def test_every_problem_of_a_file_is_told_at_once_and_none_that_follows_from_another():
    text = "G1 X10\nG1 Y10\nG5 X3\nX1,5\nG2 X3\nM2\n"
    with pytest.raises(ProgramError) as caught:
        read_program(text, "part.ngc")
    assert [p.line for p in caught.value.problems] == [1, 3, 4]


@pytest.mark.quick("many")
@pytest.mark.parametrize(
    "text, last",
    [
        ("G81\n" * 50 + "M2", None),
        ("G81\n" * 51 + "M2", "part.ngc:51: from here on 1 line more is wrong"),
        ("G81\nG0 X1\n" * 1000 + "M2", "part.ngc:101: from here on 950 lines more are wrong"),
        ("G81\n" * 49 + "G81 G83\nM2", "part.ngc:50: from here on 1 line more is wrong"),  # of two words one is told
        (
            "G81\n" * 10**6,
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
    assert all(p.value == "G81" for p in found[:MOST_PROBLEMS])
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
            path = Path(read_program("".join(chars), "part.ngc"))
            assert np.isfinite(path.s0).all()
        except ProgramError as error:
            refused += 1
            assert all(p.file == "part.ngc" and p.line for p in error.problems), str(error)
    assert 0.5 < refused / 300 < 1


def test_what_is_written_reads_back_as_it_was():
    path = CircleDiamondSquare(feed=0.04).path()
    back = Path(read_program(to_gcode(path)))
    np.testing.assert_allclose(ends(back), ends(path), atol=1e-9)  # ten decimals of a mm
    np.testing.assert_allclose(back.feed[~back.rapid], path.feed[~path.rapid], rtol=1e-12)
    np.testing.assert_array_equal(back.kind, path.kind)
    example = load_program(EXAMPLE).path()
    again = Path(read_program(to_gcode(example)))
    np.testing.assert_allclose(ends(again), ends(example), atol=1e-9)
    np.testing.assert_allclose(again.length, example.length, rtol=1e-9)


def test_the_example_takes_a_minute_and_stays_near_its_stock(machine):
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
    flat, rising = read_program("G2 I10 F100\nG2 Z5 I10\nM2\n")
    for block, height in ((flat, 0.0), (rising, 5e-3)):
        assert block.segment.sweep == pytest.approx(-2 * math.pi, abs=1e-12)
        np.testing.assert_allclose(block.segment.center, (0.01, 0, 0), atol=1e-15)
        assert block.segment.rise == pytest.approx(height, abs=1e-15)


SUB = "o<slot> sub\n#<deep> = [#1 / 2]\nG1 Z-#<deep> F600\nX#2\no<slot> endsub\n"
CALLS = "G21 G0 Z1\no<slot> call [3] [#3001]\nG0 Z1\nM2\n"


@pytest.fixture
def folder(tmp_path):
    """A program that calls a file and asks for a tool, with its tool table and parameters."""
    (tmp_path / "part.ngc").write_text("T4 G43 H4\n" + CALLS)
    (tmp_path / "slot.ngc").write_text(SUB)
    (tmp_path / "tool.tbl").write_text("T4 P1 Z12.5 D6 ;end mill\n")
    (tmp_path / "linuxcnc.var").write_text("3001\t25.0\n5161 0.0\n")
    return tmp_path


def load(folder, **more):
    files = {"tools": folder / "tool.tbl", "parameters": folder / "linuxcnc.var"}
    return load_program(folder / "part.ngc", **(files | more))


def test_called_files_tools_and_parameters_make_one_object_that_needs_no_file(folder):
    program = load(folder)
    path = program.path()
    np.testing.assert_allclose(ends(path)[-1][:3], [25, 0, 1], atol=1e-12)
    np.testing.assert_allclose(path.tool, [[0, 0, 12.5e-3]] * len(path), atol=1e-15)
    again = NCProgram.from_file(program.to_file())
    for file in folder.iterdir():
        file.unlink()
    assert again == program
    assert again.digest() == program.digest()
    np.testing.assert_array_equal(again.path().s0, path.s0)


def test_what_a_called_file_says_is_part_of_the_program(folder):
    first = load(folder)
    (folder / "slot.ngc").write_text(SUB.replace("/ 2", "/ 3"))
    assert load(folder).digest() != first.digest()


@pytest.mark.parametrize(
    "change, message",
    [
        ({"subroutines": "elsewhere"}, "part.ngc:3: "),
        ({"tools": {1: {"length": 0.1}}}, "part.ngc:1: no such tool in the tool table, got T4; there is T1"),
        ({"tools": {4: {"lenth": 0.1}}}, "4.lenth: no such key; did you mean length?"),
        ({"parameters": {3001: float("nan")}}, "parameters.3001: input should be a finite number, got nan"),
        ({"parameters": {9999: 1.0}}, "parameters: parameters go from 1 to 5601, got 9999"),
        ({"steps": 0}, "steps: must be at least 1, got 0"),
    ],
)
def test_what_is_wrong_around_a_program_is_told(folder, change, message):
    with pytest.raises(InputError) as caught:
        load(folder, **change)
    assert message in str(caught.value)


def test_the_blocks_of_a_program_can_be_printed(folder):
    text = str(load(folder).path())
    assert [line.split() for line in text.splitlines()] == [
        ["NC", "line", "move", "X", "Y", "Z", "centre", "F", "corner"],
        ["1", "halt", "0", "0", "-12.5"],  # the tip of the tool is there while the machine stands at its zero
        ["2", "G0", "0", "0", "1"],
        ["3", "G1", "0", "0", "-1.5", "600"],
        ["3", "G1", "25", "0", "-1.5", "600"],
        ["4", "G0", "25", "0", "1"],
    ]


def test_what_is_wrong_with_the_path_of_a_program_names_its_file_too():
    with pytest.raises(ProgramError) as caught:
        NCProgram(text="G0 X900000\no1 repeat [1200]\nX0\nX900000\no1 endrepeat\nM2", name="part.ngc")
    assert str(caught.value) == "part.ngc:3: a path is at most 1000 km long, got 2160.9 km"
