"""Maps: what a machine can do, pose by pose over its workspace, as a labelled dataset with units.

    dataset = machine_map(gk.load_machine("nist-octahedral"), "dexterity", over=("x", "y"), points=41)

A pose counts as inside where every limit of the machine holds, as a run checks them: stroke, cones, det J and the
condition number of J.  Outside, quantities are NaN: the machine cannot stand there.  Whether a pose lies in the
declared workspace is told apart, in `declared`.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import ExperimentError, WorkspaceError, did_you_mean
from .bounds import Bounds
from .grid import Grid, grid_of
from .quantities import QUANTITIES, TOLD, Maker, checked, limits_of

if TYPE_CHECKING:
    import xarray as xr

SCHEMA = "gough-map-1"
CHUNK = 1 << 16  # poses at a time: some 50 MB of what is thrown away again


def machine_map(
    machine,
    what: str | Sequence[str] = "workspace",
    over: Sequence[str] | Mapping[str, tuple[float, float] | None] | None = None,
    at: Mapping[str, float] | None = None,
    points: int | Sequence[int] = 41,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """One or several of QUANTITIES over a grid of poses (`grid_of` explains over, at, points; SI).

    `progress(share)` is called as it goes.  Dimensions are the coordinates that run, in their order; variables have
    units and long_name as those of a log; the attributes "fixed" and "gough" say the rest.

    Raises
    ------
    ExperimentError
        no such quantity or coordinate; a machine without what the quantity is made of (limits, force, compliance).
    WorkspaceError
        no pose of the grid is within the limits of the machine; says which limit is in the way.
    """
    asked = [what] if isinstance(what, str) else list(what)
    for name in asked:
        if name not in QUANTITIES:
            cure = did_you_mean(str(name), QUANTITIES)
            raise ExperimentError("no such map", key="what", value=repr(name)[:60], cure=cure)
    if not asked:
        raise ExperimentError("is empty", key="what", cure=f"there is {', '.join(QUANTITIES)}")
    grid = grid_of(machine, over, at, points)
    return mapped(machine, asked, grid, [checked(name, machine, grid.count) for name in asked], progress)


def mapped(
    machine, asked: Sequence[str], grid: Grid, makers: Sequence[Maker], progress: Callable[[float], None] | None = None
) -> xr.Dataset:
    """The map of what `makers` make of the poses of a grid, chunk by chunk; machine_map has the rest."""
    columns, reach = {}, Reach(machine)
    for start in range(0, grid.count, CHUNK):
        stop = min(start + CHUNK, grid.count)
        x = grid.poses(start, stop)
        inside, found = reach.of(x, "workspace" in asked)
        for maker in makers:
            found |= maker(x, inside)
        for name, values in found.items():
            if name not in columns:
                columns[name] = np.empty(grid.count, values.dtype)
            columns[name][start:stop] = values
        if progress:
            progress(stop / grid.count)
    if not columns["inside"].any():
        raise _nowhere(machine, grid, reach.bounds)
    return _dataset(machine, asked, grid, columns, reach.bounds)


class Reach:
    """Whether poses are inside, how much of the nearest limit is left, and which one that is."""

    def __init__(self, machine):
        self.bounds = Bounds(machine)
        self.spaces = machine.limits.workspace is not None

    def of(self, x, details: bool = True) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Poses (N, d): inside (N,), and the columns inside, declared, with `details` reserve and limit."""
        margins, declared = self.bounds.of(x)
        inside = (margins >= 0).all(-1)
        found = {"inside": inside.astype("i1")}
        if self.spaces:
            found["declared"] = (declared >= 0).all(-1).astype("i1")
        if details:
            found["reserve"], found["limit"] = self.bounds.nearest(margins)
        return inside, found


def _nowhere(machine, grid: Grid, bounds: Bounds) -> WorkspaceError:
    """The error of a map without a pose: it names the limit that is in the way at the pose that is nearest to all."""
    best = None
    for start in range(0, grid.count, CHUNK):
        x = grid.poses(start, min(start + CHUNK, grid.count))
        margins = bounds.of(x)[0]
        share = margins / bounds.scale
        worst = np.where(np.isnan(share), -np.inf, share).min(-1)
        row = int(worst.argmax())
        if best is None or worst[row] > best[0]:
            best = (worst[row], x[row], margins[row])
    where = ", ".join(f"{name} = {value:.6g} {unit}" for (name, unit), value in zip(machine.task, best[1], strict=True))
    rule, value, limit = bounds.told(best[1], best[2])
    return WorkspaceError(
        f"the machine can stand nowhere on this map; nearest at {where}: {rule}", value=value, limit=limit,
        cure="move the slice (at), or run over more (over)",
    )  # fmt: skip


def _dataset(machine, asked, grid: Grid, columns, bounds: Bounds) -> xr.Dataset:
    import xarray as xr

    from .. import __version__

    dims = tuple(axis.name for axis in grid.axes)
    flags = {f"{name}_limit": limits_of(machine, name) for name in ("feed", "acceleration", "force")}
    flags["limit"] = bounds.names
    variables: dict[str, Any] = {}
    for name, values in columns.items():
        unit, meaning = TOLD[name]
        attrs: dict[str, Any] = {"units": unit, "long_name": meaning}
        if name in flags:
            attrs |= {"flag_values": np.arange(len(flags[name]), dtype="i2"), "flags": "; ".join(flags[name])}
        variables[name] = (dims, values.reshape(grid.shape), attrs)
    coords = {axis.name: (axis.name, axis.values, {"units": axis.unit, "long_name": f"{axis.name} of the tool in W"})
              for axis in grid.axes}  # fmt: skip
    fixed = {name: float(value) for (name, _), value in zip(machine.task, grid.fixed, strict=True) if name not in dims}
    info = {"machine": {"name": machine.name, "kind": machine.kind, "digest": machine.digest()}, "what": list(asked),
            "fixed": fixed, "length": bounds.length, "version": __version__}  # fmt: skip
    attrs = {"schema": SCHEMA, "status": "done", "reason": "", "gough": json.dumps(info, allow_nan=False)}
    return xr.Dataset(variables, coords=coords, attrs=attrs)
