"""Arcs: identities of the geometry, the planes, and the tolerances of LinuxCNC."""

import math

import numpy as np
import pytest

from gough.program.blocks import Arc, Line
from gough.program.ngc import arcs
from gough.program.ngc.modes import INCH, MM
from gough.program.path import Path

from .machine import read, refused

PERMUTED = {  # the same program in another plane: X Y Z and I J K become
    "G18": str.maketrans("XYZIJK", "ZXYKIJ"),
    "G19": str.maketrans("XYZIJK", "YZXJKI"),
}


def arc_of(*lines, **options):
    found = [b for b in read(*lines, **options) if type(b.segment) is Arc]
    assert len(found) == 1
    return found[0]


def shape(block):
    """Centre in mm, sweep in degrees about the positive normal."""
    segment = block.segment
    return [1e3 * v for v in segment.center], math.degrees(segment.sweep) * sum(segment.normal)


@pytest.mark.parametrize(
    "lines, center, sweep",
    [
        (["G2 X20 I10 J0 F9"], (10, 0), -180),
        (["G3 X20 I10 J0 F9"], (10, 0), 180),
        (["G3 X10 Y10 I0 J10 F9"], (0, 10), 90),
        (["G2 X10 Y10 I0 J10 F9"], (0, 10), -270),
        (["G2 X0 Y0 I0 J10 F9"], (0, 10), -360),
        (["G2 J10 F9"], (0, 10), -360),
        (["G3 X10 Y10 R10 F9"], (0, 10), 90),
        (["G2 X10 Y10 R10 F9"], (10, 0), -90),
        (["G3 X10 Y10 R-10 F9"], (10, 0), 270),
        (["G2 X10 Y10 R-10 F9"], (0, 10), -270),
        (["G3 X20 R10 F9"], (10, 0), 180),
        (["G3 X20 R9.999 F9"], (10, 0), 180),  # 1 um too small; LinuxCNC allows 1.27
        (["G20", "G3 X1 Y1 J1 F9"], (0, 25.4), 90),
        (["G0 X5 Y5", "G91 G3 X10 Y10 J10 F9"], (5, 15), 90),
        (["G90.1 G2 X20 Y0 I10 J0 F9"], (10, 0), -180),
        (["G0 X5 Y5", "G91 G90.1 G3 X10 Y10 I5 J15 F9"], (5, 15), 90),  # centres absolute, ends not
        (["G2 X20 I10 P3 F9"], (10, 0), -900),
        (["G3 J10 P2 F9"], (0, 10), 720),
        (["G3 X10 Y10 R10 P2 F9"], (0, 10), 450),
        (["G3 X10 Y10 R-10 P1000 F9"], (10, 0), 270 + 999 * 360),
        (["G55 G10 L2 P2 X1 Y2", "G3 X9 Y8 J10 F9"], (0, 10), 90),
        (["G92 X1 Y2", "G90.1 G3 X11 Y12 I1 J12 F9"], (0, 10), 90),
        (["G10 L2 P1 R90", "G3 X10 Y10 J10 F9"], (-10, 0), 90),
        (["G10 L2 P1 R90", "G90.1 G3 X10 Y10 I0 J10 F9"], (-10, 0), 90),
    ],
)
def test_an_arc_has_the_centre_and_the_sense_of_its_words(lines, center, sweep):
    middle, turned = shape(arc_of(*lines))
    assert middle[:2] == pytest.approx(center, abs=1e-9)
    assert turned == pytest.approx(sweep, rel=1e-12)


@pytest.mark.parametrize("plane", ["G18", "G19"])
@pytest.mark.parametrize(
    "line",
    ["G2 X20 Y6 R14 F9", "G3 X20 Y6 R-14 F9", "G3 X10 Y10 Z3 J10 F9", "G2 I7 J1 P4 Z-5 F9", "G3 X7 Y1 I3 J4 P2 F9"],
)
def test_the_planes_are_one_another_with_their_axes_renamed(plane, line):
    flat, other = arc_of(line).segment, arc_of(f"{plane} {line.translate(PERMUTED[plane])}").segment
    order = {"G18": (2, 0, 1), "G19": (1, 2, 0)}[plane]
    for a, b in ((flat.center, other.center), (flat.normal, other.normal)):
        assert [b[k] for k in order] == pytest.approx(a, abs=1e-15)
    assert (other.sweep, other.rise) == pytest.approx((flat.sweep, flat.rise), abs=1e-15)


def test_the_sense_in_the_xz_plane_is_seen_from_y():
    """rs274 prints ARC_FEED(0, 10, 0, 5, -1) in the plane Z X: back from X to Z, the centre at X5: it bulges to -Z."""
    path = Path(read("G18 G2 X10 I5 F9"))
    middle = path.point(np.array([0]), path.length / 2)[0]
    np.testing.assert_allclose(1e3 * middle, [5, 0, -5], atol=1e-12)


def test_a_turned_coordinate_system_turns_the_normal_of_an_arc():
    segment = arc_of("G10 L2 P1 R30", "G18 G2 X10 I5 F9").segment
    assert segment.normal == pytest.approx((-0.5, math.sqrt(0.75), 0), abs=1e-15)
    assert segment.center == pytest.approx((0.005 * math.sqrt(0.75), 0.0025, 0), abs=1e-15)


def test_a_helix_rises_and_tilts_in_proportion_to_its_angle():
    path = Path(read("G0 X10", "G2 X10 Y0 Z-4 A8 I-10 J0 P2 F600"))
    i, quarter = np.array([1]), path.length[1:] / 8  # of the first of two turns
    np.testing.assert_allclose(1e3 * path.point(i, quarter)[0], [0, -10, -0.5], atol=1e-12)
    np.testing.assert_allclose(np.degrees(path.angles(i, quarter))[0], [1, 0, 0], atol=1e-12)
    assert path.length[1] == pytest.approx(math.hypot(0.04 * math.pi, 0.004), rel=1e-14)


def test_any_arc_by_its_radius_runs_through_both_ends_by_the_way_that_was_asked_for():
    rng = np.random.default_rng(1)
    for _ in range(300):
        start, end = rng.uniform(-0.1, 0.1, (2, 2))
        half = math.dist(start, end) / 2
        radius = half * 10 ** rng.uniform(0, 6) * rng.choice([-1, 1])
        clockwise = bool(rng.integers(2))
        center, sweep = arcs.by_radius(start, end, radius, clockwise)
        # the centre of a circle of radius r is known to r eps
        tolerance = 4e-16 * (1 + abs(radius))
        assert math.dist(arcs.end(start, center, sweep), end) < 10 * tolerance
        assert math.dist(start, center) == pytest.approx(abs(radius), abs=10 * tolerance)
        assert (sweep < 0) == clockwise
        assert (abs(sweep) <= math.pi) == (radius > 0)


def test_any_arc_by_its_centre_runs_through_both_ends():
    rng = np.random.default_rng(2)
    for _ in range(300):
        center, start = rng.uniform(-0.1, 0.1, (2, 2))
        turn = rng.uniform(0.3, 2 * math.pi - 0.3)
        end = np.array(arcs.end(start, center, turn)) + rng.uniform(-5e-6, 5e-6, 2)  # as CAM rounds
        found, sweep = arcs.by_center(start, end, center, False, MM)
        assert math.dist(arcs.end(start, found, sweep), end) < 1e-15
        assert math.dist(found, center) < 50e-6  # the error of the end over twice the sine of half the turn
        assert 0 < sweep < 2 * math.pi


def test_an_arc_with_a_huge_radius_is_no_full_turn():
    """On a circle of 100 km the ends of 10 mm are one direction from the centre."""
    center, sweep = arcs.by_radius((0, 0), (0.01, 0), 1e5, False)
    assert sweep == pytest.approx(1e-7, rel=1e-12)
    assert center == pytest.approx((0.005, 1e5), rel=1e-9)


def test_an_arc_rounded_by_the_cam_system_ends_on_its_end():
    blocks = read("G0 X20", "G3 X14.142 Y14.142 I-20.005 J0 F100", "G1 X0 Y0")
    assert [type(b.segment) for b in blocks] == [Line, Arc, Line]
    start, center, sweep = blocks[1].segment.start, blocks[1].segment.center, blocks[1].segment.sweep
    assert arcs.end(start[:2], center[:2], sweep) == pytest.approx((0.014142, 0.014142), abs=1e-15)
    assert center[:2] == pytest.approx((0, 0), abs=1e-5)


def test_a_full_circle_that_misses_its_start_by_rounding_keeps_its_centre():
    blocks = read("G0 X10", "G3 X10.001 Y0 I-10 J0 F100", "G1 X0")
    assert blocks[1].segment.center == pytest.approx((0, 0, 0), abs=1e-15)
    assert math.degrees(blocks[1].segment.sweep) == pytest.approx(360, abs=1e-12)
    assert blocks[2].segment == Line(pytest.approx((0.01, 0, 0)), pytest.approx((0.010001, 0, 0)))
    assert (blocks[2].line, blocks[2].feed) == (2, blocks[1].feed)


@pytest.mark.parametrize(
    "unit, miss, fine",
    [  # what rs274 accepts of G2 X[10+miss] I5 and of the same in inch
        (MM, 0.0280e-3, True),
        (MM, 0.0290e-3, False),
        (INCH, 2.0e-3 * 25.4e-3, True),
        (INCH, 3.0e-3 * 25.4e-3, False),
    ],
)
def test_the_ends_may_lie_apart_from_one_circle_as_far_as_linuxcnc_allows(unit, miss, fine):
    ends = (0.0, 0.0), (0.01 + miss, 0.0)
    if fine:
        arcs.by_center(*ends, (0.005, 0.0), True, unit)
    else:
        with pytest.raises(Exception, match="the ends of an arc must lie on one circle"):
            arcs.by_center(*ends, (0.005, 0.0), True, unit)


REFUSED = [
    ("G2", "an arc without an end; write X or Y, and I and J or R"),
    ("G2 X10", "an arc without a centre; write I and J, or R"),
    ("G18 G2 Z10", "an arc without a centre; write I and K, or R"),
    ("G2 Z5 R10", "an arc without an end; write X or Y"),
    ("G19 G2 X5 R10", "an arc without an end; write Y or Z"),
    ("G2 X10 I5 R5", "an arc has R, or I and J, not both, got R5; remove one"),
    ("G18 G2 X10 K5 R5", "an arc has R, or I and K, not both, got R5; remove one"),
    ("G2 X10 I5 K1", "an arc in the plane of G17 has no K, got K1; write I and J, or another plane before it"),
    ("G18 G2 X10 I5 J1", "an arc in the plane of G18 has no J, got J1; write I and K, or another plane before it"),
    ("G19 G2 Y10 I5", "an arc in the plane of G19 has no I, got I5; write J and K, or another plane before it"),
    ("G90.1 G2 X10 I5", "an arc without J, with G90.1; write I and J"),
    ("G90.1 G18 G2 X10 K5", "an arc without I, with G90.1; write I and K"),
    ("G2 X10 I0 J0", "an arc of radius zero, got 0.0000 mm; check I and J"),
    ("G2 X5 I5", "an arc of radius zero, got 0.0000 mm; check I and J"),
    ("G2 X.00001 I.00001", "an arc of radius zero, got 0.0000 mm; check I and J"),
    ("G2 X21 I10", "the ends of an arc must lie on one circle, got radius 10.0000 mm at the start, 11.0000 mm at the "
                   "end; check X, Y, I and J; I and J count from the start of the arc"),
    ("G90.1 G19 G2 Y21 Z0 J10 K0", "the ends of an arc must lie on one circle, got radius 10.0000 mm at the start, "
                                   "11.0000 mm at the end; check Y, Z, J and K"),
    ("G2 X10 R4", "the radius is too small to reach the end, got 4.0000 mm; at least 5.0000 mm"),
    ("G2 X10 R0", "the radius is too small to reach the end, got 0.0000 mm; at least 5.0000 mm"),
    ("G2 X0 Y0 R4", "an arc with R cannot end where it starts; write a full circle with its centre"),
    ("G2 X10 R1000000000", "the radius of an arc is too large, got 1000000000.0000 mm; write a line: G1"),
    ("G2 X10 R1000000001", "R is beyond 1000000000, got R1000000001; write at most 1000000000"),
    ("G2 X10 I5 P0", "P of an arc is a whole number of turns, got P0; write e.g. P2"),
    ("G2 X10 I5 P-1", "P of an arc is a whole number of turns, got P-1; write e.g. P2"),
    ("G2 X10 I5 P1.5", "P of an arc is a whole number of turns, got P1.5; write e.g. P2"),
    ("G2 X10 I5 P1001", "an arc has at most 1000 turns, got P1001; write several arcs"),
    ("G2 X10 I5 P1000000000", "an arc has at most 1000 turns, got P1000000000; write several arcs"),
]  # fmt: skip


@pytest.mark.parametrize("block, message", REFUSED, ids=[block for block, _ in REFUSED])
def test_a_wrong_arc_is_refused_with_its_line_its_words_and_a_cure(block, message):
    assert refused(f"F100 {block}") == f"1: {message}"


def test_an_arc_stays_within_a_kilometre():
    message = "2: a move to a place beyond 1e6 mm or degrees; check the words and the offsets"
    assert refused("G91 F9 G0 Z999999", "G2 X10 I5 Z2") == message


def test_an_arc_ends_where_the_next_block_starts():
    lines = ["F100 G10 L2 P1 R20 X3", "G0 X0 Y0", "G3 X10 Y10 I0 J10.004", "G18 G2 X20 Z1 R8", "G2 I3 P2", "G1 X0"]
    blocks = read(*lines)
    assert [type(b.segment) for b in blocks] == [Line, Arc, Arc, Arc, Line]
    path = Path(blocks)
    i = np.arange(len(path) - 1)
    np.testing.assert_allclose(path.point(i, path.length[:-1]), path.point(i + 1, 0 * path.length[1:]), atol=1e-9)
