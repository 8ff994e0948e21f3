"""How the runs of a batch spread: the share of them whose contour error stays below a value."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import LogError
from ..log import Log
from . import style
from .prepare import human, scale_for


def spread(log: Log, ax: Any = None) -> Any:
    """Largest and rms contour error of the runs of a batch, each in rising order over the share of runs.

    A run that failed has no place: its errors are those of a part of the program.  The title says how many.

    Raises
    ------
    LogError
        the log is no batch, or none of its runs has a contour error and came to its end.
    """
    if not log.batch:
        raise LogError("the log holds one run", key="run", cure="log.plot.contour() draws it over time")
    error = log.metrics.get("contour_error", {})
    failed = log["failed"] != 0
    found = {name: np.asarray(error[name], float)[~failed] for name in ("max", "rms") if name in error}
    found = {name: np.sort(values[np.isfinite(values)]) for name, values in found.items()}
    if not found or not any(len(values) for values in found.values()):
        raise LogError("no run of the batch has a contour error from start to end", key="metrics.contour_error")
    ax = ax or style.new_axes()
    scale = scale_for(np.concatenate(list(found.values())), "m")
    for name, values in found.items():
        # a step at each run: n of them stay at or below the n-th
        share = np.arange(len(values) + 1) / len(values)
        ax.step(scale.times * values[[0, *range(len(values))]], 100 * share, where="post", label=name, linewidth=1.2)
    ax.set_ylim(0, 102)
    lost = f", {failed.sum()} failed" if failed.any() else ""
    who = human(str(log.info.get("controller_kind") or "log"))
    title = f"{len(failed)} runs under {who}{lost}"
    style.label(ax, style.verbatim(title), f"contour error [{scale.unit}]", "runs at or below [%]")
    style.legend_above(ax)
    return ax
