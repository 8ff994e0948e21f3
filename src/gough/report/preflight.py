"""The figure of a preflight: how much of the limits of each kind the program uses along its time, and where most."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..plan.demand import ACCELERATION, FORCE, POSE, SPEED
from ..plan.preflight import Preflight
from . import style

_CALLED = {
    POSE: "reach: stroke, angles,\nsingularity", SPEED: "joint speed", ACCELERATION: "joint acceleration",
    FORCE: "drive force",
}  # fmt: skip
_OVER = "#b5402a"  # beyond a limit, as the errors of a path are coloured


_TOP = 250.0  # %: what is farther beyond a limit is marked there, with its number


def preflight_figure(found: Preflight) -> Any:
    """A panel for each kind of limit: the share of the nearest limit in percent over time, 100 at the limit, and the
    joint and the NC line at which it is greatest.  Grey: outside, where nothing was asked of the drives.  A Figure."""
    along = found.found.along
    panels = style.new_panels(len(along), (9.0, 1.2 + 1.45 * len(along)))
    edges = np.linspace(0, found.motion.feed.duration, len(next(iter(along.values()))) + 1) + found.motion.lead_in
    t = (edges[:-1] + edges[1:]) / 2
    panels[0].set_xlim(edges[0], edges[-1])
    panels[0].set_ylim(0, 1.3 * min(max(100.0, 100 * max(peak.use for peak in found.peaks)), _TOP))  # the same for all
    out = _whole(t, along[POSE]) > 1  # there nothing was asked of the drives: a gap, not a load of nothing
    for ax, (kind, use) in zip(panels, along.items(), strict=True):
        use = _whole(t, use)
        if kind != POSE and out.any():
            use[out] = np.nan
            ax.fill_between(t, 0, 100, where=out, color=style.INK, alpha=0.12, linewidth=0)
        _panel(ax, t, 100 * use, kind, [peak for peak in found.peaks if peak.kind == kind])
    verdict = "no limit is exceeded" if found.passed else f"{found.exceeded} limits exceeded"
    panels[-1].set_xlabel("time along the program [s]", fontsize=9, color=style.INK)
    panels[0].figure.suptitle(
        style.verbatim(f"{found.name} on {found.machine.name}: {verdict}"), x=0.01, ha="left", fontsize=11,
        weight="bold", color=style.INK,
    )  # fmt: skip
    return panels[0].figure


def _whole(t, use):
    """A curve without the gaps of times that nothing was looked at in, between two that something was."""
    there = np.isfinite(use)
    return np.interp(t, t[there], use[there]) if there.any() else np.zeros_like(t)


def _panel(ax, t, use, kind: str, peaks) -> None:
    use = np.minimum(use, _TOP)
    ax.fill_between(t, use, color=style.COLOURS[0], alpha=0.18, linewidth=0)
    ax.plot(t, use, color=style.COLOURS[0], linewidth=1.1)
    ax.fill_between(t, 100, use, where=use > 100, color=_OVER, alpha=0.75, linewidth=0, interpolate=True)
    ax.axhline(100, color=_OVER, linewidth=1.0, linestyle=(0, (5, 3)))
    if peaks:
        worst = peaks[0]  # the greatest first
        ax.plot(
            [worst.time],
            [min(100 * worst.use, _TOP)],
            "o",
            color=_OVER if worst.use > 1 else style.COLOURS[0],
            markersize=4,
        )
        line = f"line {worst.line}, " if worst.line else ""
        told = f", {worst.what}" if kind == POSE else f": {worst.value} of {worst.limit}"
        share = 100 * worst.use
        late = worst.time > (t[0] + t[-1]) / 2
        ax.annotate(
            style.verbatim(f"{line}{worst.joint}{told} ({f'{share:.0f}' if share > 999 else f'{share:.3g}'} %)"),
            (worst.time, min(share, _TOP)), (-6 if late else 6, 5), textcoords="offset points", fontsize=8,
            ha="right" if late else "left", color=style.INK,
        )  # fmt: skip
    ax.set_ylabel(f"{_CALLED[kind]} [%]", fontsize=8.5, color=style.INK)
