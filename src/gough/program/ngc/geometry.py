"""What a block changes about coordinates: plane, units, tool offset, coordinate system, G10, G52, G92, and corners."""

from __future__ import annotations

import math

from ...errors import ProgramError
from . import codes
from .block import AXES, Groups
from .codes import name_of
from .modes import DEGREE, INCH, MM, Modes
from .offsets import HOME, SECOND_HOME, Offsets
from .tip import Tip
from .tools import Tools, tool_number

_NONE = (0.0, 0.0, 0.0)


class Geometry:
    """Carries out the codes of the coordinates; axis words come as {axis 0 to 5: number as written}."""

    def __init__(self, modes: Modes, offsets: Offsets, tip: Tip, tools: Tools | None):
        self.modes, self.offsets, self.tip, self.tools = modes, offsets, tip, tools

    def set_modes(self, words, g: Groups, axes: dict[int, float]) -> None:
        """G17 to G19, G20, G21, G43 to G49, G54 to G59.3, G61 to G64, G90, G91, G90.1, G91.1, G98, G99.

        Raises
        ------
        ProgramError
            a tool that is not in the table, a tolerance that is none.
        """
        modes = self.modes
        modes.plane = g.get(codes.PLANE, modes.plane)
        if codes.UNITS in g:
            modes.unit = INCH if g[codes.UNITS] == 200 else MM
        if codes.TOOL in g:
            self._set_tool_offset(g[codes.TOOL], words, axes)
        if codes.SYSTEM in g:
            system = codes.SYSTEMS.index(g[codes.SYSTEM]) + 1
            if system != self.offsets.system:  # LinuxCNC reads the parameters of another system only
                self.offsets.select(system)
        if codes.CORNER in g:
            self._set_corner(g[codes.CORNER], words)
        if codes.DISTANCE in g:
            modes.absolute = g[codes.DISTANCE] == 900
        if codes.CENTER in g:
            modes.absolute_center = g[codes.CENTER] == 901
        if codes.RETRACT in g:
            modes.retract_r = g[codes.RETRACT] == 990

    def _set_tool_offset(self, code, words, axes):
        modes, tool = self.modes, self.offsets.tool
        if code == 490:
            new = _NONE
        elif code == 431:
            turned = [k for k in axes if k > 2]
            if turned:
                text = words.texts.get(AXES[turned[0]], AXES[turned[0]])
                raise ProgramError("a tool has an offset in X, Y and Z only", value=text, cure="remove it")
            new = tuple(axes[k] * modes.unit if k in axes else tool[k] for k in range(3))
        else:
            if code == 432 and "H" not in words.values:
                raise ProgramError("G43.2 without H", cure="write H and the number of the tool to add")
            number = words.values.get("H") or modes.current_tool  # H0 is no H
            number = tool_number(number, words.texts.get("H", "G43"), self.tools)
            new = _NONE if self.tools is None else self.tools[number].offset
            if code == 432:
                new = tuple(a + b for a, b in zip(tool, new, strict=True))
        modes.tool_offset = code
        self.tip.set_tool(new, words.line)

    def _set_corner(self, code, words):
        modes = self.modes
        modes.corner = code
        if code != 640:
            modes.tolerance = 0.0 if code == 610 else -1.0
            return
        modes.tolerance = math.inf
        for letter in "PQ":
            value = words.values.get(letter)
            if value is not None and not value > 0 and (letter == "P" or value < 0):
                cure = "write G61 for the exact path" if letter == "P" else "remove it"
                raise ProgramError("the tolerance of G64 must be above 0", value=words.texts[letter], cure=cure)
        if "P" in words.values:
            modes.tolerance = words.values["P"] * modes.unit

    def set_offsets(self, words, g: Groups, axes: dict[int, float]) -> None:
        """G28.1, G30.1, G10, G52, G92 and what G92.1 to G92.3 make of it.

        Raises
        ------
        ProgramError
            a word is missing or wrong.
        """
        special, offsets, tip = g.get(codes.AXES), self.offsets, self.tip
        if special == 281:
            offsets.set_home(HOME, tip.pose)
        elif special == 301:
            offsets.set_home(SECOND_HOME, tip.pose)
        elif special == 100:
            self._set_system(words, axes)
        elif special in (520, 920):
            if not axes:
                name = name_of("G", special)
                raise ProgramError(f"{name} without an axis word", cure=f"write e.g. {name} X0")
            values = self.modes.lengths(axes)
            if special == 920:
                offsets.shift_here(tip.pose, values)
            else:
                offsets.shift_by(values)
        cancel = g.get(codes.UNSHIFT)
        if cancel in (921, 922):
            offsets.unshift(keep=cancel == 922)
        elif cancel == 923:
            offsets.reshift()

    def _set_system(self, words, axes):
        values, texts = words.values, words.texts
        kind, p = values.get("L"), values.get("P")
        if kind not in (2, 20):
            value = texts.get("L")
            raise ProgramError("G10 goes with L2 or L20 here", value=value, cure="write e.g. G10 L2 P1 X0")
        if p is None or p % 1 or not 0 <= p <= 9:
            rule = f"P of G10 L{kind:.0f} is a whole number from 0 to 9"
            raise ProgramError(rule, value=texts.get("P"), cure="1 is G54, 9 is G59.3, 0 the one in force")
        if kind == 20:
            if "R" in values:
                raise ProgramError("R does not go with G10 L20", value=texts["R"], cure="write it with G10 L2")
            self.offsets.set_here(int(p), self.tip.pose, self.modes.lengths(axes))
        else:
            theta = values["R"] * DEGREE if "R" in values else None
            self.offsets.set_origin(int(p), self.modes.lengths(axes), theta)
