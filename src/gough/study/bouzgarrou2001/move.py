"""The reference move of the paper: sinusoidal accelerations along X, Y and Z, all from t = 0 on.

    x_i = D_i (c - sin(2 pi c) / 2 pi),   c = t / T_i up to 1                                                       (1)
    x_i' = D_i (1 - cos(2 pi c)) / T_i,   x_i'' = A_i sin(2 pi c),   T_i = sqrt(2 pi |D_i| / |A_i|)                 (2)

so amplitude and distance give the time: A sin(2 pi t / T), twice integrated, goes A T^2 / 2 pi.  The paper's X and Y
have one time, 0.315 / 10 = 0.63 / 20; Z, 0.55 m at 20 m/s2, arrives 29 ms before them, so the path bends.

The path for the contour error is a row of chords of equal length, which the closest point is quickly found on.
"""

from __future__ import annotations

import functools

import numpy as np

from ...declare import Array, quantity
from ...frames import rotation_of_abc_np
from ...program.base import Program
from ...program.blocks import Block, Line
from ...program.path import Path
from ...program.timed import TimedMotion

CHORDS = 2048  # of the path: nowhere farther than 1 um from the motion
_FINE = 50_000  # steps in which the motion's length is measured for them


class SinusoidalMove(Program):
    """Eqs. (1), (2) from program zero by `distance`, each direction at its `amplitude`."""

    distance: Array = quantity("m", "D: how far along x, y, z", theta=False, shape=(3,))
    amplitude: Array = quantity(
        "m/s2", "A: size of the greatest acceleration along each", theta=False, above=0, shape=(3,)
    )

    @property
    def times(self) -> np.ndarray:
        """T_i of eq. (2).  (3,) s."""
        return np.sqrt(2 * np.pi * np.abs(self.distance) / self.amplitude)

    @property
    def jerks(self) -> np.ndarray:
        """Greatest jerk of each direction, A 2 pi / T, at both its ends.  (3,) m/s3; 0 along which nothing moves."""
        return np.divide(2 * np.pi * self.amplitude, self.times, out=np.zeros(3), where=self.times > 0)

    def poses(self, t) -> tuple[np.ndarray, ...]:
        """p, p', p'' and the angles' nothing at times t (n,) s, in the program's frame.  (n, 3) each."""
        T = np.where(self.times > 0, self.times, 1.0)
        c = np.minimum(np.asarray(t, float)[:, None] / T, 1.0)
        angle, none = 2 * np.pi * c, np.zeros((len(c), 3))
        p = self.distance * (c - np.sin(angle) / (2 * np.pi))
        pd = self.distance / T * (1 - np.cos(angle))
        pdd = np.where(c < 1, self.distance * 2 * np.pi / T**2 * np.sin(angle), 0.0)
        return p, pd, pdd, none, none, none

    @property
    def nodes(self) -> np.ndarray:
        """Times at which a chord of the path begins, and the last ends.  (CHORDS + 1,) s."""
        t = np.linspace(0.0, self.times.max(), _FINE + 1)
        length = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(self.poses(t)[0], axis=0), axis=1)))
        return np.interp(np.linspace(0.0, length[-1], CHORDS + 1), length, t)

    def path(self) -> Path:
        t = self.nodes
        p = self.poses(t)[0]
        feed = np.linalg.norm(np.diff(p, axis=0), axis=1) / np.diff(t)
        ends = zip(p[:-1], p[1:], feed, strict=True)
        return Path([Block(Line(tuple(a), tuple(b)), feed=float(speed)) for a, b, speed in ends])

    def plan(self, machine) -> ChordMotion:
        return _planned(self, machine)


class ChordMotion(TimedMotion):
    """A TimedMotion whose path is made of chords."""

    def __init__(self, program: SinusoidalMove, machine, p_WO, R_WO):
        self.poses, self.machine, self.settle, self.lead_in = program.poses, machine, program.settle, program.lead_in
        self.path, self.start = program.path().placed(p_WO, R_WO), program.nodes
        self.end = float(self.start[-1])
        self.duration = self.lead_in + self.end + self.settle


@functools.lru_cache(maxsize=4)
def _planned(program: SinusoidalMove, machine) -> ChordMotion:
    origin = np.asarray(machine.program_zero if program.origin is None else program.origin, float)
    return ChordMotion(program, machine, origin[:3], rotation_of_abc_np(origin[3:]))
