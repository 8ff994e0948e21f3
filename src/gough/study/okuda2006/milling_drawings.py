"""Figures 7 to 10, 12 and 13 of the paper, redrawn with ours."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...files import write_atomic
from ...report import style
from ...report.prepare import thin
from ..study import Figure
from .drawings import DPI
from .milling import AIR, BELIEVED, DEPTHS, EXPERIMENTS, LENGTH, SHALLOW, STAIRS, TARED, Milled, Relation, Stairs, steps
from .milling_rows import WALL

GREY = "#8a939c"


def figures(results: Sequence[Any], folder: Path) -> list[Figure]:
    """Draw all of them into `folder`."""
    of = {experiment.label: result for experiment, result in zip(EXPERIMENTS, results, strict=True)}
    drawn = []
    for letter, (direction, runs) in zip("ab", of["end milling"].items(), strict=True):
        drawn += [
            (
                f"figure_7{letter}",
                _forces(direction, runs[-1]),
                f"Figure 7({letter}): forces towards {direction}, 4 mm.",
            ),
            (f"figure_8{letter}", _means(direction, runs), f"Figure 8({letter}): mean forces towards {direction}."),
        ]
    relation, stairs = of["force and inclination"], of["stairs"]
    drawn += [
        ("figure_9", _profiles(relation), "Figure 9: the wall over its height, for five radial depths."),
        ("figure_10", _relation(relation), "Figure 10: inclination against the estimated normal force."),
        ("figure_12", _heights(stairs), "Figure 12: the wall over its height, without and with compensation."),
        ("figure_13", _along(stairs), "Figure 13: the wall along the feed at the tip; steps at 40 and 80 mm."),
    ]
    out = []
    for name, ax, caption in drawn:
        figure = ax.figure
        write_atomic(folder / f"{name}.png", lambda file, f=figure: f.savefig(file, dpi=DPI, format="png"))
        out.append(Figure(f"{name}.png", caption))
    return out


def _forces(direction: str, run: Milled) -> Any:
    ax = style.new_axes((7.2, 3.8))
    even = np.flatnonzero((run.s > TARED[0]) & (run.s < AIR + LENGTH + 0.015))  # without its starts and stops
    rows = even[thin(run.s[even])]
    for k, axis in enumerate("XYZ"):
        colour = style.COLOURS[k]
        ax.plot(1e3 * run.s[rows], run.measured[rows, k], color=colour, linewidth=0.5, alpha=0.35)
        ax.plot(1e3 * run.s[rows], run.estimated[rows, k], color=colour, linewidth=1.2, label=axis)
    style.label(ax, f"Milling towards {direction}, 4 mm", "way [mm]", "force [N]: dynamometer pale, drives dark")
    style.legend_above(ax)
    return ax


def _means(direction: str, runs: list[Milled]) -> Any:
    ax = style.new_axes((5.6, 4.2))
    for k, axis in enumerate("XYZ"):
        measured, estimated = ([run.mean(what, *WALL)[k] for run in runs] for what in ("measured", "estimated"))
        ax.plot(1e3 * DEPTHS, measured, "o-", markersize=3, linewidth=0.9, color=style.COLOURS[k], label=axis)
        ax.plot(1e3 * DEPTHS, estimated, "x--", markersize=4, linewidth=0.9, color=style.COLOURS[k])
    style.label(ax, f"Milling towards {direction}", "radial depth [mm]", "mean force [N]: drives dashed")
    style.legend_above(ax)
    return ax


def _profiles(found: Relation) -> Any:
    ax = style.new_axes((4.6, 4.6))
    for i, depth in enumerate(SHALLOW):
        ax.plot(
            1e6 * found.profiles[i], 1e3 * found.z, linewidth=1.0, color=style.COLOURS[i], label=f"{1e3 * depth:g} mm"
        )
    style.label(ax, "Wall over its height", "proud of the nominal wall [µm]", "height [mm]")
    style.legend(ax)
    return ax


def _relation(found: Relation) -> Any:
    ax = style.new_axes((5.2, 4.0))
    force = np.linspace(0, 1.05 * found.force.max(), 100)
    ax.plot(force, np.degrees(BELIEVED.inclination(force)), color=GREY, linewidth=0.9, label="f(d) of the paper")
    ax.plot(found.force, np.degrees(found.inclination), "o", markersize=4, color=style.COLOURS[0], label="walls")
    style.label(ax, "Force and inclination", "estimated normal force [N]", "inclination [deg]")
    style.legend(ax)
    return ax


def _heights(found: Stairs) -> Any:
    ax = style.new_axes((4.6, 4.6))
    for i, within in enumerate(steps()):
        for run, line, name in ((found.plain, "-", "without"), (found.commanded, "--", "with")):
            profile = 1e6 * run.wall.along_z(*within)
            label = f"{1e3 * STAIRS[i]:g} mm, {name}"
            ax.plot(profile, 1e3 * run.wall.z, line, linewidth=1.0, color=style.COLOURS[i], label=label)
    style.label(ax, "Wall over its height", "proud of the nominal wall [µm]", "height [mm]")
    style.legend(ax)
    return ax


def _along(found: Stairs) -> Any:
    ax = style.new_axes((7.2, 3.8))
    runs = ((found.plain, "without", GREY), (found.commanded, "commands", style.COLOURS[0]))
    for run, name, colour in (*runs, (found.in_loop, "in the loop", style.COLOURS[1])):
        ax.plot(1e3 * (run.wall.s - AIR), 1e6 * run.wall.along_feed(0.0), linewidth=0.9, color=colour, label=name)
    style.label(ax, "Wall along the feed, at the tip", "distance [mm]", "proud of the nominal wall [µm]")
    style.legend(ax, ncols=3, loc="upper left")
    return ax
