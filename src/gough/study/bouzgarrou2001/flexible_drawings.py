"""Figures 5 to 9 of the paper on the flexible machine, maps of its workspace, and the line at equal cycle time."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...report import style
from ...report.prepare import thin
from . import beyond
from .experiments import Results
from .flexible import LEAD
from .rigid_rows import CTC, PID
from .setup import TIME

MM, UM = 1e-3, 1e-6


def flexible_figures(found: Results) -> list[tuple[str, Any, str]]:
    """(name, axes, caption) of each."""
    out = []
    for key, slides, tips in (("low", 5, 6), ("high", 7, 8)):
        for number, what, told in ((slides, "s21", "s21"), (tips, "y", "the tip along y")):
            out.append((
                f"figure_{number}_flexible", _errors(found, key, what),
                f"Figure {number}, {key} gains, flexible machine: error of {told} under both laws.",
            ))  # fmt: skip
    out.append((
        "figure_9", _gravity(found),
        "Figure 9: error of the tip along y, computed torque, high gains: without gravity compensation, set in within "
        "0.1 m of the target, and along the whole path from 0.25 s before the move on.",
    ))  # fmt: skip
    for section in found.sections:
        axes = "xyz"[section.across] + "xyz"[section.up]
        zero = next(c for c in "xyz" if c not in axes)
        out.append((
            f"map_frequency_{axes}", _map(section, section.frequency, "First frequency", "Hz"),
            f"First natural frequency, joints held, in the section {zero} = 0 of the workspace.",
        ))  # fmt: skip
        if axes == "yz":  # over x and y it hardly changes
            out.append((
                f"map_stiffness_{axes}", _map(section, section.stiffness / 1e6, "Least stiffness", "N/µm"),
                f"Static stiffness of the tip in its softest direction, joints held, at {zero} = 0.",
            ))  # fmt: skip
    for key in ("low", "high"):
        out.append((
            f"vibration_{key}", _swing(found, key),
            f"{key.capitalize()} gains, computed torque: distance of the tip from where it comes to rest, behind a line"
            " "
            f"of {beyond.CYCLE:g} s by five feeds.",
        ))  # fmt: skip
        out.append((
            f"model_{key}", _model(found, key),
            f"{key.capitalize()} gains, jerk-limited line: error of the tip along y without compensation, with gravity "
            "compensation, and with flexible feedforward.",
        ))  # fmt: skip
    return out


def _errors(found: Results, key: str, what: str) -> Any:
    ax = style.new_axes((6.8, 3.8))
    for name, colour in zip((PID, CTC), style.COLOURS, strict=False):
        course = found.flexible[key, name]
        values = course.e[:, 0] if what == "s21" else course.tip[:, 1]
        rows = thin(values)
        ax.plot(course.t[rows], values[rows] / MM, linewidth=0.9, color=colour, label=name)
    style.label(ax, f"Flexible machine, {key} gains: error of {what}", "time [s]", "error [mm]")
    style.legend_above(ax)
    return ax


def _map(section, values: Any, told: str, unit: str) -> Any:
    ax = style.new_axes((6.0, 4.6))
    image = ax.contourf(section.a / MM, section.b / MM, values, 14, cmap="cividis")
    ax.figure.colorbar(image, ax=ax, label=f"{told.lower()} [{unit}]")
    at = np.unravel_index(values.argmin(), values.shape)
    ax.plot(section.a[at[1]] / MM, section.b[at[0]] / MM, "o", color="white", markersize=5, clip_on=False)
    title = f"{told}: {values.min():.3g} (white) to {values.max():.3g} {unit}"
    style.label(ax, title, f"{'xyz'[section.across]} [mm]", f"{'xyz'[section.up]} [mm]")
    return ax


def _gravity(found: Results) -> Any:
    ax = style.new_axes((6.8, 3.8))
    names = {"none": "without", "target": "near the target", "path": "along the path"}
    for (way, label), colour in zip(names.items(), style.COLOURS, strict=False):
        course = found.compensated["high", CTC, way]
        rows = thin(course.tip[:, 1])
        rows = rows[course.t[rows] < LEAD + TIME]
        ax.plot(course.t[rows], course.tip[rows, 1] / MM, linewidth=0.9, color=colour, label=label)
    style.label(ax, "Gravity compensation: error of y", "time [s]", "error [mm]")
    style.legend(ax, loc="lower right")
    return ax


def _swing(found: Results, key: str) -> Any:
    ax = style.new_axes((6.8, 3.8))
    end = LEAD + beyond.CYCLE
    for feed, colour in zip(("steps", "jerk limited", "zv", "zvd", "ei"), style.COLOURS, strict=False):
        course = found.vibration[key, feed, CTC].course
        gap = beyond.from_rest(course)
        rows = thin(gap)
        rows = rows[(course.t[rows] > end - 0.1) & (course.t[rows] < end + 0.3)]
        ax.plot(course.t[rows] - end, gap[rows] / UM, linewidth=0.9, color=colour, label=feed)
    ax.set_yscale("log")
    ax.set_ylim(0.1, 1e3)
    ax.axvline(0.0, color=style.INK, linewidth=0.6)
    style.label(ax, f"Swing of the tip, {key} gains", "time behind the line [s]", "from rest [µm]")
    style.legend_above(ax)
    return ax


def _model(found: Results, key: str) -> Any:
    ax = style.new_axes((6.8, 3.8))
    for name, colour in zip(beyond.LAWS, style.COLOURS, strict=False):
        course = found.vibration[key, "jerk limited", name].course
        rows = thin(course.tip[:, 1])
        ax.plot(course.t[rows], course.tip[rows, 1] / UM, linewidth=0.9, color=colour, label=name)
    style.label(ax, f"Error of y on the line, {key} gains", "time [s]", "error [µm]")
    style.legend(ax, loc="lower left")
    return ax
