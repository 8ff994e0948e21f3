"""The figure of a tuning: every candidate in the order it was tried, and the best so far."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..report import style
from ..report.prepare import scale_for
from .result import Tuned

_MARKS = {"held": ("o", 0), "beyond": ("^", 5), "unstable": ("x", 1), "failed": ("x", 3), "refused": ("+", 3)}


def progress_figure(tuned: Tuned, ax: Any = None) -> Any:
    """Goal of every candidate over its number; those that hold the limits, those beyond, and at the top those without
    a goal, which failed or were refused."""
    ax = ax or style.new_axes()
    goals = np.array([np.nan if score.goal is None else score.goal for score in tuned.history])
    scale = scale_for(goals[np.isfinite(goals)], "m")
    known = goals[np.isfinite(goals)] * scale.times
    top = 2 * known.max()
    number = np.arange(len(goals))
    for status, (mark, colour) in _MARKS.items():
        these = np.array([score.status == status for score in tuned.history])
        if these.any():
            heights = np.where(np.isfinite(goals), goals * scale.times, top)[these]
            ax.plot(number[these], heights, mark, color=style.COLOURS[colour], label=status, markersize=3.5)
    held = np.array([score.goal if score.status == "held" else np.inf for score in tuned.history])
    best = np.minimum.accumulate(held) * scale.times
    ax.step(number[np.isfinite(best)], best[np.isfinite(best)], where="post", color=style.INK, label="best so far")
    ax.set_yscale("log")
    table = tuned.task.table
    said = f"{table.goal} {table.metric.replace('_', ' ').replace('.', ', ')}"
    machines = len(tuned.task.machines)
    title = f"{machines} machine{'s' * (machines > 1)}"
    style.label(ax, style.verbatim(title), "candidate", f"{said} [{scale.unit}]")
    style.legend_above(ax)
    return ax
