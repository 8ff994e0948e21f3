"""What the springs of the slides make of the machine at rest: frequencies, stiffness, sag; along the move and over XY.

The map, which the paper lacks: sections x = 0, over y and the ram, and z = 0, over x and y, of the workspace.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...errors import KinematicsError
from ...machine.workspace import random_poses
from ..study import Tick
from . import statics
from .setup import END, START, machine

SECTIONS = ((0, 1, 2), (2, 0, 1))  # the coordinate that is 0, and those along the axes of a section
SIDE = 13  # places along each axis of a section
PLACES = 20  # at which the algorithm of section 3.3 is tried


class Standing(NamedTuple):
    """At rest at one place, the joints held."""

    frequency: float  # Hz, the first
    stiffness: np.ndarray  # along x, y, z, N/m
    least: float  # in the softest direction, N/m
    sag: np.ndarray  # of the tip, (3,) m


class Section(NamedTuple):
    """A section of the workspace, one coordinate 0."""

    across: int  # which is along the first axis, and along the second
    up: int
    a: np.ndarray  # (k,) m along the first
    b: np.ndarray  # (k,) m along the second
    frequency: np.ndarray  # (k, k) Hz, rows by the second
    stiffness: np.ndarray  # (k, k) N/m, in the softest direction
    sag: np.ndarray  # (k, k) m, along y


class Statics(NamedTuple):
    """The algorithm of section 3.3 at START, END and PLACES random places."""

    printed: float  # least of what a turn of the printed one multiplies by
    refused: bool  # whether it ends with an error at END
    turns: int  # most of the repaired one, to 1e-13 m
    away: float  # m, most from Newton's method on the exact statics
    contraction: float  # largest |d sag / d x|


def standing(x) -> Standing:
    """At rest with the joints at the rigid machine's place x (3,)."""
    m = machine().flexible()
    C = m.tool_compliance(x)[:3, :3]
    sag = m.settled_pose(x)[:3] - x
    return Standing(float(m.modes(x).frequency[0]), 1 / np.diag(C), float(1 / np.linalg.eigvalsh(C)[-1]), sag)


def both_ends(tick: Tick | None) -> dict[str, Standing]:
    """At both ends of the move."""
    return {"start": standing(START), "end": standing(END)}


def sections(tick: Tick | None) -> list[Section]:
    """The map, at SECTIONS."""
    space, home = machine().limits.workspace, machine().home
    middle, half = home + space.middle, np.array([*space.size, space.height]) / 2
    low, high = middle - 0.999 * half, middle + 0.999 * half
    out = []
    for k, (_, across, up) in enumerate(SECTIONS):
        a, b = (np.linspace(low[i], high[i], SIDE) for i in (across, up))
        columns = np.zeros((SIDE, SIDE, 3))
        for i, j in np.ndindex(SIDE, SIDE):
            x = np.zeros(3)
            x[across], x[up] = a[j], b[i]
            one = standing(x)
            columns[i, j] = one.frequency, one.least, one.sag[1]
        out.append(Section(across, up, a, b, *np.moveaxis(columns, -1, 0)))
        if tick is not None:
            tick(k + 1, len(SECTIONS))
    return out


def iteration(tick: Tick | None) -> Statics:
    """The algorithm of section 3.3, printed and repaired."""
    true = machine().flexible()
    places = [START, END, *random_poses(machine(), PLACES, np.random.default_rng(1))]
    found = [statics.algorithm(true, x) for x in places]
    try:
        statics.algorithm(true, END, printed=True)
        refused = False
    except KinematicsError:
        refused = True
    return Statics(
        min(statics.printed_gain(true, x) for x in places), refused, max(len(one.steps) for one in found),
        max(float(np.abs(one.s - true.targets(x)).max()) for one, x in zip(found, places, strict=True)),
        max(statics.contraction(true, x) for x in places),
    )  # fmt: skip


JOBS: dict[str, Callable[[Tick | None], Any]] = {
    "flexible, at both ends": both_ends,
    "flexible, map": sections,
    "flexible, static algorithm": iteration,
}
