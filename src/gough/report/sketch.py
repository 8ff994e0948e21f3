"""A machine drawn by lines: as text in Braille dots for a terminal, and as a figure of four views."""

from __future__ import annotations

from typing import Any

import numpy as np

from . import style

DOTS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))  # of a Braille sign, by row and column
BLANK = 0x2800
VIEWS = (("along y", 0, 2), ("along x", 1, 2), ("along z", 0, 1))  # by the axes to the right and up


def oblique(points: np.ndarray, up: int = 2) -> np.ndarray:
    """Points (k, 3) m as seen from in front, to the right and above, parallel; axis `up` of W up.  (k, 2)."""
    a, b = (i for i in range(3) if i != up)
    turn, tilt = np.deg2rad(35), np.deg2rad(22)
    across = np.cos(turn) * points[:, a] - np.sin(turn) * points[:, b]
    away = np.sin(turn) * points[:, a] + np.cos(turn) * points[:, b]
    return np.stack([across, np.cos(tilt) * points[:, up] + np.sin(tilt) * away], axis=1)


def sketch(machine: Any, columns: int = 64, rows: int = 22) -> str:
    """The machine at home as text, `columns` x `rows` signs at most, with its shape kept.

    A sign is about twice as high as wide and has two by four dots, so dots lie on a square grid.
    """
    lines = [oblique(np.asarray(part["points"], float), _up(machine)) for part in machine.drawing(machine.home)]
    corners = np.concatenate(lines)
    low, extent = corners.min(0), np.maximum(np.ptp(corners, axis=0), 1e-12)
    scale = min((2 * columns - 1) / extent[0], (4 * rows - 1) / extent[1])  # dots a metre
    wide, high = (int(n) + 1 for n in np.rint(scale * extent))
    signs = np.zeros((-(-high // 4), -(-wide // 2)), int)
    for line in lines:
        for start, end in zip(line[:-1], line[1:], strict=True):
            steps = max(2, int(2 * scale * np.abs(end - start).max()) + 1)
            at = scale * (start + np.linspace(0, 1, steps)[:, None] * (end - start) - low)
            x, y = np.rint(at[:, 0]).astype(int), high - 1 - np.rint(at[:, 1]).astype(int)
            for i, j in {(int(a), int(b)) for a, b in zip(x, y, strict=True)}:
                signs[j // 4, i // 2] |= DOTS[j % 4][i % 2]
    return "\n".join("".join(chr(BLANK + sign) for sign in row).rstrip(chr(BLANK)) for row in signs)


def machine_figure(machine: Any) -> Any:
    """The machine at home along the axes of W and obliquely, with the numbers of its joints; a matplotlib figure."""
    grid = style.new_grid(2, 2, (9, 7.5), shared=False)
    parts = machine.drawing(machine.home)
    for (title, i, j), ax in zip((*VIEWS, ("oblique", -1, -1)), [ax for row in grid for ax in row], strict=True):
        for k, part in enumerate(parts):
            points = np.asarray(part["points"], float)
            shown = oblique(points, _up(machine)) if i < 0 else points[:, [i, j]]
            colour = style.COLOURS[1] if part["name"] == "tool" else style.INK
            if part["name"] in machine.joint_names:
                colour = style.COLOURS[0]
                number = 1 + machine.joint_names.index(part["name"])
                ax.text(*shown.mean(0), str(number), fontsize=8, color=colour)
            ax.plot(*shown.T, color=colour, linewidth=1.4, zorder=k)
        ax.set_aspect("equal", adjustable="datalim")
        names = ("", "") if i < 0 else (f"{'xyz'[i]} [m]", f"{'xyz'[j]} [m]")
        style.label(ax, f"{machine.name}, {title}" if title == "along y" else title, *names)
    return grid[0][0].figure


def _up(machine: Any) -> int:
    """The axis of W along gravity."""
    gravity = np.abs(np.asarray(machine.gravity, float))
    return int(np.argmax(gravity)) if gravity.any() else 2
