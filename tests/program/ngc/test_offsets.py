"""Coordinate systems, G92 and tool offsets: identities, and the numbers that LinuxCNC's rs274 printed."""

import math

import numpy as np
import pytest

from gough.frames import rotation_of_abc_np
from gough.program.ngc.offsets import Offsets, turned_by
from gough.program.ngc.parameters import Parameters

from .machine import TOOLS, ends, moves, read, refused


def random_offsets(rng):
    """Every system somewhere, turned, with G92 and a tool, and one of the systems selected."""
    offsets = Offsets(Parameters())
    for system in range(1, 10):
        offsets.set_origin(system, dict(enumerate(rng.uniform(-1, 1, 6))), rng.uniform(-3, 3))
    offsets.select(int(rng.integers(1, 10)))
    offsets.shift_by(dict(enumerate(rng.uniform(-1, 1, 6))))
    offsets.tool = tuple(rng.uniform(-0.2, 0.2, 3))
    return offsets


@pytest.fixture(params=range(20))
def rng(request):
    return np.random.default_rng(request.param)


def test_program_coordinates_and_the_frame_are_one_another_s_inverse(rng):
    offsets, p = random_offsets(rng), list(rng.uniform(-1, 1, 6))
    assert offsets.to_program(offsets.to_frame(p)) == pytest.approx(p, abs=1e-14)


def test_the_frame_is_the_origin_and_the_turned_coordinates(rng):
    """Eq. (1) with matrices of frames.py, from the parameters that the offsets keep."""
    parameters = Parameters()
    offsets = Offsets(parameters)
    offsets.set_origin(3, dict(enumerate(rng.uniform(-1, 1, 6))), rng.uniform(-3, 3))
    offsets.select(3)
    offsets.shift_by(dict(enumerate(rng.uniform(-1, 1, 6))))
    kept = np.array([parameters.get(n) for n in range(5261, 5271)])
    g92 = np.array([parameters.get(n) for n in range(5211, 5217)])
    p = rng.uniform(-1, 1, 6)
    turn = rotation_of_abc_np(np.radians([0, 0, kept[9]]))
    place = kept[:3] / 1e3 + turn @ (p[:3] + g92[:3] / 1e3)
    angles = np.radians(kept[3:6] + g92[3:]) + p[3:]
    assert offsets.to_frame(list(p)) == pytest.approx([*place, *angles], abs=1e-14)


def test_g10_l20_gives_the_point_its_coordinates_and_the_other_axes_keep_theirs(rng):
    offsets, at = random_offsets(rng), list(rng.uniform(-1, 1, 6))
    for system in (0, offsets.system % 9 + 1):
        chosen = system or offsets.system
        now = offsets.system
        offsets.select(chosen)
        before = offsets.to_program(at)
        offsets.select(now)
        axes = {int(k): float(rng.uniform(-1, 1)) for k in rng.choice(6, 3, replace=False)}
        offsets.set_here(system, at, axes)
        offsets.select(chosen)
        expected = [axes.get(k, before[k]) for k in range(6)]
        assert offsets.to_program(at) == pytest.approx(expected, abs=1e-14)
        offsets.select(now)


def test_g92_gives_the_point_its_coordinates_and_the_other_axes_keep_theirs(rng):
    offsets, at = random_offsets(rng), list(rng.uniform(-1, 1, 6))
    before = offsets.to_program(at)
    offsets.shift_here(at, {0: 0.25, 2: -0.5, 4: 1.0})
    expected = [0.25, before[1], -0.5, before[3], 1.0, before[5]]
    assert offsets.to_program(at) == pytest.approx(expected, abs=1e-14)


def test_a_tool_turns_with_the_axes(rng):
    abc, tool = rng.uniform(-3, 3, 3), tuple(rng.uniform(-1, 1, 3))
    assert turned_by(abc, tool) == pytest.approx(rotation_of_abc_np(abc) @ tool, abs=1e-15)


def test_the_tip_and_the_tool_point_are_one_another_s_inverse(rng):
    offsets, at = random_offsets(rng), list(rng.uniform(-1, 1, 6))
    assert offsets.tip_of(offsets.tool_point(at)) == pytest.approx(at, abs=1e-15)


def test_another_tool_leaves_the_machine_where_it_is():
    """T = tip + R tool, from the blocks themselves, before and behind each change of the offset."""
    blocks = read("G0 X10 A30 B-20 C50", "G43 H5", "G43.1 X3 Z7", "G43.2 H1", "G49", tools=TOOLS)
    t = [rotation_of_abc_np(np.array(b.abc1)) @ b.tool + (b.segment[-1]) for b in blocks]
    assert [b.tool for b in blocks] == [
        pytest.approx(v)
        for v in [(0, 0, 0), (0.001, 0.002, 0.05), (0.003, 0.002, 0.007), (0.003, 0.002, 0.017), (0, 0, 0)]
    ]
    np.testing.assert_allclose(t, [[0.01, 0, 0]] * 5, atol=1e-15)


def test_with_a_tool_offset_the_tip_goes_where_the_words_say():
    blocks = moves(read("G43 H5", "G0 X1 Y1 Z1", "G53 G0 Z0", "G0 Z3", tools=TOOLS))
    assert ends(blocks) == [pytest.approx(v) for v in [(1, 1, 1, 0, 0, 0), (1, 1, -50, 0, 0, 0), (1, 1, 3, 0, 0, 0)]]


@pytest.mark.parametrize(
    "lines, last",
    [
        # rs274: USE_TOOL_LENGTH_OFFSET(1, 0, 3); home is where T was, so G28 without offset leads to (1, 0, 3)
        (["G43.1 Z3 X1", "G0 X0 Y0 Z0", "G28.1", "G49", "G0 X50 Y50 Z50", "G28"], (1, 0, 3)),
        (["G0 X5", "G92 X0", "X1", "G92 X3 Y4", "X0"], (3, 0, 0)),
        (["G0 X5", "G92 X0", "X1", "G92 X3 Y4", "X0", "G92.2", "X0"], (0, 0, 0)),
        (["G0 X5", "G92 X0", "X1", "G92 X3 Y4", "X0", "G92.2", "X0", "G92.3", "X0"], (3, 0, 0)),
        (["G0 X5", "G92 X0", "X1", "G92 X3 Y4", "X0", "G92.1", "G92.3", "X1"], (1, 0, 0)),
        (["G92 X5", "G92.2", "#5211=9", "G92.3", "G0 X0"], (9, 0, 0)),
        (["G0 X5", "G92 X0", "G10 L2 P1 X10", "X1"], (16, 0, 0)),  # both offsets
        (["G0 X5", "G92 X0", "G10 L2 P1 X10", "X1", "G55", "X1"], (6, 0, 0)),  # G92 holds in all systems
        (["G20", "G52 X1", "G21", "G0 X0"], (25.4, 0, 0)),
        (["G0 X5", "G52 X1", "X0", "G52 X2 Y3", "X0 Y0"], (2, 3, 0)),
        (["G10 L2 P1 X1 Y2 R90", "G0 X3 Y4", "G92 X10 Y20", "G53 G0 X7 Y8"], (7, 8, 0)),
        (["G91", "G10 L2 P1 X5", "G10 L2 P1 X5", "G90 G0 X0"], (5, 0, 0)),
        (["G10 L2 P0 X5", "G10 L2 P9 X7", "G59.3 G0 X0"], (7, 0, 0)),
        (["G20 G10 L2 P1 X1", "G21 G0 X0"], (25.4, 0, 0)),
        (["#5221=5", "G54", "G0 X1"], (1, 0, 0)),  # G54 is in force and not read again
        (["#5221=5", "G55", "G54", "G0 X0"], (5, 0, 0)),
        (["G10 L2 P2 X5", "G0 X[#5241+1]"], (6, 0, 0)),
        (["G10 L20 P1 X9", "G0 X[#5420+1]"], (1, 0, 0)),
        (["G10 L2 P1 X1 R45", "G10 L2 P1 X2", "G10 L2 P1 R0", "G0 X0"], (2, 0, 0)),
    ],
)
def test_offsets_lead_where_linuxcnc_s_do(lines, last):
    assert ends(read(*lines))[-1][:3] == pytest.approx(last, abs=1e-9)


@pytest.mark.parametrize(
    "lines, first, values",
    [  # what rs274 printed as SET_G5X_OFFSET
        (["G0 X5 Y6", "G10 L2 P1 R90", "G10 L20 P1 X0"], 5221, (0, 6)),
        (["G0 X5 Y6", "G10 L2 P1 R90", "G10 L20 P1 X0 Y0"], 5221, (5, 6)),
        (["G0 X5 Y6", "G92 X1", "G10 L20 P1 X0 Y0"], 5221, (1, 6)),
        (["G0 X5 Y6", "G92 X1", "G10 L20 P2 X0 Y0"], 5241, (1, 6)),
        (["G10 L2 P2 X1 Y2 R30", "G0 X5 Y6", "G10 L20 P2 X0"], 5241, (5.7321, 4.7321)),
        (["G0 X5 Y6", "G10 L2 P1 R90", "G10 L20 P1 X0", "G0 X1", "G92 X3", "G10 L20 P1 Y2"], 5221, (7, 6)),
        (
            ["G0 X5 Y6", "G10 L2 P1 R90", "G10 L20 P1 X0", "G0 X1", "G92 X3", "G10 L20 P1 Y2", "G0 X0 Y0",
             "G10 L2 P2 R30 X1", "G10 L20 P2 X7 Y8"],
            5241, (6.6699, -5.4282),
        ),
    ],
)  # fmt: skip
def test_origins_are_where_linuxcnc_puts_them(lines, first, values):
    parameters = Parameters()
    read(*lines, parameters=parameters)
    assert [parameters.get(first), parameters.get(first + 1)] == pytest.approx(values, abs=0.5e-4)  # printed digits


def test_a_turned_system_turns_the_path():
    lines = ["G0 X3 Y4 Z0", "G1 X7 Y-1 Z2 F50", "G91", "X-4", "Y2 Z-1"]
    plain, turned = ends(read(*lines)), ends(read("G10 L2 P3 X10 Y20 Z30 R37", "G56", *lines))
    c, s = math.cos(math.radians(37)), math.sin(math.radians(37))
    for (x, y, z, *_), got in zip(plain, turned, strict=True):
        assert got[:3] == pytest.approx((10 + c * x - s * y, 20 + s * x + c * y, 30 + z), abs=1e-9)


def test_a_parameter_file_says_where_a_program_begins():
    parameters = Parameters()
    parameters.read("5220 2\n5241 10\n5250 90\n5210 1\n5211 1\n")
    assert ends(read("G0 X3 Y0", parameters=parameters))[-1][:2] == pytest.approx((10, 4), abs=1e-12)


@pytest.mark.parametrize(
    "block, message",
    [
        ("G92", "G92 without an axis word; write e.g. G92 X0"),
        ("G52", "G52 without an axis word; write e.g. G52 X0"),
        ("G10 P1 X1", "G10 goes with L2 or L20 here; write e.g. G10 L2 P1 X0"),
        ("G10 L1 P1 Z1", "G10 goes with L2 or L20 here, got L1; write e.g. G10 L2 P1 X0"),
        ("G10 L2 X1", "P of G10 L2 is a whole number from 0 to 9; 1 is G54, 9 is G59.3, 0 the one in force"),
        ("G10 L2 P10 X1", "P of G10 L2 is a whole number from 0 to 9, got P10; "
            "1 is G54, 9 is G59.3, 0 the one in force"),
        ("G10 L20 P-1 X1", "P of G10 L20 is a whole number from 0 to 9, got P-1; "
            "1 is G54, 9 is G59.3, 0 the one in force"),
        ("G10 L2 P1.5 X1", "P of G10 L2 is a whole number from 0 to 9, got P1.5; "
            "1 is G54, 9 is G59.3, 0 the one in force"),
        ("G10 L20 P1 X0 R30", "R does not go with G10 L20, got R30; write it with G10 L2"),
        ("G10 L2 P1 I1", "I belongs to an arc, got I1; write G2 or G3"),
        ("G10 L2 P1 Q1", "Q without a code that takes it, got Q1; remove it, or write G64 or M61 beside it"),
        ("G92.1 X1", "an axis word with no G0, G1, G2 or G3 in force, got X1; write e.g. G0 or G1"),
        ("G28.1 X1", "an axis word with no G0, G1, G2 or G3 in force, got X1; write e.g. G0 or G1"),
    ],
)  # fmt: skip
def test_a_wrong_offset_is_refused(block, message):
    assert refused(block) == f"1: {message}"


def test_an_offset_beyond_all_machines_is_refused_where_it_is_used():
    text = refused("#5221=1000000000000", "G55", "G54", "G0 X1")
    assert text == "4: a move to a place beyond 1e6 mm or degrees; check the words and the offsets"
