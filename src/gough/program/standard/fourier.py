"""A periodic motion in all task coordinates: finite Fourier series over time."""

from __future__ import annotations

import functools

import numpy as np

from ...declare import Array, quantity
from ...errors import ExperimentError
from ...frames import rotation_of_abc_np
from ..base import Program
from ..path import Path
from ..shaper import shaped_poses
from ..timed import TimedMotion, path_of

_POINTS = 128  # of the path in the shortest period: the curve through them is 1e-9 of the amplitude from the motion
_REST = 1e-6  # of the largest rate: what a start may have left of speed and acceleration
FASTEST = 64  # harmonics


class Fourier(Program):
    """Fourier series of the tip and of the angles a b c, each with K harmonics of one period, from rest to rest:

        p(t)   = sum over k of sine_k sin(k w t) + cosine_k (cos(k w t) - 1),   w = 2 pi / period
        abc(t) = the same of turn_sine, turn_cosine

    The motion begins and ends at program zero.  It is at rest there where sum k sine_k = 0 and sum k^2 cosine_k = 0.
    `gough.identify.excite` finds coefficients that show a machine's parameters.
    """

    period: float = quantity("s", "the common period", above=0, at_most=3600)
    cycles: float = quantity(
        "",
        "periods that are run, one behind the other; a whole number",
        default=1.0,
        theta=False,
        above=0,
        at_most=10_000,
    )
    sine: Array | None = quantity("m", "sines of x y z, a row a harmonic", default=None, theta=False, shape=(-1, -1))
    cosine: Array | None = quantity("m", "cosines of x y z", default=None, theta=False, shape=(-1, -1))
    turn_sine: Array | None = quantity("rad", "sines of a b c", default=None, theta=False, shape=(-1, -1))
    turn_cosine: Array | None = quantity("rad", "cosines of a b c", default=None, theta=False, shape=(-1, -1))

    def model_post_init(self, context) -> None:
        if self.cycles != round(self.cycles):
            raise ExperimentError("must be a whole number", key="cycles", value=f"{self.cycles:g}")
        given = {key: getattr(self, key) for key in _SERIES if getattr(self, key) is not None}
        if not given:
            raise ExperimentError("a motion needs a coefficient", key="sine", cure="give sine, cosine or turn_sine")
        harmonics = len(next(iter(given.values())))
        for key, rows in given.items():
            if rows.shape[1] != 3 or not 1 <= len(rows) <= FASTEST:
                raise ExperimentError(
                    "a row of three numbers for each harmonic", key=key, value=" x ".join(map(str, rows.shape)),
                    limit=f"{FASTEST} rows",
                )  # fmt: skip
            if len(rows) != harmonics:
                raise ExperimentError(
                    "all series must have equally many harmonics", key=key, value=str(len(rows)), limit=str(harmonics)
                )
        for first, power, what in (("sine", 1, "speed"), ("cosine", 2, "acceleration")):
            for key in (first, f"turn_{first}"):
                self._check_rest(key, power, what)

    def _check_rest(self, key: str, power: int, what: str) -> None:
        rows = self.series(key)
        weight = np.arange(1.0, len(rows) + 1)[:, None] ** power
        left, most = np.abs((weight * rows).sum(0)), np.abs(weight * rows).max(initial=0.0)
        if (left > _REST * most).any():
            j = int(left.argmax())
            raise ExperimentError(
                f"the motion must begin without {what}: the sum of {'k' if power == 1 else 'k^2'} {key}_k must be 0",
                key=key, value=f"{left[j]:.3g} in column {j + 1}",
                cure="change the last row by the sum over its k" + ("" if power == 1 else "^2"),
            )  # fmt: skip

    def series(self, key: str) -> np.ndarray:
        """One of the four series, zeros where it is left out.  (K, 3)."""
        rows = getattr(self, key)
        return np.zeros((self.harmonics, 3)) if rows is None else np.asarray(rows, float)

    @property
    def harmonics(self) -> int:
        """K."""
        return next(len(getattr(self, key)) for key in _SERIES if getattr(self, key) is not None)

    def poses(self, t) -> tuple[np.ndarray, ...]:
        """p, p', p'', abc, abc', abc'' at times t (n,) s, in the program's frame.  (n, 3) each."""
        k = np.arange(1.0, self.harmonics + 1) * (2 * np.pi / self.period)
        phase = np.multiply.outer(np.asarray(t, float), k)
        sine, cosine = np.sin(phase), np.cos(phase)
        values = []
        for a, b in (("sine", "cosine"), ("turn_sine", "turn_cosine")):
            a, b = self.series(a), self.series(b)
            values += [
                sine @ a + (cosine - 1) @ b,
                (cosine * k) @ a - (sine * k) @ b,
                -(sine * k**2) @ a - (cosine * k**2) @ b,
            ]
        return tuple(values)

    @property
    def nodes(self) -> np.ndarray:
        """Times of the points that the path goes through.  (m + 1,) s."""
        steps = _POINTS * self.harmonics * round(self.cycles)
        return np.linspace(0.0, self.period * self.cycles, steps + 1)

    def path(self) -> Path:
        return path_of(self.poses, self.nodes)[0]

    def plan(self, machine) -> TimedMotion:
        """The motion of `machine` along this program.  The last one is kept.

        Raises
        ------
        ProgramError
            nothing moves.
        """
        return _planned(self, machine)


_SERIES = ("sine", "cosine", "turn_sine", "turn_cosine")


@functools.lru_cache(maxsize=1)
def _planned(program: Fourier, machine) -> TimedMotion:
    origin = np.asarray(machine.home if program.origin is None else program.origin, float)
    if len(origin) < 6:  # a machine of fewer freedoms: its tool's pose at home
        origin = np.asarray(machine.tool_pose(origin), float)
    R_WO = rotation_of_abc_np(origin[3:])
    poses, nodes, shaper = program.poses, program.nodes, program.shaping()
    if shaper is not None:
        poses, nodes = shaped_poses(poses, nodes, shaper)
    return TimedMotion(poses, nodes, machine, origin[:3], R_WO, program.settle, program.lead_in)
