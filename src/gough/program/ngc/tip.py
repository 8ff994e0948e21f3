"""Where the tool is, and the blocks that its moves become."""

from __future__ import annotations

import math

from ...errors import ProgramError
from ..blocks import Arc, Block, Line, Rest
from . import arcs
from .arcs import NEAR
from .modes import Modes
from .offsets import Offsets

MOST_MOVES = 1_000_000
FARTHEST = 1e3  # m
_FARTHEST_TURN = math.radians(1e6)
_STOP = 0.0  # s, a dwell without time


class Tip:
    """The position of the tool's tip in the frame of the program's zero, `at` (m) and `abc` (rad), and its moves.

    Every move stays within a kilometre and a million degrees; it becomes a block, or two, of `blocks`.
    """

    def __init__(self, modes: Modes, offsets: Offsets, blocks):
        self.modes, self.offsets, self.blocks = modes, offsets, blocks
        self.at = (0.0, 0.0, 0.0)
        self.abc = (0.0, 0.0, 0.0)
        self.moves = 0
        self._stopped = False

    @property
    def pose(self) -> list[float]:
        """x y z a b c of the tip in the frame of the program's zero."""
        return [*self.at, *self.abc]

    # -- straight -----------------------------------------------------------------------------------------------------

    def line(self, end, rapid: bool, line: int, per_minute: float | None = None) -> None:
        """Straight to `end`, (6,) in the frame of the program's zero; `per_minute`: of which F there are (G93)."""
        x, y, z, a, b, c = end
        abc0, abc1 = self.abc, (a, b, c)
        tip0, tip1 = self.at, (x, y, z)
        length = math.dist(tip0, tip1)
        if not (-FARTHEST <= x <= FARTHEST and -FARTHEST <= y <= FARTHEST and -FARTHEST <= z <= FARTHEST) or (
            abc0 != abc1 and not max(map(abs, abc1)) <= _FARTHEST_TURN
        ):
            raise ProgramError("a move to a place beyond 1e6 mm or degrees", cure="check the words and the offsets")
        self.abc = abc1
        if length > NEAR:
            self.at = tip1
            feed = self.modes.feed if per_minute is None else length * per_minute / 60
            self._append(Line(tip0, tip1), abc0, feed, rapid, line)
        elif abc0 != abc1:
            feed = self.modes.turn_feed if per_minute is None else math.dist(abc0, abc1) * per_minute / 60
            self._append(Rest(tip0), abc0, feed, rapid, line)

    def _append(self, segment, abc0, feed, rapid, line, dwell=_STOP):
        self.moves += 1
        if self.moves > MOST_MOVES:
            raise ProgramError(f"a program has at most {MOST_MOVES} moves", cure="split it")
        m = self.modes
        spindle = m.spindle * m.speed
        self.blocks.append(
            Block(segment, abc0, self.abc, feed, rapid, line, dwell, m.tolerance, self.offsets.tool, spindle)
        )
        self._stopped = False

    # -- standing -----------------------------------------------------------------------------------------------------

    def stop(self, line: int, dwell: float = _STOP) -> None:
        """A full stop of the motion, for `dwell` s.  Of stops in a row that take no time one is enough."""
        if dwell == _STOP and self._stopped:
            return
        self._append(Rest(self.at), self.abc, 0.0, False, line, dwell)
        self._stopped = dwell == _STOP

    def set_tool(self, tool: tuple[float, float, float], line: int) -> None:
        """Another tool offset, (3,) m: T stays where it is, the tip is elsewhere."""
        if tool == self.offsets.tool:
            return
        point = self.offsets.tool_point(self.pose)
        self.offsets.tool = tool
        self.at = tuple(self.offsets.tip_of(point)[:3])
        self._stopped = False
        self.stop(line)

    # -- arcs ---------------------------------------------------------------------------------------------------------

    def arc(self, end, target, center, radius, clockwise, turns, line, per_minute=None) -> None:
        """Along an arc or helix of the plane in force to `end`, (6,) in program coordinates, `target` in the frame's.

        `center` (2,) in program coordinates along the plane's axes, or None: then by `radius`.

        Raises
        ------
        ProgramError
            as arcs.py says.
        """
        offsets, modes = self.offsets, self.modes
        i, j, k = arcs.PLANES[modes.plane]
        start = offsets.to_program(self.pose)
        start2, end2 = (start[i], start[j]), (end[i], end[j])
        if center is None:
            center, sweep = arcs.by_radius(start2, end2, radius, clockwise)
        else:
            center, sweep = arcs.by_center(
                start2, end2, center, clockwise, modes.unit, sorted("IJK"[n] for n in (i, j)), not modes.absolute_center
            )
        if turns > 1:
            sweep = arcs.turns(sweep, turns)
        rise = end[k] - start[k]
        if not max(map(abs, target[:3])) <= FARTHEST or not max(map(abs, target[3:])) <= _FARTHEST_TURN:
            raise ProgramError("a move to a place beyond 1e6 mm or degrees", cure="check the words and the offsets")
        middle, last = list(start), list(end)
        middle[i], middle[j] = center
        last[i], last[j] = arcs.end(start2, center, sweep)
        normal = [0.0, 0.0, 0.0]
        normal[k] = 1.0
        segment = Arc(self.at, tuple(offsets.to_frame(middle)[:3]), offsets.direction(tuple(normal)), sweep, rise)
        feed = modes.feed
        if per_minute is not None:
            feed = math.hypot(math.dist(start2, center) * sweep, rise) * per_minute / 60
        abc0, self.abc = self.abc, tuple(target[3:])
        self._append(segment, abc0, feed, False, line)
        self.at = tuple(target[:3])
        reached = tuple(offsets.to_frame(last)[:3])
        if math.dist(reached, self.at) > NEAR:
            self._append(Line(reached, self.at), self.abc, feed, False, line)
