"""Paths as NC programs, which gough and LinuxCNC read back.

What is written: straight lines, arcs and helices in planes parallel to XY, ZX and YZ (G17 G18 G19) of any number of
turns (P), turns of the tool at rest, dwells and full stops (G4), rapids, F, A B C, the spindle (S M3 M4 M5), and what
may happen at corners (G61.1 G61 G64).  Other curves become short lines, if the caller says how far these may leave
the curve.  End points are absolute, so that their rounding does not add up; the centre of an arc is counted from its
start as written.  Between the short lines of one curve a blend within the same distance is allowed (G64 P), or else
the machine would stop at each.

A change of the spindle's sense is a stop in an NC program, whether or not the path has one there.
"""

from __future__ import annotations

import math
import re

import numpy as np

from ..errors import ProgramError
from .path import Path
from .writer import HEAD, Writer, line_of

# comments that LinuxCNC acts on: they print, write files or run Python
_ACTIVE = re.compile("(msg|print|debug|log|logopen|logappend|logclose|probeopen|probeclose|py|abort)(,|$)", re.I)
_NO_TEXT = re.compile("[()\x00-\x1f\x7f\ud800-\udfff]")


def to_gcode(
    path: Path,
    title: str = "written by gough",
    *,
    decimals: int = 10,
    chord: float | None = None,
    numbered: bool = False,
) -> str:
    """A path in its own frame as an NC program in mm and degrees.

    title: comment above the program, a line for each line.
    decimals: of X Y Z I J K in mm and A B C in degrees, 3 to 12.  Ten, 0.1 pm, lose nothing; with fewer every end
        point is off by half of the last decimal at most, in each coordinate.
    chord: m, how far short lines may leave an ellipse, or an arc in a skew plane.
    numbered: each block begins with N and the number of its line in the file.

    Raises
    ------
    ProgramError
        a path that was placed, a tool offset, a curve without `chord`, blends and splines, an arc of more than
        1000 turns, a move too short for the decimals, a comment that could not be one.
    """
    if isinstance(decimals, bool) or not isinstance(decimals, int) or not 3 <= decimals <= 12:
        raise ProgramError("decimals must be a whole number from 3 to 12", value=repr(decimals)[:40])
    if chord is not None and not 0 < chord < math.inf:
        raise ProgramError("chord must be above 0 m", value=f"{chord!r}"[:40])
    if path.p_WO.any() or not np.array_equal(path.R_WO, np.eye(3)):
        raise ProgramError("a path is written in its own frame, and this one was placed", cure="write program.path()")
    if path.tool.any():
        i = int(np.argmax(path.tool.any(1)))
        raise ProgramError("a tool offset cannot be written", line=line_of(path, i), cure="write the path of the tip")
    writer = Writer(path, decimals, chord)
    writer.lines += [_comment(line) for line in title.splitlines()]
    writer.add(HEAD)
    writer.start()
    for i in range(len(path)):
        writer.block(i)
    writer.add("M2")
    return "\n".join([*(_numbered(writer.lines) if numbered else writer.lines), ""])


def _numbered(lines):
    return [text if text.startswith("(") else f"N{number} {text}" for number, text in enumerate(lines, 1)]


def _comment(text: str) -> str:
    if _NO_TEXT.search(text) or _ACTIVE.match("".join(text.split())) or len(text.encode()) > 250:
        raise ProgramError(
            "this cannot be a comment of an NC program",
            value=ascii(text)[:60],
            cure="leave out brackets and words that LinuxCNC acts on, at most 250 bytes",
        )
    return f"({text})"
