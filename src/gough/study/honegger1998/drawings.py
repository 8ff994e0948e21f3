"""Figures 6 to 8 of the paper, redrawn with ours."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...files import write_atomic
from ...report import style
from ...report.prepare import thin
from ..study import Figure
from .circle import RADIUS, Turn
from .experiments import FAST, Results
from .learning import Learned

DPI = 150
MAGNIFIED = 40


def figures(results: Sequence[Any], folder: Path) -> list[Figure]:
    """Draw all of them into `folder`."""
    found = Results(results)
    pd = {f"PD, {speed:g} m/s": turn for speed, turn in found.pd.items()}
    both = {f"PD, {FAST:g} m/s": found.pd[FAST], f"computed torque, {FAST:g} m/s": found.ctc}
    drawn = [
        ("figure_6", _learned(found.turned[8], "Learning, lines with turns of ±8°"),
         "Figure 6: the estimates over the truth while the machine moves, from half of it."),
        ("figure_6_translation", _learned(found.translation, "Learning, translation"),
         "The same from a translation, as in the paper: the inertias (dashed) are not shown and stay."),
        ("friction_drift", _learned(found.drift, "Friction drifts", limits=(0.85, 1.1)),
         "Friction grows by 20 % in ten minutes: the estimates over the truth of the moment."),
        ("figure_7", _circle(pd, "Linear axis controllers"), f"Figure 7: errors magnified {MAGNIFIED} times."),
        ("figure_8", _circle(both, "Linear and nonlinear control"), f"Figure 8: errors magnified {MAGNIFIED} times."),
    ]  # fmt: skip
    out = []
    for name, ax, caption in drawn:
        figure = ax.figure
        write_atomic(folder / f"{name}.png", lambda file, f=figure: f.savefig(file, dpi=DPI, format="png"))
        out.append(Figure(f"{name}.png", caption))
    return out


GROUPS = {  # start of a parameter's name -> what one colour stands for
    "friction.coulomb": "Coulomb friction", "friction.viscous": "viscous friction", "platform.I": "inertias",
    "platform.m c": "first moment", "platform.m": "platform mass", "carriage.m": "motor mass",
}  # fmt: skip


def _learned(run: Learned, title: str, limits=(0.0, 1.6)) -> Any:
    ax = style.new_axes((7.2, 4.0))
    told: set[str] = set()
    colours: dict[str, str] = {}
    for j, name in enumerate(run.names):
        true = run.true[:, j]
        if not true.all():  # what is 0 has no share
            continue
        group = next(told_as for start, told_as in GROUPS.items() if name.startswith(start))
        colour = colours.setdefault(group, style.COLOURS[len(colours) % len(style.COLOURS)])
        share = run.p[:, j] / true
        rows = thin(share)
        label = None if group in told else group
        told.add(group)
        dash = "--" if name.startswith("platform.I") else "-"
        ax.plot(run.t[rows] / 60, share[rows], dash, linewidth=0.9, color=colour, label=label)
    ax.set_ylim(*limits)
    style.label(ax, title, "time [min]", "estimate over truth")
    style.legend(ax, loc="lower right", ncols=3)
    return ax


def _circle(turns: dict[str, Turn], title: str) -> Any:
    ax = style.new_axes((5.6, 5.8))
    around = np.linspace(0, 2 * np.pi, 361)
    ax.plot(
        1e3 * RADIUS * np.cos(around), 1e3 * RADIUS * np.sin(around), color="#8a939c", linewidth=0.9, label="circle"
    )
    for name, turn in turns.items():
        r = 1e3 * (RADIUS + MAGNIFIED * turn.error)
        ax.plot(r * np.cos(turn.angle), r * np.sin(turn.angle), linewidth=1.1, label=name)
    ax.set_aspect("equal")
    style.label(ax, f"{title}, errors {MAGNIFIED} times", "x [mm]", "y [mm]")
    style.legend(ax, loc="center")
    return ax
