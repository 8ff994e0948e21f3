"""Input shapers: a motion as the mean of itself and of itself some time later, so that what it shakes dies with it.

A mode of frequency f and damping zeta, w = 2 pi f, w_d = w sqrt(1 - zeta^2), answers an impulse with
e^(-zeta w t) sin(w_d t).  Impulses of size A_i >= 0, sum of A_i = 1, at the times t_1 = 0 ... t_n leave of it

    V = e^(-zeta w t_n) |sum of A_i e^((zeta w + i w_d) t_i)|                                                       (9)

times what one impulse at t_n would shake.  With K = e^(-pi zeta / sqrt(1 - zeta^2)) and half a period h = pi / w_d
between the impulses,

    zv    A = (1, K) / (1 + K)                              V = 0 at f                                             (10)
    zvd   A = (1, 2 K, K^2) / (1 + K)^2                     V = 0 at f, and dV/df = 0
    ei    A = (1 + T, 2 (1 - T) K, (1 + T) K^2) / sum       V = 4 T K^2 / sum at f, 0 on either side of it

For several modes the shapers follow one another.  Whatever bounds a motion's derivatives bounds those of the mean too;
it takes t_n longer.  docs/theory/feed.md, section 8.

Source: Smith, Posicast control of damped oscillatory systems, 1957 (zv); Singer and Seering, Preshaping command inputs
to reduce system vibration, 1990 (zvd); Singhose, Seering and Singer, Residual vibration reduction using vector diagrams
to generate shaped inputs, 1994 (ei, there without damping; the powers of K here are those of zvd).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..errors import ExperimentError

EI = 0.05  # T: what the shaper "ei" may leave at its frequency
MOST = 4  # modes
KINDS = ("zv", "zvd", "ei")


class Shaper(NamedTuple):
    """Impulses: `size` (n,), which sum to 1, at `time` (n,) s, the first at 0."""

    size: np.ndarray
    time: np.ndarray

    @property
    def delay(self) -> float:
        """t_n, s: how much longer a shaped motion takes."""
        return float(self.time[-1])

    def residual(self, frequency, damping: float = 0.0) -> np.ndarray:
        """V of eq. (9) for modes at `frequency` (...) Hz of the damping ratio `damping`.  (...)."""
        w = 2 * np.pi * np.asarray(frequency, float)[..., None]
        pole = damping * w + 1j * w * np.sqrt(1 - damping**2)
        return np.abs((self.size * np.exp(pole * (self.time - self.delay))).sum(-1))

    def after(self, other: Shaper) -> Shaper:
        """One shaper behind another: both their modes are left at rest."""
        size, time = np.multiply.outer(self.size, other.size).ravel(), np.add.outer(self.time, other.time).ravel()
        order = np.argsort(time, kind="stable")
        return Shaper(size[order], time[order])


def shaper_of(kind: str, frequency, damping: float = 0.0) -> Shaper:
    """The shaper `kind`, "zv", "zvd" or "ei", of eq. (10) for a mode, or for several one behind the other.

    frequency  Hz, one or (m,), natural (undamped)
    damping    ratio of all of them, at least 0 and below 1

    Raises
    ------
    ExperimentError
        no such kind, a frequency that is not above 0, more than 4 of them, a damping outside 0 ... 1.
    """
    if kind not in KINDS:
        raise ExperimentError("no such shaper", key="shaper", value=repr(kind)[:40], cure="one of " + ", ".join(KINDS))
    f = np.atleast_1d(np.asarray(frequency, float))
    if f.ndim != 1 or not 1 <= len(f) <= MOST or not (np.isfinite(f) & (f > 0)).all():
        raise ExperimentError(
            f"needs one to {MOST} frequencies above 0", key="shaper_frequency", value=str(np.size(f)) + " values"
            if f.ndim != 1 or not 1 <= len(f) <= MOST else f"{f.min():g} Hz",
        )  # fmt: skip
    if not 0 <= damping < 1:
        raise ExperimentError("must be at least 0 and below 1", key="shaper_damping", value=f"{damping:g}")
    found = Shaper(np.ones(1), np.zeros(1))
    for one in f:
        found = _single(kind, one, damping).after(found)
    return found


def _single(kind: str, f: float, zeta: float) -> Shaper:
    """Eq. (10) for one mode."""
    root = np.sqrt(1 - zeta * zeta)
    K, h = np.exp(-np.pi * zeta / root), 1 / (2 * f * root)
    size = {"zv": [1, K], "zvd": [1, 2 * K, K * K], "ei": [1 + EI, 2 * (1 - EI) * K, (1 + EI) * K * K]}[kind]
    return Shaper(np.array(size) / sum(size), h * np.arange(len(size)))


Poses = Callable[[np.ndarray], tuple[np.ndarray, ...]]


def shaped_poses(poses: Poses, nodes: np.ndarray, shaper: Shaper) -> tuple[Poses, np.ndarray]:
    """A motion over time (program/timed.py) shaped in every coordinate, and its nodes (k,) s.

    The mean of places at different times is no place of the motion: only where all coordinates run along one line does
    the tool keep its path.  At both ends the motion must be at rest.
    """
    end = float(nodes[-1])

    def made(t):
        total: list = [0.0] * 6
        for size, late in zip(shaper.size, shaper.time, strict=True):
            at = np.asarray(t, float) - late
            on = ((at >= 0) & (at <= end))[:, None]
            for k, part in enumerate(poses(np.clip(at, 0.0, end))):
                total[k] = total[k] + size * (part if k in (0, 3) else np.where(on, part, 0.0))  # outside it rests
        return tuple(total)

    behind = nodes[-1] + np.linspace(0.0, shaper.delay, 1 + max(1, round(shaper.delay / np.diff(nodes).max())))
    return made, np.union1d(nodes, behind)
