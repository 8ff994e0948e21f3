"""The writer of NC programs: a line for each block, and the state in which the lines so far leave a reader."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from ..errors import ProgramError
from .blocks import ARC, ELLIPSE, LINE, REST
from .path import Path

HEAD = "G17 G21 G90 G94 G61"
_PLANES = {2: ("G17", "XY", "IJ"), 1: ("G18", "ZX", "KI"), 0: ("G19", "YZ", "JK")}  # by the axis that is its normal
_AXES = "XYZABC"
_FINE = 10  # decimals of F, P, S
_MOST_TURNS, _MOST_LINES = 1000, 1_000_000  # what a reader takes
_SAME = 1e-6  # mm, a circle that ends so close to its start is closed: what Path takes for one place
_LEAST = 2e-6  # rad, twice the sweep that is read as a whole turn


class Writer:
    """`lines` so far.  `start`, then `block` for each block in order."""

    def __init__(self, path: Path, decimals: int, chord: float | None):
        self.path, self.decimals, self.chord = path, decimals, chord
        self.lines: list[str] = []
        self.at = np.zeros(6)  # mm and deg as written
        self.mode, self.plane, self.feed, self.spindle = "G61", 2, None, 0.0
        self.ends = _numbers(path, np.arange(len(path)), path.extent).round(decimals)

    def add(self, text: str):
        self.lines.append(text)

    def start(self):
        first = _numbers(self.path, np.zeros(1, int), np.zeros(1))[0]
        self._straight("G0", first.round(self.decimals), 0)

    def block(self, i: int):
        path, kind = self.path, self.path.kind[i]
        if kind not in (LINE, ARC, ELLIPSE, REST):
            raise ProgramError("blends and splines are made as the path is driven", cure="write program.path()")
        stopped = self._spindle(i)
        if kind == REST:
            self._rest(i, stopped)
            return
        if path.rapid[i] and kind != LINE:
            raise ProgramError("a rapid is a straight line", line=line_of(path, i))
        axis = self._axis(i) if kind == ARC else None
        if kind == LINE:
            self._mode(path.tolerance[i])
            self._straight("G0" if path.rapid[i] else "G1", self.ends[i], i)
        elif axis is not None:
            self._mode(path.tolerance[i])
            self._arc(i, axis)
        else:
            self._curve(i)

    # -- moves ------------------------------------------------------------------------------------------------

    def _straight(self, code: str, end, i: int):
        words = self._ends(end)
        if not words:
            return
        moves, rests = (end[:3] != self.at[:3]).any(), self.path.kind[i] == REST
        if not (moves or rests or code == "G0"):
            raise ProgramError(
                f"a move is shorter than {self.decimals} decimals can say, and the tool turns in it",
                line=line_of(self.path, i), cure="more decimals",
            )  # fmt: skip
        self.add(code + words + ("" if code == "G0" else self._feed(i, rests)))
        self.at = end.copy()

    def _arc(self, i: int, axis: int):
        path, a = self.path, self.path.index[i]
        arcs, end = path.batches[ARC], self.ends[i].copy()
        inside = [_AXES.index(letter) for letter in _PLANES[axis][1]]
        sweep, radius = arcs.sweep[a], 1e3 * arcs.radius[a]
        turns = round(sweep / (2 * math.pi))
        more = sweep - 2 * math.pi * turns
        left, unit = radius * abs(more), 10.0**-self.decimals  # mm
        if turns and left < max(_SAME, unit):
            end[inside] = self.at[inside]
        elif more > 0 and (more < _LEAST or left < 4 * unit):
            # a reader takes so small a sweep for a whole turn, and rounded ends could lie the wrong way round; it is
            # as straight as a line
            if turns:
                u = np.array([path.length[i] * (1 - more / sweep)])
                row = np.array([i])
                self._turns(i, axis, turns, _numbers(path, row, u)[0].round(self.decimals))
            self._straight("G1", end, i)
            return
        elif left < 4 * unit:
            raise ProgramError(
                f"an arc is closer to whole turns than {self.decimals} decimals can say",
                line=line_of(path, i), cure="more decimals",
            )  # fmt: skip
        else:
            turns = math.ceil(sweep / (2 * math.pi))
        self._turns(i, axis, turns, end)

    def _turns(self, i: int, axis: int, turns: int, end):
        """An arc of so many turns, the last one whole or not, that ends at `end`."""
        path, arcs = self.path, self.path.batches[ARC]
        a, letters, offsets = path.index[i], *_PLANES[axis][1:]
        inside = [_AXES.index(letter) for letter in letters]
        if turns > _MOST_TURNS:
            raise ProgramError(f"an arc has at most {_MOST_TURNS} turns", value=str(turns), line=line_of(path, i))
        words = self._ends(end, always=letters)
        words += self._words(offsets, (1e3 * arcs.center[a] - self.at[:3])[inside])
        code = "G3" if arcs.normal[a][axis] > 0 else "G2"
        plane = ""
        if axis != self.plane:
            self.plane, plane = axis, f"{_PLANES[axis][0]} "
        self.add(plane + code + words + (f" P{turns}" if turns > 1 else "") + self._feed(i, False))
        self.at = end

    def _axis(self, i: int) -> int | None:
        """Which axis of the frame the arc turns about, if it is one."""
        normal = self.path.batches[ARC].normal[self.path.index[i]]
        axis = int(np.argmax(np.abs(normal)))
        # an arc that leans over less than this ends where it should to 0.1 pm for every 100 mm of its radius
        return axis if np.delete(np.abs(normal), axis).max() < 1e-12 else None

    def _curve(self, i: int):
        path = self.path
        if self.chord is None:
            what = "an ellipse" if path.kind[i] == ELLIPSE else "an arc in a skew plane"
            raise ProgramError(
                f"{what} has no word of its own",
                line=line_of(path, i),
                cure="give chord, how far short lines may be off",
            )
        if not hasattr(self, "_sharpest"):
            self._sharpest = path.sharpest()
        # |p''| <= k keeps a chord of length h within k h^2 / 8
        count = path.length[i] * math.sqrt(self._sharpest[i] / (8 * self.chord))
        if not count < _MOST_LINES:
            raise ProgramError(
                f"more than {_MOST_LINES} short lines", value=f"chord = {self.chord:g} m", line=line_of(path, i),
                cure="a larger chord",
            )  # fmt: skip
        u = np.linspace(0, path.length[i], max(1, math.ceil(count)) + 1)[1:]
        ends = _numbers(path, np.full(len(u), i), u).round(self.decimals)
        for end in ends[:-1]:
            self._mode(self.chord)
            self._straight("G1", end, i)
        self._mode(path.tolerance[i])
        self._straight("G1", self.ends[i], i)

    def _rest(self, i: int, stopped: bool):
        path = self.path
        turns = path.turning_at_rest[i]
        if turns:
            self._mode(path.tolerance[i])
            self._straight("G0" if path.rapid[i] else "G1", np.r_[self.at[:3], self.ends[i][3:]], i)
        if path.dwell[i] > 0 or not (turns or stopped):
            self.add("G4" + self._words("P", [path.dwell[i]], _FINE))

    # -- words ------------------------------------------------------------------------------------------------

    def _mode(self, tolerance: float):
        mode = "G61" if tolerance == 0 else "G61.1"
        if tolerance > 0:
            mode = "G64"
            if tolerance < math.inf:
                mode += self._words("P", [1e3 * tolerance], _FINE)
        if mode != self.mode:
            self.mode = mode
            self.add("G61" if mode == "G64 P0" else mode)  # P0 would mean: as far as it likes

    def _spindle(self, i: int) -> bool:
        """Write the spindle of block i if it changes; whether that is a stop."""
        old, new = self.spindle, float(self.path.spindle[i])
        if new == old:
            return False
        self.spindle = new
        full_stop = self.path.kind[i] == REST and not self.path.turning_at_rest[i] and self.path.dwell[i] == 0
        if new == 0:
            self.add("M5")
        elif old * new > 0 and not full_stop:
            self.add(self._words("S", [abs(new)], _FINE).strip())
            return False
        else:
            self.add(self._words("S", [abs(new)], _FINE).strip() + (" M3" if new > 0 else " M4"))
        return True

    def _feed(self, i: int, turning: bool) -> str:
        text = self._words("F", [(60 * 180 / math.pi if turning else 60e3) * self.path.feed[i]], _FINE)
        if text == self.feed:
            return ""
        if text == " F0":
            raise ProgramError("a feed too slow to be written", line=line_of(self.path, i))
        self.feed = text
        return text

    def _ends(self, end, always: str = "") -> str:
        """The words of the axes that change, and of those named; none where nothing changes."""
        letters = [a for k, a in enumerate(_AXES) if a in always or end[k] != self.at[k]]
        return self._words(letters, [end[_AXES.index(a)] for a in letters])

    def _words(self, letters: Iterable[str], numbers, decimals: int | None = None) -> str:
        decimals = self.decimals if decimals is None else decimals
        return "".join(f" {a}{_number(value, decimals)}" for a, value in zip(letters, numbers, strict=True))


def _numbers(path: Path, i, u):
    """Tip in mm and angles in deg of blocks i (n,) at the extents u (n,).  (n, 6)."""
    return np.column_stack([1e3 * path.point(i, u), np.degrees(path.angles(i, u))])


def _number(value: float, decimals: int) -> str:
    text = f"{value:.{decimals}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def line_of(path: Path, i: int) -> int | None:
    return int(path.line[i]) or None
