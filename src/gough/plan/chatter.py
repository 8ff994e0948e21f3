"""Maps of chatter: how deep a cut may be over the workspace of a machine that gives way (cutting/posed.py).

Beside `machine_map`, because a cut must be told: its tool, material and wall, and the way it goes.  What comes is a
dataset like any other map's, with `depth`, `depth_here` and `chatter_frequency`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import ExperimentError
from ..quantities import brief
from .grid import grid_of
from .maps import mapped
from .quantities import checked_count

if TYPE_CHECKING:
    import xarray as xr


def chatter_map(
    flexible, cutting, feed, over: Sequence[str] | Mapping[str, tuple[float, float] | None] | None = None,
    at: Mapping[str, float] | None = None, points: int | Sequence[int] = 11, radial: float | None = None,
    joints: Any = "held", progress: Callable[[float], None] | None = None,
) -> xr.Dataset:  # fmt: skip
    """The axial depth that is free of chatter over a grid of poses (`grid_of` explains over, at, points; SI).

    `flexible` is a machine's `flexible()`; feed (3,) in W, `radial` (m) and `joints` are as
    `gough.cutting.posed.depth_map` takes them.

    Raises
    ------
    ExperimentError
        no such coordinate, too many poses, a feed along the tool, or no cut of this kind shakes the machine anywhere.
    WorkspaceError
        no pose of the grid is within the limits of the machine.
    """
    from ..cutting.posed import depth_map

    grid = grid_of(flexible.rigid, over, at, points)
    checked_count("chatter", grid.count)

    def make(x: np.ndarray, inside: np.ndarray) -> dict[str, np.ndarray]:
        found = depth_map(flexible, x[inside], cutting, feed, radial, joints) if inside.any() else {}
        out = {}
        for name, told in (("depth", "least"), ("depth_here", "limit"), ("chatter_frequency", "frequency")):
            out[name] = np.full(len(x), np.nan)
            if found:
                out[name][inside] = found[told]
        return out

    dataset = mapped(flexible.rigid, ["chatter"], grid, [make], progress)
    if not np.isfinite(dataset["depth"].values).any():
        raise ExperimentError(
            "no cut of this kind shakes the machine anywhere on this map, or it cannot stand there",
            key="feed", value=brief(feed), cure="move the slice (at), or run over more (over)",
        )  # fmt: skip
    return dataset
