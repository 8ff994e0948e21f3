"""Figures: one function each, logs in, axes out.  Without `ax` a new figure is made: `ax.figure.savefig(path)`.

None uses pyplot or changes rcParams, so figures can be drawn in threads.  Lines are thinned to what the eye can see;
the largest value is always drawn (prepare.thin).
"""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import LogError
from ..files import write_atomic
from ..log import Log
from ..names import slug
from . import style
from .prepare import (
    as_logs,
    circle_numbers,
    circles,
    counted,
    force_range,
    human,
    labels,
    magnification,
    magnified,
    path_rows,
    plane_of,
    reversals,
    scale_for,
    spans,
    thin,
    tip,
    with_margin,
)
from .table import number as of_log
from .table import worst

DPI = 150
MOST_CIRCLES = 12


def contour_error(logs: Log | Iterable[Log], ax: Any = None) -> Any:
    """Contour error over time, one line a log; velocity reversals are ticks below, what is not counted is grey."""
    logs = as_logs(logs)
    ax = ax or style.new_axes()
    for log in logs:
        _need(log, "contour_error")
    scale = scale_for(np.concatenate([log["contour_error"] for log in logs]), "m")
    drawn: list[Any] = []
    top = 0.0
    for log, name in zip(logs, labels(logs), strict=True):
        error = scale.times * log["contour_error"]
        rows = thin(error)
        drawn += ax.plot(log.t[rows], error[rows], label=style.verbatim(human(name)), linewidth=0.8)
        top = max(top, _top(error))
        place = worst(log)
        if place:
            most = scale.times * of_log(log, ("contour_error", "max"))
            side = "left" if place[0] < 0.8 * log.t[-1] else "right"  # of the largest error, inside the frame
            colour = drawn[-1].get_color()
            ax.annotate(f" NC line {place[1]} ", (place[0], most), ha=side, fontsize="small", color=colour)
    _uncounted(logs[0], ax)
    for i, log in enumerate(logs):
        times = [entry["time"] for entry in reversals(log)]
        level = -(0.04 + 0.045 * i) * top
        ax.plot(
            times,
            np.full(len(times), level),
            linestyle="",
            marker="|",
            markersize=4,
            markeredgewidth=0.8,
            color=drawn[i].get_color(),
        )
    title = f"Contour error: {_whose(logs[0])}" if len(logs) == 1 else "Contour error"
    style.label(ax, title, "time [s]", f"contour error [{scale.unit}]")
    style.legend_above(ax)
    _failed(logs, ax)
    return ax


def path(log: Log, ax: Any = None) -> Any:
    """Tool path coloured by contour error, seen along the axis of W in which it extends least."""
    from matplotlib.collections import LineCollection
    from matplotlib.colors import LinearSegmentedColormap

    _need(log, "x", "contour_error")
    ax = ax or style.new_axes((6.4, 5.6))
    p = tip(log)
    plane = plane_of([p])
    error = log["contour_error"]
    rows = path_rows(error)
    scale = scale_for(error[counted(log)], "m")
    length = scale_for(p[:, [plane.first, plane.second]], "m")
    xy = length.times * p[rows][:, [plane.first, plane.second]]
    colours = LinearSegmentedColormap.from_list("gough_error", style.ERROR_SCALE)
    feed = counted(log)[rows]
    feed = feed[:-1] & feed[1:]  # pieces of which both ends count
    ax.plot(xy[:, 0], xy[:, 1], color="#cfd7df", linewidth=0.8)
    lines = LineCollection(np.stack([xy[:-1], xy[1:]], axis=1)[feed], cmap=colours, linewidths=2.2, capstyle="round")
    shown = scale.times * np.maximum(error[rows][:-1], error[rows][1:])[feed]
    lines.set_array(shown)
    lines.set_clim(0, _top(shown))
    ax.add_collection(lines)
    ax.autoscale_view()
    ax.set_aspect("equal", adjustable="datalim")
    first, second = plane.label
    style.label(ax, f"Path: {_whose(log)}", f"{first} [{length.unit}]", f"{second} [{length.unit}]")
    bar = ax.figure.colorbar(lines, ax=ax, shrink=0.8)
    bar.set_label(f"contour error [{scale.unit}]", fontsize=9, color=style.INK)
    bar.ax.tick_params(labelsize=8.5, colors="#5a646e")
    bar.outline.set_visible(False)
    _failed([log], ax)
    return ax


def circle(logs: Log | Iterable[Log], number: int | None = None, ax: Any = None) -> Any:
    """Polar plot of a circle: radial error magnified over the reference circle, outside +, all logs overlaid.

    Raises
    ------
    LogError
        no log has a circle of this number.
    """
    logs = as_logs(logs)
    found = [(name, c) for log, name in zip(logs, labels(logs), strict=True) for c in circles(log)]
    known = sorted({c.number for _, c in found})
    if not known or (number is not None and number not in known):
        cure = f"there is {', '.join(map(str, known))}" if known else "the program has no full circle or arc"
        raise LogError("the log has no such circle", key="circle", value=str(number), cure=cure)
    number = known[0] if number is None else number
    found = [(name, c) for name, c in found if c.number == number]
    ax = ax or style.new_axes((6.0, 6.0))
    radius = found[0][1].radius
    times = magnification(radius, [c.error for _, c in found])
    length = scale_for([radius], "m")
    turn = np.linspace(0, 2 * np.pi, 361)
    ring = length.times * radius
    step = 0.1 * radius / times
    division = scale_for([step], "m")
    for part in (-3, -2, -1, 1, 2, 3):  # rings every tenth of the radius: the scale of the error
        r = ring * (1 + 0.1 * part)
        ax.plot(r * np.cos(turn), r * np.sin(turn), color="#e3e7eb", linewidth=0.7)
        if part in (-3, 3):  # where the error hardly ever is
            ax.annotate(
                f"{part * division.times * step:+.3g} {division.unit}",
                (0.7071 * r, 0.7071 * r),
                fontsize=8,
                color="#5a646e",
                ha="center",
                va="center",
            )
    ax.plot(ring * np.cos(turn), ring * np.sin(turn), color=style.INK, linewidth=1.0, label="programmed circle")
    for i, (name, c) in enumerate(found):
        x, y = magnified(c, times)
        rows = thin(c.error)
        ax.plot(
            length.times * x[rows],
            length.times * y[rows],
            label=style.verbatim(human(name)),
            linewidth=0.9,
            color=style.COLOURS[i % len(style.COLOURS)],
        )
    ax.set_aspect("equal", adjustable="datalim")
    text = f"Circle {number}: radial error × {times:g}, outside +"
    style.label(ax, text, f"{found[0][1].axes[0]} [{length.unit}]", f"{found[0][1].axes[1]} [{length.unit}]")
    style.legend(ax, loc="center")
    _failed(logs, ax)
    return ax


def forces(log: Log, ax: Any = None, span: tuple[float, float] | None = None) -> Any:
    """Forces of the joints, as applied, over time; `span` (N) is what the axis shows, to compare several logs."""
    return _joints(log, ax, "u", lambda log: log["u"], "N", f"{log.joint_word.capitalize()} forces", "force", span)


def velocities(log: Log, ax: Any = None) -> Any:
    """Velocities of the joints over time, by differences of their true coordinates."""
    return _joints(log, ax, "q", rate, "m/s", f"{log.joint_word.capitalize()} velocities", "velocity")


def tracking(log: Log, ax: Any = None) -> Any:
    """Tracking errors of the joints over time: reference minus true."""
    _need(log, "q_r", "q")
    return _joints(log, ax, "q", lambda log: log["q_r"] - log["q"], "m", "Tracking error", "q_r - q")


def save_all(logs: Log | Iterable[Log], folder: str | Path) -> list[Path]:
    """Write every figure the logs have data for as PNG into `folder`, which is made; the paths, in reading order.

    Raises
    ------
    StorageError
        a file could not be written.
    """
    logs = as_logs(logs)
    folder = Path(folder)
    drawn: list[tuple[str, Callable[[], Any]]] = []
    having = [log for log in logs if "contour_error" in log]
    if having:
        drawn.append(("contour_error", lambda: contour_error(having)))
    for number in circle_numbers(logs)[:MOST_CIRCLES]:
        drawn.append((f"circle_{number}", lambda number=number: circle(logs, number)))
    alike = {"forces": partial(forces, span=force_range(logs))}
    for log, name in zip(logs, labels(logs), strict=True):
        for figure, needed in (
            (path, ("x", "contour_error")),
            (forces, ("u",)),
            (velocities, ("q",)),
            (tracking, ("q", "q_r")),
        ):
            if all(key in log for key in needed):
                kind = figure.__name__
                drawn.append((f"{kind}_{slug(name)}", partial(alike.get(kind, figure), log)))
    used: set[str] = set()
    out = []
    for name, draw in drawn:
        while name in used:  # two names may have one slug
            name += "_"
        used.add(name)
        figure = draw().figure
        folder.mkdir(parents=True, exist_ok=True)
        out.append(write_atomic(folder / f"{name}.png", lambda file, f=figure: f.savefig(file, dpi=DPI, format="png")))
    return out


def rate(log: Log) -> np.ndarray:
    """Velocities of the joints by central differences over the rows.  (n, joints) m/s."""
    q = log["q"]
    return np.gradient(q, log.t, axis=0) if len(q) > 1 else np.zeros_like(q)


def _joints(
    log: Log,
    ax: Any,
    needed: str,
    values: Callable[[Log], np.ndarray],
    unit: str,
    title: str,
    what: str,
    span: tuple[float, float] | None = None,
) -> Any:
    _need(log, needed)
    ax = ax or style.new_axes()
    data = values(log)
    scale = scale_for(data if span is None else span, unit)
    for i in range(data.shape[1]):
        y = scale.times * data[:, i]
        rows = thin(y)
        ax.plot(log.t[rows], y[rows], label=f"{i + 1}", linewidth=0.8)
    if span is not None:
        ax.set_ylim(*(scale.times * end for end in with_margin(span)))
    style.label(ax, f"{title}: {_whose(log)}", "time [s]", f"{what} [{scale.unit}]")
    style.legend_above(ax)
    _failed([log], ax)
    return ax


def _top(values: np.ndarray) -> float:
    """The largest finite value, 1 if there is none."""
    finite = values[np.isfinite(values)]
    return float(finite.max()) if finite.size and finite.max() > 0 else 1.0


def _whose(log: Log) -> str:
    """The controller and the program, no longer than leaves room for a legend."""
    program = log.info.get("program")
    name = str(program.get("name") or "") if isinstance(program, dict) else ""
    text = ", ".join(filter(None, [human(labels([log])[0]), name]))
    return text if len(text) <= 48 else text[:47] + "…"


def _uncounted(log: Log, ax: Any) -> None:
    """Grey where rows are not counted in the metrics: rapids, dwells, after the end."""
    if "counted" in log:
        for start, end in spans(log["counted"] == 0, log.t)[:200]:
            ax.axvspan(start, end, color="#f0f2f4", linewidth=0, zorder=0)


def _failed(logs: list[Log], ax: Any) -> None:
    failed = [log for log in logs if log.failed]
    if failed:
        reason = textwrap.shorten(f"FAILED: {failed[0].reason}", 150, placeholder=" ...")
        text = ax.text(
            0.01,
            0.02,
            style.verbatim(textwrap.fill(reason, 58)),
            transform=ax.transAxes,
            color="#b00020",
            fontsize=9,
            weight="bold",
        )
        text.set_in_layout(False)  # else the axes shrink until a long reason fits beside them


def _need(log: Log, *names: str) -> None:
    for name in names:
        log[name]  # raises LogError with the name
