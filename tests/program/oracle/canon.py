"""LinuxCNC's canonical commands as a list of moves: what its interpreter makes of an NC program.

It tells moves in program coordinates p and says when an offset changes; the place in the machine's frame is

    x = R_z(rotation) (p + g92) + g5x          lengths of X and Y turned, all else only shifted                   (1)

and the tool is beyond it: LinuxCNC adds the tool offset along the machine's axes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

INCH = 25.4
# normal and the two axes of a plane, in the order the canon names them: G17, G18, G19
PLANES = {"XY": (2, 0, 1), "XZ": (1, 2, 0), "YZ": (0, 1, 2)}


class Move(NamedTuple):
    """What the machine is told.  Places in mm and deg in the machine's frame, tool offset left out."""

    kind: str  # rapid, feed, arc, dwell or stop
    line: int | None = None  # rs274 prints none
    start: np.ndarray | None = None  # (6,) x y z a b c
    end: np.ndarray | None = None
    center: np.ndarray | None = None  # (3,), at any height of the axis
    normal: np.ndarray | None = None
    sweep: float = 0.0  # deg, right-handed about the normal
    feed: float = 0.0  # mm/min; deg/min for a turn
    dwell: float = 0.0  # s
    tool: np.ndarray = np.zeros(3)  # mm
    tolerance: float | None = None  # mm; -1 exact stop, 0 exact path, inf: as much as there is; None: not told
    spindle: float | None = None  # rev/min, clockwise above 0


class Refused(NamedTuple):
    """The program was not accepted; the moves up to there."""

    text: str
    line: int | None
    moves: list[Move]


class Machine:
    """Offsets and place, in mm and deg, as the canon's calls set them.  Moves up to `blind` mm are none."""

    def __init__(self, blind=1e-9):
        self.blind = blind
        self.g5x, self.g92, self.tool = np.zeros(6), np.zeros(6), np.zeros(3)
        self.rotation, self.plane, self.at = np.eye(3), "XY", np.zeros(6)
        self.feed = self.feed_word = 0.0
        self.tolerance, self.spindle = None, 0.0
        self.moves: list[Move] = []

    def turn(self, degrees):
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        self.rotation = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])

    def place(self, p):
        """(1)"""
        p = np.asarray(p, float) + self.g92
        return np.concatenate([self.rotation @ p[:3], p[3:]]) + self.g5x

    def change_tool_offset(self, tool):
        """The machine stays; the tip it has from now on is elsewhere."""
        if np.abs(self.tool - tool).max() > 0:
            self.at[:3] += self.tool - tool
            self.tool = np.array(tool, float)
            self.add("stop")

    def add(self, kind, end=None, **more):
        end = self.at if end is None else end
        told = {"feed": self.feed, "tool": self.tool, "tolerance": self.tolerance, "spindle": self.spindle}
        self.moves.append(Move(kind, start=self.at.copy(), end=end.copy(), **told | more))
        self.at = end.copy()

    def dwell(self, seconds, **more):
        self.add("dwell" if seconds else "stop", dwell=seconds, **more)

    def straight(self, kind, end, **more):
        end = self.place(end)
        moved = np.abs(end - self.at)
        if moved[:3].max() > self.blind:
            self.add(kind, end, **more)
        elif moved[3:].max() > 1e-9:  # a turn: F is deg/min in mm and in inch
            self.add(kind, end, feed=self.feed_word, **more)
        else:  # a move to where the machine is asks for nothing
            self.at = end

    def arc(self, first, second, first_center, second_center, turns, height, abc, **more):
        """The numbers of ARC_FEED, mm and deg."""
        axis, i, j = PLANES[self.plane]
        end, center = np.zeros(6), np.zeros(6)
        end[[i, j, axis]], end[3:] = (first, second, height), abc
        center[[i, j]] = first_center, second_center
        end, center = self.place(end), self.place(center)[:3]
        normal = self.rotation @ np.eye(3)[axis]
        center += normal * (normal @ (self.at[:3] - center))
        sweep = angle(self.at[:3] - center, end[:3] - center, normal * np.sign(turns))
        sweep += 360.0 * (abs(turns) - 1)
        self.add("arc", end, center=center, normal=normal * np.sign(turns), sweep=sweep, **more)


def angle(a, b, normal) -> float:
    """From a to b, right-handed about the normal.  deg in (0, 360]: to the same place it is a whole turn."""
    turned = np.degrees(np.arctan2(normal @ np.cross(a, b), a @ b - (normal @ a) * (normal @ b)))
    return turned + 360.0 if turned < 1e-6 else turned
