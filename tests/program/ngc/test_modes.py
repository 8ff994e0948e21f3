"""What stays in force: feed, units, corners, spindle, tools, and what M70 to M73 keep."""

import math

import numpy as np
import pytest

from gough.program.blocks import Arc, Rest
from gough.program.ngc.modes import Modes, Saves
from gough.program.ngc.parameters import Parameters

from .machine import TOOLS, ends, moves, read, refused


@pytest.mark.parametrize(
    "lines, feed",
    [
        (["G1 X10 F600"], 0.01),
        (["G20", "G1 X10 F60"], 0.0254),
        (["G1 A10 F600"], math.radians(10)),
        (["G20", "G1 A10 F600"], math.radians(10)),  # degrees a minute, whatever the unit of length
        (["G1 X10 A10 F600"], 0.01),  # along the path of the tip
        (["F600", "G20", "G1 X1"], 0.01),  # F is a speed; it stays when the unit changes
        (["F600", "G20", "G1 A1"], math.radians(10)),
        (["G21 G1 X10 F600"], 0.01),
        (["F60", "G94 G1 X1 F600"], 0.01),
        (["G93 G1 X10 F2", "G94 F600 X20"], 0.01),
        (["G2 X10 I5 F600"], 0.01),
        # G93: F of them in a minute
        (["G93 G1 X30 Y40 F3"], 0.05 * 3 / 60),
        (["G93 G1 X30 Y40 A90 F3"], 0.05 * 3 / 60),
        (["G20", "G93 G1 X3 Y4 F3"], 5 * 0.0254 * 3 / 60),
        (["G93 G1 A3 C4 F2"], math.radians(5) * 2 / 60),
        (["G93 G2 X10 I5 F2"], 5e-3 * math.pi * 2 / 60),
        (["G93 G3 X10 I5 P3 Z8 F1"], math.hypot(5e-3 * math.pi * 5, 8e-3) / 60),  # rs274: 78.54 of its length
        (["G93 G53 G1 X10 F6"], 0.01 * 6 / 60),
    ],
)
def test_the_feed_is_what_f_says_in_the_unit_and_the_mode_in_force(lines, feed):
    assert read(*lines)[-1].feed == pytest.approx(feed, rel=1e-14)


def test_a_block_in_inverse_time_takes_a_minute_over_f():
    for block in moves(read("G93 G1 X3 Y-4 F7", "G3 X9 R5 F7", "G2 I2 P2 Z1 F7", "G1 A9 F7", "G18 G2 Z5 R4 A1 F7")):
        s = block.segment
        if type(s) is Arc:
            arm = np.subtract(s.start, s.center)
            arm -= np.dot(arm, s.normal) * np.array(s.normal)
            length = math.hypot(np.linalg.norm(arm) * s.sweep, s.rise)
        else:
            length = math.dist(block.abc0, block.abc1) if type(s) is Rest else math.dist(*s)
        assert length / block.feed == pytest.approx(60 / 7, rel=1e-12)


def test_rapids_have_no_feed_of_their_own_and_need_none():
    blocks = read("G0 X1", "G93 X2", "A3", "G94", "G1 X3 F60", "G0 B5")
    assert [b.rapid for b in blocks] == [True, True, True, False, True]


@pytest.mark.parametrize(
    "code, tolerance",
    [
        ("", 0.0),
        ("G61", 0.0),
        ("G61.1", -1.0),
        ("G64", math.inf),
        ("G64 P0.05", 5e-5),
        ("G64 P.05 Q.02", 5e-5),
        ("G64 Q.02", math.inf),
        ("G20 G64 P0.01", 2.54e-4),
        ("G20 G64 P0.01\nG21", 2.54e-4),  # a length; it stays when the unit changes
        ("G64 P1\nG64", math.inf),
        ("G64 P1\nG61.1", -1.0),
    ],
)
def test_the_junction_behind_a_block_has_the_tolerance_in_force(code, tolerance):
    assert read(code, "G0 X1")[-1].tolerance == pytest.approx(tolerance, rel=1e-15)


@pytest.mark.parametrize(
    "block, message",
    [
        ("G64 P0", "1: the tolerance of G64 must be above 0, got P0; write G61 for the exact path"),
        ("G64 P-1", "1: the tolerance of G64 must be above 0, got P-1; write G61 for the exact path"),
        ("G64 P1 Q-1", "1: the tolerance of G64 must be above 0, got Q-1; remove it"),
    ],
)
def test_a_tolerance_that_is_none_is_refused(block, message):
    assert refused(block) == message


@pytest.mark.parametrize(
    "lines, spindle",
    [
        (["M3 S1000"], 1000),
        (["S1000 M4"], -1000),
        (["S1000"], 0),
        (["M3"], 0),
        (["M3", "S200.5"], 200.5),
        (["M3 S100", "M5"], 0),
        (["M3 S100", "M5", "M4"], -100),
        (["M3 S100", "G97 S50"], 50),
        (["M3 S100", "T1 M6"], 0),  # a change of tool stops it, as LinuxCNC does
        (["T1 M6 M3 S100"], 100),  # the change comes first
    ],
)
def test_the_spindle_turns_as_it_was_told(lines, spindle):
    assert read(*lines, "G0 X1")[-1].spindle == spindle


@pytest.mark.parametrize(
    "lines, tool",
    [
        (["T5"], (0, 0, 0)),
        (["T5 M6"], (0, 0, 0)),  # the offset comes with G43
        (["G43"], (0, 0, 0)),
        (["T5", "G43"], (0, 0, 0)),  # chosen, not in the spindle
        (["T5 M6", "G43"], (0.001, 0.002, 0.05)),
        (["M6 T5 G43"], (0.001, 0.002, 0.05)),
        (["T5 M6 G43 H1"], (0, 0, 0.01)),
        (["T5 M6", "T1", "G43"], (0.001, 0.002, 0.05)),
        (["T5 M6", "G43 H0"], (0.001, 0.002, 0.05)),  # H0 is no H
        (["G43 H5", "T1 M6"], (0.001, 0.002, 0.05)),
        (["G43 H5", "T1 M6", "G43"], (0, 0, 0.01)),
        (["G43 H5", "G49"], (0, 0, 0)),
        (["M61 Q5", "G43"], (0.001, 0.002, 0.05)),
        (["G43 H5", "T0 M6", "G43"], (0, 0, 0)),
        (["G43.1 Z5 X1"], (0.001, 0, 0.005)),
        (["G43.1 Z5 X1", "G43.1 Z7"], (0.001, 0, 0.007)),
        (["G43.1 Z5", "G43.1"], (0, 0, 0.005)),
        (["G20", "G43.1 Z1"], (0, 0, 0.0254)),
        (["G43 H5", "G43.2 H1"], (0.001, 0.002, 0.06)),
    ],
)
def test_the_tool_offset_in_force_is_that_of_the_tool_asked_for(lines, tool):
    assert read(*lines, "G0 X9", tools=TOOLS)[-1].tool == pytest.approx(tool, abs=1e-15)


def test_without_a_tool_table_every_tool_is_that_of_the_data_sheet():
    assert {b.tool for b in read("T12 M6", "G43", "G0 Z3", "G43 H99", "G0 Z5")} == {(0.0, 0.0, 0.0)}


@pytest.mark.parametrize(
    "block, message",
    [
        ("T9", "no such tool in the tool table, got T9; there is T1, T5"),
        ("G43 H7", "no such tool in the tool table, got H7; there is T1, T5"),
        ("M61 Q9", "no such tool in the tool table, got Q9; there is T1, T5"),
        ("M61 Q1.5", "the number of a tool is whole, and not below 0, got Q1.5; write e.g. T5"),
        ("T-1", "the number of a tool is whole, and not below 0, got T-1; write e.g. T5"),
        ("G43 H-1", "the number of a tool is whole, and not below 0, got H-1; write e.g. T5"),
        ("G43.2", "G43.2 without H; write H and the number of the tool to add"),
        ("G43.1 Z5 A1", "a tool has an offset in X, Y and Z only, got A1; remove it"),
    ],
)
def test_a_tool_that_there_is_not_is_refused(block, message):
    assert refused(block, tools=TOOLS) == f"1: {message}"


# -- M70 to M73 -------------------------------------------------------------------------------------------------------

SET = "G20 G18 G91 G90.1 G64 P1 G55"
OTHER = "G21 G17 G90 G91.1 G61 G54"


def test_m72_brings_back_what_m70_saved():
    lines = ["F100 S300 G43 H5", SET, "M3", "M70", "M4 S20 G49", OTHER, "F7", "G10 L2 P1 X9", "M72"]
    kept = read("G10 L2 P2 X3", *lines, "G1 X1", "G1 Z2", tools=TOOLS)
    plain = read("G10 L2 P2 X3", *lines[:3], "G1 X1", "G1 Z2", tools=TOOLS)
    for a, b in zip(moves(kept), moves(plain), strict=True):
        assert a._replace(line=0) == b._replace(line=0)


def test_m72_brings_back_neither_the_motion_mode_nor_g92_nor_the_tool():
    parameters = Parameters()
    lines = ["F9 G1 X5", "M70", "G0 X6", "G92 X7", "T5 M6", "M72", "X8", "G43"]
    blocks = read(*lines, tools=TOOLS, parameters=parameters)
    assert moves(blocks)[-1].rapid
    assert ends(moves(blocks))[-1][0] == pytest.approx(7)
    assert parameters.get(5211) == pytest.approx(-1)
    assert blocks[-1].tool == (0.001, 0.002, 0.05)


def test_m72_into_another_feed_mode_leaves_no_feed():
    text = refused("G91 F50", "M70", "F60 G93", "M72", "G1 X5")
    assert text == "5: G1 without a feed; write F, in mm/min, before it or with it"


@pytest.mark.parametrize(
    "lines",
    [
        ["M72"],
        ["M70", "M71", "M72"],
        ["O<a> sub", "M72", "O<a> endsub", "M70", "O<a> call"],  # saved one level up
        ["O<a> sub", "M70", "O<a> endsub", "O<a> call", "M72"],  # saved at a level that has ended
    ],
)
def test_m72_needs_a_state_saved_at_its_own_level(lines):
    text = refused(*lines, "G0 X1")
    assert text.endswith(": M72 without M70 or M73 at this level of calls; write M70 before it")


@pytest.mark.parametrize(
    "inside, twice",
    [
        (["M73", "G91 G20"], False),
        (["M73", "G91", "M71"], True),  # rs274: M71 takes back the restore too
        (["M70", "G91"], True),
        (["M70", "G91", "M72"], False),
    ],
)
def test_a_return_restores_what_m73_saved(inside, twice):
    blocks = read("O<a> sub", *inside, "O<a> endsub", "O<a> call", "G0 X#5420 Y1", "G0 X1", "G0 X1")
    assert ends(blocks)[-1][0] == pytest.approx(2 if twice else 1)


def test_a_return_through_two_levels_restores_what_the_outer_one_saved():
    inner = ["O<b> sub", "M73", "G20", "O<b> endsub"]
    outer = ["O<a> sub", "M73", "G91", "O<b> call", "G0 X1", "O<a> endsub"]
    blocks = read(*inner, *outer, "O<a> call", "G0 X5")
    assert [e[0] for e in ends(blocks)] == pytest.approx([1, 5])


def test_the_end_of_a_program_resets_what_m2_resets():
    modes = Modes(motion=20, plane=180, absolute=False, inverse_time=True, spindle=1, mist=True, unit=25.4e-3, feed=1.0)
    modes.end()
    assert modes == Modes(motion=10, unit=25.4e-3)


def test_saved_modes_are_a_copy():
    modes, saves = Modes(), Saves()
    saves.save(0, modes, 1, (0.0, 0.0, 0.0), False)
    modes.plane = 190
    assert saves.restore(0, modes)[0].plane == 170
    modes.plane = 180
    assert saves.restore(0, modes)[0].plane == 170


def test_a_program_reads_the_state_of_the_machine():
    """The numbers are those that rs274 prints of (PRINT, #<...>)."""
    names = {
        "_motion_mode": 10, "_plane": 190, "_metric": 0, "_imperial": 1, "_absolute": 0, "_incremental": 1,
        "_coord_system": 593, "_tool_offset": 1, "_spindle_on": 1, "_spindle_cw": 1, "_flood": 1, "_mist": 0,
        "_rpm": 50, "_current_tool": 5, "_selected_tool": 5, "_ccomp": 400, "_retract_old_z": 1, "_feed_override": 1,
        "_inverse_time": 0, "_units_per_minute": 1, "_feed": 10,
    }  # fmt: skip
    numbers = {5400: 5, 5401: 1, 5402: 2, 5403: 50, 5410: 6, 5220: 9}
    setup = ["G20", "G1 F10 X1 G59.3 G64 P1", "G91.1 G91 G19", "M3 S50 M8 T5 M6", "M3", "G43"]
    checks = [f"#<_sum>=[#<_sum>+ABS[{n}-{v}]]" for n, v in [*((f"#<{k}>", v) for k, v in names.items()),
                                                             *((f"#{k}", v) for k, v in numbers.items())]]  # fmt: skip
    blocks = read(*setup, "#<_sum>=0", *checks, "G90 G21 G49", "G0 Z[#<_sum>+1]", tools=TOOLS)
    assert ends(blocks)[-1][2] == pytest.approx(1)


def test_a_program_reads_where_it_is_in_its_own_coordinates_and_unit():
    lines = ["G10 L2 P1 X1 Y2 R30", "G0 X5 Y6 A10", "G92 Z4", "G20"]
    blocks = read(*lines, "G0 X[#<_x>+1] Y[#5421-1] Z[#<_z>*2] A[#5423+#<_a>]")
    c, s = math.cos(math.radians(30)), 0.5
    x, y = 5 + 25.4, 6 - 25.4
    assert ends(blocks)[-1] == pytest.approx((1 + c * x - s * y, 2 + s * x + c * y, 4, 20, 0, 0), abs=1e-9)
