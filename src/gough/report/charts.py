"""The charts of the page as plain data for plotly.js: logs in, a dict a chart out.  No plotly objects are made.

Texts that come from outside are escaped here, because plotly.js reads a little HTML in names.  Numbers travel as
base64 of little-endian floats, a third of the size of digits.
"""

from __future__ import annotations

import base64
import html
from typing import Any

import numpy as np

from ..log import Log
from .prepare import (
    LIMIT,
    Circle,
    circle_numbers,
    circles,
    counted,
    human,
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
from .style import COLOURS, ERROR_SCALE, INK

GRID = "#e6eaee"
_FONT = {"family": "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif", "size": 12.5}
_SCALE = [list(stop) for stop in ERROR_SCALE]
_PARTS = {
    "base": ("#4a545e", 6), "platform": ("#0072B2", 6), "strut": ("#8d98a3", 5), "tool": ("#D55E00", 16),
    "rail": ("#4a545e", 3), "carriage": ("#4a545e", 12), "leg": ("#8d98a3", 5),
}  # fmt: skip


def contour(logs: list[Log], names: list[str]) -> dict[str, Any]:
    """Contour error over time with velocity reversals marked."""
    scale = scale_for(np.concatenate([log["contour_error"] for log in logs]), "m")
    data, marks, top = [], [], 0.0
    for log in logs:
        finite = log["contour_error"][np.isfinite(log["contour_error"])]
        top = max(top, scale.times * float(finite.max()) if finite.size else 0.0)
    for i, (log, name) in enumerate(zip(logs, names, strict=True)):
        error = scale.times * log["contour_error"]
        rows = thin(error)
        line = log["line"][rows] if "line" in log else np.zeros(len(rows))
        data.append(
            _line(log.t[rows], error[rows], name, COLOURS[i % 6], 1.1)
            | {"customdata": packed(line), "hovertemplate": f"%{{y:.3g}} {scale.unit}, NC line %{{customdata:.0f}}"}
        )
        found = reversals(log)
        level = -(0.045 + 0.05 * i) * (top or 1.0)
        joints = [_joint(entry) for entry in found]
        glitch = [scale.times * float(entry.get("glitch") or 0.0) for entry in found]
        marks.append(
            {
                "type": "scatter",
                "mode": "markers",
                "name": f"reversals, {escape(name)}",
                "showlegend": False,
                "x": packed([entry["time"] for entry in found]),
                "y": packed([level] * len(found)),
                "marker": {"symbol": "line-ns", "size": 6, "line": {"width": 1.2, "color": COLOURS[i % 6]}},
                "customdata": packed(np.c_[joints, glitch].reshape(-1, 2)),
                "hovertemplate": f"reversal of {log.joint_word} %{{customdata[0]:.0f}}, "
                f"glitch %{{customdata[1]:.3g}} {scale.unit}",
            }
        )
    layout = _layout("time [s]", f"contour error [{scale.unit}]", 400)
    layout["shapes"] = _bands(logs[0])
    layout["xaxis"] |= _extent(logs)
    return {"data": data + marks, "layout": layout}


def path(log: Log, top: float, length: Any) -> dict[str, Any]:
    """Tool path coloured by contour error; `top` (m) is the end of the colours, shared by all logs of a page."""
    error, p = log["contour_error"], tip(log)
    plane = plane_of([p])
    scale = scale_for([top], "m")
    rows = path_rows(error)
    xy = length.times * p[rows][:, [plane.first, plane.second]]
    thread = _line(xy[:, 0], xy[:, 1], "", "#cfd7df", 1) | {"hoverinfo": "skip"}
    keep = counted(log)[rows]
    rows, xy = rows[keep], xy[keep]
    line = log["line"][rows] if "line" in log else np.zeros(len(rows))
    shown = scale.times * error[rows]
    order = np.argsort(shown, kind="stable")  # the largest errors on top, NaN last
    trace = {
        "type": "scatter",
        "mode": "markers",
        "x": packed(xy[order, 0]),
        "y": packed(xy[order, 1]),
        "name": "",
        "marker": {
            "color": packed(shown[order]),
            "colorscale": _SCALE,
            "cmin": 0,
            "cmax": scale.times * top or 1.0,
            "size": 4.5,
            "colorbar": {"title": {"text": scale.unit}, "thickness": 10, "len": 0.8, "outlinewidth": 0},
        },
        "customdata": packed(np.c_[line, log.t[rows]][order]),
        "hovertemplate": f"contour error %{{marker.color:.3g}} {scale.unit}<br>NC line %{{customdata[0]:.0f}}<br>"
        f"t = %{{customdata[1]:.3f}} s<br>{plane.label[0]} %{{x:.2f}}, {plane.label[1]} %{{y:.2f}} {length.unit}",
    }
    layout = _layout(f"{plane.label[0]} [{length.unit}]", f"{plane.label[1]} [{length.unit}]", 430)
    layout["margin"]["t"] = 34
    return {"data": [thread, trace], "layout": _square(layout) | {"showlegend": False}}


def circle(found: list[tuple[int, str, Circle]]) -> tuple[dict[str, Any], str]:
    """Magnified-error polar plot of one circle from (index, name, circle) of each log; and what its caption says."""
    first = found[0][2]
    times = magnification(first.radius, [c.error for _, _, c in found])
    length, turn = scale_for([first.radius], "m"), np.linspace(0, 2 * np.pi, 181)
    ring = length.times * first.radius
    step = first.radius * 0.1 / times
    division = scale_for([step], "m")
    data, notes = [], []
    for part in (-3, -2, -1, 1, 2, 3):
        data.append(_ring(ring * (1 + 0.1 * part), turn, GRID, 1))
        if part in (-3, 3):  # where the error hardly ever is
            notes.append(
                _text(
                    0.7071 * ring * (1 + 0.1 * part),
                    0.7071 * ring * (1 + 0.1 * part),
                    f"{part * step * division.times:+.3g} {division.unit}",
                )
            )
    data.append(_ring(ring, turn, INK, 1.4) | {"name": "programmed circle", "showlegend": True})
    for i, name, c in found:
        scale = scale_for(c.error, "m")
        x, y = magnified(c, times)
        rows = thin(c.error)
        data.append(
            _line(length.times * x[rows], length.times * y[rows], name, COLOURS[i % 6], 1.2)
            | {
                "customdata": packed(np.c_[np.rad2deg(c.angle), scale.times * c.error][rows]),
                "hovertemplate": f"%{{customdata[1]:+.3g}} {scale.unit} at %{{customdata[0]:.0f}}°",
            }
        )
    layout = _square(_layout("", "", 430))
    for axis in ("xaxis", "yaxis"):  # millimetres of a magnified picture would mislead
        layout[axis] |= {"visible": False, "range": [-1.42 * ring, 1.42 * ring]}
    notes += [_text(1.38 * ring, 0, first.axes[0]), _text(0, 1.38 * ring, first.axes[1])]
    layout |= {"annotations": notes, "margin": {"l": 8, "r": 8, "t": 58, "b": 8}}
    head = f"Circle {first.number}" + (f", NC line {first.line}" if first.line else "")
    head += f": radius {ring:.4g} {length.unit}" + (f", feed {60 * first.feed:.3g} m/min" if first.feed else "")
    head += f". Error × {times:g}, outside +, rings every {division.times * step:.3g} {division.unit}."
    return {"data": data, "layout": layout}, head


def forces(log: Log, span: tuple[float, float] | None = None) -> dict[str, Any]:
    """Forces of the joints as applied; `span` (N), smallest and largest, is shared by all logs of a page."""
    u = log["u"]
    scale = scale_for(u if span is None else span, "N")
    data = []
    for i, name in enumerate(log.joint_names):
        y = scale.times * u[:, i]
        rows = thin(y, LIMIT // 2)
        data.append(
            _line(log.t[rows], y[rows], name, COLOURS[i % 6], 1.0)
            | {"hovertemplate": f"{name}: %{{y:.4g}} {scale.unit} at %{{x:.3f}} s<extra></extra>"}
        )
    layout = _layout("time [s]", f"force [{scale.unit}]", 380) | {"shapes": _bands(log)}
    layout["legend"] |= {"itemwidth": 30, "entrywidth": 42}
    layout["margin"]["t"] = 80  # two rows of legend under the buttons
    layout["xaxis"] |= _extent([log])
    if span is not None:
        layout["yaxis"] |= {"range": [scale.times * end for end in with_margin(span)]}
    return {"data": data, "layout": layout}


def wrench(log: Log) -> dict[str, Any]:
    """The force on the tool as an observer tells it, in axes of W; gaps where it is held from before."""
    force = np.array(log["wrench_hat"][:, :3])
    if "observer.held" in log:
        force[log["observer.held"] > 0] = np.nan
    scale = scale_for(np.nan_to_num(force), "N")
    data = []
    for i, name in enumerate(("fx", "fy", "fz")):
        y = scale.times * force[:, i]
        rows = thin(y, LIMIT // 2)
        data.append(
            _line(log.t[rows], y[rows], name, COLOURS[i], 1.0)
            | {"hovertemplate": f"{name}: %{{y:.4g}} {scale.unit} at %{{x:.3f}} s<extra></extra>"}
        )
    layout = _layout("time [s]", f"force [{scale.unit}]", 320) | {"shapes": _bands(log)}
    layout["xaxis"] |= _extent([log])
    return {"data": data, "layout": layout}


def machine(log: Log) -> dict[str, Any] | None:
    """The machine at home in 3-D with the tool path; None if the log holds no drawing."""
    data, corners = [], []
    for part in log.info.get("drawing") or []:
        points = np.asarray(part.get("points"), float)
        if points.ndim != 2 or points.shape[1] != 3:
            continue
        name = str(part.get("name", ""))
        colour, width = next((look for key, look in _PARTS.items() if name.startswith(key)), ("#8d98a3", 4))
        data.append(_space(points, name, colour, width))
        if name == "tool":  # a dot at its tip, because a sheet may have a tool without length
            sizes = [0] * (len(points) - 1) + [7]
            data[-1] |= {"mode": "lines+markers", "marker": {"size": sizes, "color": colour, "line": {"width": 0}}}
        corners.append(points)
    if not data:
        return None
    if len(log) and "x" in log:
        p = tip(log)
        rows = thin(log["contour_error"] if "contour_error" in log else p[:, 0], 2000)
        data.append(_space(p[rows], "tool path", "#D55E00", 3))
    extent = np.ptp(np.concatenate(corners), axis=0)
    # as large as the picture allows, seen 18 degrees from above: 1.62 high and 2.7 wide fill it, by trial
    extent = np.maximum(extent, 0.1 * extent.max()) if extent.max() > 0 else np.ones(3)
    wide = float(np.hypot(extent[0], extent[1]))
    size = min(1.62 / (0.95 * extent[2] + 0.31 * wide), 2.7 / wide)
    ratio = {n: float(size * side) for n, side in zip("xyz", extent, strict=True)}
    axis = {"backgroundcolor": "#ffffff", "gridcolor": GRID, "zerolinecolor": GRID, "color": "#5a646e"}
    scene = {f"{n}axis": axis | {"title": {"text": f"{n} [m]"}} for n in "xyz"}
    camera = {"eye": {"x": 1.2, "y": 1.0, "z": 0.5}, "projection": {"type": "orthographic"}}
    scene |= {"aspectmode": "manual", "aspectratio": ratio, "camera": camera}
    layout = {"scene": scene, "height": 560, "margin": {"l": 0, "r": 0, "t": 0, "b": 0}, "showlegend": False}
    return {"data": data, "layout": layout | {"font": _FONT, "paper_bgcolor": "#ffffff"}}


def packed(values: Any) -> dict[str, Any]:
    """An array for plotly.js; doubles where single precision would show (times of long runs), else singles."""
    array = np.asarray(values, float)
    finite = array[np.isfinite(array)]
    kind = "f4" if not finite.size or np.abs(finite).max() < 1000 else "f8"
    data = np.ascontiguousarray(array, f"<{kind}")
    out = {"dtype": kind, "bdata": base64.b64encode(data.tobytes()).decode()}
    return out | {"shape": ",".join(map(str, array.shape))} if array.ndim > 1 else out


def escape(text: str) -> str:
    """A text that plotly.js shows as it is."""
    return html.escape(text, quote=False)


def common_circles(logs: list[Log], names: list[str]) -> list[list[tuple[int, str, Circle]]]:
    """The circles worth a picture, of all logs, by number and radius: [(index of the log, its name, circle), ...]."""
    worth = circle_numbers(logs)
    groups: dict[tuple, list[tuple[int, str, Circle]]] = {}
    for i, (log, name) in enumerate(zip(logs, names, strict=True)):
        for found in (c for c in circles(log) if c.number in worth):
            groups.setdefault((found.number, round(found.radius, 9)), []).append((i, name, found))
    return [groups[key] for key in sorted(groups)]


def _line(x: np.ndarray, y: np.ndarray, name: str, colour: str, width: float) -> dict[str, Any]:
    return {
        "type": "scatter",
        "mode": "lines",
        "x": packed(x),
        "y": packed(y),
        "name": escape(human(name)),
        "line": {"color": colour, "width": width},
    }


def _ring(radius: float, turn: np.ndarray, colour: str, width: float) -> dict[str, Any]:
    return _line(radius * np.cos(turn), radius * np.sin(turn), "", colour, width) | {
        "hoverinfo": "skip",
        "showlegend": False,
    }


def _space(points: np.ndarray, name: str, colour: str, width: float) -> dict[str, Any]:
    x, y, z = (packed(points[:, i]) for i in range(3))
    return {
        "type": "scatter3d",
        "mode": "lines",
        "x": x,
        "y": y,
        "z": z,
        "name": escape(name),
        "line": {"color": colour, "width": width},
        "hoverinfo": "name",
    }


def _text(x: float, y: float, text: str) -> dict[str, Any]:
    return {"x": x, "y": y, "text": text, "showarrow": False, "font": {"size": 11, "color": "#5a646e"}}


def _layout(x: str, y: str, height: int) -> dict[str, Any]:
    axis = {
        "gridcolor": GRID,
        "zeroline": False,
        "linecolor": "#8a939c",
        "ticks": "outside",
        "ticklen": 4,
        "tickcolor": "#c9d0d6",
        "color": "#4a545e",
    }
    return {
        "height": height,
        "font": _FONT,
        "paper_bgcolor": "#ffffff",
        "plot_bgcolor": "#ffffff",
        "margin": {"l": 62, "r": 12, "t": 58, "b": 46},
        "hovermode": "closest",
        "legend": {"orientation": "h", "x": 0, "y": 1.02, "yanchor": "bottom", "itemsizing": "constant"},
        "xaxis": axis | {"title": {"text": x, "standoff": 8}},
        "yaxis": axis | {"title": {"text": y, "standoff": 6}},
    }


def _square(layout: dict[str, Any]) -> dict[str, Any]:
    layout["yaxis"] |= {"scaleanchor": "x", "scaleratio": 1}
    return layout


def _bands(log: Log) -> list[dict[str, Any]]:
    """Grey where rows are not counted in the metrics."""
    if "counted" not in log:
        return []
    look = {
        "type": "rect",
        "yref": "paper",
        "y0": 0,
        "y1": 1,
        "fillcolor": "#f1f3f5",
        "line": {"width": 0},
        "layer": "below",
    }
    return [look | {"x0": start, "x1": end} for start, end in spans(log["counted"] == 0, log.t)[:200]]


def _extent(logs: list[Log]) -> dict[str, Any]:
    """The range of a time axis, from the first row to the last."""
    ends = [float(end) for log in logs if len(log) for end in (log.t[0], log.t[-1])]
    return {"range": [min(ends), max(ends)]} if ends and max(ends) > min(ends) else {}


def _joint(entry: dict[str, Any]) -> int:
    joint = entry.get("joint")
    return int(joint) + 1 if isinstance(joint, int | float) else 0
