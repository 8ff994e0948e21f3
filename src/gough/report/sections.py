"""The parts of the page in reading order: table, path, circles, error over time, forces, force on the tool, machine."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from typing import NamedTuple

import numpy as np

from ..log import Log
from . import charts as draw
from .prepare import counted, force_range, labels, plane_of, scale_for, tip
from .style import COLOURS
from .table import heads, report_table, where

MOST_CIRCLES = 12
SCENE = "<!-- scene -->"  # where `gough view --export` puts its link

# as the meters of gough.measure take them
TERMS = {
    "Contour error": "distance of the tool tip to the programmed path, over feed moves only (G1 to G3); the closest "
    "point is sought near the reference: within 5 mm + 0.1 s of feed along the path.",
    "Lag": "how far that closest point is from the reference, along the path.",
    "Velocity reversal": "the reference velocity of a joint changes its sign during a feed move, where friction shows.",
    "Glitch": "of a reversal: the largest contour error in the 0.2 s after it, less the median of the 0.2 s before.",
}


class Section(NamedTuple):
    """A heading with what stands under it."""

    id: str
    heading: str
    body: str

    def html(self) -> str:
        """The section as HTML."""
        return f'<section id="{self.id}">\n<h2>{escape(self.heading)}</h2>\n{self.body}\n</section>'


def build(logs: list[Log], charts: dict[str, dict]) -> Iterator[Section]:
    """The sections that the logs have data for; their charts are added to `charts` by the id of their place."""
    names = labels(logs)
    yield Section("numbers", "In numbers", _table(logs))
    for part in (_path, _circles, _contour, _forces, _wrench, _machine):
        section = part(logs, names, charts)
        if section:
            yield section


def _table(logs: list[Log]) -> str:
    head = "".join(
        f'<th scope="col"><span class="swatch" style="background:{COLOURS[i % 6]}"></span>{escape(name)}</th>'
        for i, name in enumerate(heads(logs))
    )
    rows = []
    table = report_table(logs)
    for row in table:
        looks = ["best" if i in row.best else "bad" if "FAILED" in value else "" for i, value in enumerate(row.values)]
        cells = "".join(
            f'<td class="{look}">{escape(value)}</td>' for look, value in zip(looks, row.values, strict=True)
        )
        rows.append(f'<tr><th scope="row">{escape(row.label)}</th>{cells}</tr>')
    caption = "<caption>Bold: the best of each line.</caption>" if any(row.best for row in table) else ""
    terms = "".join(f"<div><dt>{term}:</dt><dd>{meaning}</dd></div>" for term, meaning in TERMS.items())
    place = _note(escape(where(logs))) if where(logs) else ""
    return (
        f'<div class="scroll"><table>{caption}<thead><tr><th></th>{head}</tr></thead>'
        f'<tbody>{"".join(rows)}</tbody></table></div>\n{place}<dl class="terms">{terms}</dl>'
    )


def _path(logs: list[Log], names: list[str], charts: dict[str, dict]) -> Section | None:
    shown = [
        (i, log, name)
        for i, (log, name) in enumerate(zip(logs, names, strict=True))
        if len(log) and "x" in log and "contour_error" in log
    ]
    if not shown:
        return None
    top, told = max(_top(log) for _, log, _ in shown), heads(logs)
    plane = plane_of([tip(log) for _, log, _ in shown])
    length = scale_for(np.concatenate([tip(log)[:, [plane.first, plane.second]] for _, log, _ in shown]).ravel(), "m")
    boxes = []
    for i, log, _ in shown:
        charts[f"path-{i}"] = draw.path(log, top, length)
        boxes.append(_figure(f"path-{i}", f"<b>{escape(told[i])}</b>", 430))
    note = f"Seen in the {plane.label} plane of W. Dark is far from the programmed path, a thin line is a rapid"
    note += "; the colours mean the same in each picture." if len(shown) > 1 else "."
    return Section("path", "Tool path coloured by contour error", _note(note) + _grid(boxes))


def _circles(logs: list[Log], names: list[str], charts: dict[str, dict]) -> Section | None:
    groups = draw.common_circles(logs, names)
    boxes = []
    for k, group in enumerate(groups[:MOST_CIRCLES]):
        charts[f"circle-{k}"], head = draw.circle(group)
        boxes.append(_figure(f"circle-{k}", escape(head), 430))
    if not boxes:
        return None
    note = "The deviation from the programmed circle, magnified. A perfect machine draws the dark ring."
    if len(groups) > MOST_CIRCLES:
        note += f" The first {MOST_CIRCLES} of {len(groups)}; the logs hold all."
    return Section("circles", "Circles", _note(note) + _grid(boxes))


def _contour(logs: list[Log], names: list[str], charts: dict[str, dict]) -> Section | None:
    shown = [(log, name) for log, name in zip(logs, names, strict=True) if len(log) and "contour_error" in log]
    if not shown:
        return None
    charts["contour"] = draw.contour([log for log, _ in shown], [name for _, name in shown])
    note = f"Ticks below zero: a {logs[0].joint_word} reverses its velocity, where friction shows. "
    note += "Grey: not counted (rapid, dwell, after the end). Drag to zoom, double-click to return."
    return Section("contour", "Contour error over time", _note(note) + _box("contour", 400))


def _forces(logs: list[Log], _names: list[str], charts: dict[str, dict]) -> Section | None:
    boxes, span = [], force_range(logs)
    for i, (log, head) in enumerate(zip(logs, heads(logs), strict=True)):
        if len(log) and "u" in log:
            charts[f"forces-{i}"] = draw.forces(log, span)
            boxes.append(_figure(f"forces-{i}", f"<b>{escape(head)}</b>", 380))
    word = logs[0].joint_word if logs else "joint"
    note = "As the drives apply them; positive pushes a joint the way its coordinate grows"
    note += ": it lengthens a strut." if word == "strut" else "."
    note += " The scale is the same in each picture." if len(boxes) > 1 else ""
    return Section("forces", f"{word.capitalize()} forces", _note(note) + _grid(boxes)) if boxes else None


def _wrench(logs: list[Log], _names: list[str], charts: dict[str, dict]) -> Section | None:
    boxes = []
    for i, (log, head) in enumerate(zip(logs, heads(logs), strict=True)):
        if len(log) and "wrench_hat" in log:
            charts[f"wrench-{i}"] = draw.wrench(log)
            boxes.append(_figure(f"wrench-{i}", f"<b>{escape(head)}</b>", 320))
    note = "What the observer makes of the drives' forces, at the tool tip in axes of W. A gap: it is held from before."
    return Section("wrench", "Force on the tool, as observed", _note(note) + _grid(boxes)) if boxes else None


def _machine(logs: list[Log], _names: list[str], charts: dict[str, dict]) -> Section | None:
    chart = draw.machine(logs[0])
    if chart is None:
        return None
    charts["machine"] = chart
    note = (
        "At its home pose, with the tool path. Drag to turn, scroll to come nearer. Moving along the run: <code>gough"
    )
    note += " view</code> with this folder."
    return Section("machine", "The machine", _note(note) + SCENE + _box("machine", 560))


def _top(log: Log) -> float:
    """The largest counted contour error, m: what is not counted must not set the colours."""
    error = log["contour_error"]
    keep = np.isfinite(error) & counted(log)
    return float(error[keep].max()) if keep.any() else 0.0


def _box(name: str, height: int) -> str:
    return f'<div class="chart" id="{name}" style="min-height:{height}px"></div>'


def _figure(name: str, caption: str, height: int) -> str:
    return f"<figure><figcaption>{caption}</figcaption>{_box(name, height)}</figure>"


def _grid(boxes: list[str]) -> str:
    return f'<div class="grid">{"".join(boxes)}</div>'


def _note(text: str) -> str:
    return f'<p class="note">{text}</p>'
