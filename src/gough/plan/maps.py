"""Maps: what a machine can do, pose by pose over its workspace, as a labelled dataset with units.

    dataset = machine_map(gk.load_machine("nist-octahedral"), "dexterity", over=("x", "y"), points=41)

A pose counts as inside where every limit of the machine holds, as a run checks them: stroke, cones, det J and the
condition number of J.  Outside, quantities are NaN: the machine cannot stand there.  Whether a pose lies in the declared
workspace is told apart, in `declared`.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import ExperimentError, WorkspaceError, did_you_mean
from ..machine.workspace import margin_names
from . import abilities
from .grid import Grid, grid_of
from .quantities import QUANTITIES, Quantities, checked

if TYPE_CHECKING:
    import xarray as xr

SCHEMA = "gough-map-1"
CHUNK = 1 << 16  # poses at a time: some 50 MB of what is thrown away again
CONDITION = "near a singularity: condition number of J"


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
            cure = f"{did_you_mean(str(name), QUANTITIES)} there is {', '.join(QUANTITIES)}"
            raise ExperimentError("no such map", key="what", value=repr(name)[:60], cure=cure)
    if not asked:
        raise ExperimentError("is empty", key="what", cure=f"there is {', '.join(QUANTITIES)}")
    grid = grid_of(machine, over, at, points)
    makers = [checked(name, machine, grid.count) for name in asked]
    columns, reach = {}, Reach(machine)
    for start in range(0, grid.count, CHUNK):
        stop = min(start + CHUNK, grid.count)
        x = grid.poses(start, stop)
        inside, found = reach.of(x, "workspace" in asked)
        for maker in makers:
            found |= maker(x, inside)
        for name, values in found.items():
            if name not in columns:
                columns[name] = np.empty((grid.count, *values.shape[1:]), values.dtype)
            columns[name][start:stop] = values
        if progress:
            progress(stop / grid.count)
    if not columns["inside"].any():
        raise _nowhere(machine, grid, reach)
    return _dataset(machine, asked, grid, columns, reach)


class Reach:
    """Whether poses are inside, how much of the nearest limit is left, and which one that is."""

    def __init__(self, machine):
        self.machine = machine
        self.spaces = len(margin_names(machine)) - len(machine.limit_names)
        self.names = (*machine.limit_names, *((CONDITION,) if len(machine.task) > 1 else ()))
        self.length = abilities.platform_length(machine)
        at_home = self._shares(np.atleast_2d(np.asarray(machine.home, float)))[0][0]
        self.scale = _scales(self.names, at_home)

    def of(self, x, details: bool = True) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Poses (N, d): inside (N,), and the columns inside, declared, with `details` reserve and limit."""
        margins, declared = self._shares(x)
        inside = (margins >= 0).all(-1)
        found = {"inside": inside.astype("i1")}
        if self.spaces:
            found["declared"] = declared.astype("i1")
        if details:
            found |= self.binding(margins)
        return inside, found

    def binding(self, margins) -> dict[str, np.ndarray]:
        """What is left of each limit's margin as a share of its scale: the least, and whose it is."""
        share = margins / self.scale
        known = np.where(np.isnan(share), np.inf, share)
        limit = known.argmin(-1)
        reserve = np.take_along_axis(known, limit[:, None], 1)[:, 0]
        # where something is no number and nothing that is one is negative, no joint coordinates have the pose
        lost = np.isnan(share).any(-1) & ~(reserve < 0)
        return {"reserve": np.where(lost, np.nan, reserve), "limit": np.where(lost, -1, limit).astype("i2")}

    def margins(self, x) -> np.ndarray:
        """Margins in the order of `names`, their own units.  (N, k)."""
        return self._shares(x)[0]

    def _shares(self, x):
        m = self.machine
        margins, space = abilities.rows_of("margins", m)(m.theta, x, self.length)
        if len(m.task) > 1:
            s = abilities.rows_of("dexterity", m)(m.theta, x, self.length)[0]
            with np.errstate(invalid="ignore", divide="ignore"):
                margins = np.concatenate([margins, s[:, :1] / s[:, 1:] - 1 / m.limits.condition], 1)
        return margins, (space >= 0).all(-1)


def _scales(names, at_home) -> np.ndarray:
    """For each limit the greatest margin at home of its sort: "strut 3: too long" is measured by that of all struts."""
    sorts = [name.rpartition(": ")[2] for name in names]
    greatest = {sort: max(at_home[i] for i, one in enumerate(sorts) if one == sort) for sort in sorts}
    return np.array([greatest[sort] if greatest[sort] > 0 else 1.0 for sort in sorts])


def _nowhere(machine, grid: Grid, reach: Reach) -> WorkspaceError:
    """The error of a map without a pose; it names the limit that is in the way at the pose that is nearest to all."""
    best = None
    for start in range(0, grid.count, CHUNK):
        x = grid.poses(start, min(start + CHUNK, grid.count))
        margins = reach.margins(x)
        share = margins / reach.scale
        worst = np.where(np.isnan(share), -np.inf, share).min(-1)
        row = int(worst.argmax())
        if best is None or worst[row] > best[0]:
            best = (worst[row], x[row], margins[row], share[row])
    _, x, margins, share = best
    where = ", ".join(
        f"{name} = {value:.6g} {unit}" for (name, unit), value in zip(machine.task, x, strict=True)
    )
    cure = "move the slice (at), or run over more (over)"
    lost = machine.unreachable(x)
    if np.isnan(share).any() and lost is not None:
        problem = lost[1].problems[0]
        value, limit, rule = problem.value, problem.limit, problem.rule
    else:
        index = int(np.nanargmin(share))
        rule, value, limit = told(machine, reach.names, index, float(margins[index]))
    return WorkspaceError(
        f"the machine can stand nowhere on this map; nearest at {where}: {rule}", value=value, limit=limit, cure=cure,
    )  # fmt: skip


def told(machine, names, index: int, margin: float) -> tuple[str, str, str]:
    """Rule, value and limit in words of the limit `index` of `names` (see Reach) that is `margin` < 0."""
    if names[index] != CONDITION:
        return machine.limit_told(index, margin)
    left = margin + 1 / machine.limits.condition
    return CONDITION, f"{1 / left:.3g}" if left > 0 else "infinite", f"{machine.limits.condition:g}"


def _dataset(machine, asked, grid: Grid, columns, reach: Reach) -> xr.Dataset:
    import xarray as xr

    from .. import __version__

    dims = tuple(axis.name for axis in grid.axes)
    flags = {
        "limit": reach.names,
        **{f"{name}_limit": Quantities(machine).limits(name) for name in ("feed", "acceleration", "force")},
    }
    variables: dict[str, Any] = {}
    for name, values in columns.items():
        unit, meaning = Quantities(machine).told(name)
        attrs: dict[str, Any] = {"units": unit, "long_name": meaning}
        if name in flags:
            attrs |= {"flag_values": np.arange(len(flags[name]), dtype="i2"), "flags": "; ".join(flags[name])}
        more = ("axis",) if values.ndim == 2 else ()
        variables[name] = (dims + more, values.reshape(grid.shape + values.shape[1:]), attrs)
    coords = {axis.name: (axis.name, axis.values, {"units": axis.unit, "long_name": f"{axis.name} of the tool in W"})
              for axis in grid.axes}  # fmt: skip
    fixed = {
        name: float(value) for (name, _), value in zip(machine.task, grid.fixed, strict=True) if name not in dims
    }
    info = {"machine": {"name": machine.name, "kind": machine.kind, "digest": machine.digest()}, "what": asked,
            "fixed": fixed, "length": reach.length, "version": __version__}  # fmt: skip
    attrs = {"schema": SCHEMA, "status": "done", "reason": "", "gough": json.dumps(info, allow_nan=False)}
    return xr.Dataset(variables, coords=coords, attrs=attrs)
