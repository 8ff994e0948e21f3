"""Figures 5 and 6 of the paper, redrawn with ours."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...files import write_atomic
from ...report import style
from ...report.prepare import thin
from ..study import Figure
from .experiments import Circle, Results
from .load import DIRECTIONS, Loaded

DPI = 150


def figures(results: Sequence[Any], folder: Path) -> list[Figure]:
    """Draw all of them into `folder`."""
    found = Results(results)
    drawn = [
        (f"figure_5{letter}", _torques(circle), f"Figure 5({letter}): tilt {circle.tilt}; read pale, predicted dark.")
        for letter, circle in zip("ab", found.learned.circles, strict=True)
    ] + [
        (f"figure_6{letter}", _loads(name, found.loads[name]), f"Figure 6({letter}): load in {name}, up and down.")
        for letter, name in zip("ab", DIRECTIONS, strict=True)
    ]
    out = []
    for name, ax, caption in drawn:
        figure = ax.figure
        write_atomic(folder / f"{name}.png", lambda file, f=figure: f.savefig(file, dpi=DPI, format="png"))
        out.append(Figure(f"{name}.png", caption))
    return out


def _torques(circle: Circle) -> Any:
    ax = style.new_axes((7.2, 4.2))
    rows = thin(circle.read[:, 0])
    angle = np.degrees(circle.angle[rows] - circle.angle[0])
    for j in range(6):
        colour = style.COLOURS[j]
        ax.plot(angle, circle.read[rows, j], color=colour, linewidth=2.4, alpha=0.35)
        ax.plot(angle, circle.predicted[rows, j], color=colour, linewidth=0.9, label=f"strut {j + 1}")
    style.label(ax, f"Motor torques, circle of 144 mm, tilt {circle.tilt}", "angle [deg]", "torque [N m]")
    low, high = ax.get_ylim()
    ax.set_ylim(low, high + 0.12 * (high - low))  # room for the legend
    style.legend(ax, ncols=6, loc="upper center")
    return ax


def _loads(name: str, test: Loaded) -> Any:
    ax = style.new_axes((5.6, 4.6))
    load = test.force[:, DIRECTIONS[name]]
    for k, axis in enumerate("XYZ"):
        ax.plot(load, test.estimate[:, k], "o-", markersize=3, linewidth=0.9, color=style.COLOURS[k], label=axis)
    ax.plot([0, load.max()], [0, load.max()], color="#8a939c", linewidth=0.8, label="the load")
    style.label(ax, f"Static load in {name}, estimated from the drives", "force [N]", "estimate [N]")
    style.legend(ax)
    return ax
