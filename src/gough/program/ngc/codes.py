"""Every G and M code: which belong together, and what to write instead of one that is not supported.

A code is its number times ten, G61.1 is 611.  Of each group of codes one may stand in a block, as LinuxCNC 2.9 groups
them (all pairs were tried on its rs274): that G92.1 may stand beside G4, and that M3 may not beside M70, is its rule.
"""

from __future__ import annotations

MOTION, AXES, PLANE, UNITS, DISTANCE, CENTER, FEED, TOOL, SYSTEM, CORNER, UNSHIFT = (
    "motion", "axes", "plane", "units", "distance", "center", "feed", "tool", "system", "corner", "unshift",
)  # fmt: skip
RADIUS, SPINDLE_MODE, RETRACT = "radius", "spindle mode", "retract"
STOP, CHANGE, SPINDLE, COOLANT, OVERRIDE = "stop", "change", "spindle", "coolant", "override"

G: dict[int, str] = {
    **dict.fromkeys((0, 10, 20, 30), MOTION),
    **dict.fromkeys((40, 100, 280, 281, 300, 301, 520, 530, 920), AXES),
    **dict.fromkeys((921, 922, 923), UNSHIFT),
    **dict.fromkeys((170, 180, 190), PLANE),
    **dict.fromkeys((200, 210), UNITS),
    **dict.fromkeys((900, 910), DISTANCE),
    **dict.fromkeys((901, 911), CENTER),
    **dict.fromkeys((930, 940), FEED),
    **dict.fromkeys((430, 431, 432, 490), TOOL),
    **dict.fromkeys((540, 550, 560, 570, 580, 590, 591, 592, 593), SYSTEM),
    **dict.fromkeys((610, 611, 640), CORNER),
    400: RADIUS,
    970: SPINDLE_MODE,
    **dict.fromkeys((980, 990), RETRACT),
}
CANCEL = 800  # G80 is of no group: beside a motion code it means nothing
M: dict[int, str] = {
    **dict.fromkeys((0, 1, 2, 30, 60), STOP),
    **dict.fromkeys((6, 61), CHANGE),
    **dict.fromkeys((3, 4, 5, 70, 71, 72, 73), SPINDLE),
    **dict.fromkeys((7, 8, 9), COOLANT),
    **dict.fromkeys((48, 49, 50, 51, 52, 53), OVERRIDE),
}
SYSTEMS = (540, 550, 560, 570, 580, 590, 591, 592, 593)  # G54 is coordinate system 1, G59.3 is 9

_KNOWN = "docs/nc-programs.md lists the codes that are"
_OFFSET = "offset the path in CAM"
_CYCLE = "write the moves of the cycle: G0 and G1"
_LATHE = "remove it: it is for lathes"
_PROBE = "remove it: nothing is probed"
_SPLINE = "write arcs or short G1 lines; the option `spline` makes one smooth curve of them"
_OUTPUT = "remove it: inputs and outputs are not simulated"
_ZERO = "write G54 to G59.3"
_SCALE = "scale the path in CAM"
_SUB = "write O<name> sub ... O<name> endsub, and O<name> call"
_MODAL = "write G61.1 in a block before, and G64 or G61 behind"
_CURES = {
    **dict.fromkeys(("G5", "G5.1", "G5.2", "G5.3", "G6.2"), _SPLINE),
    "G7": _LATHE, "G8": "remove it: radius mode is all there is", "G9": _MODAL, "G60": _MODAL, "G63": _MODAL,
    "G12": "write the moves of the pocket: G1, G2 and G3", "G13": "write the moves of the pocket: G1, G2 and G3",
    "G15": "remove it: there are no polar coordinates", "G16": "write X and Y instead of polar coordinates",
    "G17.1": _LATHE, "G18.1": _LATHE, "G19.1": _LATHE,
    "G31": _PROBE, "G33": "write G1: the spindle's angle is not simulated", "G38": _PROBE,
    "G41": _OFFSET, "G42": _OFFSET, "G43.4": "write G43: the tip stays on the path while the tool tilts",
    "G43.5": "write G43, and A, B, C for the tool's axis",
    "G54.1": _ZERO, "G154": _ZERO, "G642": "write G64 P and the tolerance",
    "G50": _SCALE, "G51": _SCALE, "G65": _SUB, "G66": _SUB, "G67": "remove it: nothing to cancel",
    "G68": "write G10 L2 P1 R and the angle", "G69": "write G10 L2 P1 R0, or remove it",
    "G68.2": "write the moves in the machine's axes: five-axis output of the CAM system",
    "G53.1": "write the moves in the machine's axes: five-axis output of the CAM system",
    "G70": _LATHE, "G71": _LATHE, "G72": _LATHE,
    **{f"G{number}": _CYCLE for number in (73, 74, 76, *range(81, 90))},
    "G95": "write G94, and F in mm/min: the feed times the turns a minute", "G96": "write G97, and S in rev/min",
    "M10": "remove it: there are no clamps", "M11": "remove it: there are no clamps",
    "M19": "remove it: the spindle's angle is not simulated",
    **{f"M{number}": _OUTPUT for number in range(62, 69)},
    "M98": _SUB, "M99": "write O<name> endsub, or M2 where the program ends",
    "G94.1": "write G94",
    "D": f"remove it: {_OFFSET}", "E": "remove it: nothing is extruded",
    "U": "write X, and G91 for a way from the last point", "V": "write Y, and G91 for a way from the last point",
    "W": "write Z, and G91 for a way from the last point",
}  # fmt: skip
_SCRIPT = "remove it: M100 to M199 run scripts, and no script is run"
# letters that only mean something beside a code, and the codes that take them
TAKERS = {
    "I": "G2 or G3", "J": "G2 or G3", "K": "G2 or G3", "R": "G2, G3 or G10 L2", "H": "G43",
    "L": "G10", "P": "G2, G3, G4, G10 or G64", "Q": "G64 or M61",
}  # fmt: skip


def name_of(letter: str, code: int) -> str:
    """("G", 611) -> "G61.1", ("M", 6) -> "M6"."""
    return f"{letter}{code / 10:g}" if letter == "G" else f"M{code}"


def cure_of(name: str) -> str:
    """What to write instead of a code ("G41.1", "M101") or a letter that is not supported."""
    found = _CURES.get(name) or _CURES.get(name.split(".")[0])
    if found:
        return found
    if name[0] == "M" and name[1:].isdigit() and 100 <= int(name[1:]) <= 199:
        return _SCRIPT
    return _KNOWN


def cure_of_unused(letter: str) -> str:
    """What to do about a letter that no code of its block takes."""
    return f"remove it, or write {TAKERS[letter]} beside it"
