"""Writing NC programs: what is written reads back as it was, and LinuxCNC takes it."""

import math
import shutil
import subprocess

import numpy as np
import pytest

from gough.errors import ProgramError
from gough.program import Circle, Ellipse
from gough.program.blocks import ARC, LINE, Arc, Block, Line, Rest
from gough.program.ngc.read import read_program
from gough.program.path import Path
from gough.program.write import to_gcode

RS274 = shutil.which("rs274")
needs_rs274 = pytest.mark.skipif(RS274 is None, reason="LinuxCNC's interpreter rs274 is not installed")
NORMALS = {"G17": (0, 0, 1), "G18": (0, 1, 0), "G19": (1, 0, 0)}


def read(text):
    return Path(read_program(text, "part.ngc"))


def places(path, shares=(0.0, 0.3, 0.71, 1.0)):
    """Points and angles at some shares of every block.  (k, m, 6)."""
    i = np.arange(len(path))
    return np.array(
        [np.column_stack([path.point(i, w * path.length), path.angles(i, w * path.extent)]) for w in shares]
    )


def rounding(path):
    """How far ten decimals, half of 1e-13 m or 1.7e-12 rad, may move a point, or an angle.

    Of an arc both ends and the centre are rounded; the reader makes them one circle by moving the centre along the
    chord, which counts radius / chord times.
    """
    arcs = path.batches[ARC]
    chord = 2 * arcs.radius * np.abs(np.sin(arcs.sweep / 2))
    worst = (arcs.radius / chord)[chord > 1e-9].max(initial=1.0)
    return max(1e-12, 2e-13 * worst)


def assert_alike(back, path):
    """The same blocks; `back` begins with a rapid to where the path begins, unless that is zero."""
    skip = len(back) - len(path)
    assert skip == (1 if np.abs(places(path)[0, 0]).max() > 1e-13 else 0)
    np.testing.assert_allclose(places(back)[:, skip:], places(path), rtol=0, atol=rounding(path))
    for name in ("kind", "rapid", "dwell", "spindle"):
        np.testing.assert_array_equal(getattr(back, name)[skip:], getattr(path, name), err_msg=name)
    moving = (path.length > 0) | path.turning_at_rest  # any other block is a stop whatever its tolerance says
    np.testing.assert_allclose(back.tolerance[skip:][moving], path.tolerance[moving], rtol=0, atol=1e-13)
    fed = ~path.rapid & moving
    np.testing.assert_allclose(back.feed[skip:][fed], path.feed[fed], rtol=3e-12)  # ten decimals of 17 deg/min


class Walk:
    """A random path of everything that has a word, from zero on."""

    def __init__(self, seed, blocks=25):
        self.rng = np.random.default_rng(seed)
        self.at, self.abc = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        self.modes = {"tolerance": 0.0, "spindle": 0.0}
        self.blocks, self.used = [], set()
        for _ in range(blocks):
            self.used.add(getattr(self, self.rng.choice(["line", "rapid", "arc", "arc", "turn", "dwell", "mode"]))())

    def add(self, segment, end, turn=False, **more):
        abc = tuple(self.rng.uniform(-0.4, 0.4, 3)) if turn or self.rng.random() < 0.4 else self.abc
        feed = float(self.rng.uniform(0.005, 0.1))
        self.blocks.append(Block(segment, self.abc, abc, **{"feed": feed, **self.modes, **more}))
        self.at, self.abc = end, abc

    def line(self, rapid=False):
        end = tuple(np.array(self.at) + self.rng.uniform(-0.05, 0.05, 3))
        self.add(Line(self.at, end), end, rapid=rapid)
        return "line"

    def rapid(self):
        self.line(rapid=True)
        return "rapid"

    def arc(self):
        rng, plane = self.rng, self.rng.choice(list(NORMALS))
        n = np.array(NORMALS[plane], float)
        out = np.cross(n, rng.uniform(-1, 1, 3))
        center = np.array(self.at) + rng.uniform(0.005, 0.05) * out / np.linalg.norm(out)
        sweep = rng.choice([-1, 1]) * rng.choice([rng.uniform(0.01, 6.2), 2 * np.pi, 6 * np.pi, rng.uniform(7, 60)])
        rise = rng.choice([0.0, rng.uniform(-0.03, 0.03)])
        arc = Arc(self.at, tuple(center), tuple(n), float(sweep), float(rise))
        path = Path([Block(arc, feed=1.0)])
        self.add(arc, tuple(path.point(np.zeros(1, int), path.length)[0]))
        return plane

    def turn(self):
        self.add(Rest(self.at), self.at, turn=True, rapid=bool(self.rng.random() < 0.3))
        return "turn"

    def dwell(self):
        self.blocks.append(
            Block(Rest(self.at), self.abc, self.abc, dwell=round(self.rng.uniform(0, 2), 3), **self.modes)
        )
        return "dwell"

    def mode(self):
        """Another mode for the junctions from here on; or another spindle, which is a stop."""
        if self.rng.random() < 0.6:
            self.modes["tolerance"] = float(self.rng.choice([-1.0, 0.0, math.inf, self.rng.uniform(1e-6, 1e-4)]))
            return "tolerance"
        last = self.blocks[-1] if self.blocks else None
        if last and isinstance(last.segment, Rest) and not last.dwell and last.abc0 == last.abc1:
            return "spindle"  # two stops at one place are one
        old = self.modes["spindle"]
        self.modes["spindle"] = float(self.rng.choice([x for x in (0, 500, -800, 12000.5) if x != old]))
        self.blocks.append(Block(Rest(self.at), self.abc, self.abc, **self.modes))
        return "spindle"


@pytest.mark.parametrize("seed", range(40))
def test_what_is_written_reads_back_as_it_was(seed):
    path = Path(Walk(seed).blocks)
    assert_alike(read(to_gcode(path)), path)


def test_the_random_paths_hold_all_that_has_a_word():
    used = set().union(*(Walk(seed).used for seed in range(40)))
    assert used == {"line", "rapid", "G17", "G18", "G19", "turn", "dwell", "tolerance", "spindle"}


@needs_rs274
@pytest.mark.parametrize("seed", range(12))
def test_linuxcnc_takes_what_is_written(seed, tmp_path):
    path = Path(Walk(seed).blocks)
    file = tmp_path / "part.ngc"
    file.write_text(to_gcode(path, numbered=bool(seed % 2)))
    found = subprocess.run([RS274, "-g", file], cwd=tmp_path, capture_output=True, text=True, timeout=20)
    assert found.returncode == 0, found.stderr
    moves = [line for line in found.stdout.splitlines() if any(w in line for w in ("STRAIGHT_", "ARC_FEED"))]
    assert len(moves) == ((path.length > 0) | path.turning_at_rest).sum()


@pytest.mark.parametrize("seed", range(8))
def test_three_decimals_move_every_end_by_half_a_micrometre_at_most(seed):
    path = Path(Walk(seed, 40).blocks)
    back = read(to_gcode(path, decimals=3))
    skip = len(back) - len(path)
    off = np.abs(places(back, (1.0,))[0, skip:] - places(path, (1.0,))[0])
    assert off[:, :3].max() <= 0.5e-6 + 1e-12
    assert off[:, 3:].max() <= np.radians(0.5e-3) + 1e-12
    arcs, again = path.batches[ARC], back.batches[ARC]
    # both ends and the centre are each rounded to a diagonal of 0.7 um at most, on radii of 5 mm and more
    np.testing.assert_allclose(again.sweep, arcs.sweep, atol=4 * 0.71e-6 / 5e-3)


@pytest.mark.full
def test_a_circle_of_whole_turns_stays_one_however_its_ends_are_rounded():
    """Start and end of a computed circle differ in their last digits, and may be rounded apart."""
    rng = np.random.default_rng(0)
    for _ in range(300):
        center, turns = tuple(rng.uniform(-0.2, 0.2, 3)), float(rng.integers(1, 5))
        circle = Circle(radius=rng.uniform(0.001, 0.3), feed=0.05, center=center, start=rng.uniform(-7, 7), turns=turns)
        for decimals in (3, 6, 10):
            back = read(to_gcode(circle.path(), decimals=decimals))
            assert back.batches[ARC].sweep == pytest.approx([2 * np.pi * turns], abs=1e-12)


@pytest.mark.parametrize("off", [-5e-9, 5e-9])
@pytest.mark.parametrize("turns", [1, 3])
def test_an_arc_that_just_misses_whole_turns_ends_where_it_should(turns, off):
    radius, sweep = 0.05, 2 * np.pi * turns + off / 0.05
    path = Path([Block(Arc((radius, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), sweep), feed=0.05)])
    back = read(to_gcode(path))
    kinds, more = ([LINE, ARC], 0) if off < 0 else ([LINE, ARC, LINE], back.length[-1] / radius)
    assert list(back.kind) == kinds  # a reader would take the little that is behind whole turns for another turn
    # ten decimals of a mm on a radius of 50 mm, at both ends
    assert back.batches[ARC].sweep[0] + more == pytest.approx(sweep, abs=2e-13 / radius * 2)
    assert places(back)[-1, -1] == pytest.approx(places(path)[-1, -1], abs=1e-13)


def test_an_arc_shorter_than_its_decimals_becomes_a_line():
    arc = Arc((0.05, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 3e-6 / 0.05)
    path = Path([Block(arc, feed=0.05)])
    assert list(read(to_gcode(path, decimals=3)).kind) == [LINE, LINE]
    assert list(read(to_gcode(path, decimals=4)).kind) == [LINE, ARC]
    path = Path([Block(arc._replace(sweep=1.5e-6), feed=0.05)])
    assert list(read(to_gcode(path)).kind) == [LINE, LINE]  # its sweep is too near none for a reader


CURVES = {
    "ellipse": Ellipse(first=0.05, second=0.02, feed=0.03, plane=(0.3, 0.2, 0.1), turns=1.3),
    "circle": Circle(radius=0.05, feed=0.03, plane=(0.3, 0.2, 0.1), abc=(0.1, 0.2, 0.0)),
}


@pytest.mark.parametrize("name", CURVES)
@pytest.mark.parametrize("chord", [1e-6, 50e-6])
def test_short_lines_stay_as_near_the_curve_as_said_and_are_not_more_than_needed(name, chord):
    path = CURVES[name].path()
    back = read(to_gcode(path, chord=chord))
    assert set(back.kind) == {LINE}
    i = np.arange(1, len(back))
    middle = back.point(i, back.length[1:] / 2)
    near = (back.s0[1:-1] + back.s0[2:]) / 2 - back.length[0]
    zero = np.zeros(len(i), int)
    s = path.closest(zero, middle, near - 2e-3, near + 2e-3, near)
    off = np.linalg.norm(middle - path.point(zero, s), axis=1).max()
    assert 0.8 * chord < off <= chord  # 0.8: the number of lines is rounded up, by the sharpest point of the curve
    np.testing.assert_allclose(back.tolerance[1:-1], chord, rtol=1e-9)  # else the machine stops between the lines
    assert back.tolerance[-1] == path.tolerance[-1] == 0.0
    np.testing.assert_allclose(back.point(i[-1:], back.length[-1:]), path.point(zero[:1], path.length), atol=1e-12)


def test_a_block_may_carry_the_number_of_its_line():
    text = to_gcode(Circle(radius=0.1, feed=0.05).path(), "one\ntwo", numbered=True)
    assert text == ("(one)\n(two)\nN3 G17 G21 G90 G94 G61\nN4 G0 X100\nN5 G3 X100 Y0 I-100 J0 F3000\nN6 M2\n")
    assert list(read(text).line) == [4, 5]


def test_a_program_reads_like_one_a_person_wrote():
    """Modal words once, F where it changes, a full stop as G4 P0, planes as they come."""
    x = Line((0.0, 0.0, 0.0), (0.01, 0.0, 0.0))
    arc = Arc((0.01, 0.0, 0.0), (0.01, 0.0, 0.005), (0.0, 1.0, 0.0), np.pi)
    tip = (0.01, 0.0, 0.01)
    path = Path(
        [
            Block(x, feed=0.02, tolerance=math.inf, spindle=1000.0),
            Block(arc, feed=0.02, tolerance=-1.0, spindle=1200.0),
            Block(Rest(tip), (0.0, 0.0, 0.0), (0.0, np.radians(5), 0.0), feed=np.radians(2), spindle=1200.0),
            Block(Rest(tip), (0.0, np.radians(5), 0.0), (0.0, np.radians(5), 0.0), spindle=1200.0),
            Block(Rest(tip), (0.0, np.radians(5), 0.0), (0.0, np.radians(5), 0.0), dwell=0.25, spindle=0.0),
            Block(Line(tip, (0.0, 0.0, 0.0)), (0.0, np.radians(5), 0.0), rapid=True, tolerance=2e-5),
        ]
    )
    assert to_gcode(path).splitlines() == [
        "(written by gough)", "G17 G21 G90 G94 G61", "S1000 M3", "G64", "G1 X10 F1200", "S1200", "G61.1",
        "G18 G3 X10 Z10 K5 I0", "G61", "G1 B5 F120", "G4 P0", "M5", "G4 P0.25", "G64 P0.02", "G0 X0 Z0 B0", "M2",
    ]  # fmt: skip


LONG = Path([Block(Arc((0.1, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 1000.5 * 2 * np.pi), feed=0.1, line=7)])
TILTING = Path([Block(Line((0.0,) * 3, (2e-7, 0.0, 0.0)), abc1=(0.1, 0.0, 0.0), feed=0.1, line=3)])
RAPID_ARC = Path([Block(Arc((0.1, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 1.0), rapid=True, line=4)])
ALMOST = Path([Block(Arc((0.1, 0.0, 0.0), (0.0,) * 3, (0.0, 0.0, 1.0), 2 * np.pi - 2e-5), feed=0.1, line=5)])
OFFSET = Path([Block(Line((0.0,) * 3, (0.1, 0.0, 0.0)), feed=0.1, tool=(0.0, 0.0, 0.01), line=2)])
SLOW = Path([Block(Line((0.0,) * 3, (0.1, 0.0, 0.0)), feed=1e-17, line=6)])
X = Path([Block(Line((0.0,) * 3, (0.1, 0.0, 0.0)), feed=0.1)])
COMMENT = "leave out brackets and words that LinuxCNC acts on, at most 250 bytes"


@pytest.mark.parametrize(
    "path, options, message",
    [
        (CURVES["ellipse"].path(), {}, "an ellipse has no word of its own; give chord, how far short lines may be off"),
        (CURVES["circle"].path(), {},
         "an arc in a skew plane has no word of its own; give chord, how far short lines may be off"),
        (CURVES["circle"].path(), {"chord": 1e-18},
         "more than 1000000 short lines, got chord = 1e-18 m; a larger chord"),
        (LONG, {}, "7: an arc has at most 1000 turns, got 1001"),
        (RAPID_ARC, {}, "4: a rapid is a straight line"),
        (OFFSET, {}, "2: a tool offset cannot be written; write the path of the tip"),
        (TILTING, {"decimals": 3},
         "3: a move is shorter than 3 decimals can say, and the tool turns in it; more decimals"),
        (ALMOST, {"decimals": 3}, "5: an arc is closer to whole turns than 3 decimals can say; more decimals"),
        (SLOW, {}, "6: a feed too slow to be written"),
        (X.placed((0.0, 0.0, 0.1), np.eye(3)), {},
         "a path is written in its own frame, and this one was placed; write program.path()"),
        (X, {"decimals": 2}, "decimals must be a whole number from 3 to 12, got 2"),
        (X, {"decimals": True}, "decimals must be a whole number from 3 to 12, got True"),
        (X, {"decimals": 4.0}, "decimals must be a whole number from 3 to 12, got 4.0"),
        (X, {"chord": 0.0}, "chord must be above 0 m, got 0.0"),
        (X, {"chord": math.nan}, "chord must be above 0 m, got nan"),
        (X, {"title": "part (old)"}, f"this cannot be a comment of an NC program, got 'part (old)'; {COMMENT}"),
        (X, {"title": "ok\nMSG, wait"}, f"this cannot be a comment of an NC program, got 'MSG, wait'; {COMMENT}"),
        (X, {"title": " py,import os"}, f"this cannot be a comment of an NC program, got ' py,import os'; {COMMENT}"),
        (X, {"title": "log close"}, f"this cannot be a comment of an NC program, got 'log close'; {COMMENT}"),
        (X, {"title": "\ud800"}, f"this cannot be a comment of an NC program, got '\\ud800'; {COMMENT}"),
        (X, {"title": "\x00"}, f"this cannot be a comment of an NC program, got '\\x00'; {COMMENT}"),
    ],
)  # fmt: skip
def test_what_cannot_be_written_is_told(path, options, message):
    with pytest.raises(ProgramError) as caught:
        to_gcode(path, **options)
    assert str(caught.value) == message


def test_a_path_without_zero_at_its_start_begins_with_a_rapid_to_it():
    text = to_gcode(Circle(radius=0.1, feed=0.05, abc=(np.radians(3), 0, 0)).path())
    assert "G0 X100 A3\n" in text
    assert "G0" not in to_gcode(X)
