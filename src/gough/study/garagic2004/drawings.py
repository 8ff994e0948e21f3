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
from .setup import CASES, FAST, LAWS, SLOW, Case, machine

DPI = 150
UM, ARCMIN = 1e-6, np.pi / 180 / 60
WINDOW = (-0.01, 0.05)  # s about the corner
FAINT = "#5a646e"  # what is published


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
            "figure_3", _corner({"CCTPID": waits["CCTPID", FAST.name][at]}, 350),
            "Figure 3: the corner under CCTPID, half a sample before the next one; calibrated to the published 350 um.",
        ),
        (
            "figure_4", _corner({law: waits[law, FAST.name][at] for law in ("CDAC", "FCDAC")}, 15),
            "Figure 4: the corner under the adaptive laws, motors without a limit, no preview.  The published 15 um "
            "are different by design.",
        ),
        (
            "corner_torque", _torques(found),
            "What the corner costs: contour error of CDAC over the greatest torque that a motor gave.  Round: motors "
            f"of {', '.join(f'{torque:.0f}' for torque in TORQUES)} N m and without a limit.  Square: without a limit, "
            "the corner on a sample, at three sample rates; 10 kHz with K_D / M = 5000 1/s.",
        ),
        (
            "lyapunov", _lyapunov(found),
            "The Lyapunov function where its assumptions hold, and its parts: sigma' M sigma / 2, and what the "
            "estimates lack of the truth.",
        ),
    ]  # fmt: skip
    out = []
    for name, ax, caption in drawn:
        figure = ax.figure
        write_atomic(folder / f"{name}.png", lambda file, f=figure: f.savefig(file, dpi=DPI, format="png"))
        out.append(Figure(f"{name}.png", caption))
    return out


def _caption(case: Case, what: str) -> str:
    return (
        f"Figure 2: {what.lower()} on the circle; sampling and encoder: {_micro(case)}.  CDAC and FCDAC start with "
        "parameters 20 % off; the peaks at both ends are start and stop."
    )


def _circle(found: Results, case: Case, what: str) -> Any:
    panels = style.new_panels(len(LAWS), (7.6, 6.4))
    scale, unit = (UM, "µm") if what == "contour" else (ARCMIN, "arcmin")
    for i, (law, ax) in enumerate(zip(LAWS, panels, strict=True)):
        turn = found.turn(law, case)
        error = getattr(turn, what) / scale
        rows = thin(error)
        ax.plot(turn.t[rows], error[rows], linewidth=0.8, color=style.COLOURS[i])
        for value, text in _printed(law, what):
            _published(ax, value, f"published:\n{text}")
        if what == "contour" and law != "CCTPID":
            ax.annotate("published: under 20 µm, off this scale", (0.995, 0.97), xycoords="axes fraction", ha="right",
                        va="top", fontsize=8, color=FAINT)  # fmt: skip
        head = f"{law}: {what} error on the circle, {_micro(case)}"
        style.label(ax, head, "time [s]" if law == LAWS[-1] else "", f"error [{unit}]")
    panels[0].set_ylim(0, None)
    return panels[0]


def _printed(law: str, what: str) -> list[tuple[float, str]]:
    """What the paper prints of a law's error on the circle."""
    if what == "contour":
        glitches = [(10, "six of 10 µm"), (3, "six of 3 µm")]
        return glitches if law == "CCTPID" else []  # 20 um, below which the adaptive laws are, is off the scale
    return [] if law == "CCTPID" else [(0.08, "at most 0.08'")]


def _micro(case: Case) -> str:
    return case.name.replace(" um", " µm")


def _corner(passed: dict[str, Passed], published: float) -> Any:
    ax = style.new_axes((6.4, 3.6))
    for law, run in passed.items():
        near = (run.t >= WINDOW[0]) & (run.t <= WINDOW[1])
        ax.plot(1e3 * run.t[near], run.contour[near] / UM, linewidth=1.1, label=law)
    _published(ax, published, f"published:\n{published} µm")
    ax.set_ylim(0, None)
    style.label(ax, f"Corner, {_micro(FAST)}", "time from the corner [ms]", "contour error [µm]")
    style.legend_above(ax)
    return ax


def _torques(found: Results) -> Any:
    corners, true = found.corners, machine()
    ax = style.new_axes((6.4, 4.2))
    fine = np.geomspace(TORQUES[0], 5000, 60)
    for label, acceleration, error, colour in (
        ("least without preview", bounds.greatest, bounds.unseen, style.COLOURS[1]),
        ("shortest turn with preview", bounds.straight, bounds.previewed, style.COLOURS[0]),
    ):
        values = [error(acceleration(true, torque)) / UM for torque in fine]
        ax.plot(fine, values, linewidth=1.0, color=colour, label=label)
    fast, slow = (corners.waits["CDAC", case.name][0] for case in (FAST, SLOW))  # the corner on a sample
    runs = {
        "no preview, 4 kHz": [*corners.sharp.values(), fast],
        "previewed, 10 kHz": [*(run for run, _ in corners.previewed.values()), corners.free],
    }
    for (label, passed), colour in zip(runs.items(), (style.COLOURS[1], style.COLOURS[0]), strict=True):
        _points(ax, passed, "o", color=colour, label=label)
    rates = {"1 kHz": slow, "4 kHz": fast, "10 kHz": corners.quick["CDAC"]}
    _points(ax, list(rates.values()), "s", color=style.COLOURS[2], label="no preview, no limit", fillstyle="none")
    for name, run in rates.items():
        ax.annotate(name, (run.torque, run.error / UM), (0, 8), textcoords="offset points", ha="center", fontsize=8,
                    color=style.INK)  # fmt: skip
    _published(ax, 15, "published:\n15 µm")
    for axis, scale in ((ax.xaxis, ax.set_xscale), (ax.yaxis, ax.set_yscale)):
        scale("log")
        axis.set_major_formatter("{x:g}")
    style.label(ax, "The corner at 0.2 m/s", "greatest motor torque [N m]", "contour error [µm]")
    style.legend(ax, loc="upper right")
    return ax


def _lyapunov(found: Results) -> Any:
    course = found.of["Lyapunov function"]
    ax = style.new_axes((6.4, 3.6))
    sigma = f"of sigma, at most {course.parts[:, 0].max():.1g} J"
    names = (sigma, "of the inertial estimates", "of the Coulomb estimates", "of the viscous estimates")
    ax.plot(course.t, course.V, linewidth=1.4, color=style.INK, label="V")
    for name, part in zip(names, course.parts.T, strict=True):
        ax.plot(course.t, part, linewidth=0.9, label=name)
    ax.set_ylim(0, 1.45 * course.V[0])  # room for the legend
    style.label(ax, "Lyapunov function, continuous limit", "time [s]", "V [J]")
    style.legend(ax, loc="upper right", ncols=2)
    return ax


def _published(ax: Any, value: float, text: str) -> None:
    ax.axhline(value, color="#8a939c", linewidth=0.9, linestyle=(0, (5, 3)))
    ax.annotate(text, (1.005, value), xycoords=("axes fraction", "data"), va="center", fontsize=8, color=FAINT)


def _points(ax: Any, passed: Sequence[Passed], marker: str, **options: Any) -> None:
    torques, errors = [run.torque for run in passed], [run.error / UM for run in passed]
    ax.plot(torques, errors, marker, markersize=6, linestyle="", **options)
