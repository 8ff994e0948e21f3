"""Figures 2 to 4 of the paper, redrawn with ours, its numbers as dashed lines; and what the corner costs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...files import write_atomic
from ...report import style
from ...report.prepare import thin
from ..study import Figure
from . import bounds
from .corner import Passed
from .experiments import TORQUES, WAITS, Results
from .setup import CASES, FAST, LAWS, Case, machine

DPI = 150
UM, ARCMIN = 1e-6, np.pi / 180 / 60
WINDOW = (-0.01, 0.05)  # s about the corner


def figures(results: Sequence[Any], folder: Path) -> list[Figure]:
    """Draw all of them into `folder`."""
    found = Results(results)
    drawn = []
    for case in CASES:
        tail = "" if case is FAST else "_slow"
        drawn.append((f"figure_2_contour{tail}", _circle(found, case, "contour"), _caption(case, "Contour error")))
        drawn.append(
            (f"figure_2_orientation{tail}", _circle(found, case, "orientation"), _caption(case, "Orientation error"))
        )
    waits = found.corners.waits
    at = WAITS.index(0.5)
    drawn += [
        (
            "figure_3", _corner({"CCTPID": waits["CCTPID", FAST.name][at]}, 350, "CCTPID"),
            "Figure 3: the corner under CCTPID, half a sample before the next one; calibrated to the published 350 um.",
        ),
        (
            "figure_4", _corner({law: waits[law, FAST.name][at] for law in ("CDAC", "FCDAC")}, 15, "CDAC and FCDAC"),
            "Figure 4: the corner under the adaptive laws, motors without a limit, no preview.  The published 15 um "
            "are different by design.",
        ),
        ("corner_torque", _torques(found), "What the corner costs: contour error over the greatest motor torque."),
        ("lyapunov", _lyapunov(found), "The Lyapunov function where its assumptions hold."),
    ]  # fmt: skip
    out = []
    for name, ax, caption in drawn:
        figure = ax.figure
        write_atomic(folder / f"{name}.png", lambda file, f=figure: f.savefig(file, dpi=DPI, format="png"))
        out.append(Figure(f"{name}.png", caption))
    return out


def _caption(case: Case, what: str) -> str:
    return f"Figure 2: {what.lower()} on the circle, {case.name}; CDAC and FCDAC start with parameters 20 % off."


def _circle(found: Results, case: Case, what: str) -> Any:
    panels = style.new_panels(len(LAWS), (7.6, 6.4))
    scale, unit = (UM, "µm") if what == "contour" else (ARCMIN, "arcmin")
    for i, (law, ax) in enumerate(zip(LAWS, panels, strict=True)):
        turn = found.turn(law, case)
        error = getattr(turn, what) / scale
        rows = thin(error)
        ax.plot(turn.t[rows], error[rows], linewidth=0.8, color=style.COLOURS[i])
        for value, text in _printed(law, what):
            _published(ax, value, f"published: {text}")
        head = f"{law}: {what} error on the circle, {case.name}"
        style.label(ax, head, "time [s]" if law == LAWS[-1] else "", f"[{unit}]")
    panels[0].set_ylim(0, None)
    return panels[0]


def _printed(law: str, what: str) -> list[tuple[float, str]]:
    """What the paper prints of a law's error on the circle."""
    if what == "contour":
        glitches = [(10, "six glitches of 10 µm"), (3, "six of 3 µm")]
        return glitches if law == "CCTPID" else []  # 20 um, below which the adaptive laws are, is off the scale
    return [] if law == "CCTPID" else [(0.08, "at most 0.08'")]


def _corner(passed: dict[str, Passed], published: float, title: str) -> Any:
    ax = style.new_axes((6.4, 3.6))
    for law, run in passed.items():
        near = (run.t >= WINDOW[0]) & (run.t <= WINDOW[1])
        ax.plot(1e3 * run.t[near], run.contour[near] / UM, linewidth=1.1, label=law)
    _published(ax, published, f"published: {published} µm")
    ax.set_ylim(0, None)
    style.label(ax, f"Corner: {title}, {FAST.name}", "time from the corner [ms]", "contour error [µm]")
    style.legend_above(ax)
    return ax


def _torques(found: Results) -> Any:
    corners, true = found.corners, machine()
    ax = style.new_axes((6.4, 4.2))
    fine = np.geomspace(TORQUES[0], 5000, 60)
    for label, acceleration, error, colour in (
        ("no preview, no law below", bounds.greatest, bounds.unseen, style.COLOURS[1]),
        ("shortest previewed turn", bounds.straight, bounds.previewed, style.COLOURS[0]),
    ):
        values = [error(acceleration(true, torque)) / UM for torque in fine]
        ax.plot(fine, values, linewidth=1.0, color=colour, label=label)
    runs = {"CDAC, no preview": corners.sharp, "CDAC, previewed": {t: p for t, (p, _) in corners.previewed.items()}}
    for (label, found_at), colour in zip(runs.items(), (style.COLOURS[1], style.COLOURS[0]), strict=True):
        ax.plot(
            list(found_at), [run.error / UM for run in found_at.values()], "o", markersize=5, color=colour, label=label
        )
    quick = corners.quick["CDAC"]
    ax.plot([quick.torque], [quick.error / UM], "s", markersize=6, color=style.COLOURS[2], label="CDAC, 10 kHz")
    _published(ax, 15, "published: 15 µm")
    ax.set_xscale("log")
    ax.set_yscale("log")
    style.label(ax, "The corner at 0.2 m/s", "motor torque [N m]", "contour error [µm]")
    style.legend(ax, loc="upper right")
    return ax


def _lyapunov(found: Results) -> Any:
    course = found.of["Lyapunov function"]
    ax = style.new_axes((6.4, 3.6))
    names = ("of sigma", "of the inertial estimates", "of the Coulomb estimates", "of the viscous estimates")
    ax.plot(course.t, course.V, linewidth=1.4, color=style.INK, label="V")
    for name, part in zip(names, course.parts.T, strict=True):
        ax.plot(course.t, part, linewidth=0.9, label=name)
    ax.set_ylim(0, 1.45 * course.V[0])  # room for the legend
    style.label(ax, "Lyapunov function, continuous limit", "time [s]", "V [J]")
    style.legend(ax, loc="upper right", ncols=2)
    return ax


def _published(ax: Any, value: float, text: str) -> None:
    ax.axhline(value, color="#8a939c", linewidth=0.9, linestyle=(0, (5, 3)))
    ax.annotate(text, (0.995, value), xycoords=("axes fraction", "data"), ha="right", va="bottom", fontsize=8,
                color="#5a646e")  # fmt: skip
