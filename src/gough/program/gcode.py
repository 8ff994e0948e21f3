"""NC programs (RS274/NGC) to blocks: the subset below.  What is not in it is an error, never skipped.

    G0                     rapid, a straight line in X Y Z A B C together
    G1                     line at the feed F
    G2 G3                  arc or helix in the XY plane, clockwise or counter-clockwise seen from +Z, with I J or R;
                           an arc that ends where it starts, or has I J only, is a full circle; Z, A, B, C change in
                           proportion
    G17                    the XY plane, the only one
    G20 G21                inch, mm                                                  at the start: G21
    G90 G91                end points absolute, or counted from the last point       at the start: G90
    F                      mm/min (G20: inch/min) along the path of the tip; deg/min when only A, B, C change
    M2 M30                 the end; or "%" if the first line is "%"
    N  ( )  ;              line number, comments

The program's frame: zero is the machine's home pose, or the experiment's `origin`; X Y Z are the position of the tool
tip in it; A B C, in degrees, are the angles a b c of the tool, R = Rz(C) Ry(B) Rx(A): A turns the tool about the
frame's x axis, then B about its y axis, then C about its z axis.  The tip stays on the path while the tool tilts.
A program starts at X0 Y0 Z0 A0 B0 C0, at rest.
"""

from __future__ import annotations

import math

from ..errors import Problem, ProgramError
from . import arc
from .blocks import Arc, Block, Line, Rest
from .cures import cure_of
from .lexer import Word, words

MOST_PROBLEMS = 50
_MOST_COUNTED = 10_000  # wrong lines; a file with more is no NC program and is not read on
_MOST_BLOCKS = 1_000_000
_DEGREE = math.pi / 180
_AXES = "XYZABC"
_MOTION, _PLANE, _UNITS, _DISTANCE, _END = "motion", "plane", "units", "distance", "end"
_GROUPS = {
    "G0": _MOTION, "G1": _MOTION, "G2": _MOTION, "G3": _MOTION, "G17": _PLANE, "G20": _UNITS, "G21": _UNITS,
    "G90": _DISTANCE, "G91": _DISTANCE, "M2": _END, "M30": _END,
}  # fmt: skip


def read_gcode(text: str, file: str | None = None) -> list[Block]:
    """The blocks of an NC program, in its own frame, SI.

    Raises
    ------
    ProgramError
        with file and line of the first fifty problems, and how many lines more are wrong.
    """
    reader, found = _Reader(), _Found(file)
    lines = text.split("\n")
    for number, line in enumerate(lines, 1):
        try:
            reader.line(number, line.removesuffix("\r"))
        except ProgramError as error:
            reader.sure = False
            found.add(error, number)
            if found.more >= _MOST_COUNTED:
                break
    else:
        try:
            reader.close()
        except ProgramError as error:
            found.add(error, max((n for n, line in enumerate(lines, 1) if line.strip()), default=1))
    found.tell()
    return reader.blocks


class _Found:
    """The problems of a program: the first ones whole, of the rest the number of lines."""

    def __init__(self, file: str | None):
        self.file = file
        self.problems: list[Problem] = []
        self.more, self.since = 0, None

    def add(self, error: ProgramError, line: int):
        room = MOST_PROBLEMS - len(self.problems)
        problems = error.at(file=self.file, line=line).problems
        self.problems += problems[:room]
        if len(problems) > room:
            self.more += 1
            self.since = self.since or line

    def tell(self):
        if self.more:
            count = "1 line more is" if self.more == 1 else f"{self.more} lines more are"
            if self.more >= _MOST_COUNTED:
                count, cure = f"{count} wrong, and there may be more", "check that this is an NC program"
            else:
                count, cure = f"{count} wrong", None
            self.problems.append(Problem(f"from here on {count}", file=self.file, line=self.since, cure=cure))
        if self.problems:
            raise ProgramError(problems=self.problems)


def _code(word: Word) -> str:
    """ "G01" -> "G1", "X10" -> "X"."""
    return f"{word.letter}{word.value:g}" if word.letter in "GM" else word.letter


class _Reader:
    """The interpreter's state.  Lengths in m, angles in rad, feed in m/s and, for turns at rest, rad/s."""

    def __init__(self):
        self.blocks: list[Block] = []
        self.at = [0.0] * 6
        self.unit = 1e-3
        self.motion = None
        self.absolute = True
        self.feed = self.turn_feed = None
        self.percent = False  # the first line was "%"
        self.begun = self.ended = False
        # after a first problem, what depends on earlier lines is no longer judged: it would be guessing
        self.sure = True

    def line(self, number: int, text: str):
        if text.strip() == "%":
            self._percent()
            return
        found = words(text)
        if not found:
            return
        if self.ended:
            raise ProgramError("a block behind the end of the program", value=found[0].text, cure="remove it")
        self.begun = True
        try:
            self._block(number, found)
        finally:
            self.ended = any(word.letter == "M" and word.value in (2, 30) for word in found)

    def _percent(self):
        if not self.begun:
            self.percent = self.begun = True
        elif self.percent:
            self.ended = True
        elif not self.ended:
            raise ProgramError('"%" ends a program only if its first line is "%"', cure="write M2")

    def close(self):
        if not self.ended:
            raise ProgramError("the program has no end", cure="write M2 or M30 as its last line")
        if self.sure and not self.blocks:
            raise ProgramError("the program moves nothing", cure="write a G0 or G1 with an axis word")

    def _block(self, number, found: list[Word]):
        codes, given = self._sort(found)
        if "F" in given:
            self._set_feed(given["F"], codes)
        if _UNITS in codes:
            self.unit = 25.4e-3 if codes[_UNITS] == "G20" else 1e-3
        if _DISTANCE in codes:
            self.absolute = codes[_DISTANCE] == "G90"
        if _MOTION in codes:
            self.motion = codes[_MOTION]
        axes = {letter: given[letter] for letter in _AXES if letter in given}
        extra = [given[letter].text for letter in "IJR" if letter in given]
        if axes or extra:
            if self.motion is None and self.sure:
                word = next(iter(axes.values())).text if axes else extra[0]
                raise ProgramError("an axis word before any G0, G1, G2 or G3", value=word, cure="write e.g. G0 or G1")
            if extra and self.motion not in ("G2", "G3") and self.sure:
                raise ProgramError(f"{extra[0][0]} belongs to an arc", value=extra[0], cure="write G2 or G3")
            if self.sure:
                self._move(number, axes, given)
        elif codes.get(_MOTION) in ("G2", "G3"):
            raise ProgramError("an arc without an end", cure="write X and Y, and I and J or R")

    def _sort(self, found):
        """Codes by modal group, and the other words by letter.  Every wrong word is told, not only the first."""
        codes: dict[str, str] = {}
        given: dict[str, Word] = {}
        problems: list[Problem] = []
        strange = [code for code in map(_code, found) if code[0] in "GM" and code not in _GROUPS]
        for place, word in enumerate(found):
            letter, code = word.letter, _code(word)
            if letter in "GM":
                group = _GROUPS.get(code)
                if group is None:
                    problems.append(Problem("not in the subset", value=word.text, cure=cure_of(code)))
                elif group in codes:
                    rule, both = "two words of one kind in a block", f"{codes[group]} {code}"
                    problems.append(Problem(rule, value=both, cure="write them in two blocks"))
                else:
                    codes[group] = code
            elif letter not in _AXES + "IJRFN":
                problems.append(Problem("not in the subset", value=word.text, cure=cure_of(code, strange)))
            elif letter == "N" and place:
                problems.append(Problem("N is not the first word of its block", value=word.text, cure="remove it"))
            elif letter == "N" and not (word.value.is_integer() and word.value >= 0):
                problems.append(Problem("a line number is a whole number", value=word.text, cure="write e.g. N10"))
            elif letter in given:
                both = f"{given[letter].text} {word.text}"
                problems.append(Problem(f"{letter} twice in a block", value=both, cure="write it once"))
            else:
                given[letter] = word
        if problems:
            raise ProgramError(problems=problems)
        return codes, given

    def _set_feed(self, word, codes):
        if not word.value > 0:
            self.feed, self.turn_feed = 1.0, 1.0  # so that the next blocks do not complain as well
            raise ProgramError("the feed must be above 0", value=word.text, cure="write F in mm/min, e.g. F1000")
        unit = {"G20": 25.4e-3, "G21": 1e-3}.get(codes.get(_UNITS), self.unit)
        if unit != self.unit:
            self.feed, self.turn_feed = 1.0, 1.0
            raise ProgramError(
                "F in the block that changes the unit can be read in either",
                value=f"{codes[_UNITS]} {word.text}",
                cure=f"write {codes[_UNITS]} in a block before it",
            )
        self.feed, self.turn_feed = word.value * unit / 60, word.value * _DEGREE / 60

    # -- motion -----------------------------------------------------------------------------------------------

    def _move(self, number, axes, given):
        if self.motion != "G0" and self.feed is None:
            raise ProgramError(f"{self.motion} without a feed", cure="write F, in mm/min, before it or with it")
        end = list(self.at)
        for letter, word in axes.items():
            k = _AXES.index(letter)
            value = word.value * (self.unit if k < 3 else _DEGREE)
            end[k] = value if self.absolute else end[k] + value
        start, self.at = self.at, end
        if len(self.blocks) >= _MOST_BLOCKS:
            raise ProgramError(f"a program has at most {_MOST_BLOCKS} moves", cure="split it")
        tip, abc0, abc1 = tuple(start[:3]), tuple(start[3:]), tuple(end[3:])
        rapid = self.motion == "G0"
        if self.motion in ("G2", "G3"):
            for segment in self._arc(start, end, axes, given):
                self.blocks.append(Block(segment, abc0, abc1, self.feed, rapid, number))
                abc0 = abc1
        elif math.dist(start[:3], end[:3]) > 1e-9:
            self.blocks.append(Block(Line(tip, tuple(end[:3])), abc0, abc1, self.feed or 0.0, rapid, number))
        else:
            self.at = [*start[:3], *abc1]
            if abc0 != abc1:  # else the tool is there already
                self.blocks.append(Block(Rest(tip), abc0, abc1, self.turn_feed or 0.0, rapid, number))

    def _arc(self, start, end, axes, given):
        clockwise = self.motion == "G2"
        offset = [given[letter].value * self.unit if letter in given else 0.0 for letter in "IJ"]
        if "R" in given and ("I" in given or "J" in given):
            raise ProgramError("an arc has R, or I and J, not both", value=given["R"].text, cure="remove one")
        if not ("X" in axes or "Y" in axes or "I" in given or "J" in given):
            raise ProgramError("an arc without an end", cure="write X or Y")
        if "R" in given:
            center, sweep = arc.by_radius(start[:2], end[:2], given["R"].value * self.unit, clockwise)
        elif "I" in given or "J" in given:
            center, sweep = arc.by_center(start[:2], end[:2], offset, clockwise, self.unit)
        else:
            raise ProgramError("an arc without a centre", cure="write I and J, or R")
        yield Arc(tuple(start[:3]), (*center, start[2]), (0.0, 0.0, 1.0), sweep, end[2] - start[2])
        last = (*arc.end(start[:2], center, sweep), end[2])
        if math.dist(last, end[:3]) > 1e-9:
            yield Line(last, tuple(end[:3]))
