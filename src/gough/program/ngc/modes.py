"""What stays in force from block to block (modal state), and its save and restore by M70 to M73."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass

from ...errors import ProgramError

MM, INCH = 1e-3, 25.4e-3  # m
DEGREE = math.pi / 180


@dataclass
class Modes:
    """The modes of a program, as at its start."""

    motion: int | None = None  # 0, 10, 20, 30: G0 to G3; None: none yet, or G80
    plane: int = 170
    unit: float = MM  # m
    absolute: bool = True  # G90
    absolute_center: bool = False  # G90.1
    inverse_time: bool = False  # G93
    feed: float = 0.0  # m/s, 0: none given
    turn_feed: float = 0.0  # rad/s, the same F for turns at rest
    feed_word: float = 0.0  # F as written
    corner: int = 610  # G61, G61.1 or G64
    tolerance: float = 0.0  # of junctions, as Block has it
    tool_offset: int = 490  # G43, G43.1 or G49
    spindle: int = 0  # 1: M3, -1: M4
    speed: float = 0.0  # rev/min, S
    mist: bool = False
    flood: bool = False
    feed_override: bool = True
    speed_override: bool = True
    adaptive_feed: bool = False
    feed_hold: bool = True
    retract_r: bool = False  # G99
    current_tool: int = 0  # in the spindle
    selected_tool: int = 0  # T, what M6 changes to

    def end(self) -> None:
        """What M2 and M30 set: G17 G40 G90 G94, M5 M9 M48; the rest stays."""
        self.plane, self.absolute, self.inverse_time = 170, True, False
        self.motion, self.spindle, self.mist, self.flood = 10, 0, False, False
        self.feed = self.turn_feed = self.feed_word = 0.0
        self.feed_override = self.speed_override = True

    def lengths(self, axes: dict[int, float]) -> dict[int, float]:
        """Axis words, {axis 0 to 5: number as written}, in m and rad."""
        return {k: value * (self.unit if k < 3 else DEGREE) for k, value in axes.items()}


@dataclass
class _Saved:
    modes: Modes
    system: int
    tool: tuple[float, float, float]
    on_return: bool


# neither the motion mode nor the tools in use are part of what M70 saves
_KEPT = ("motion", "current_tool", "selected_tool")


class Saves:
    """The states that M70 and M73 saved, one at most for each level of subroutine calls."""

    def __init__(self):
        self._levels: dict[int, _Saved] = {}

    def save(self, level: int, modes: Modes, system: int, tool, on_return: bool) -> None:
        """M70; M73 with `on_return`, which in the main text is the same."""
        self._levels[level] = _Saved(copy.copy(modes), system, tool, on_return)

    def forget(self, level: int) -> None:
        """M71, and the end of a call."""
        self._levels.pop(level, None)

    def on_return(self, level: int) -> bool:
        """Whether the return from `level` restores what was saved there."""
        return level in self._levels and self._levels[level].on_return

    def restore(self, level: int, modes: Modes) -> tuple[Modes, int, tuple]:
        """M72: the modes to go on with, the coordinate system and the tool offset to select.

        Where G93 was in force on one side only, no feed is: F means something else then.

        Raises
        ------
        ProgramError
            nothing was saved at this level.
        """
        saved = self._levels.get(level)
        if saved is None:
            raise ProgramError("M72 without M70 or M73 at this level of calls", cure="write M70 before it")
        new = copy.copy(saved.modes)
        for name in _KEPT:
            setattr(new, name, getattr(modes, name))
        if new.inverse_time != modes.inverse_time:
            new.feed = new.turn_feed = 0.0
        return new, saved.system, saved.tool
