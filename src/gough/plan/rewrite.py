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
from ..program.blocks import REST
from ..program.nc import NCProgram
from .lines import LinePlan
from .pieces import Piece
from .trace import trace

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
    plan = LinePlan(program, path, origins, lines, wanted)
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


def _read_back(program: NCProgram, text: str, plan: LinePlan, changes: list[Changed]) -> tuple:
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
