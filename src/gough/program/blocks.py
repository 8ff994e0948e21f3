"""Blocks: what a path is made of, as descriptions, and the table that keeps them as columns.

A table of a million blocks is some 200 MB; a list of as many descriptions would be a gigabyte.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from ..errors import ProgramError
from .ellipse import Ellipses
from .segments import Arcs, Lines, Points, dot, norm


class Line(NamedTuple):
    """A straight segment, from `start` to `end`, (3,) m."""

    start: tuple
    end: tuple


class Arc(NamedTuple):
    """A circular arc or helix: from `start`, right-handed about `normal` through `center`, by `sweep` rad,
    rising by `rise` m along `normal`.  `center` may lie at any height of the axis; sweep < 0 turns the other way."""

    start: tuple
    center: tuple
    normal: tuple
    sweep: float
    rise: float = 0.0


class Ellipse(NamedTuple):
    """An arc of an ellipse: center + cos(phi) first + sin(phi) second, phi from `begin` on by `sweep` > 0 rad."""

    center: tuple
    first: tuple
    second: tuple
    begin: float
    sweep: float


class Rest(NamedTuple):
    """The tip rests at `at`, (3,) m, while the tool turns, or waits."""

    at: tuple


class Block(NamedTuple):
    """One segment with everything the feed needs to know.

    `feed` is m/s along a segment and rad/s for a turn at rest; it is not used for a rapid or a dwell.
    `tolerance` says what may happen at the junction behind the block: -1 an exact stop (G61.1), 0 an exact path (G61),
    so many m beside a corner (G64 P), inf: as far as the program's option says (G64).
    `tool` is where the T of the data sheet stands from the tip of the tool in use, (3,) m along the axes of T (G43).
    `spindle` is rev/min, clockwise above 0.
    """

    segment: Line | Arc | Ellipse | Rest
    abc0: tuple = (0.0, 0.0, 0.0)
    abc1: tuple = (0.0, 0.0, 0.0)
    feed: float = 0.0
    rapid: bool = False
    line: int = 0
    dwell: float = 0.0
    tolerance: float = 0.0
    tool: tuple = (0.0, 0.0, 0.0)
    spindle: float = 0.0


class CircleOfPath(NamedTuple):
    """A circle on the path, for the polar plot: `id` from 1 on, centre and unit normal in the path's frame.

    The tool runs right-handed about `normal`; `ccw` tells whether that is counter-clockwise seen from +z.
    """

    id: int
    line: int
    center: np.ndarray
    radius: float
    normal: np.ndarray
    feed: float
    ccw: bool

    def to_json(self) -> dict:
        """Plain numbers, for the log."""
        out = self._asdict()
        return {**out, "center": [float(v) for v in self.center], "normal": [float(v) for v in self.normal]}


KINDS = {Line: 0, Arc: 1, Ellipse: 2, Rest: 3}
LINE, ARC, ELLIPSE, REST = range(4)
CURVE = 4  # made, never programmed: curves.py
_WIDTH = (6, 11, 11, 3)  # numbers of a segment of each kind
_NUMBERS = 13  # abc0, abc1, tool, feed, dwell, tolerance, spindle


class Blocks:
    """Blocks in order, kept as columns.  Reads like a list of Block; `append` adds one."""

    def __init__(self, blocks: Iterable[Block] = ()):
        self._kind, self._rapid, self._line = array("b"), array("b"), array("l")
        self._place = array("l")  # row in the numbers of its kind
        self._numbers = array("d")
        self._segments = tuple(array("d") for _ in _WIDTH)
        for block in blocks:
            self.append(block)

    def append(self, block: Block) -> None:
        """Add a block at the end."""
        segment, abc0, abc1, feed, rapid, line, dwell, tolerance, tool, spindle = block
        kind = KINDS[type(segment)]
        numbers = self._segments[kind]
        self._kind.append(kind)
        self._place.append(len(numbers) // _WIDTH[kind])
        self._rapid.append(rapid)
        self._line.append(line)
        self._numbers.extend((*abc0, *abc1, *tool, feed, dwell, tolerance, spindle))
        for value in segment:
            numbers.extend(value) if isinstance(value, tuple) else numbers.append(value)

    def __len__(self) -> int:
        return len(self._kind)

    def __iter__(self) -> Iterator[Block]:
        return (self[i] for i in range(len(self)))

    def __getitem__(self, i: int) -> Block:
        i = range(len(self))[i]
        kind, n = self._kind[i], self._numbers[_NUMBERS * i : _NUMBERS * (i + 1)].tolist()
        width = _WIDTH[kind]
        row = self._segments[kind][width * self._place[i] : width * (self._place[i] + 1)].tolist()
        return Block(
            _segment(kind, row), tuple(n[:3]), tuple(n[3:6]), n[9], bool(self._rapid[i]), self._line[i], n[10], n[11],
            tuple(n[6:9]), n[12],
        )  # fmt: skip

    def __str__(self) -> str:
        from .path import Path  # a path is made of blocks

        try:
            return str(Path(self))
        except ProgramError as error:
            return f"{len(self)} blocks: {error}"

    def __eq__(self, other) -> bool:
        return isinstance(other, Blocks) and list(self) == list(other)

    # -- columns, as copies ---------------------------------------------------------------------------------------

    def columns(self) -> dict[str, np.ndarray]:
        """kind index (m,), abc0 abc1 tool (m, 3), feed dwell tolerance spindle rapid line (m,)."""
        numbers = np.array(self._numbers, float).reshape(-1, _NUMBERS)
        out = {name: numbers[:, 3 * k : 3 * k + 3].copy() for k, name in enumerate(("abc0", "abc1", "tool"))}
        out |= {name: numbers[:, 9 + k].copy() for k, name in enumerate(("feed", "dwell", "tolerance", "spindle"))}
        return out | {
            "kind": np.array(self._kind, np.int8),
            "index": np.array(self._place, np.int64),
            "rapid": np.array(self._rapid, bool),
            "line": np.array(self._line, np.int32),
        }

    def batches(self) -> list:
        """The four batches Lines, Arcs, Ellipses, Points, each in order.

        Raises
        ------
        ProgramError
            an arc without radius or sweep.
        """
        lines, arcs, ellipses, rests = (
            np.array(numbers, float).reshape(-1, width) for numbers, width in zip(self._segments, _WIDTH, strict=True)
        )
        with np.errstate(divide="ignore", invalid="ignore"):  # no length: found by the path's own check, with its line
            out = [Lines(lines[:, :3], lines[:, 3:])]
        start, center, normal, sweep, rise = arcs[:, :3], arcs[:, 3:6], arcs[:, 6:9], arcs[:, 9], arcs[:, 10]
        # one form: right-handed about the normal, centre at the height of the start
        back = np.where(sweep < 0, -1.0, 1.0)
        normal = normal * back[:, None] / norm(normal)[:, None] + 0.0 if len(arcs) else normal  # + 0.0: no -0
        sweep, rise = np.abs(sweep), rise * back
        center = center + dot(start - center, normal)[:, None] * normal
        if (~(norm(start - center) > 0) | ~(sweep > 0)).any():
            raise ProgramError("an arc must have a radius and a sweep above 0")
        out.append(Arcs(center, start - center, normal, sweep, rise))
        out.append(Ellipses(ellipses[:, :3], ellipses[:, 3:6], ellipses[:, 6:9], ellipses[:, 9], ellipses[:, 10]))
        out.append(Points(rests, np.tile((0.0, 0.0, 1.0), (len(rests), 1))))
        return out


def _segment(kind, row):
    if kind == LINE:
        return Line(tuple(row[:3]), tuple(row[3:]))
    if kind == REST:
        return Rest(tuple(row))
    return (Arc if kind == ARC else Ellipse)(tuple(row[:3]), tuple(row[3:6]), tuple(row[6:9]), row[9], row[10])
