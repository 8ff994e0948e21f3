"""Figures of a sweep: how the metric spreads, and what each factor does to it."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..measure.tree import told
from ..report import style
from ..report.prepare import Scale, human, scale_for
from .run import Swept
from .table import Axis, Lines

MOST_PANELS = 12
_MOST_POINTS = 2000  # drawn of a cloud; medians are of all
_BINS = 8


def spread(swept: Swept, lines: Lines, ax: Any = None) -> Any:
    """The share of runs whose metric stays at or below a value: a line a controller at each point of the grid, or
    where these are many, a line a controller.  A run that failed stays below nothing."""
    ax = ax or style.new_axes()
    values, scale = lines.metric(swept.design.metric), _scale(swept, lines)
    labels, grid = [human(label) for label in swept.experiment.labels], swept.design.grid()
    groups = []
    several = len(grid) > 1 and len(grid) * len(labels) <= len(style.COLOURS)
    for point in range(len(grid)) if several else [None]:
        for i, label in enumerate(labels):
            at = (lines.controller == i) & ((lines.point == point) if several else True)
            told_ = ", ".join(str(value) for value in dict.fromkeys(grid[point].values())) if several else ""
            groups.append((f"{label}{f', {told_}' if told_ else ''}", values[at]))
    for k, (label, found) in enumerate(groups):
        good = np.sort(found[np.isfinite(found)])
        if not len(good):
            continue
        share = np.arange(len(good) + 1) / len(found)
        colour = style.COLOURS[k % len(style.COLOURS)]
        ax.step(scale.times * good[[0, *range(len(good))]], 100 * share, where="post", label=label, color=colour)
    _logarithmic(ax.set_xscale, values)
    ax.set_ylim(0, 102)
    failed = int((lines.status != "done").sum())
    lost = f", {failed} failed" if failed else ""
    style.label(ax, f"{len(lines.ids)} runs{lost}", _axis(swept, scale), "runs at or below [%]")
    if ax.get_legend_handles_labels()[1]:
        style.legend(ax, loc="lower right")
    return ax


def effects(swept: Swept, lines: Lines) -> Any | None:
    """One panel a factor: the metric of every run over its value, and medians; None without factors to draw."""
    drawn = [k for k in range(len(lines.axes)) if len(np.unique(lines.values[k])) > 1][:MOST_PANELS]
    values, scale = lines.metric(swept.design.metric), _scale(swept, lines)
    if not drawn or not np.isfinite(values).any():
        return None
    columns = min(len(drawn), 3)
    rows = -(-len(drawn) // columns)
    panels = [ax for row in style.new_grid(rows, columns, (4.0 * max(columns, 2), 3.2 * rows)) for ax in row]
    for ax, k in zip(panels, drawn, strict=False):
        for i in range(len(swept.experiment.controllers)):
            at = np.flatnonzero((lines.controller == i) & np.isfinite(values))
            if len(at):
                _panel(ax, lines.axes[k], lines.values[k][at], scale.times * values[at], i, swept)
        _ticks(ax, lines.axes[k])
        unit = lines.axes[k].unit
        left = ax in panels[::columns]
        name = f"{_short(lines.axes[k].key)}{f' [{unit}]' if unit else ''}"
        style.label(ax, "", style.verbatim(name), _axis(swept, scale) if left else "")
    for ax in panels[len(drawn) :]:
        ax.set_visible(False)
    _logarithmic(panels[0].set_yscale, values)
    if len(swept.experiment.controllers) > 1:
        style.legend_above(panels[0])
    return panels[0].figure


def _panel(ax: Any, axis: Axis, x: np.ndarray, y: np.ndarray, i: int, swept: Swept) -> None:
    colour = style.COLOURS[i % len(style.COLOURS)]
    step = -(-len(x) // _MOST_POINTS)
    ax.plot(x[::step], y[::step], ".", color=colour, alpha=0.25, markersize=3)
    places = np.unique(x)
    if len(places) > _BINS:  # bins of equally many runs
        edges = np.quantile(x, np.linspace(0, 1, _BINS + 1))
        bins = np.clip(np.searchsorted(edges, x, "right") - 1, 0, _BINS - 1)
        middles = [(np.median(x[bins == b]), np.median(y[bins == b])) for b in range(_BINS) if (bins == b).any()]
    else:
        middles = [(place, np.median(y[x == place])) for place in places]
    label = human(swept.experiment.labels[i])
    ax.plot(*zip(*middles, strict=True), "o-", color=colour, markersize=4, linewidth=1.4, label=label)


def _ticks(ax: Any, axis: Axis) -> None:
    if axis.words:
        ax.set_xticks(range(len(axis.words)), [_short(word, 16) for word in axis.words])


def _scale(swept: Swept, lines: Lines) -> Scale:
    values = lines.metric(swept.design.metric)
    good = values[np.isfinite(values)]
    # of the median: one run that went astray must not choose the unit
    return scale_for(np.median(good) if len(good) else 0.0, told(swept.design.metric)[0])


def _axis(swept: Swept, scale: Scale) -> str:
    name = swept.design.metric.replace("_", " ").replace(".", ", ")
    return f"{name} [{scale.unit}]" if scale.unit not in ("", "1") else name


def _logarithmic(set_scale: Any, values: np.ndarray) -> None:
    """A logarithmic axis where values spread over more than a decade."""
    good = values[np.isfinite(values) & (values > 0)]
    if len(good) and np.percentile(good, 99) > 10 * np.percentile(good, 1):
        set_scale("log")


def _short(text: str, most: int = 44) -> str:
    return text if len(text) <= most else f"{text[: most - 1]}…"
