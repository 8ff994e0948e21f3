"""The start that is not printed: offsets of the tool from the path, and the three averages that come out of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...simulate.plant import Plant
from ...simulate.run import simulate
from ..study import Tick, parts
from .setup import CASES, CIRCLE, law, machine, program, scaled

PUBLISHED = (0.773e-6, 5.532e-6, 9.429e-6)  # m, average contour errors over CASES
COARSE, FINE = np.arange(-60, 61, 15) * 1e-6, np.arange(-10, 11, 5) * 1e-6  # m, along x (across the path) and z


class Found(NamedTuple):
    """The offset whose averages are nearest the published ones, by the largest relative deviation of the three."""

    offset: np.ndarray  # (3,) m, in W
    averages: np.ndarray  # (3,) m, over CASES
    deviation: float
    nearest: np.ndarray  # least deviation of each of the three averages over all offsets tried


def search(tick: Tick | None) -> Found:
    """Offsets across the path on a grid, then on a finer one about the best."""
    first, second = parts(tick, [2.0, 1.0])
    grid = [np.array([x, 0.0, z]) for x in COARSE for z in COARSE]
    found = averages(grid, first)
    best = grid[int(np.argmin(deviations(found).max(1)))]
    near = [best + [x, 0.0, z] for x in FINE for z in FINE]
    tried = np.concatenate([found, averages(near, second)])
    i = int(np.argmin(deviations(tried).max(1)))
    return Found([*grid, *near][i], tried[i], float(deviations(tried)[i].max()), deviations(tried).min(0))


def averages(offsets, tick: Tick | None = None) -> np.ndarray:
    """Average contour errors over CASES.  (offsets, 3) m."""
    plants = [Plant(machine=one, offset=offset) for offset in offsets for one in map(_scaled, CASES)]
    log = simulate(machine(), law(CIRCLE), program(CIRCLE), plant=plants, signals=["contour_error"], progress=tick)
    return log.dataset["contour_error"].values.mean(0).reshape(len(offsets), len(CASES))


def deviations(found) -> np.ndarray:
    """Of averages (n, 3) from the published ones, as a share of these."""
    return np.abs(found / np.array(PUBLISHED) - 1)


def _scaled(times: float):
    return scaled(machine(), times)
