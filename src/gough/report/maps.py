"""Maps over the workspace of a machine with elastic joints: stiffness, first natural frequency, sag, chatter."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import ExperimentError, did_you_mean
from ..machine.vibration import stiffness_map
from ..plan.grid import grid_of, middle_of
from . import style

# name: (what is shown, unit, factor from SI, which of `stiffness_map` by the direction)
SHOWN = {
    "least": ("stiffness in the softest direction", "N/um", 1e-6),
    "x": ("stiffness along x", "N/um", 1e-6),
    "y": ("stiffness along y", "N/um", 1e-6),
    "z": ("stiffness along z", "N/um", 1e-6),
    "frequency": ("first natural frequency, joints held", "Hz", 1.0),
    "sag": ("sag of the tool under gravity", "um", 1e6),
}

CHATTER = {
    "least": ("axial depth stable at every speed", "mm", 1e3),
    "limit": ("axial depth stable at this speed", "mm", 1e3),
    "frequency": ("frequency of chatter", "Hz", 1.0),
}


def grid(machine, height: float | None = None, points: int = 21) -> np.ndarray:
    """Poses (points, points, d) over the declared workspace at `height` m of W (default: that of its middle), turned
    as home.

    Raises
    ------
    ExperimentError
        the machine declares no workspace, or has one coordinate.
    """
    space, home = machine.limits.workspace, np.asarray(machine.home)
    if space is None or len(home) < 3:
        raise ExperimentError("a map needs a declared workspace", key="limits.workspace", value=machine.name)
    found, middle = grid_of(machine, ("x", "y"), {} if height is None else {"z": height}, points), middle_of(machine)
    poses = found.poses(0, found.count).reshape(points, points, -1).swapaxes(0, 1).copy()
    if space.size is None:  # what is outside the cylinder is no pose of the workspace
        poses[np.hypot(poses[..., 0] - middle[0], poses[..., 1] - middle[1]) > space.radius * (1 + 1e-9)] = np.nan
    return poses


def workspace_map(flexible, what: str = "least", height: float | None = None, points: int = 21, ax: Any = None) -> Any:
    """One of SHOWN over x and y at a height, as an image with its scale; the least value is marked.  Axes.

    `flexible` is a machine's `flexible()`; poses where it cannot stand stay empty.
    """
    if what not in SHOWN:
        raise ExperimentError("no such map", key="what", value=repr(what)[:60], cure=did_you_mean(str(what), SHOWN))
    poses = grid(flexible.rigid, height, points)
    inside = np.isfinite(poses).all(-1)
    found = stiffness_map(flexible, poses[inside])
    if not np.isfinite(found["least"]).any():
        raise ExperimentError(
            "the machine can stand nowhere on this map", key="height",
            value="the middle" if height is None else f"{height:g} m", cure="give a height within limits.workspace",
        )  # fmt: skip
    told, unit, factor = SHOWN[what]
    values = np.full(inside.shape, np.nan)
    values[inside] = factor * (
        found["stiffness"][:, "xyz".index(what)]
        if what in ("x", "y", "z")
        else np.linalg.norm(found["sag"], axis=-1)
        if what == "sag"
        else found[what]
    )
    return _drawn(ax, flexible, poses, values, told, unit, np.nanargmax if what == "sag" else np.nanargmin)


def chatter_map(
    flexible, cutting, feed, what: str = "least", height: float | None = None, points: int = 11, ax: Any = None,
    radial: float | None = None, joints="held",
) -> Any:  # fmt: skip
    """The axial depth that is free of chatter over x and y at a height (cutting/posed.py), least value marked.  Axes.

    `what` is "least", at every spindle speed, "limit", at the cut's own, or "frequency", of the chatter; the rest is as
    `gough.cutting.posed.depth_map` takes it.
    """
    from ..cutting.posed import depth_map

    if what not in CHATTER:
        raise ExperimentError("no such map", key="what", value=repr(what)[:60], cure=did_you_mean(str(what), CHATTER))
    poses = grid(flexible.rigid, height, points)
    inside = np.isfinite(poses).all(-1)
    told, unit, factor = CHATTER[what]
    values = np.full(inside.shape, np.nan)
    values[inside] = factor * depth_map(flexible, poses[inside], cutting, feed, radial, joints)[what]
    values[~np.isfinite(values)] = np.nan
    if np.isnan(values).all():
        raise ExperimentError(
            "no cut of this kind shakes the machine anywhere at this height, or it cannot stand there", key="height",
            value="the middle" if height is None else f"{height:g} m",
        )  # fmt: skip
    return _drawn(ax, flexible, poses, values, told, unit, np.nanargmin)


def _drawn(ax, flexible, poses, values, told, unit, worst_of) -> Any:
    """Values (n, n) over x and y of poses (n, n, d) as an image; the worst is marked and told."""
    ax = ax or style.new_axes((5.6, 4.6))
    x, y = (1e3 * np.nanmean(poses[..., i], axis=i) for i in range(2))
    image = ax.pcolormesh(x, y, np.ma.masked_invalid(values), cmap="cividis", shading="nearest")
    ax.figure.colorbar(image, ax=ax, label=f"{told} [{unit}]")
    place = np.unravel_index(worst_of(values), values.shape)
    worst = values[place]
    ax.plot(x[place[1]], y[place[0]], "o", markersize=5, markerfacecolor="none", markeredgecolor="white")
    z = 1e3 * poses[place][2]
    word = "most" if worst_of is np.nanargmax else "least"
    style.label(ax, f"{flexible.name} at z = {z:g} mm: {word} {worst:.4g} {unit} (o)", "x [mm]", "y [mm]")
    ax.set_aspect("equal")
    return ax
