"""The figure of a Watch: force and moment over time, what friction may hide, events marked."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..files import write_atomic
from ..report.style import COLOURS, label, legend, new_axes

if TYPE_CHECKING:
    from .watch import Watch

POINTS = 4000  # drawn of a curve: each is the largest and the smallest of its stretch


def draw(watch: Watch, ax: Any = None) -> Any:
    """Force over time in axes; the band is what friction near rest may hide of the force's size."""
    ax = new_axes((9.0, 4.0)) if ax is None else ax
    rows = watch.rows
    t, w = rows["t"], np.where(rows["held"][:, None] > 0, np.nan, rows["wrench_hat"])
    for i, name in enumerate(("fx", "fy", "fz")):
        ax.plot(*_envelope(t, w[:, i]), color=COLOURS[i], linewidth=0.8, label=name)
    hidden = np.linalg.norm(rows["hidden"][:, :3], axis=1)
    at, band = _envelope(t, hidden)
    ax.fill_between(at, -band, band, color="#999999", alpha=0.2, linewidth=0, label="friction may hide")
    for event in watch.events[:200]:
        style = {"alarm": ("#b00020", "-"), "collision": ("#000000", "--"), "breakage": ("#7a3fb0", ":")}[event.kind]
        ax.axvline(event.start, color=style[0], linestyle=style[1], linewidth=0.8)
    label(ax, f"Force on the tool, {watch.machine.name}", "time in s", "force in N")
    legend(ax)
    return ax


def save(watch: Watch, path: Path) -> Path:
    """Write the figure as PNG."""
    ax = draw(watch)
    return write_atomic(path, lambda temporary: ax.figure.savefig(temporary, dpi=120))


def _envelope(t: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A curve of at most 2 POINTS points with every extreme of y."""
    if len(t) <= 2 * POINTS:
        return t, y
    size = -(-len(t) // POINTS)
    count = len(t) // size
    pieces = y[: count * size].reshape(count, size)
    low, high = (f(np.where(np.isfinite(pieces), pieces, fill), 1) for f, fill in ((np.min, np.inf), (np.max, -np.inf)))
    at = np.repeat(t[: count * size : size], 2)
    both = np.stack([low, high], 1).ravel()
    return at, np.where(np.isfinite(both), both, np.nan)
