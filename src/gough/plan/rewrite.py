"""An NC program again with other feeds.  Every move stays where it is, lines stay lines and arcs stay arcs:

    N20 G1 X80 F6000              N20 G1 X80 F4820                  a line that is slower as a whole

    N30 G1 X-80                   ; was: N30 G1 X-80
                                  N30 G1 X31.2 F4820                a line whose feed changes on its way
                                  X-11.6 F4875
                                  X-80 F5210

What was written is read back, and must come to the moves and feeds that were meant.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..errors import ProgramError
from ..program.blocks import ARC, REST
from ..program.nc import NCProgram
from ..program.ngc.arcs import PLANES
from ..program.ngc.modes import INCH, MM
from .nc_text import Written, feed_text, number_text, with_feed, with_motion, written
from .pieces import Piece
from .trace import Origin, trace

_HALF = np.pi * (1 - 1e-9)  # rad: an arc of a piece turns by less than half a circle
_PLACES = {MM: 6, INCH: 8}  # decimals of lengths; 1 nm and below
_ROUND = {MM: "0.001", INCH: "0.00004"}  # what corners between pieces may be rounded by under G61.1
_SAME = 2e-8  # m and rad: the rounding of what is written is 0.5 nm and 9 nrad
_FEED = 3e-5  # of a feed, that rounding it down may take
_WAS = 240  # characters; a line has 252


class Changed(NamedTuple):
    """A line that was replaced."""

    line: int  # of the program as it was
    was: str
    now: list[str]


class Rewritten(NamedTuple):
    """The program with its new feeds.  `origin` (m,) is the block that each of its blocks was a part of, from the
    extent `begin` (m,) on; -1 where nothing moves."""

    program: NCProgram
    changes: list[Changed]
    origin: np.ndarray
    begin: np.ndarray

    def back(self, block, u) -> tuple[np.ndarray, np.ndarray]:
        """The block and extent of the program as it was, of extents u (n,) in blocks (n,) of the new one."""
        return self.origin[block], self.begin[block] + u


def rewritten(program: NCProgram, wanted: dict[int, list[Piece]]) -> Rewritten:
    """`program` with the pieces `wanted` of its blocks, by block.

    Raises
    ------
    ProgramError
        a line that runs several times under several feeds, moves of a called file, an F that is a formula.
    """
    path, origins = program.path(), trace(program)
    lines = program.text.split("\n")
    plan = _Plan(program, path, origins, lines, wanted)
    plan.settle()
    out, changes = [], []
    for number, text in enumerate(lines, 1):
        now = plan.line(number)
        if now is None:
            out.append(text)
            continue
        bare = text.rstrip("\r")
        changes.append(Changed(number, bare.strip(), now))
        ending = "\r" if text.endswith("\r") else ""
        was = [f"; was: {bare.strip()}"[:_WAS]] if len(now) > 1 else []
        out += [one + ending for one in (*was, *now)]
    if not changes:
        return Rewritten(program, [], np.arange(len(path)), np.zeros(len(path)))
    return Rewritten(*_read_back(program, "\n".join(out), plan, changes))


class _Plan:
    """What each line should say."""

    def __init__(self, program, path, origins: list[Origin], lines, wanted):
        self.program, self.path, self.origins, self.lines, self.wanted = program, path, origins, lines, wanted
        moving = (path.kind != REST) | path.turning_at_rest
        self.runs: dict[int, dict[int, list[int]]] = {}  # line: run: its moving blocks
        self.order: list[tuple[int, int]] = []  # (line, run), as they ran
        for i in np.flatnonzero(moving).tolist():
            line, run = origins[i].line, origins[i].run
            blocks = self.runs.setdefault(line, {}).setdefault(run, [])
            if not blocks:
                self.order.append((line, run))
            blocks.append(i)
        self.read: dict[int, Written] = {}
        self.slow = {origins[i].line for i in wanted}  # lines that must change
        self.fed: set[int] = set()  # lines that need an F although their own feed is as it was
        self.moved: set[int] = set()  # lines that must say their motion

    def written(self, line: int) -> Written:
        if line not in self.read:
            try:
                self.read[line] = written(self.lines[line - 1].rstrip("\r"), line)
            except ProgramError as error:
                raise error.at(file=self.program.name, line=line) from None
        return self.read[line]

    # -- what lines around a changed one need -------------------------------------------------------------------------

    def settle(self) -> None:
        """Find the lines that must say an F or a motion of their own because one before them has changed."""
        while True:
            before = len(self.fed) + len(self.moved)
            self._pass()
            if len(self.fed) + len(self.moved) == before:
                return

    def _pass(self):
        was = now = None  # feeds in force: of the program as it was, and as it will be
        motion = None  # G code in force, as it will be, where that is another one
        changed = self.slow | self.fed | self.moved
        if not changed:
            return
        for line, run in self.order:
            if now == was and motion is None and line not in changed:
                i = self.runs[line][run][-1]
                if not self.path.rapid[i] and not self.origins[i].modes.inverse_time:
                    was = now = self._word(i, self.path.feed[i])
                continue
            told = self.written(line)
            blocks = self.runs[line][run]
            i = blocks[-1]
            mode = self.origins[i].modes
            rapid = bool(self.path.rapid[i])
            if motion is not None and told.motion is None and line not in self.slow:
                self.moved.add(line)
            motion = 1 if rapid and line in self.slow else None
            if mode.inverse_time:
                was = now = None
                continue
            if rapid:
                if line in self.slow:
                    now = self._feed(line, run)
                continue
            here = self._word(i, self.path.feed[i])
            if not told.has_feed and was is not None and here != was:
                now = here  # a line that only says F has come in between
            was = here
            if line in self.slow:
                now = self._feed(line, run)
            elif told.has_feed:
                now = here
            elif now != here:
                if (
                    line in self.fed
                    or len({self._word(b[-1], self.path.feed[b[-1]]) for b in self.runs[line].values()}) == 1
                ):
                    self.fed.add(line)
                    now = here
                else:
                    raise ProgramError(
                        "a line that runs several times has several feeds", file=self.program.name, line=line,
                        value=told.text.strip()[:40], cure="write F on it, or write out the loop",
                    )  # fmt: skip

    def _word(self, i: int, feed: float) -> float:
        """A feed of block i as its F would say it, in m/s or rad/s: turns at rest and moves share one F."""
        unit = self.origins[i].modes.unit
        return round(np.degrees(feed) * unit, 12) if self.path.turning_at_rest[i] else round(feed, 12)

    def _feed(self, line: int, run: int) -> float:
        """The feed in force behind a line that changes."""
        i = self.runs[line][run][-1]
        return self._word(i, self._pieces(line, i)[-1].feed)

    # -- a line -------------------------------------------------------------------------------------------------------

    def divisible(self, line: int) -> bool:
        """Whether a line may become several: it only moves, once, along one block."""
        runs = self.runs[line]
        return len(runs) == 1 and len(next(iter(runs.values()))) == 1 and self.written(line).only_moves

    def _pieces(self, line: int, i: int) -> list[Piece]:
        """The pieces of block i as they will be: one, where the line cannot be divided."""
        path = self.path
        if line not in self.slow:
            return [Piece(float(path.extent[i]), None if path.rapid[i] else float(path.feed[i]))]
        if self.divisible(line):
            return self._turned(i, self.wanted[i])
        feeds = []
        for blocks in self.runs[line].values():
            for k in blocks:
                own = [Piece(0.0, float(path.feed[k]))] if not path.rapid[k] else []
                feeds += [piece.feed for piece in self.wanted.get(k, own)]
        least = min(feeds)
        if not path.rapid[i]:
            least = min(least, float(path.feed[i]))
        return [Piece(float(path.extent[i]), least)]

    def _turned(self, i: int, pieces: list[Piece]) -> list[Piece]:
        """The pieces, none of an arc that is divided turning by half a circle."""
        path = self.path
        if path.kind[i] != ARC or len(pieces) == 1:
            return pieces
        most = _HALF * path.batches[ARC].gain[path.index[i]]
        out, begin = [], 0.0
        for piece in pieces:
            count = int(np.ceil((piece.end - begin) / most))
            cuts = np.linspace(begin, piece.end, count + 1)[1:]
            out += [Piece(float(end), piece.feed) for end in cuts]
            begin = piece.end
        return out

    def line(self, number: int) -> list[str] | None:
        """What stands for the line `number`; None: it stays."""
        if number not in self.slow and number not in self.fed and number not in self.moved:
            return None
        told = self.written(number)
        run, blocks = next(iter(self.runs[number].items()))
        i = blocks[-1]
        if number in self.slow and self.divisible(number):
            pieces = self._pieces(number, i)
            if len(pieces) > 1:
                return self._divided(told, i, pieces)
        text = told.text
        if number in self.moved:
            text = with_motion(text, self.origins[i].modes.motion // 10)
        if number in self.slow or number in self.fed:
            if self.path.rapid[i]:
                text = with_motion(text, 1)
            mode = self.origins[i].modes
            if mode.inverse_time and len(blocks) > 1 and len({self.path.extent[k] for k in blocks}) > 1:
                i = max(blocks, key=lambda k: self.path.extent[k])
            piece = self._pieces(number, i)[0] if number in self.slow else Piece(self.path.extent[i], self.path.feed[i])
            text = with_feed(text, self._feed_word(i, piece.feed, float(self.path.extent[i])))
        return [text]

    def _feed_word(self, i: int, feed: float, extent: float) -> str:
        modes = self.origins[i].modes
        if modes.inverse_time:
            return feed_text(60 * feed / extent, 6)
        if self.path.turning_at_rest[i]:
            return feed_text(60 * float(np.degrees(feed)), 6)
        return feed_text(60 * feed / modes.unit, 6)

    def _divided(self, told: Written, i: int, pieces: list[Piece]) -> list[str]:
        path, modes, out, begin = self.path, self.origins[i].modes, [], 0.0
        at = self._coordinates(i, 0.0)
        end = self._coordinates(i, float(path.extent[i]))
        moved = [
            k for k in range(6) if abs(end[k] - at[k]) > 1e-12 or (path.kind[i] == ARC and k in PLANES[modes.plane][:2])
        ]
        code = "G1" if path.rapid[i] else f"G{modes.motion // 10}"
        for n, piece in enumerate(pieces):
            last = n == len(pieces) - 1
            here = end if last else self._rounded(self._coordinates(i, piece.end), modes)
            if last and modes.absolute:
                words = " ".join(told.of("XYZABC"))
            else:
                shown = here if modes.absolute else [b - a for a, b in zip(at, here, strict=True)]
                words = " ".join(self._axis(k, shown[k], modes) for k in moved)
            if path.kind[i] == ARC:
                words += " " + self._center(i, at, told, modes)
            head = f"{told.number}{code} " if n == 0 else ""
            feed = self._feed_word(i, piece.feed, piece.end - begin)
            if path.tolerance[i] < 0 and last:
                out.append("G61.1")
            out.append(f"{head}{words} {feed}")
            at, begin = here, piece.end
        return [f"G64 P{_ROUND[modes.unit]}", *out] if path.tolerance[i] < 0 else out

    def _coordinates(self, i: int, u: float) -> list[float]:
        """Program coordinates of block i at the extent u, m and rad."""
        path, block, along = self.path, np.array([i]), np.array([u])
        length = along if path.kind[i] != REST else np.zeros(1)
        pose = [*path.point(block, length)[0].tolist(), *path.angles(block, along)[0].tolist()]
        return self.origins[i].offsets.to_program(pose)

    @staticmethod
    def _rounded(place, modes) -> list[float]:
        d = _PLACES[modes.unit]
        lengths = [round(v / modes.unit, d) * modes.unit for v in place[:3]]
        return lengths + [float(np.radians(round(float(np.degrees(v)), 6))) for v in place[3:]]

    @staticmethod
    def _axis(k: int, value: float, modes) -> str:
        if k < 3:
            return f"{'XYZ'[k]}{number_text(value / modes.unit, _PLACES[modes.unit])}"
        return f"{'ABC'[k - 3]}{number_text(float(np.degrees(value)), 6)}"

    def _center(self, i: int, at, told: Written, modes) -> str:
        """The words of the centre of an arc, seen from its start at `at`."""
        path, letters = self.path, "IJK"
        if modes.absolute_center and told.of("IJK"):
            return " ".join(told.of("IJK"))
        arcs = path.batches[ARC]
        center = self.origins[i].offsets.to_program([*arcs.center[path.index[i]].tolist(), 0.0, 0.0, 0.0])
        base = [0.0] * 3 if modes.absolute_center else at
        return " ".join(
            f"{letters[k]}{number_text((center[k] - base[k]) / modes.unit, _PLACES[modes.unit])}"
            for k in sorted(PLANES[modes.plane][:2])
        )

    def expected(self):
        """Ends and feeds that the new program should have: block, extent, feed; in order."""
        for line, run in self.order:
            for i in self.runs[line][run]:
                for piece in self._pieces(line, i):
                    yield i, piece.end, piece.feed


def _read_back(program: NCProgram, text: str, plan: _Plan, changes: list[Changed]) -> tuple:
    """The fields of Rewritten for a new text, which must come to the moves and feeds that were meant."""
    cure = "write G94, places and feeds as numbers"
    try:
        made = program.replace(text=text)
    except ProgramError as error:
        raise ProgramError(
            "the program with new feeds cannot be read back", file=program.name, value=str(error)[:200], cure=cure
        ) from None
    old, new = plan.path, made.path()
    rows = np.flatnonzero((new.kind != REST) | new.turning_at_rest)
    blocks, ends, feeds = zip(*plan.expected(), strict=True)
    if len(rows) != len(blocks):
        raise _other(program, None, f"{len(rows)} moves instead of {len(blocks)}", cure)
    i, u = np.array(blocks), np.array(ends)
    meant = np.concatenate([old.point(i, np.where(old.kind[i] != REST, u, 0.0)), old.angles(i, u)], 1)
    found = np.concatenate([new.point(rows, new.length[rows]), new.angles(rows, new.extent[rows])], 1)
    off = np.abs(found - meant).max(1)
    rapid = np.array([feed is None for feed in feeds])
    wanted = np.array([0.0 if feed is None else feed for feed in feeds])
    ratio = np.where(rapid, 1.0, new.feed[rows] / np.where(rapid, 1.0, wanted))
    wrong = (off > _SAME) | (new.rapid[rows] != rapid) | (ratio > 1 + 1e-6) | (ratio < 1 - _FEED)
    if wrong.any():
        k = int(np.argmax(wrong))
        value = f"{off[k]:.3g} m or rad beside its place" if off[k] > _SAME else f"{ratio[k]:.6g} times its feed"
        raise _other(program, int(old.line[i[k]]), value, cure)
    origin, begin = np.full(len(new), -1), np.zeros(len(new))
    origin[rows] = i
    begin[rows] = np.where(np.append(True, i[1:] != i[:-1]), 0.0, np.append(0.0, u[:-1]))
    return made, changes, origin, begin


def _other(program, line, value, cure) -> ProgramError:
    return ProgramError(
        "the program with new feeds does not come to the moves that were meant", file=program.name, line=line,
        value=value, cure=cure,
    )  # fmt: skip
