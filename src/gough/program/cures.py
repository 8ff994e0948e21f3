"""What to write instead of a word that is not in the subset of gcode.py."""

from __future__ import annotations

from collections.abc import Collection

_KNOWN = "this reader knows G0-G3, G17, G20, G21, G90, G91, M2, M30 and X Y Z A B C I J R F N"
_TOOL = "remove it: the tool is that of the data sheet"
_ZERO = "remove it: zero is the machine's home, or `origin` of the experiment"
_SPINDLE = "remove it: the spindle is not simulated"
_COOLANT = "remove it: coolant is not simulated"
_NOTHING = "remove it: nothing to cancel"
_WAIT = "remove it: a program does not wait"
_GO = "write the move: G0 and where it goes in X Y Z A B C"
_OFFSET = "offset the path in CAM"
_CYCLE = "write the moves of the cycle: G0 and G1"
_PLANE = "arcs run in the XY plane"

_CURES = {
    "G4": "remove it: a program does not dwell",
    "G10": _ZERO, "G18": _PLANE, "G19": _PLANE,
    "G28": _GO, "G28.1": "remove it: no place is stored", "G30": _GO, "G30.1": "remove it: no place is stored",
    "G38": "remove it: nothing is probed", "G40": _NOTHING, "G41": _OFFSET, "G42": _OFFSET,
    "G43": _TOOL, "G49": _TOOL, "G52": _ZERO, "G53": "remove it, and write the place in the program's frame",
    **{f"G{number}": _ZERO for number in range(54, 60)},
    "G61": 'remove it: the option corner = "stop" is this', "G64": 'remove it: see the option corner = "constant"',
    "G69": _NOTHING, "G73": _CYCLE, "G74": _CYCLE, "G76": _CYCLE, "G80": _NOTHING,
    **{f"G{number}": _CYCLE for number in range(81, 90)},
    "G90.1": "write I and J from the start of the arc", "G91.1": "remove it: I and J count from the start of the arc",
    "G92": _ZERO, "G93": "write F in mm/min", "G94": "remove it: F is mm/min",
    "G95": "write F in mm/min: the feed times the turns a minute", "G96": _SPINDLE, "G97": _SPINDLE,
    "G98": "remove it: there are no cycles", "G99": "remove it: there are no cycles",
    "M0": _WAIT, "M1": _WAIT, "M3": _SPINDLE, "M4": _SPINDLE, "M5": _SPINDLE, "M6": _TOOL,
    "M7": _COOLANT, "M8": _COOLANT, "M9": _COOLANT, "M19": _SPINDLE, "M60": _WAIT,
    "M48": "remove it: there are no overrides", "M49": "remove it: there are no overrides",
    "M98": "write out the blocks of the subprogram", "M99": "remove it, or write M2 if the program ends here",
    "D": f"remove it: {_OFFSET}", "E": "remove it: nothing is extruded", "H": _TOOL,
    "K": "remove it: arcs take I and J, helices Z as well", "L": "remove it, and write the block as often as it runs",
    "P": "write one block for each turn", "Q": "remove it, with the cycle it belongs to",
    "S": _SPINDLE, "T": _TOOL,
}  # fmt: skip
_OWNED = "DHKLPQ"  # letters whose meaning depends on the code beside them


def cure_of(code: str, beside: Collection[str] = ()) -> str:
    """The cure for a code ("G41", "G28.1") or a letter; `beside`: the other codes of its block not in the subset."""
    if code in _OWNED and beside:
        return f"remove it, with {' and '.join(beside)}"
    return _CURES.get(code) or _CURES.get(code.split(".")[0]) or _KNOWN
