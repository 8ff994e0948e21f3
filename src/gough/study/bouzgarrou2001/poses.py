"""What the springs of the slides make of the machine at rest: frequencies, stiffness, sag; along the move and over XY.

The map is the section z = 0 and z = 0.55 m of the workspace; the paper has none.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...machine.workspace import random_poses
from ..study import Tick
from . import statics
from .setup import END, START, machine

RAM = (0.0, 0.55)  # m
SIDE = 9  # places along x and y of a section
PLACES = 20  # at which the algorithm of section 3.3 is tried


class Standing(NamedTuple):
    """At rest at one place, the joints held."""

    frequency: float  # Hz, the first
    stiffness: np.ndarray  # along x, y, z, N/m
    least: float  # in the softest direction, N/m
    sag: np.ndarray  # of the tip, (3,) m


class Section(NamedTuple):
    """A section of the workspace at one z."""

    z: float
    x: np.ndarray  # (k,) m
    y: np.ndarray  # (k,) m
    frequency: np.ndarray  # (k, k) Hz, rows by y
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
    """The map, at RAM."""
    space, home = machine().limits.workspace, machine().home
    middle = (home + space.middle)[:2]
    x, y = (middle[i] + np.linspace(-0.5, 0.5, SIDE) * space.size[i] * 0.999 for i in (0, 1))
    out = []
    for k, z in enumerate(RAM):
        found = [[standing(np.array([a, b, z])) for a in x] for b in y]
        columns = np.array([[[one.frequency, one.least, one.sag[1]] for one in row] for row in found])
        out.append(Section(z, x, y, *np.moveaxis(columns, -1, 0)))
        if tick is not None:
            tick(k + 1, len(RAM))
    return out


def iteration(tick: Tick | None) -> Statics:
    """The algorithm of section 3.3, printed and repaired."""
    from ...errors import KinematicsError

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
