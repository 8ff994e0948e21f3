"""Beyond the paper: the wall of a cantilever, made tooth by tooth, and how far a lean of the spindle helps it.

The paper's law is one of walls as measured.  A beam of carbide bends under the force of each instant, and each height
of the wall is made when a tooth leaves the stock there: towards the upper edge fewer teeth cut then, at the edge none.
So its wall is bent where the paper's is straight.  Its free length is chosen such that a wall of 0.9 mm leans about as
the paper's; it is leant by the slope of its own walls, so that what is left is what no lean takes away.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...cutting import Beam, Cutting
from ...cutting.compensation import Corrected
from ...report import style
from ..study import Beyond, Experiment, Tick, parts
from . import milling
from .milling import HEIGHT, STAIRS, STEPS, Milled

LENGTH = 0.053  # m, free: chosen
KINDS = ("30 deg of helix", "10 deg of helix")
HELIX = dict(zip(KINDS, np.radians([30.0, 10.0]), strict=True))


class Bent(NamedTuple):
    """Stairs cut by a beam: without, and leant by the slopes of the walls without."""

    plain: Milled
    leant: Milled


def bent(helix: float, tick: Tick | None) -> Bent:
    """Cut the stairs of table 3 twice."""
    first, second = parts(tick, [1.0, 1.0])
    cutting: Cutting = milling.cut(STEPS, STAIRS).replace(
        deflection=Beam(), **{"tool.extension": LENGTH, "tool.helix": helix}
    )
    plain = milling.milled("-Y", cutting, 90, first)
    slope = np.array([plain.wall.slope(*w) for w in milling.steps()])
    program = Corrected(program=milling.line("-Y"), places=STEPS, tilt=slope, height=HEIGHT)
    return Bent(plain, milling.milled("-Y", cutting, 91, second, program=program))


def _job(name: str) -> Experiment:
    return Experiment(f"a cantilever, {name}", lambda tick: bent(HELIX[name], tick))


def _table(results: Sequence[Bent]) -> list[list[str]]:
    rows = []
    for name, found in zip(KINDS, results, strict=True):
        for depth, within in zip(STAIRS, milling.steps(), strict=True):
            walls = found.plain.wall, found.leant.wall
            rows.append(
                [name, f"{1e3 * depth:g} mm"]
                + [f"{1e6 * wall.deviation(*within):.1f} um" for wall in walls]
                + [f"{np.degrees(wall.slope(*within)):.3f} deg" for wall in walls]
            )
    return rows


def _picture(results: Sequence[Bent]) -> Any:
    ax = style.new_axes((4.8, 4.6))
    within = milling.steps()[-1]
    for i, (name, found) in enumerate(zip(KINDS, results, strict=True)):
        for wall, line, how in ((found.plain.wall, "-", "without"), (found.leant.wall, "--", "leant")):
            profile = 1e6 * wall.along_z(*within)
            ax.plot(profile, 1e3 * wall.z, line, linewidth=1.0, color=style.COLOURS[i], label=f"{name}, {how}")
    style.label(ax, "A cantilever's wall, 0.9 mm", "proud of the nominal wall [µm]", "height [mm]")
    style.legend(ax)
    return ax


def _text(results: Sequence[Bent]) -> str:
    left = [_left(found) for found in results]
    return (
        "The straight part is taken away, the bend stays: of the deviation without compensation at most "
        f"{100 * left[0]:.0f} % is left with 30 deg of helix and {100 * left[1]:.0f} % with 10 deg.  Only the tilt can "
        "do no better; the paper's third is that of its tool, whose wall leans straight."
    )


def _left(found: Bent) -> float:
    """Deviation leant over that without, largest of the three depths."""
    return max(found.leant.wall.deviation(*w) / found.plain.wall.deviation(*w) for w in milling.steps())


CANTILEVER = Beyond(
    name="cantilever",
    title=f"A cantilever of {1e3 * LENGTH:.0f} mm whose wall is made tooth by tooth, and a lean of the spindle",
    experiments=[_job(name) for name in KINDS],
    heads=("tool", "radial depth", "deviation without", "leant", "slope without", "leant"),
    table=_table,
    picture=_picture,
    text=_text,
)
