"""Which lines of an NC program must change, and into what, so that its moves get the feeds that are wanted.

A line changes if a feed of its own does, if it relies on an F that a line before it has changed, or on a G0 that has
become G1.  A line that runs once and does nothing but one move may become several; any other gets the least feed that
its moves want.
"""

from __future__ import annotations

import numpy as np

from ..errors import ProgramError
from ..program.blocks import ARC, REST
from .move_text import MoveText
from .nc_text import Written, with_feed, with_motion, written
from .pieces import Piece
from .trace import Origin

_HOMING = ("G28", "G30")
_HALF = np.pi * (1 - 1e-9)  # rad: an arc of a piece turns by less than half a circle


class LinePlan:
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
        self.text = MoveText(path, origins)
        self.slow = {origins[i].line for i in wanted}  # lines that must change
        self.fed: set[int] = set()  # lines that need an F although their own feed is as it was
        self.moved: set[int] = set()  # lines that must say their motion

    def written(self, line: int) -> Written:
        if line not in self.read:
            try:
                self.read[line] = written(self.lines[line - 1].rstrip("\r"), line, self.program.block_delete)
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
            if rapid and line in self.slow and any(word.text in _HOMING for word in told.words):
                raise ProgramError(
                    "a move of G28 or G30 is too fast, and has no F", file=self.program.name, line=line,
                    value=told.text.strip()[:40], cure="write G1 to the place",
                )  # fmt: skip
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
                return self.text.divided(told, i, pieces)
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
            text = with_feed(text, self.text.feed_word(i, piece.feed, float(self.path.extent[i])))
        return [text]

    def expected(self):
        """Ends and feeds that the new program should have: block, extent, feed; in order."""
        for line, run in self.order:
            for i in self.runs[line][run]:
                for piece in self._pieces(line, i):
                    yield i, piece.end, piece.feed
