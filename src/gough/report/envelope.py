"""The figure of an Envelope: how far each coordinate may go both ways, and the ball that is free in all directions."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..plan.envelope import Envelope
from ..plan.findings import place_text
from . import style

_EYE = {"m": ("mm", 1e3), "rad": ("deg", 180 / np.pi)}


def envelope_figure(found: Envelope) -> Any:
    """Bars along each coordinate, the limit that ends each beside it; the ball's radius as a band.  A Figure."""
    units = list(dict.fromkeys(way.unit for way in found.ways))
    rows = [len({way.axis for way in found.ways if way.unit == unit}) for unit in units]
    figure = style.new_axes((9.0, 1.5 + 0.75 * sum(rows))).figure
    figure.clear()
    for ax, unit in zip(figure.subplots(len(units), 1, squeeze=False, height_ratios=rows).flat, units, strict=True):
        _bars(ax, found, unit)
    title = f"{found.machine} at {place_text(found.pose)}: how far until the first limit"
    figure.suptitle(style.verbatim(title), x=0.01, ha="left", fontsize=11, weight="bold", color=style.INK)
    return figure


def _bars(ax, found: Envelope, unit: str) -> None:
    eye, factor = _EYE[unit]
    ways = [way for way in found.ways if way.unit == unit]
    axes = list(dict.fromkeys(way.axis for way in ways))
    known = [factor * way.distance for way in ways if np.isfinite(way.distance)]
    span = max([*known, 1e-9])
    for ball in found.balls:
        if ball.unit == unit:
            ax.axvspan(-factor * ball.radius, factor * ball.radius, color=style.COLOURS[2], alpha=0.25, lw=0)
            name = "in any direction" if unit == "m" else "about any axis"
            ax.text(0, -0.62, f"{factor * ball.radius:.4g} {eye} {name}", ha="center", va="center", fontsize=8,
                    color=style.INK)  # fmt: skip
    for way in ways:
        row = axes.index(way.axis)
        length = min(factor * way.distance, 1.1 * span)
        ax.barh(row, way.sense * length, height=0.42, color=style.COLOURS[0 if way.sense > 0 else 4])
        value = f"{factor * way.distance:.4g} {eye}" if np.isfinite(way.distance) else "free"
        ax.text(way.sense * (length + 0.015 * span), row, f"{value}\n{way.limit}", fontsize=7.5, va="center",
                ha="left" if way.sense > 0 else "right", color=style.INK)  # fmt: skip
    ax.axvline(0, color=style.INK, linewidth=0.8)
    ax.set_yticks(range(len(axes)), axes)
    ax.set_ylim(len(axes) - 0.5, -0.9)
    ax.set_xlim(-2.0 * span, 2.0 * span)
    ax.set_axisbelow(True)
    for side in ("top", "right", "left"):
        ax.spines[side].set_visible(False)
    style.label(ax, "", eye, "")
    ticks = [tick for tick in ax.get_xticks() if abs(tick) <= 1.15 * span]
    ax.set_xticks(ticks)
