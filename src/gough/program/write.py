"""Paths as NC programs that gcode.py reads back."""

from __future__ import annotations

import math

import numpy as np

from ..errors import ProgramError
from .blocks import ARC, ELLIPSE, REST
from .path import Path


def to_gcode(path: Path, title: str = "written by gough") -> str:
    """A path in its own frame as an NC program in mm; ten decimals, 0.1 pm, so that reading it back loses nothing.

    Raises
    ------
    ProgramError
        the path does not start at zero, or has an ellipse, a dwell or an arc outside the XY plane.
    """
    lines = [f"({title})", "G21 G90 G17"]
    every = np.arange(len(path))
    end = 1e3 * path.point(every, path.length)
    abc = np.degrees(path.angles(every, path.extent))
    first = np.concatenate([path.point(every[:1], np.zeros(1))[0], path.abc0[0]])
    if np.abs(first).max() > 1e-12:
        lines.append("G0" + _words("XYZABC", [*(1e3 * first[:3]), *np.degrees(first[3:])]))
    for i in every:
        kind, index = path.kind[i], path.index[i]
        words = _words("XYZ", end[i])
        if path.turn[i].any():
            words += _words("ABC", abc[i])
        if kind == ELLIPSE or path.dwell[i] > 0:
            raise ProgramError("an ellipse or a dwell cannot be written in the NC subset")
        code = "G0" if path.rapid[i] else "G1"
        if kind == ARC:
            arcs = path.batches[ARC]
            up = arcs.normal[index][2]
            if abs(abs(up) - 1) > 1e-12 or path.rapid[i] or arcs.sweep[index] > 2 * math.pi + 1e-9:
                raise ProgramError("an arc must lie in the XY plane and turn once at most")
            offset = -1e3 * arcs.radius[index] * arcs.e1[index]
            code, words = ("G3" if up > 0 else "G2"), words + _words("IJ", offset[:2])
        feed = ""
        if not path.rapid[i]:
            scale = 60 * 180 / math.pi if kind == REST else 60e3
            feed = _words("F", [scale * path.feed[i]])
        lines.append(code + words + feed)
    return "\n".join([*lines, "M2", ""])


def _words(letters, numbers):
    return "".join(f" {letter}{_number(value)}" for letter, value in zip(letters, numbers, strict=True))


def _number(value):
    text = f"{value:.10f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text
