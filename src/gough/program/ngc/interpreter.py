"""Blocks of evaluated words to changes of mode and to moves, in the order in which LinuxCNC 2.9 carries out a block:

    G93 G94, F, S, T, M6 M61, M3-M5 or M70-M73, M7-M9, M48-M53, G4, G17-G19, G20 G21, G43 G43.1 G49, G54-G59.3, G61 G64,
    G90 G91, G90.1 G91.1, G28.1 G30.1 G10 G52 G92, G28 G30 or G0-G3, G80, M0 M1 M2 M30 M60

What a block may hold is in block.py, what stays in force in modes.py and offsets.py, moves are in moves.py and tip.py.
Accepted, and without effect: G40, G97, G98, G99, M48 to M53, Q of G64.  M0, M1, M60, M3 to M9 and a change of the tool
offset are full stops of the motion that take no time.
"""

from __future__ import annotations

from ...errors import ProgramError
from . import block, codes
from .block import AXES, LARGEST
from .geometry import Geometry
from .modes import DEGREE, INCH, MM, Modes, Saves
from .moves import Moves, no_feed
from .offsets import Offsets
from .system import offer
from .tip import Tip
from .tools import Tools, tool_number

LONGEST_DWELL = 1e6  # s
_PLAIN = frozenset("XYZABCF")


class Interpreter:
    """The machine that a program drives: `execute` takes one block of words after the other.

    blocks      the moves so far, in the frame of the program's zero
    modes, offsets, tip     its state
    """

    def __init__(self, parameters, blocks, tools: Tools | None = None):
        self.parameters, self.blocks, self.tools = parameters, blocks, tools
        self.modes, self.offsets = Modes(), Offsets(parameters)
        self.tip = Tip(self.modes, self.offsets, blocks)
        self._moves = Moves(self.modes, self.offsets, self.tip)
        self._geometry = Geometry(self.modes, self.offsets, self.tip, tools)
        self._saves, self._level, self._line = Saves(), 0, 1
        offer(self)
        parameters.level = self.level

    def execute(self, words) -> bool:
        """Carry out one block; whether it ends the program.

        Raises
        ------
        ProgramError
            with the block's line: what is wrong with it, and with nothing carried out of what is wrong.
        """
        self._line = words.line  # a return has no line of its own
        try:
            if not words.m and self._plain(words):
                return False
            return self._block(words)
        except ProgramError as error:
            raise error.at(line=words.line) from None

    def level(self, depth: int) -> None:
        """Subroutine calls are `depth` deep from now on; a return may restore what M73 saved."""
        while self._level > depth:
            if self._saves.on_return(self._level):
                self._restore(self._level, self._line)
            self._saves.forget(self._level)
            self._level -= 1
        self._level = depth

    def _plain(self, words) -> bool:
        """The short way for most lines of a program: G0 or G1, axis words, F, in the modes most programs use."""
        modes, values, g = self.modes, words.values, words.g
        code = modes.motion if not g else g[0]
        if len(g) > 1 or (code != 10 and code != 0) or not values or not modes.absolute or modes.inverse_time:
            return False
        offsets = self.offsets
        if offsets.turned or not _PLAIN.issuperset(values):
            return False
        if "F" in values:
            if len(values) == 1:
                return False
            self._set_feed(words, modes.unit)
        if code and not modes.feed:
            raise no_feed("G1")
        tip, unit, s = self.tip, modes.unit, offsets.shift
        (x, y, z), (a, b, c) = tip.at, tip.abc
        for letter, value in values.items():
            if letter == "X":
                x = value * unit + s[0]
            elif letter == "Y":
                y = value * unit + s[1]
            elif letter == "Z":
                z = value * unit + s[2]
            elif letter == "A":
                a = value * DEGREE + s[3]
            elif letter == "B":
                b = value * DEGREE + s[4]
            elif letter == "C":
                c = value * DEGREE + s[5]
        modes.motion = code
        tip.line((x, y, z, a, b, c), code == 0, words.line)
        return True

    def _block(self, words) -> bool:
        g, m = block.sort(words)
        axes = {AXES.index(letter): value for letter, value in words.values.items() if letter in AXES}
        moving = block.moving(words, g, axes, self.modes)
        block.check_letters(words, g, m, moving)
        self._set_modes(words, g, m)
        self._geometry.set_modes(words, g, axes)
        self._geometry.set_offsets(words, g, axes)
        if moving is not None:
            self._moves.move(moving, words, axes, g.get(codes.AXES) == 530)
        if codes.CANCEL in words.g and codes.MOTION not in g:
            self.modes.motion = None
        stop = m.get(codes.STOP)
        if stop in (2, 30):
            self.modes.end()
            return True
        if stop is not None:
            self.tip.stop(words.line)
        return False

    # -- modes, in their order ----------------------------------------------------------------------------------------

    def _set_modes(self, words, g, m):
        modes, values, line = self.modes, words.values, words.line
        if codes.FEED in g:
            modes.inverse_time = g[codes.FEED] == 930
            modes.feed = modes.turn_feed = 0.0  # F means something else now, or is to be written anew, as in LinuxCNC
        if "F" in values:
            self._set_feed(words, {200: INCH, 210: MM}.get(g.get(codes.UNITS), modes.unit))
        if "S" in values:
            if values["S"] < 0:
                cure = "write M4 to turn the other way"
                raise ProgramError("the spindle speed is below 0", value=words.texts["S"], cure=cure)
            modes.speed = values["S"]
        if "T" in values:
            modes.selected_tool = tool_number(values["T"], words.texts["T"], self.tools)
        change = m.get(codes.CHANGE)
        if change == 6:
            modes.current_tool, modes.spindle = modes.selected_tool, 0  # it stands still for the change
            self.tip.stop(line)
        elif change == 61:
            if "Q" not in values:
                raise ProgramError("M61 without Q", cure="write Q and the number of the tool in the spindle")
            modes.current_tool = tool_number(values["Q"], words.texts["Q"], self.tools)
        spindle = m.get(codes.SPINDLE)
        if spindle in (3, 4, 5):
            modes.spindle = {3: 1, 4: -1, 5: 0}[spindle]
            self.tip.stop(line)
        elif spindle is not None:
            self._save_or_restore(spindle, line)
        coolant = m.get(codes.COOLANT)
        if coolant is not None:
            self.modes.mist = coolant == 7 or (self.modes.mist and coolant == 8)
            self.modes.flood = coolant == 8 or (self.modes.flood and coolant == 7)
            self.tip.stop(line)
        self._override(m.get(codes.OVERRIDE), values.get("P", 1.0))
        if g.get(codes.AXES) == 40:
            self._dwell(words)

    def _override(self, code, p):
        modes = self.modes
        if code in (48, 49):
            modes.feed_override = modes.speed_override = code == 48
        elif code is not None:
            name = {50: "feed_override", 51: "speed_override", 52: "adaptive_feed", 53: "feed_hold"}[code]
            setattr(modes, name, p != 0)

    def _set_feed(self, words, unit):
        modes, value = self.modes, words.values["F"]
        if not 0 <= value <= LARGEST:
            text = words.texts.get("F", "F")
            if value < 0:
                raise ProgramError("the feed must be above 0", value=text, cure="write F in mm/min, e.g. F1000")
            cure = f"F is mm/min: write at most {LARGEST:.0f}"
            raise ProgramError(f"F is beyond {LARGEST:.0f}", value=text, cure=cure)
        modes.feed_word = value
        if modes.inverse_time:
            return
        if unit != modes.unit:
            change = "G20" if unit == INCH else "G21"
            raise ProgramError(
                "F in the block that changes the unit can be read in either",
                value=f"{change} {words.texts.get('F', 'F')}",
                cure=f"write {change} in a block before it",
            )
        modes.feed, modes.turn_feed = value * unit / 60, value * DEGREE / 60

    def _save_or_restore(self, code, line):
        level, offsets = self._level, self.offsets
        if code in (70, 73):
            self._saves.save(level, self.modes, offsets.system, offsets.tool, code == 73)
        elif code == 71:
            self._saves.forget(level)
        else:
            self._restore(level, line)

    def _restore(self, level, line):
        modes = self.modes
        new, system, tool = self._saves.restore(level, modes)
        stops = (new.spindle, new.mist, new.flood) != (modes.spindle, modes.mist, modes.flood)
        vars(modes).update(vars(new))  # the object stays: others hold it
        if system != self.offsets.system:
            self.offsets.select(system)
        self.tip.set_tool(tool, line)
        if stops:
            self.tip.stop(line)

    def diameter(self) -> float:
        """Of the tool in the spindle, m."""
        return 0.0 if self.tools is None else self.tools[self.modes.current_tool].diameter

    def _dwell(self, words):
        p = words.values.get("P")
        if p is None:
            raise ProgramError("G4 without P", cure="write P and the seconds, e.g. G4 P0.5")
        if not 0 <= p <= LONGEST_DWELL:
            cure = "write seconds, e.g. G4 P0.5"
            raise ProgramError(f"a dwell is between 0 and {LONGEST_DWELL:.0f} s", value=words.texts["P"], cure=cure)
        self.tip.stop(words.line, float(p))
