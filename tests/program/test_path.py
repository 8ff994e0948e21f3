"""Paths: what they refuse, their circles, their size."""

import numpy as np
import pytest

from gough.errors import ProgramError
from gough.program.blocks import Arc, Block, Blocks, Line, Rest
from gough.program.feed import Feed, Limits
from gough.program.path import Path
from growth import growth

LINE = Line((0, 0, 0), (0.1, 0, 0))


@pytest.mark.parametrize(
    "blocks, message",
    [
        ([], "a path has at least one block"),
        ([Block(LINE, feed=0.0, line=3)], "3: the feed must be above 0, got 0"),
        ([Block(LINE, feed=-1.0, line=3)], "3: the feed must be above 0, got -1"),
        ([Block(Line((0, 0, 0), (0, 0, 0)), feed=1.0, line=7)], "7: a move has no length, got 0 m"),
        ([Block(Line((0, 0, 0), (float("nan"), 0, 0)), feed=1.0, line=7)], "7: a block must have finite numbers"),
        ([Block(Line((0, 0, 0), (float("inf"), 0, 0)), feed=1.0)], "a block must have finite numbers"),
        ([Block(LINE, feed=float("nan"))], "a block must have finite numbers"),
        ([Block(Arc((1, 0, 0), (1, 0, 5), (0, 0, 1), 1.0), feed=1.0)], "an arc must have a radius and a sweep above 0"),
        ([Block(Arc((1, 0, 0), (0, 0, 0), (0, 0, 1), 0.0), feed=1.0)], "an arc must have a radius and a sweep above 0"),
        (
            [Block(LINE, feed=1.0, line=1), Block(Line((0.2, 0, 0), (0.3, 0, 0)), feed=1.0, line=2)],
            "2: a block must start where the last one ended, got a gap of 0.1 m",
        ),
        (
            [Block(LINE, (0, 0, 0), (0, 0, 0), 1.0), Block(Rest((0.1, 0, 0)), (0, 0, 0.1), (0, 0, 0), 1.0, line=5)],
            "5: a block must start with the angles the last one ended with",
        ),
    ],
)
def test_a_path_that_cannot_be_run_is_refused(blocks, message):
    with pytest.raises(ProgramError) as caught:
        Path(blocks)
    assert str(caught.value) == message


def test_arcs_on_one_circle_are_one_circle():
    """CAM systems split a circle into halves or quarters."""
    quarter = [
        Arc((0.1 * np.cos(a), 0.1 * np.sin(a), 0), (0, 0, 0), (0, 0, 1), np.pi / 2) for a in np.arange(4) * np.pi / 2
    ]
    path = Path([Block(arc, feed=0.05, line=k) for k, arc in enumerate(quarter, 21)])
    np.testing.assert_array_equal(path.circle, [1, 1, 1, 1])
    (circle,) = path.circles
    assert (circle.id, circle.line, circle.ccw, circle.radius) == (1, 21, True, pytest.approx(0.1, rel=1e-15))
    assert Path([Block(arc, feed=0.05) for arc in quarter[:3]]).circles == []


def test_a_helix_and_a_rapid_are_no_circles():
    turn = Arc((0.1, 0, 0), (0, 0, 0), (0, 0, 1), 2 * np.pi, 0.01)
    assert Path([Block(turn, feed=0.05)]).circles == []


def test_a_clockwise_circle_says_so():
    turn = Arc((0.1, 0, 0), (0, 0, 0), (0, 0, 1), -2 * np.pi)
    (circle,) = Path([Block(turn, feed=0.05, line=4)]).circles
    assert circle.to_json() == {
        "id": 1, "line": 4, "center": [0.0, 0.0, 0.0], "radius": 0.1, "normal": [0.0, 0.0, -1.0], "feed": 0.05,
        "ccw": False,
    }  # fmt: skip


def test_a_placed_path_keeps_its_lengths_and_places_its_circles():
    turn = Arc((0.1, 0, 0), (0, 0, 0), (0, 0, 1), 2 * np.pi)
    path = Path([Block(turn, feed=0.05)])
    R = np.array([[0.0, -1, 0], [0, 0, -1], [1, 0, 0]])
    placed = path.placed([1, 2, 3], R)
    assert placed.s0[-1] == path.s0[-1]
    np.testing.assert_allclose(placed.circles[0].center, [1, 2, 3], atol=1e-15)
    np.testing.assert_allclose(placed.circles[0].normal, R[:, 2], atol=1e-15)
    np.testing.assert_array_equal(path.R_WO, np.eye(3))  # the first is as it was


def test_blocks_and_paths_print_a_line_a_block_in_the_units_of_nc_programs():
    end = (0.1, 0.05, 0.0)
    blocks = [
        Block(Line((0, 0, 0), (0.1, 0, 0)), rapid=True, line=3),
        Block(Arc((0.1, 0, 0), (0.1, 0.025, 0), (0, 0, 1), np.pi), feed=0.02, line=4, tolerance=2e-5),
        Block(Arc(end, (0.1, 0.025, 0), (0, 0, 1), -np.pi, -0.001), feed=0.02, line=5, tolerance=-1.0),
        Block(Rest((0.1, 0, -0.001)), (0, 0, 0), (0.5, 0, 0), feed=0.1, line=6, tolerance=np.inf),
        Block(Rest((0.1, 0, -0.001)), (0.5, 0, 0), (0.5, 0, 0), dwell=1.5, line=7),
        Block(Line((0.1, 0, -0.001), (0, 0, 0)), (0.5, 0, 0), (0, 0, 0), feed=0.03),
    ]
    expected = """\
NC line  move        X   Y   Z        A  B  C  centre          F  corner
      3  G0        100   0   0        0  0  0
      4  G3        100  50   0        0  0  0  100 25 0     1200  blend 0.02
      5  G2 helix  100   0  -1        0  0  0  100 25 0     1200  exact stop
      6  turn      100   0  -1  28.6479  0  0            343.775  blend
      7  G4 P1.5   100   0  -1  28.6479  0  0
         G1          0   0   0        0  0  0               1800"""
    assert str(Path(blocks)) == expected
    assert str(Blocks(blocks)) == expected


def test_a_long_table_is_cut_in_the_middle_and_an_empty_one_says_so():
    points = [(k * 1e-3, 0.0, 0.0) for k in range(1001)]
    path = Path(
        [Block(Line(a, b), feed=0.1, line=k) for k, (a, b) in enumerate(zip(points[:-1], points[1:], strict=True), 1)]
    )
    rows = str(path).splitlines()
    assert len(rows) == 42
    assert rows[21] == "... 960 more ..."
    assert rows[20].split()[:3] == ["20", "G1", "20"]
    assert rows[22].split()[:3] == ["981", "G1", "981"]
    assert str(Blocks()) == "0 blocks: a path has at least one block"


@pytest.mark.full
def test_the_time_of_paths_and_feeds_grows_with_the_blocks():
    def chain(n):
        points = np.cumsum(np.random.default_rng(0).normal(size=(n + 1, 3)) * 1e-4, axis=0)
        return [Block(Line(tuple(a), tuple(b)), feed=0.05) for a, b in zip(points[:-1], points[1:], strict=True)]

    assert (
        growth(chain, lambda blocks: Feed(Path(blocks), Limits(0.3, 2.0, 1.0, 5.0)), 2500) < 2
    )  # 2: caches and the garbage collector's passes; anything quadratic would be 8


def test_a_path_is_at_most_a_thousand_kilometres_long():
    there, back = (
        Block(Line(a, b), feed=1.0, line=n) for n, a, b in ((7, (0, 0, 0), (4e5, 0, 0)), (8, (4e5, 0, 0), (0, 0, 0)))
    )
    assert Path([there, back]).s0[-1] == 8e5
    with pytest.raises(ProgramError) as caught:
        Path([there, back, there])
    assert str(caught.value) == "7: a path is at most 1000 km long, got 1200 km"
