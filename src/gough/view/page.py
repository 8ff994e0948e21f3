"""The moving machine as one page that plays from disk: a recording of viser, and a legend over it.

The page loads nothing: viser's player and the recording stand in it.  It plays in the run's own time where that is
short enough; of long runs it takes every so many rows, and says so in its legend.
"""

from __future__ import annotations

from html import escape
from typing import Any

import numpy as np

from ..report.prepare import scale_for
from .scene import Scene
from .stage import Stage, error_colours, force_colour

FRAMES = 25  # a second
MOST = 1500  # frames; a page of some megabytes


def page(server: Any, scene: Scene, magnify: float | None = None) -> str:
    """The text of the page that plays a scene; `server` is a viser server without other nodes."""
    stage = Stage(server, scene)
    if magnify is not None:
        stage.magnify(magnify)
    position, target = stage.camera()
    server.initial_camera.position, server.initial_camera.look_at = tuple(position), tuple(target)
    recording = server.get_scene_serializer()
    speed = max(1.0, scene.duration * FRAMES / MOST)
    count = max(2, int(round(scene.duration / speed * FRAMES)) + 1)
    times = np.linspace(scene.t[0], scene.t[-1], count)
    for time in times:
        with server.atomic():
            stage.show(scene.row(float(time)))
        recording.insert_sleep(1 / FRAMES)
    text = recording.as_html()
    end = text.rindex("</body>")
    return text[:end] + legend(scene, scene.fitting if magnify is None else magnify, speed) + text[end:]


def legend(scene: Scene, magnify: float, speed: float = 1.0, over: bool = True) -> str:
    """What the colours mean, as HTML; `over` the picture, or for a panel beside it."""
    error, force = scale_for([scene.largest_error], "m"), scale_for([scene.force], "N")
    rows = [f"<b>{escape(scene.title)}</b>"]
    if over and speed > 1:
        rows.append(f"played {speed:.3g} times as fast as it ran")
    rows.append(
        f"{_bar([error_colours(np.array([s]))[0] for s in np.linspace(0, 1, 9)])}"
        f"contour error 0 to {error.times * scene.largest_error:.3g} {error.unit}, drawn {magnify:g} times as large"
    )
    top = f"{force.times * scene.force:.3g} {force.unit}"
    word = escape(scene.word)
    rows.append(f"{_bar([force_colour(s) for s in np.linspace(-1, 1, 9)])}force of a {word}, -{top} to {top}")
    if scene.reversals:
        rows.append(f"<span style='color:#282e34'>&#9679;</span> a {word} reverses ({len(scene.reversals)} times)")
    text = "<br>".join(rows)
    if not over:
        return text
    look = (
        "position:fixed;left:8px;bottom:48px;max-width:min(340px,calc(100vw - 32px));padding:6px 10px;"
        "pointer-events:none;"
        "font:12px/1.5 system-ui,sans-serif;color:#2b333b;background:rgba(255,255,255,.86);border-radius:4px;z-index:9"
    )
    return f'<div id="gough-legend" style="{look}">{text}</div>'


def _bar(colours) -> str:
    stops = ",".join(f"rgb({r},{g},{b})" for r, g, b in colours)
    look = f"display:inline-block;width:60px;height:9px;margin-right:6px;background:linear-gradient(90deg,{stops})"
    return f"<span style='{look}'></span>"
