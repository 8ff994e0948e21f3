"""The figure of a Fit: what the model does not explain, joint by joint, over time and over speed.

Each error is that of a row which its prediction has not seen: the motion in FOLDS parts, each predicted from the
others (regress.py).  The residual of rows that were learned from lies behind it; where the two part, the model has more
freedom than the motion can teach.  Over speed an error that is no noise has a shape: a step at 0 is Coulomb friction,
a slope viscous friction, two slopes friction that differs by direction.
"""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import ExperimentError
from ..files import write_atomic
from ..report.prepare import thin
from ..report.style import COLOURS, INK, label, legend, new_grid, verbatim
from .fit import Fit
from .regress import parts_of

FORMATS = (".png", ".svg", ".pdf")
BINS, FEW = 25, 5
MOST_NAMES = 12  # of a line below the figure
_PALE = "#b8c0c8"
_POINTS = 1500  # of a cloud


def check_name(path: Path) -> None:
    """Refuse a file name that is none of a figure.

    Raises
    ------
    ExperimentError
        it ends in none of FORMATS.
    """
    if path.suffix.lower() not in FORMATS:
        raise ExperimentError(
            "is no figure that gough draws", key="--plot", value=repr(path.name), cure=f"end it in {', '.join(FORMATS)}"
        )


def draw(fit: Fit) -> Any:
    """A matplotlib figure: a row of two panels for each joint that takes part, and what the motion does not show."""
    found = fit.estimate
    rows, learned, tested = found.rows, found.residuals(), found.held_out
    shown = [j for j in range(len(rows.joints)) if rows.used[:, j].any()]
    t = rows.t if rows.t is not None else np.arange(len(rows.u)) * (rows.step or 1.0)
    grid = new_grid(len(shown), 2 if rows.speed is not None else 1, (9.0, 1.2 + 1.5 * max(2, len(shown))))
    unit = _force_unit(found)
    for axes, j in zip(grid, shown, strict=True):
        last, name = axes is grid[-1], rows.joints[j]
        _over_time(axes[0], t, learned[:, j], tested[:, j], parts_of(len(t)))
        title = f"{fit.machine.name}: {name}" if axes is grid[0] else name
        label(axes[0], title, "time [s]" if last else "", f"error [{unit}]")
        if rows.speed is not None:
            _over_speed(axes[1], rows.speed[:, j], tested[:, j])
            label(axes[1], "", f"speed [{'m/s' if unit == 'N' else 'rad/s'}]" if last else "", "")
    handles = [line for ax in grid[0] for line in ax.get_legend_handles_labels()[0]]
    above = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "ncols": len(handles), "columnspacing": 1.0}
    legend(grid[0][-1], handles=handles, markerscale=2, handlelength=1.0, borderaxespad=0.2, **above)
    figure = grid[0][0].figure
    figure.supxlabel("\n".join(_told(fit)), fontsize=7.5, color=INK, x=0.01, ha="left")
    return figure


def save(fit: Fit, path: Path) -> Path:
    """Write the figure; its kind is the suffix's, one of FORMATS."""
    check_name(path)
    figure, kind = draw(fit), path.suffix.lower()[1:]
    return write_atomic(path, lambda temporary: figure.savefig(temporary, dpi=150, format=kind))


def _over_time(ax, t, learned, tested, edges) -> None:
    """Errors over time; every other part of the motion is shaded, and rows that take no part stand at the bottom."""
    for k in range(0, len(edges) - 1, 2):
        ax.axvspan(t[edges[k]], t[min(edges[k + 1], len(t) - 1)], color="#eef2f5", linewidth=0, zorder=0)
    for errors, colour, size, name in ((learned, _PALE, 5, "learned from"), (tested, COLOURS[0], 1.5, "held out")):
        rows = np.flatnonzero(np.isfinite(errors))
        rows = rows[thin(errors[rows], 2 * _POINTS)]
        ax.plot(t[rows], errors[rows], ".", markersize=size, color=colour, label=name)
    idle = np.flatnonzero(~np.isfinite(tested))
    ax.plot(t[idle], np.zeros(len(idle)), "|", markersize=3, color=COLOURS[1], label="left out", alpha=0.6,
            transform=ax.get_xaxis_transform())  # fmt: skip


def _over_speed(ax, speed, tested) -> None:
    """Errors over speed, and their mean in BINS of equal width, where FEW rows or more are in one."""
    rows = np.flatnonzero(np.isfinite(tested))
    few = rows[thin(tested[rows], 2 * _POINTS)]
    ax.plot(speed[few], tested[few], ".", markersize=1.5, color=COLOURS[0], alpha=0.6)
    v, e = speed[rows], tested[rows]
    place = np.clip((BINS * (v - v.min()) / max(np.ptp(v), 1e-12)).astype(int), 0, BINS - 1)
    kept = [np.flatnonzero(place == k) for k in range(BINS)]
    middle = [(v[b].mean(), e[b].mean()) for b in kept if len(b) >= FEW]
    ax.plot(*np.array(middle).T.reshape(2, -1), color=COLOURS[1], linewidth=1.4, label="mean")
    ax.axhline(0.0, color=INK, linewidth=0.5)


def _force_unit(found) -> str:
    """N, or N m of joints that turn: the unit of a Coulomb friction where there is one."""
    return next((u for n, u in zip(found.rows.names, found.rows.units, strict=True) if ".coulomb" in n), "N")


def _told(fit: Fit) -> list[str]:
    """The lines below: how large the errors are, and what this motion could not show."""
    found = fit.estimate
    lines = [
        f"{found.held_out_rms:.3g} N rms held out (each shaded or white part predicted from the others), "
        f"{found.residual_rms:.3g} N learned from; condition number {found.base.condition:.3g}"
    ]
    for head, names in (
        ("this motion does not show", fit.unseen), ("no motion shows", fit.never),
        ("seen only together with others", fit.together),
    ):  # fmt: skip
        if names:
            more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
            lines += textwrap.wrap(f"{head}: {', '.join(names[:MOST_NAMES])}{more}", 150)
    return [verbatim(line) for line in lines]
