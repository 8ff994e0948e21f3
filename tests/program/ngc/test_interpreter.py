"""What a block does, in which order, and which words are refused; numbers are those that LinuxCNC's rs274 printed."""

import itertools
import math
import os
import re
import shutil
import subprocess

import pytest

from gough.program.blocks import Arc, Line, Rest
from gough.program.ngc import codes
from gough.program.ngc.codes import name_of

from .machine import TOOLS, ends, moves, read, refused


@pytest.mark.parametrize(
    "lines, last",
    [
        (["G0 X10 Y20 Z30"], (10, 20, 30, 0, 0, 0)),
        (["G1 X10 F100", "Y20", "Z30"], (10, 20, 30, 0, 0, 0)),
        (["G91", "G0 X10", "X10 Y5"], (20, 5, 0, 0, 0, 0)),
        (["G91 G0 X10", "G90 X3"], (3, 0, 0, 0, 0, 0)),
        (["G20", "G0 X1 Y2"], (25.4, 50.8, 0, 0, 0, 0)),
        (["G20", "G0 X1", "G21", "Y1"], (25.4, 1, 0, 0, 0, 0)),
        (["G0 X1 A10 B-20 C30"], (1, 0, 0, 10, -20, 30)),
        (["G20", "G0 X1 A10"], (25.4, 0, 0, 10, 0, 0)),
        (["G80 G1 X1 F100"], (1, 0, 0, 0, 0, 0)),  # G80 beside a motion code means nothing
        (["X5 G0"], (5, 0, 0, 0, 0, 0)),
        (["G1 F100 X5", "G28 X7", "X9"], (9, 0, 0, 0, 0, 0)),  # G1 is still in force behind G28
        (["G0 X5", "G4 P1 X6"], (6, 0, 0, 0, 0, 0)),  # a dwell, then the move
        (["G10 L2 P1 X3 R90", "G0 X1 Y0"], (3, 1, 0, 0, 0, 0)),
    ],
)
def test_a_program_ends_where_its_words_say(lines, last):
    assert ends(read(*lines))[-1] == pytest.approx(last, abs=1e-9)


def test_a_block_with_a_code_of_no_effect_is_the_block_without_it():
    """The short way for plain lines and the long way for all others are one."""
    lines = ["G0 X1 Y2", "G1 Z-3 F200", "X4.5 A10", "F300 Y1 B-2 C7", "G92 X9", "X1", "G0 A0", "A5", "G1 A7"]
    lines += ["G20", "X.5 Y-.25", "F9 Z1", "G55", "X1 A3", "G64 P.1 X3", "G1 X3", "X3.000000001"]
    assert read(*lines) == read(*(line if "G92" in line else f"{line} G40" for line in lines))


def test_a_move_counted_from_the_last_point_is_the_move_to_where_it_leads():
    steps = [(1.5, -2, 0.25, 3), (-7, 0.5, 1, -4), (0.125, 3, -9, 0)]
    for system in ("G54", "G10 L2 P1 X7 Y-1 Z2 A5 R30"):
        at = [0.0] * 4
        relative, absolute = [system, "G0 X0 Y0 Z0 A0", "G91"], [system, "G0 X0 Y0 Z0 A0"]
        for step in steps:
            at = [a + b for a, b in zip(at, step, strict=True)]
            relative.append("G1 F9 X{} Y{} Z{} A{}".format(*step))
            absolute.append("G1 F9 X{} Y{} Z{} A{}".format(*at))
        for a, b in zip(ends(read(*relative)), ends(read(*absolute)), strict=True):
            assert a == pytest.approx(b, abs=1e-9)


def test_an_inch_program_is_the_mm_program_times_25_4():
    words = ["G0 X{x} Y{y}", "G1 Z{z} F{f}", "G2 X{y} I{r} J0", "G3 X{x} R{r}", "G1 A10", "G92 X{y}", "G0 X0 Y0"]
    numbers = {"x": 1.0, "y": 2.0, "z": -0.5, "f": 10.0, "r": 0.5}
    inch = read("G20", *(w.format(**numbers) for w in words[:4]), words[5].format(**numbers), words[6])
    scaled = {k: f"{25.4 * v:.6f}" for k, v in numbers.items()}
    mm = read(*(w.format(**scaled) for w in words[:4]), words[5].format(**scaled), words[6])
    for a, b in zip(inch, mm, strict=True):
        assert a.feed == pytest.approx(b.feed, rel=1e-12)
        for u, v in zip(a.segment, b.segment, strict=True):
            assert u == pytest.approx(v, abs=1e-12)


def test_what_moves_nothing_makes_no_block():
    assert len(read("G0 X1", "X1", "G0", "G1 F10", "X1.0000000001", "A0")) == 1
    # the A word moves nothing, and leaves not a rounding error of a turn
    assert len(read("G10 L2 P1 A0.1", "G0 X1 A0.2", "G91 G40", "X0 A0")) == 1


def test_a_block_of_many_codes_runs_in_the_order_of_the_standard():
    blocks = read("G0 X1", "X2 M0 G4 P3 M3 S100 T5 M6 G43 H5 G1 F600", tools=TOOLS)
    kinds = [(type(b.segment), b.dwell, b.spindle, b.tool[2]) for b in blocks]
    assert kinds == [
        (Line, 0, 0, 0),
        (Rest, 0, 0, 0),  # M6; M3 stops too, and is there already
        (Rest, 3, 100, 0),  # the dwell comes before the tool offset
        (Rest, 0, 100, 0.05),
        (Line, 0, 100, 0.05),
        (Rest, 0, 100, 0.05),  # M0 waits behind the move
    ]
    assert [b.line for b in blocks] == [1, 2, 2, 2, 2, 2]


@pytest.mark.parametrize("code", ["M0", "M1", "M60", "M3", "M4", "M5", "M6", "M7", "M8", "M9", "G4 P0"])
def test_a_full_stop_is_a_rest_without_time(code):
    stop = read("G0 X1", code, "X2")[1]
    assert stop.segment == Rest((0.001, 0, 0))
    assert (stop.dwell, stop.abc0, stop.line) == (0, stop.abc1, 2)


@pytest.mark.parametrize("code", ["M48", "M49", "M50 P0", "M51", "M52 P1", "M53 P0", "S500", "T3", "G40", "G97", "G98",
                                  "G99", "G80", "M70", "G17", "G64 Q1"])  # fmt: skip
def test_what_stops_nothing_makes_no_block(code):
    assert len(read("G0 X1", code, "G0 X2")) == 2


def test_stops_in_a_row_are_one_and_dwells_are_not():
    blocks = read("G0 X1", "M5", "M9", "M0", "G4 P1", "G4 P2", "M0", "X2", "M0")
    assert [(type(b.segment), b.dwell) for b in blocks[1:]] == [
        (Rest, 0), (Rest, 1), (Rest, 2), (Rest, 0), (Line, 0), (Rest, 0)
    ]  # fmt: skip


def test_home_is_reached_by_way_of_the_axis_words_and_by_these_axes_only():
    setup = ["G0 X5 Y6 Z7 A3", "G28.1", "G0 X0 Y0 Z0", "G92 X100", "G10 L2 P1 Y7"]
    blocks = read(*setup, "G28 Y1", "G30 X0", "G28")
    assert all(b.rapid for b in blocks)
    assert ends(blocks)[2:] == [
        pytest.approx(v, abs=1e-9)
        for v in [(0, 8, 0, 3, 0, 0), (0, 6, 0, 3, 0, 0), (-100, 6, 0, 3, 0, 0), (0, 6, 0, 3, 0, 0), (5, 6, 7, 3, 0, 0)]
    ]


def test_home_of_one_axis_of_a_turned_system_is_its_own_axis():
    """rs274: after G28 Y5 the program stands at X-11.3301 Y-12.3205, under R30 about X10 Y20."""
    last = ends(read("G10 L2 P2 X10 Y20 R30", "G0 X5 Y6", "G55", "G28 Y5"))[-1]
    c, s = math.cos(math.radians(30)), 0.5
    assert last[:2] == pytest.approx(
        (10 - 11.3301270 * c + 12.3205081 * s, 20 - 11.3301270 * s - 12.3205081 * c), abs=1e-6
    )


def test_a_place_by_g53_is_counted_from_the_frame_along_its_own_axes():
    """rs274 under G10 L2 P1 R30 at X5 Y6: G53 G0 X0 leads to X3.8481 Y6.6651 of the program."""
    last = ends(read("G10 L2 P1 R30", "G0 X5 Y6", "G53 G0 X0"))[-1]
    c, s = math.cos(math.radians(30)), 0.5
    assert last[:2] == pytest.approx((0, 5 * s + 6 * c), abs=1e-12)
    assert last[:2] == pytest.approx((3.8481 * c - 6.6651 * s, 3.8481 * s + 6.6651 * c), abs=1e-4)


REFUSED = [
    ("G1 X10", "1: G1 without a feed; write F, in mm/min, before it or with it"),
    ("G1", "1: G1 without a feed; write F, in mm/min, before it or with it"),
    ("G2 X10 R5", "1: G2 without a feed; write F, in mm/min, before it or with it"),
    ("F100\nF0\nG1 X1", "3: G1 without a feed; write F, in mm/min, before it or with it"),
    ("F100\nG94\nG1 X1", "3: G1 without a feed; write F, in mm/min, before it or with it"),
    ("G0 X1\nF-100", "2: the feed must be above 0, got F-100; write F in mm/min, e.g. F1000"),
    ("G0 X1 F-1", "1: the feed must be above 0, got F-1; write F in mm/min, e.g. F1000"),
    ("G1 X1 F2000000", "1: F is beyond 1000000, got F2000000; F is mm/min: write at most 1000000"),
    ("X10", "1: an axis word with no G0, G1, G2 or G3 in force, got X10; write e.g. G0 or G1"),
    ("G93 X10", "1: an axis word with no G0, G1, G2 or G3 in force, got X10; write e.g. G0 or G1"),
    ("G43 H5 Z10", "1: an axis word with no G0, G1, G2 or G3 in force, got Z10; write e.g. G0 or G1"),
    ("G0 X1\nG80 X5", "2: an axis word beside G80, got X5; write G0 or G1 for a move"),
    ("G0 X1\nG80\nX5", "3: an axis word with no G0, G1, G2 or G3 in force, got X5; write e.g. G0 or G1"),
    ("G28 G0 X1", "1: two codes of a block that both take its axis words, got G0 G28; write them in two blocks"),
    ("G92 X1 G1", "1: two codes of a block that both take its axis words, got G1 G92; write them in two blocks"),
    ("G10 L2 P1 X1 G0", "1: two codes of a block that both take its axis words, got G0 G10; write them in two blocks"),
    ("G43.1 Z1 G0", "1: two codes of a block that both take its axis words, got G0 G43.1; write them in two blocks"),
    ("G43.1 Z1 G92", "1: two codes of a block that both take its axis words, got G92 G43.1; write them in two blocks"),
    ("G0 G1 X10 F100", "1: two words of one kind in a block, got G0 G1; write them in two blocks"),
    ("G1 G01 X1 F1", "1: two words of one kind in a block, got G1 G1; write them in two blocks"),
    ("M3 M70", "1: two words of one kind in a block, got M3 M70; write them in two blocks"),
    ("G92 X1 G92.1", "1: two words of one kind in a block, got G92 G92.1; write them in two blocks"),
    ("G53", "1: G53 goes with G0 or G1; write e.g. G53 G0 X0"),
    ("F10 G53 G2 X5 R5", "1: G53 goes with G0 or G1, got G2; write e.g. G53 G0 X0"),
    ("G91\nG53 G0 X5", "2: G53 with G91; write G90: the place is counted from the machine's zero"),
    ("G0 X1 P1", "1: P without a code that takes it, got P1; remove it, or write G2, G3, G4, G10 or G64 beside it"),
    ("G61 P1", "1: P without a code that takes it, got P1; remove it, or write G2, G3, G4, G10 or G64 beside it"),
    ("G0 X1 Q1", "1: Q without a code that takes it, got Q1; remove it, or write G64 or M61 beside it"),
    ("G49 H1", "1: H without a code that takes it, got H1; remove it, or write G43 beside it"),
    ("G0 X1 L1", "1: L without a code that takes it, got L1; remove it, or write G10 beside it"),
    ("G0 X1 D1", "1: not supported, got D1; remove it: offset the path in CAM"),
    ("G0 X1 E2", "1: not supported, got E2; remove it: nothing is extruded"),
    ("G0 X1 I5", "1: I belongs to an arc, got I5; write G2 or G3"),
    ("G0 X1 R5", "1: R belongs to an arc, got R5; write G2 or G3"),
    ("F9 G2 X10 I5\nR5", "2: R belongs to an arc, got R5; write G2 or G3"),
    ("F9 G2 X10 I5\nP2", "2: P without a code that takes it, got P2; "
                          "remove it, or write G2, G3, G4, G10 or G64 beside it"),
    ("G4 P1 G64", "1: two codes of a block that both take P, got P1; write them in two blocks"),
    ("F9 G64 P2 G2 X10 I5", "1: two codes of a block that both take P, got P2; write them in two blocks"),
    ("G4", "1: G4 without P; write P and the seconds, e.g. G4 P0.5"),
    ("G4 P-1", "1: a dwell is between 0 and 1000000 s, got P-1; write seconds, e.g. G4 P0.5"),
    ("S-100", "1: the spindle speed is below 0, got S-100; write M4 to turn the other way"),
    ("G20 G1 X1 F10", "1: F in the block that changes the unit can be read in either, got G20 F10; "
                      "write G20 in a block before it"),
    ("G93 G1 X1", "1: G1 without F in its own block, with G93; write F, in 1/min, with it"),
    ("G93 G1 X1 F0", "1: G1 without F in its own block, with G93, got F0; write F, in 1/min, with it"),
    ("G93\nF2\nG2 X1 R1", "3: G2 without F in its own block, with G93; write F, in 1/min, with it"),
    ("F9 G93\nG1 F2 X1\nX2", "3: G1 without F in its own block, with G93; write F, in 1/min, with it"),
    ("G0 X1000001", "1: a move to a place beyond 1e6 mm or degrees; check the words and the offsets"),
    ("G0 X1\nG91\nG0 X999999.5", "3: a move to a place beyond 1e6 mm or degrees; check the words and the offsets"),
    ("G0 A1000001", "1: a move to a place beyond 1e6 mm or degrees; check the words and the offsets"),
    ("G92 X1000001", "1: X is beyond 1000000, got X1000001; write at most 1000000"),
    ("M61", "1: M61 without Q; write Q and the number of the tool in the spindle"),
    ("M72", "1: M72 without M70 or M73 at this level of calls; write M70 before it"),
    ("G41 D1", "1: not supported, got G41; offset the path in CAM"),
    ("G81 X1 Z-1 R1 F10", "1: not supported, got G81; write the moves of the cycle: G0 and G1"),
    ("G43.4 H1 U2", "1: not supported, got G43.4; write G43: the tip stays on the path while the tool tilts"),
    ("U2", "1: not supported, got U2; write X, and G91 for a way from the last point"),
    ("G38.2 X5 F10", "1: not supported, got G38.2; remove it: nothing is probed"),
    ("G95", "1: not supported, got G95; write G94, and F in mm/min: the feed times the turns a minute"),
    ("G68 R30", "1: not supported, got G68; write G10 L2 P1 R and the angle"),
    ("M98 P100", "1: not supported, got M98; write O<name> sub ... O<name> endsub, and O<name> call"),
    ("M101", "1: not supported, got M101; remove it: M100 to M199 run scripts, and no script is run"),
    ("M62 P1", "1: not supported, got M62; remove it: inputs and outputs are not simulated"),
    ("G1.5 X1", "1: not supported, got G1.5; docs/nc-programs.md lists the codes that are"),
    ("G123", "1: not supported, got G123; docs/nc-programs.md lists the codes that are"),
    ("G41 G81 M19", "1: not supported, got G41; offset the path in CAM\n"
                    "1: not supported, got G81; write the moves of the cycle: G0 and G1\n"
                    "1: not supported, got M19; remove it: the spindle's angle is not simulated"),
]  # fmt: skip


@pytest.mark.parametrize("text, message", REFUSED, ids=[text.replace("\n", "|") for text, _ in REFUSED])
def test_a_wrong_block_is_refused_with_its_line_its_words_and_a_cure(text, message):
    assert refused(*text.split("\n")) == message


def test_a_dwell_runs_from_where_the_tool_is():
    dwell = read("G0 X1 A5", "G4 P2.5")[1]
    assert dwell.segment == Rest((0.001, 0, 0))
    assert (dwell.dwell, dwell.abc0, dwell.abc1) == (2.5, (math.radians(5), 0, 0), (math.radians(5), 0, 0))


def test_a_full_circle_needs_no_motion_code_of_its_own():
    blocks = moves(read("F100 G2 X10 I5", "I-5"))
    assert [type(b.segment) for b in blocks] == [Arc, Arc]
    assert blocks[1].segment.sweep == pytest.approx(-2 * math.pi, rel=1e-15)


# the groups as rs274 has them: of all pairs of supported codes it refuses those within a row
ROWS = [
    "G0 G1 G2 G3", "G4 G10 G28 G28.1 G30 G30.1 G52 G53 G92", "G17 G18 G19", "G20 G21", "G40",
    "G43 G43.1 G43.2 G49", "G54 G55 G56 G57 G58 G59 G59.1 G59.2 G59.3", "G61 G61.1 G64", "G90 G91", "G90.1 G91.1",
    "G92.1 G92.2 G92.3", "G93 G94", "G97", "G98 G99",
    "M0 M1 M2 M30 M60", "M3 M4 M5 M70 M71 M72 M73", "M48 M49 M50 M51 M52 M53", "M6 M61", "M7 M8 M9",
]  # fmt: skip


def test_the_groups_of_codes_are_those_of_linuxcnc():
    ours: dict[tuple, set] = {}
    for letter, table in (("G", codes.G), ("M", codes.M)):
        for code, group in table.items():
            ours.setdefault((letter, group), set()).add(name_of(letter, code))
    assert sorted(map(sorted, ours.values())) == sorted(sorted(row.split()) for row in ROWS)


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("rs274") is None, reason="LinuxCNC's interpreter rs274 is not installed")
def test_linuxcnc_refuses_the_pairs_of_codes_of_one_group_and_no_others(tmp_path):
    file, environment = tmp_path / "p.ngc", {**os.environ, "HOME": str(tmp_path)}  # it keeps its tools in HOME
    for letter in "GM":
        known = {code: k for k, row in enumerate(ROWS) for code in row.split() if code[0] == letter}
        for a, b in itertools.combinations_with_replacement(known, 2):
            file.write_text(f"{a} {b}\nM2\n")
            run = subprocess.run(
                ["rs274", "-g", file], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=20
            )
            together = re.search("same modal group", run.stderr) is None
            assert together == (known[a] != known[b]), f"{a} {b}: {run.stderr}"
