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
_MOST_LINES = 4  # points of a grid that have medians of their own


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
    _logarithmic(ax.xaxis, values)
    ax.set_ylim(0, 102)
    failed = int((lines.status != "done").sum())
    lost = f", {failed} failed" if failed else ""
    style.label(ax, f"{len(lines.ids)} runs{lost}", _axis(swept, scale), "runs at or below [%]")
    if ax.get_legend_handles_labels()[1]:
        _legend(ax)
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
    factors, points = swept.design.factors, swept.design.points
    for ax, k in zip(panels, drawn, strict=False):
        # machines are drawn alike at every point of a grid: medians over all of it would mix what is far apart
        apart = range(points) if factors[k].distribution is not None and points <= _MOST_LINES else [None]
        for i in range(len(swept.experiment.controllers)):
            for point in apart:
                at = (lines.controller == i) & np.isfinite(values) & ((lines.point == point) | (point is None))
                if at.any():
                    name = swept.experiment.labels[i] if point in (None, 0) else None
                    _panel(ax, lines.values[k][at], scale.times * values[at], i, name)
        _ticks(ax, lines.axes[k])
        unit = lines.axes[k].unit
        left = ax in panels[::columns]
        first, _, more = lines.axes[k].key.partition(",")
        name = f"{_short(first)}{', ...' if more else ''}{f' [{unit}]' if unit else ''}"
        style.label(ax, "", style.verbatim(name), _axis(swept, scale) if left else "")
    for ax in panels[len(drawn) :]:
        ax.set_visible(False)
    for ax in panels[: len(drawn)]:
        _logarithmic(ax.yaxis, values)
    if len(swept.experiment.controllers) > 1:
        _legend(panels[0])
    return panels[0].figure


def _panel(ax: Any, x: np.ndarray, y: np.ndarray, i: int, name: str | None) -> None:
    colour = style.COLOURS[i % len(style.COLOURS)]
    step = -(-len(x) // _MOST_POINTS)
    ax.plot(x[::step], y[::step], ".", color=colour, alpha=0.25, markersize=4)
    places = np.unique(x)
    if len(places) > _BINS:  # bins of equally many runs
        count = max(2, min(_BINS, len(x) // 8))
        edges = np.quantile(x, np.linspace(0, 1, count + 1))
        bins = np.clip(np.searchsorted(edges, x, "right") - 1, 0, count - 1)
        middles = [(np.median(x[bins == b]), np.median(y[bins == b])) for b in range(count) if (bins == b).any()]
    else:
        middles = [(place, np.median(y[x == place])) for place in places]
    label = human(name) if name else None
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


def _logarithmic(axis: Any, values: np.ndarray) -> None:
    """A logarithmic axis with plain numbers, where values spread over more than half a decade."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    good = values[np.isfinite(values) & (values > 0)]
    if len(good) and np.percentile(good, 99) > 3 * np.percentile(good, 1):
        axis.axes.set(**{f"{axis.axis_name}scale": "log"})
        axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())


def _legend(ax: Any) -> None:
    """A legend over the axes, in rows of two."""
    style.legend(
        ax, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.2, handlelength=1.2,
        columnspacing=1.2,
    )  # fmt: skip


def _short(text: str, most: int = 44) -> str:
    return text if len(text) <= most else f"{text[: most - 1]}…"
