"""Beyond the paper: how surely the wrench is told, by pose, if each strut's friction is off by a tenth of f_0."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...cutting.uncertainty import Uncertainty, wrench_uncertainty
from ...report import style
from ..study import Beyond, Experiment, Tick
from . import setup

OFF = 0.1 * setup.F_0  # N, one deviation of each strut
MM, DEG = 1e-3, np.pi / 180
POSES = {  # beside home: x y z, a b c
    "home": (0, 0, 0, 0, 0, 0),
    "250 mm to +X": (250, 0, 0, 0, 0, 0),
    "150 mm up": (0, 0, 150, 0, 0, 0),
    "150 mm down": (0, 0, -150, 0, 0, 0),
    "tilted, A -23 deg": (0, 100, 0, -23, 0, 0),
    "tilted, B 25 deg at 150 mm": (150, 0, 0, 0, 25, 0),
    "turned, C 88 deg": (0, 0, 0, 0, 0, 88),
}
REACH = 0.3  # m, of the map


class Certainty(NamedTuple):
    """Ellipsoids at POSES, and over the plane of home."""

    at: Uncertainty
    side: np.ndarray  # (n,) m
    largest: np.ndarray  # (n, n) N, the longest half axis of the force, rows by y


def certainty(tick: Tick | None) -> Certainty:
    """One deviation of the wrench at POSES and over the workspace at home's height."""
    machine = setup.machine()
    x = machine.home + np.array(list(POSES.values()), float) * ([MM] * 3 + [DEG] * 3)
    side = np.linspace(-REACH, REACH, 31)
    X, Y = np.meshgrid(side, side)
    plane = np.tile(machine.home, (*X.shape, 1))
    plane[..., 0] += X
    plane[..., 1] += Y
    largest = wrench_uncertainty(machine, plane, OFF).force_axes[..., 0]
    return Certainty(wrench_uncertainty(machine, x, OFF), side, np.where(np.hypot(X, Y) <= REACH, largest, np.nan))


def _table(results: Sequence[Certainty]) -> list[list[str]]:
    found = results[0].at
    rows = []
    for i, name in enumerate(POSES):
        way = found.force_directions[i, :, 0]
        way = way * np.sign(way[np.argmax(np.abs(way))])
        rows.append(
            [
                name,
                " x ".join(f"{a:.1f}" for a in found.force_axes[i]) + " N",
                " ".join(f"{w:.2f}" for w in way),
                " x ".join(f"{a:.2f}" for a in found.moment_axes[i]) + " N m",
                f"{found.condition[i]:.1f}",
                "poor" if found.poor[i] else "",
            ]
        )
    return rows


def _picture(results: Sequence[Certainty]) -> Any:
    found = results[0]
    ax = style.new_axes((5.0, 4.4))
    shown = ax.contourf(1e3 * found.side, 1e3 * found.side, found.largest, 10, cmap="cividis")
    ax.figure.colorbar(shown, ax=ax, label="half axis [N]")
    ax.set_aspect("equal")
    style.label(ax, "Longest half axis of a told force", "x [mm]", "y [mm]")
    return ax


def _text(results: Sequence[Certainty]) -> str:
    found = results[0].at
    low, high = found.force_axes[:, 0].min(), found.force_axes[:, 0].max()
    return (
        f"Each strut off by {OFF:g} N, none knowing of the others: the force is told to between {low:.0f} and "
        f"{high:.0f} N in its least certain direction, which is upright or nearly so: the struts stand steeply.  The "
        "paper finds Z the worst too.  A condition number beyond the machine's warning is flagged: there a wrench may "
        "move no strut."
    )


CERTAINTY = Beyond(
    name="certainty",
    title=f"How surely a wrench is told, by pose: half axes of its ellipsoids, each strut off by {OFF:g} N",
    experiments=[Experiment("certainty by pose", certainty)],
    heads=("pose", "force", "least certain way", "moment", "condition", ""),
    table=_table,
    picture=_picture,
    text=_text,
)
