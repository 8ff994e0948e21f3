"""An NC program again, its tool leaning against the cut: every line that changes stands above its new ones.

    ; was: G1 Y-80 F6000
    G64 P0.002
    G1 Y10 F6000
    G1 X-0.0119 Y6.5 B0.038
    ...
    G61

A line is replaced where its tool leans, or where the one before ended beside its place; all others stay as they are.
New lines are straight moves to absolute places in millimetres and degrees: arcs become chords of `CHORD`.  Where the
program stops at corners (G61, G61.1) those between the new lines are rounded by `ROUND`, so that the feed goes on.
What was written is read back, and must come to the path that was meant: so a program whose units, offsets
or distances are others than G21 G90 is refused and never bent.
"""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np

from ..errors import ProgramError
from ..frames import abc_of_rotation_np, rotation_of_abc_np, rotation_of_vector_np
from ..program.blocks import ARC, ELLIPSE, REST
from ..program.nc import NCProgram
from ..program.path import Path
from .profile import frame

CHORD = 1e-6  # m, that short lines leave an arc
ROUND = 2e-6  # m, that corners between the new lines are rounded by, where the program stops at corners
MM, DEG = 4, 4  # decimals that are written
_CURE = "write it in G21 G90 and G94, without G92 or other offsets"
_WORD = re.compile(r"([A-Z])\s*([+-]?(?:\d+\.?\d*|\.\d+))")
_MOVES = {0.0, 1.0, 2.0, 3.0}
_SAME = 2e-6  # m and rad: the rounding of what is written is 0.05 um and 0.9 urad


class Changed(NamedTuple):
    """A line that was replaced."""

    line: int  # of the program as it was
    was: str
    now: list[str]
    tilt: float  # rad, the greatest on it
    shift: float  # m
    first: float  # m of the path as it was: where its move begins
    last: float


class Rewritten(NamedTuple):
    """The program with its tool leaning."""

    program: NCProgram
    changes: list[Changed]


def rewritten(program: NCProgram, s, tilt, height: float, shift=None) -> Rewritten:
    """`program` with the tool leant by tilt (n,) rad at path lengths s (n,) m, straight in between.

    Its tip goes back by shift (n,) m; without it, by as much as the tilt asks for where the tool stays at `height` m.

    Raises
    ------
    ProgramError
        a line that would change does more than move, runs more than once, or does not say millimetres, absolute.
    """
    path = program.path()
    meant = _Meant(path, np.asarray(s, float), np.asarray(tilt, float), height, shift)
    lines = program.text.splitlines()
    of_line = {}
    for i in range(len(path)):
        if path.kind[i] != REST or path.turning_at_rest[i]:
            of_line.setdefault(int(path.line[i]), []).append(i)
    changes, out = [], []
    at = meant.written(meant.start())
    ends: list[tuple[np.ndarray, float, int]] = []  # where each move should end, at what feed, and of which line it is
    displaced, replaced_arc = False, False
    for number, text in enumerate(lines, 1):
        blocks = of_line.get(number, [])
        leans = any(meant.leans(i) for i in blocks)
        implicit = replaced_arc and blocks and not _motion_of(text)
        if not (leans or (displaced and blocks) or implicit):
            out.append(text)
            ends += [(meant.end(i), path.feed[i], number) for i in blocks]
            if blocks:
                at, replaced_arc = meant.written(meant.end(blocks[-1])), False
            continue
        _check_line(program, text, number, blocks)
        (i,) = blocks
        now = []
        for pose in meant.pieces(i):
            target = meant.written(pose)
            words = _words(target, at)
            if not words:
                continue
            rapid = path.rapid[i]
            feed = "" if rapid or now else f" F{_text(60e3 * path.feed[i], 6)}"
            now.append(f"{'G0' if rapid else 'G1'}{words}{feed}")
            ends.append((pose, path.feed[i], number))
            at = target
        displaced = meant.leans_at(meant.end_s(i))
        replaced_arc = path.kind[i] in (ARC, ELLIPSE)
        most, back = meant.most(i)
        exact = path.tolerance[i] <= 0 and len(now) > 1
        if exact:  # else the tool would stop at every new corner, and cut free there
            now = [f"G64 P{_text(1e3 * ROUND, 4)}", *now, "G61" if path.tolerance[i] == 0 else "G61.1"]
        changes.append(Changed(number, text.strip(), now, most, back, meant.first_s(i), meant.end_s(i)))
        out += [f"; was: {text.strip()}", *now]
    return Rewritten(_read_back(program, "\n".join(out) + "\n", ends), changes)


class _Meant:
    """Where the tool is meant to be along a path in its own frame."""

    def __init__(self, path: Path, s, tilt, height, shift):
        self.path, self.s, self.tilt, self.height = path, s, tilt, height
        self.shift = None if shift is None else np.asarray(shift, float)

    def command_at(self, s) -> tuple[np.ndarray, np.ndarray]:
        """theta and delta at path lengths s (n,) m."""
        theta = np.interp(s, self.s, self.tilt, left=0.0, right=0.0)
        if self.shift is None:
            return theta, self.height * np.tan(theta)
        return theta, np.interp(s, self.s, self.shift, left=0.0, right=0.0)

    def leans_at(self, s: float) -> bool:
        return any(float(part) != 0 for part in self.command_at(s))

    def first_s(self, i) -> float:
        return float(self.path.s0[i])

    def end_s(self, i) -> float:
        return float(self.path.s0[i + 1])

    def leans(self, i) -> bool:
        return self.most(i) != (0, 0)

    def most(self, i) -> tuple[float, float]:
        """The greatest tilt along block i, with its sign, and the greatest shift."""
        a, b = self.path.s0[i], self.path.s0[i + 1]
        every = self.command_at(np.array([a, b, *self.s[(self.s > a) & (self.s < b)]]))
        return tuple(float(part[np.argmax(np.abs(part))]) for part in every)

    def start(self) -> np.ndarray:
        """Where the program takes the tool to be before its first move."""
        path, first = self.path, np.zeros(1, int)
        return np.concatenate([path.point(first, np.zeros(1)), path.angles(first, np.zeros(1))], 1)[0]

    def end(self, i) -> np.ndarray:
        return self.pose(np.array([i]), np.array([self.path.extent[i]]))[0]

    def pose(self, i, u) -> np.ndarray:
        """x y z a b c of blocks i (n,) at extents u (n,), leaning: eq. (1) of compensation.py.  (n, 6)."""
        path = self.path
        length = np.where(path.kind[i] == REST, 0.0, u)
        s = path.s0[i] + length
        theta, delta = self.command_at(s)
        p, abc = path.point(i, length), path.angles(i, u)
        if not (theta.any() or delta.any()):
            return np.concatenate([p, abc], 1)
        # the frame of the block itself, also at its end
        e_x, e_y, _ = frame(path, path.s0[i] + np.minimum(length, (1 - 1e-9) * path.length[i]))
        leant = abc_of_rotation_np(rotation_of_vector_np(-theta[:, None] * e_x) @ rotation_of_abc_np(abc))
        leant += 2 * np.pi * np.round((abc - leant) / (2 * np.pi))
        turned = np.where(theta[:, None] != 0, leant, abc)
        return np.concatenate([p - delta[:, None] * e_y, turned], 1)

    def pieces(self, i) -> np.ndarray:
        """Poses at the ends of the straight moves that block i becomes.  (k, 6)."""
        path = self.path
        length = path.length[i]
        if path.rapid[i] or path.kind[i] == REST:
            return self.end(i)[None]
        inside = self.s[(self.s > path.s0[i] + 1e-6) & (self.s < path.s0[i + 1] - 1e-6)] - path.s0[i]
        if path.kind[i] in (ARC, ELLIPSE):
            count = int(np.ceil(length * np.sqrt(path.sharpest()[i] / (8 * CHORD))))
            inside = np.union1d(inside, np.linspace(0, length, max(count, 1) + 1)[1:-1])
        u = np.append(inside, length)
        return self.pose(np.full(len(u), i), u)

    @staticmethod
    def written(pose) -> np.ndarray:
        """Millimetres and degrees as they are written."""
        return np.concatenate([np.round(1e3 * pose[:3], MM), np.round(np.degrees(pose[3:]), DEG)]) + 0.0


def _words(target, at) -> str:
    """The words that change."""
    decimals = [MM] * 3 + [DEG] * 3
    return "".join(
        f" {letter}{_text(value, places)}"
        for letter, value, places, old in zip("XYZABC", target, decimals, at, strict=True)
        if value != old
    )


def _text(value: float, decimals: int) -> str:
    text = f"{value:.{decimals}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def _code(text: str) -> str:
    """A line without its comments, in capitals."""
    return re.sub(r"\([^)]*\)|;.*", "", text).upper()


def _motion_of(text: str) -> bool:
    """Whether a line says itself how it moves."""
    return any(letter == "G" and float(number) in _MOVES for letter, number in _WORD.findall(_code(text)))


def _check_line(program, text, number, blocks):
    code = _code(text)
    words = _WORD.findall(code)
    more = re.sub(r"[\s/%]", "", _WORD.sub("", code))
    other = [f"{a}{b}" for a, b in words if a not in "NGXYZABCIJKRPF" or (a == "G" and float(b) not in _MOVES)]
    place = {"file": program.name, "line": number}
    if more or other:
        raise ProgramError(
            "a line whose tool leans must do no more than move", value=(other + [more])[0][:40],
            cure="write numbers, and codes on a line of their own", **place,
        )  # fmt: skip
    if len(blocks) != 1:
        raise ProgramError(
            "a line whose tool leans must run once", value=f"{len(blocks)} moves", cure="write out the loop", **place
        )


def _read_back(program: NCProgram, text: str, ends: list[tuple[np.ndarray, float, int]]) -> NCProgram:
    """The program with a new text, which must come to the path and the feeds that were meant."""
    try:
        made = program.replace(text=text)
    except ProgramError as error:
        raise ProgramError(
            "the corrected program cannot be read back", file=program.name, value=str(error)[:200], cure=_CURE
        ) from None
    path = made.path()
    rows = np.flatnonzero((path.kind != REST) | path.turning_at_rest)
    found = np.concatenate([path.point(rows, path.length[rows]), path.angles(rows, path.extent[rows])], 1)
    if len(rows) == len(ends):
        off = np.abs(found - np.array([pose for pose, _, _ in ends])).max(1)
        feed = np.array([feed for _, feed, _ in ends])
        slow = ~path.rapid[rows] & (np.abs(path.feed[rows] - feed) > 1e-6 * feed)
        bad = np.flatnonzero((off > _SAME) | slow)
        if not len(bad):
            return made
        line, value = ends[bad[0]][2], f"{off[bad[0]]:.3g} m or rad beside its place"
        if off[bad[0]] <= _SAME:
            value = f"a feed of {path.feed[rows[bad[0]]]:g} m/s instead of {feed[bad[0]]:g}"
    else:
        line, value = None, f"{len(rows)} moves instead of {len(ends)}"
    raise ProgramError(
        "the corrected program does not come to the path that was meant", file=program.name, line=line, value=value,
        cure=_CURE,
    )  # fmt: skip
