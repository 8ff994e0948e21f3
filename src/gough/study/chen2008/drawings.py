"""Figures 3 and 4 of the paper, redrawn: contour errors of both paths with every uncertainty."""

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
from .rows import STEADY, TIMES, UM

DPI = 150


def figures(results: Sequence[Any], folder: Path) -> list[Figure]:
    """Draw all of them into `folder`."""
    found = Results(results)
    drawn = [
        ("figure_3", _errors(found.circle, "Circle"), "Figure 3: contour error of the circle, as printed."),
        (
            "figure_4", _errors(found.ellipse("without screws"), "Ellipse, screws certain"),
            "Figure 4: contour error of the ellipse, printed equation and gains; masses and inertias uncertain.",
        ),
        (
            "figure_4_area", _errors(found.ellipse("area"), "Ellipse, equation in m2"),
            "Figure 4 with everything uncertain and the equation times a b, in m2.",
        ),
        (
            "figure_4_printed", _errors(found.ellipse("printed"), "Ellipse, all uncertain"),
            "Figure 4 with everything uncertain: the printed gains do not hold the printed equation at 50 %.",
        ),
    ]  # fmt: skip
    out = []
    for name, ax, caption in drawn:
        write_atomic(folder / f"{name}.png", lambda file, f=ax.figure: f.savefig(file, dpi=DPI, format="png"))
        out.append(Figure(f"{name}.png", caption))
    return out


def _errors(courses, title: str) -> Any:
    ax = style.new_axes((6.8, 3.8))
    for (s, course), colour in zip(courses.items(), style.COLOURS, strict=False):
        error = np.maximum(course.contour, 1e-10)
        rows = thin(error)
        ax.plot(course.t[rows], error[rows] / UM, linewidth=0.8, color=colour, label=TIMES[s])
        ax.axhline(STEADY[s] / UM, color=colour, linewidth=0.7, linestyle=(0, (5, 3)))
    ax.set_yscale("log")
    ax.set_ylim(1e-3, None)
    style.label(ax, title, "time [s]", "contour error [µm], dashed: as published")
    style.legend_above(ax)
    return ax
