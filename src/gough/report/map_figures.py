"""Maps of plan/ as figures: a line over one coordinate, an image over two, slices of an image over more."""

from __future__ import annotations

import json
import re
from typing import Any

import numpy as np

from ..errors import ExperimentError, did_you_mean
from ..plan.findings import LABELS, findings, place_text
from ..plan.quantities import SHOWN, WORST
from . import style

# name: (unit for the eye, factor from SI)
_EYE = {"N": ("kN", 1e-3), "N/m": ("N/um", 1e-6), "m": ("um", 1e6), "rad/s": ("deg/s", 180 / np.pi),
        "rad/s2": ("deg/s2", 180 / np.pi)}  # fmt: skip
_EYE_OF = {"depth": ("mm", 1e3), "depth_here": ("mm", 1e3)}  # as people set it
_AXIS = {"m": ("mm", 1e3), "rad": ("deg", 180 / np.pi)}


def map_figure(dataset, name: str) -> Any:
    """The figure of a map by its name ("dexterity", "chatter"), or of any number that it holds ("frequency", "sag").

    The worst pose is a circle, the edge of the declared workspace a line; where the machine cannot stand it is grey.
    The map of the workspace shows what is left of the nearest limit, negative beyond it, and the limits' names.  What
    comes is a matplotlib Figure.

    Raises
    ------
    ExperimentError
        the dataset holds no such map or number; no pose of it has one.
    """
    shown = SHOWN.get(name, name)
    if name == "gravity" and shown not in dataset:  # a drive without a limit
        shown = "holding"
    if shown not in LABELS or shown not in dataset:
        there = [one for one in (*SHOWN, *LABELS) if SHOWN.get(one, one) in dataset]
        raise ExperimentError("the map holds no such thing", key="name", value=repr(name)[:60],
                              cure=did_you_mean(str(name), there))  # fmt: skip
    if not np.isfinite(dataset[shown].values).any():
        raise ExperimentError("no pose of the map has this number", key="name", value=name, cure="move the slice (at)")
    return _workspace(dataset) if shown == "reserve" else _panels(dataset, shown)


def _panels(dataset, shown: str) -> Any:
    si = dataset[shown].attrs["units"]
    unit, factor = _EYE_OF.get(shown) or _EYE.get(si, (si, 1.0))
    values = factor * dataset[shown].values
    values = np.where(np.isfinite(values), values, np.nan)  # no lobe at this speed: any depth, which is no colour
    label = LABELS[shown] if unit == "1" else f"{LABELS[shown]} [{unit}]"
    title = f"{_machine(dataset)}: {_worst(dataset, shown, unit, factor)}"
    if values.ndim == 1:
        return _line(dataset, values, label, title)
    slices = _slices(dataset, shown)
    panels = _grid_of(dataset, len(slices))
    ends = [np.nanmin(values), np.nanmax(values)]
    if ends[1] - ends[0] < 1e-6 * abs(ends[1]):  # the same everywhere: rounding is no picture
        ends = [ends[0] - 0.05 * abs(ends[0]) - 1e-12, ends[1] + 0.05 * abs(ends[1]) + 1e-12]
    place = findings(dataset)["worst"].get(shown)
    image = None
    for ax, (told, index) in zip(panels, slices, strict=False):
        image = _image(ax, dataset, values[index], vmin=ends[0], vmax=ends[1], cmap="cividis")
        _edge(ax, dataset, index)
        if place is not None and "everywhere" not in place:
            _mark(ax, dataset, index, place["pose"])
        _name(ax, dataset, told)
    _finish(panels, image, label, title)
    return panels[0].figure


def _workspace(dataset) -> Any:
    """What is left of the nearest limit, and which one it is."""
    values = dataset["reserve"].values
    reached = findings(dataset)["reached"]
    told = "" if reached is None else f": {100 * reached:.4g} % of the declared workspace is reached"
    title = f"{_machine(dataset)}{told}"
    label = LABELS["reserve"]
    if values.ndim == 1:
        return _line(dataset, values, label, title)
    slices = _slices(dataset, "reserve", 3)
    panels = _grid_of(dataset, 2 * len(slices), columns=2)
    top, beyond = max(1e-9, float(np.nanmax(values))), float(np.nanmin(values)) < 0
    # beyond a limit in another colour, as deep as the middle is high
    look = {"vmin": -top, "vmax": top, "cmap": "RdYlBu"} if beyond else {"vmin": 0, "vmax": top, "cmap": "cividis"}
    sorts, groups = _sorts(dataset)
    image = None
    for k, (slice_told, index) in enumerate(slices):
        left, right = panels[2 * k : 2 * k + 2]
        image = _image(left, dataset, values[index], **look)
        x, y, _ = _xy(dataset, values[index])
        some = np.nan_to_num(values[index], nan=-1.0)
        if (some >= 0).any() and (some < 0).any():
            left.contour(x, y, some.T, levels=[0.0], colors=[style.INK], linewidths=1.4)
        _edge(left, dataset, index)
        _edge(right, dataset, index)
        numbers = np.array([np.nan, *groups])[dataset["limit"].values[index] + 1]
        _image(right, dataset, numbers, vmin=-0.5, vmax=len(style.COLOURS) - 0.5, cmap=_colours())
        _name(left, dataset, slice_told)
        _name(right, dataset, slice_told)
    _legend(panels[1], dataset, sorts)
    _finish(panels[0::2], image, label, title)
    return panels[0].figure


def _sorts(dataset) -> tuple[list[str], list[int]]:
    """Sorts of limits in their order ("too long"), and the colour of the sort of each limit."""
    names = [_sort(name) for name in dataset["limit"].attrs["flags"].split("; ")]
    sorts = list(dict.fromkeys(names))
    return sorts, [sorts.index(name) % len(style.COLOURS) for name in names]


def _sort(name: str) -> str:
    """The name without the number of its joint."""
    return re.sub(r" \d+(?=:)", "", name)


def _colours() -> Any:
    from matplotlib.colors import ListedColormap

    return ListedColormap(style.COLOURS)


def _legend(ax, dataset, sorts) -> None:
    """The sorts of limits that are the nearest somewhere on the map."""
    from matplotlib.patches import Patch

    names = dataset["limit"].attrs["flags"].split("; ")
    there = {_sort(names[int(number)]) for number in np.unique(dataset["limit"].values) if number >= 0}
    handles = [
        Patch(color=style.COLOURS[k % len(style.COLOURS)], label=sort.replace(": ", ":\n"))
        for k, sort in enumerate(sorts) if sort in there
    ]  # fmt: skip
    style.legend(ax, handles=handles, loc="upper left", bbox_to_anchor=(1.0, 1.0), title="nearest limit")


def _line(dataset, values, label: str, title: str) -> Any:
    ax, axis = style.new_axes((6.4, 3.6)), dataset["inside"].dims[0]
    unit, factor = _AXIS[dataset[axis].attrs["units"]]
    ax.plot(factor * dataset[axis].values, values)
    style.label(ax, title, f"{axis} [{unit}]", label)
    return ax.figure


def _slices(dataset, shown: str, most: int = 6) -> list[tuple[str, tuple]]:
    """(what it is, index) of slices over the first two dimensions: along the third, all or evenly some; those of
    more dimensions where the worst pose is; the worst pose is on one of them."""
    dims = dataset["inside"].dims
    if len(dims) == 2:
        return [("", (slice(None), slice(None)))]
    row = findings(dataset)["worst"].get(shown)
    worst = [0 if row is None else int(np.abs(dataset[dim].values - row["pose"][dim]).argmin()) for dim in dims[2:]]
    third = np.linspace(0, dataset.sizes[dims[2]] - 1, min(most, dataset.sizes[dims[2]])).round().astype(int)
    third[np.abs(third - worst[0]).argmin()] = worst[0]
    out = []
    for place in ((i, *worst[1:]) for i in third):
        told = []
        for dim, i in zip(dims[2:], place, strict=True):
            unit, factor = _AXIS[dataset[dim].attrs["units"]]
            told.append(f"{dim} {factor * float(dataset[dim].values[i]):.4g} {unit}")
        out.append((", ".join(told), (slice(None), slice(None), *place)))
    return out


def _grid_of(dataset, count: int, columns: int = 3) -> list[Any]:
    columns = min(columns, count)
    rows = -(-count // columns)
    grid = style.new_grid(rows, columns, (1.6 + 4.0 * columns, 0.7 + 3.7 * rows))
    panels = [ax for row in grid for ax in row]
    for ax in panels[count:]:
        ax.set_visible(False)
    return panels[:count]


def _xy(dataset, values):
    """Edges and values for pcolormesh: the first dimension across."""
    first, second = dataset["inside"].dims[:2]
    x, y = (_AXIS[dataset[dim].attrs["units"]][1] * dataset[dim].values for dim in (first, second))
    return x, y, values


def _image(ax, dataset, values, **look) -> Any:
    x, y, _ = _xy(dataset, values)
    ax.set_facecolor("#d9dde1")
    ax.grid(False)
    units = {dataset[dim].attrs["units"] for dim in dataset["inside"].dims[:2]}
    if len(units) == 1:
        ax.set_aspect("equal")
    return ax.pcolormesh(x, y, np.ma.masked_invalid(values.T), shading="nearest", rasterized=True, **look)


def _edge(ax, dataset, index) -> None:
    """The edge of the declared workspace."""
    if "declared" not in dataset:
        return
    declared = dataset["declared"].values[index]
    if declared.any() and not declared.all():
        x, y, _ = _xy(dataset, declared)
        for colour, width, line in ((style.INK, 2.2, "-"), ("white", 1.0, "--")):  # seen on dark and on pale
            ax.contour(x, y, declared.T.astype(float), levels=[0.5], colors=[colour], linewidths=width, linestyles=line)


def _mark(ax, dataset, index, pose) -> None:
    dims = dataset["inside"].dims
    for dim, i in zip(dims[2:], index[2:], strict=True):
        if float(dataset[dim].values[i]) != pose[dim]:
            return
    x, y = (_AXIS[dataset[dim].attrs["units"]][1] * pose[dim] for dim in dims[:2])
    ax.plot(x, y, "o", markersize=6, markerfacecolor="none", markeredgecolor="#D55E00", markeredgewidth=1.6)


def _name(ax, dataset, told: str) -> None:
    first, second = dataset["inside"].dims[:2]
    style.label(ax, told, *(f"{dim} [{_AXIS[dataset[dim].attrs['units']][0]}]" for dim in (first, second)))


def _finish(panels, image, label: str, title: str) -> None:
    figure = panels[0].figure
    figure.colorbar(image, ax=panels, label=label)
    figure.suptitle(style.verbatim(title), x=0.01, ha="left", fontsize=11, weight="bold", color=style.INK)


def _machine(dataset) -> str:
    told = json.loads(dataset.attrs["gough"])
    fixed = place_text(dict(told["fixed"].items()))
    return told["machine"]["name"] + (f" at {fixed}" if fixed.strip(" m") else "")


def _worst(dataset, shown: str, unit: str, factor: float) -> str:
    row = findings(dataset)["worst"].get(shown)
    if row is None:  # of a number none of which is the worst
        return LABELS[shown]
    if "everywhere" in row:
        return f"{factor * row['value']:.4g}{'' if unit == '1' else ' ' + unit} everywhere"
    word = "least" if WORST[shown] is min else "greatest"
    return f"{word} {factor * row['value']:.4g}{'' if unit == '1' else ' ' + unit} (o)"
