"""Figures 4 to 8 of the paper on the rigid machine, and those of flexible_drawings.py: all of the study's."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...files import write_atomic
from ...report import style
from ...report.prepare import thin
from ..study import Figure
from .experiments import Results
from .flexible_drawings import flexible_figures
from .setup import END, START, move

DPI, MM = 150, 1e-3
UNLIKE = "centres of mass off"


def figures(results: Sequence[Any], folder: Path) -> list[Figure]:
    """Draw all of them into `folder`."""
    found = Results(results)
    drawn = [("figure_4", _move(), "Figure 4: the reference move of the tip.")]
    for key, slides, tips in (("low", 5, 6), ("high", 7, 8)):
        drawn.append((
            f"figure_{slides}_rigid", _errors(found, key, "s21"),
            f"Figure {slides}, {key} gains: error of s21 on the machine that is known, and on the worst of sixteen "
            "whose centres of mass are off by 20 %.",
        ))  # fmt: skip
        drawn.append((
            f"figure_{tips}_rigid", _errors(found, key, "y"),
            f"Figure {tips}, {key} gains: the same of the tip along y.",
        ))  # fmt: skip
    drawn += flexible_figures(found)
    out = []
    for name, ax, caption in drawn:
        write_atomic(folder / f"{name}.png", lambda file, f=ax.figure: f.savefig(file, dpi=DPI, format="png"))
        out.append(Figure(f"{name}.png", caption))
    return out


def _move() -> Any:
    program = move()
    t = np.linspace(0.0, program.times.max() + 0.1, 500)
    p = START + program.poses(t)[0]
    ax = style.new_axes((6.8, 3.4))
    for i, name in enumerate("xyz"):
        ax.plot(t, p[:, i], color=style.COLOURS[i], label=f"{name}, to {END[i]:g} m")
    style.label(ax, "Reference move", "time [s]", "tip [m]")
    style.legend_above(ax)
    return ax


def _errors(found: Results, key: str, what: str) -> Any:
    ax = style.new_axes((6.8, 3.8))
    colours = iter(style.COLOURS)
    for name in ("PID", "computed torque"):
        for courses, label in ((found.known, name), (found.unlike, f"{name}, {UNLIKE}")):
            course = courses[key, name]
            values = course.e[..., 0] if what == "s21" else course.tip[..., 1]
            if values.ndim == 2:  # the run that errs most
                values = values[:, int(np.abs(values).max(0).argmax())]
            rows = thin(values)
            ax.plot(course.t[rows], values[rows] / MM, linewidth=0.9, color=next(colours), label=label)
    style.label(ax, f"Rigid machine, {key} gains: error of {what}", "time [s]", "error [mm]")
    style.legend(ax, loc="lower right")
    return ax
