"""The moves of a block: G0 to G3, G53, G28, G30, from their words to places."""

from __future__ import annotations

from ...errors import ProgramError
from .arcs import MOST_TURNS, PLANES
from .block import ARC, AXES
from .codes import name_of
from .modes import Modes
from .offsets import HOME, SECOND_HOME, Offsets
from .tip import Tip


class Moves:
    """Carries out moves with the modes and offsets in force; axis words come as {axis 0 to 5: number as written}."""

    def __init__(self, modes: Modes, offsets: Offsets, tip: Tip):
        self.modes, self.offsets, self.tip = modes, offsets, tip

    def move(self, code: int, words, axes: dict[int, float], in_frame: bool) -> None:
        """By `code` (0, 10, 20, 30, 280, 300); `in_frame`: G53.

        Raises
        ------
        ProgramError
            no feed, a wrong arc, a place too far away.
        """
        modes = self.modes
        if code in (280, 300):
            self._go_home(HOME if code == 280 else SECOND_HOME, axes, words.line)
            return
        modes.motion = code
        per_minute = None
        if code and modes.inverse_time:
            per_minute = words.values.get("F")
            if not per_minute:
                rule = f"{name_of('G', code)} without F in its own block, with G93"
                raise ProgramError(rule, value=words.texts.get("F"), cure="write F, in 1/min, with it")
        elif code and not modes.feed:
            raise no_feed(name_of("G", code))
        if code in ARC:
            self._arc(code, words, axes, per_minute)
        elif axes:
            target = self._in_frame(axes) if in_frame else self._placed(self._end(axes), axes)
            self.tip.line(target, code == 0, words.line, per_minute)

    def _end(self, axes):
        """Where axis words lead, in program coordinates.  (6,)"""
        end = self.offsets.to_program(self.tip.pose)
        for k, value in self.modes.lengths(axes).items():
            end[k] = value if self.modes.absolute else end[k] + value
        return end

    def _placed(self, end, axes):
        """Program coordinates in the frame of the program's zero; what no word moves stays exactly where it is."""
        out, now = self.offsets.to_frame(end), self.tip.pose
        for k in range(2 if self.offsets.turned else 0, 6):
            if k not in axes:
                out[k] = now[k]
        return out

    def _in_frame(self, axes):
        """The tip's place when T goes to the axis words, counted from the frame's zero."""
        point = self.offsets.tool_point(self.tip.pose)
        for k, value in self.modes.lengths(axes).items():
            point[k] = value
        return self.offsets.tip_of(point)

    def _go_home(self, which, axes, line):
        """By way of the axis words, then those axes, or all, home."""
        offsets, tip = self.offsets, self.tip
        if axes:
            tip.line(self._placed(self._end(axes), axes), True, line)
        home, now = offsets.home(which), tip.pose
        turned = [home[k] if k in axes or not axes else now[k] for k in range(3, 6)]
        there = offsets.to_program(offsets.tip_of([*home[:3], *turned]))
        end = offsets.to_program(now)
        homing = axes or range(6)
        for k in homing:
            end[k] = there[k]
        tip.line(self._placed(end, homing), True, line)

    def _arc(self, code, words, axes, per_minute):
        values, modes = words.values, self.modes
        plane = PLANES[modes.plane]
        letters = "".join(sorted("IJK"[k] for k in plane[:2]))
        centers = [letter for letter in "IJK" if letter in values]
        _check_arc(words, axes, sorted(plane[:2]), letters, centers, modes)
        center = None
        if centers:
            start = [0.0] * 6 if modes.absolute_center else self.offsets.to_program(self.tip.pose)
            center = tuple(start[k] + values.get("IJK"[k], 0.0) * modes.unit for k in plane[:2])
        radius = values.get("R", 0.0) * modes.unit
        turns = int(values.get("P", 1))
        end = self._end(axes)
        self.tip.arc(end, self._placed(end, axes), center, radius, code == 20, turns, words.line, per_minute)


def _check_arc(words, axes, ends, letters, centers, modes):
    """The words that LinuxCNC wants of an arc, and no others; `ends`: the two axes of the plane."""
    values, texts = words.values, words.texts
    either, both = f"{AXES[ends[0]]} or {AXES[ends[1]]}", " and ".join(letters)
    if "R" in values and centers:
        raise ProgramError(f"an arc has R, or {both}, not both", value=texts.get("R"), cure="remove one")
    if "R" not in values and not centers:
        if not axes:
            raise ProgramError("an arc without an end", cure=f"write {either}, and {both} or R")
        raise ProgramError("an arc without a centre", cure=f"write {both}, or R")
    wrong = next((letter for letter in centers if letter not in letters), None)
    if wrong:
        rule = f"an arc in the plane of {name_of('G', modes.plane)} has no {wrong}"
        raise ProgramError(rule, value=texts.get(wrong), cure=f"write {both}, or another plane before it")
    if "R" in values and axes.keys().isdisjoint(ends):
        raise ProgramError("an arc without an end", cure=f"write {either}")
    missing = next((letter for letter in letters if letter not in values), None)
    if centers and modes.absolute_center and missing:
        raise ProgramError(f"an arc without {missing}, with G90.1", cure=f"write {both}")
    turns = values.get("P", 1)
    if not turns >= 1 or turns % 1:
        raise ProgramError("P of an arc is a whole number of turns", value=texts.get("P"), cure="write e.g. P2")
    if turns > MOST_TURNS:
        raise ProgramError(f"an arc has at most {MOST_TURNS} turns", value=texts.get("P"), cure="write several arcs")


def no_feed(name: str) -> ProgramError:
    """The error for a feed move with no F so far."""
    return ProgramError(f"{name} without a feed", cure="write F, in mm/min, before it or with it")
