"""How large a program is: the box its tool tip stays in, and a program that is most likely in inches."""

from __future__ import annotations

import numpy as np

INCH = 0.0254  # m
WOULD_FIT = "in mm (G21) it would fit"
_PLACES = 200_000  # along the whole path
_FEWEST, _MOST = 3, 257  # of a block; 257 come by the quarters of a full circle, and elsewhere within r / 13 000


def box(path) -> np.ndarray:
    """Least and greatest x, y, z of the tip along a path, as far as its places show.  (2, 3) m.

    Lines are exact; arcs are looked at in up to 257 places.
    """
    count = int(np.clip(_PLACES // len(path), _FEWEST, _MOST)) | 1
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    every = np.arange(len(path))
    for share in np.linspace(0, 1, count):
        p = path.point(every, share * path.length)
        low, high = np.minimum(low, p.min(0)), np.maximum(high, p.max(0))
    return np.stack([low, high])


def sides(workspace) -> np.ndarray:
    """Lengths of the declared workspace along the axes of W.  (3,) m."""
    across = np.full(2, 2 * workspace.radius) if workspace.size is None else np.asarray(workspace.size, float)
    return np.r_[across, workspace.height]


def too_large(path, machine, text: str | None = None) -> str | None:
    """What to say where the path is larger than the declared workspace, wherever it is put; else None.

    That is no error: the joints may go further than the workspace that a sheet declares.

    `text` is that of the NC program: one in inches that would fit in millimetres is told as such.
    """
    space = machine.limits.workspace
    if space is None:
        return None
    size, room = np.ptp(box(path), axis=0), sides(space)
    if (size <= room).all():
        return None
    said = f"the program is {_mm(size)} mm large, more than the workspace of {machine.name}, {_mm(room)} mm"
    line = None if text is None else _line_of_inches(text)
    if line is not None and (size / INCH * 1e-3 <= room).all():
        said += f"; line {line} says G20, inches: {WOULD_FIT}"
    return said


def _mm(lengths) -> str:
    return " x ".join(f"{1e3 * one:.4g}" for one in lengths)


def _line_of_inches(text: str) -> int | None:
    """The first line with G20, as far as the lines are in order."""
    from ..errors import ProgramError
    from .ngc.lexer import read_line

    for number, line in enumerate(text.splitlines(), 1):
        try:
            words = read_line(line, number).words
        except ProgramError:
            continue
        if any(word.letter == "G" and word.value == 20.0 for word in words):
            return number
    return None
