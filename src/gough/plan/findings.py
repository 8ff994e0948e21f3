"""What a map says in a few lines: how much of the workspace is reached, what is in the way, where it is worst."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from ..units import show
from .quantities import WORST

if TYPE_CHECKING:
    import xarray as xr

EVERYWHERE = 1e-9  # relative: what differs by less differs by rounding


def findings(dataset: xr.Dataset) -> dict[str, Any]:
    """Numbers of a map: {"poses", "inside", "declared", "reached", "in_the_way", "worst"}.

    `reached` is the share of the declared workspace's poses that are inside (None where none is declared or none of
    the map is in it), `in_the_way` the shares of limits among the poses of the workspace (of all, without one) that
    are not, `worst` of each variable the value, the pose and what limits it there; within the declared workspace where
    there is one on the map, else wherever the machine can stand; "everywhere" if it is the same at all of them.
    """
    inside = dataset["inside"].values.astype(bool)
    declared = dataset["declared"].values.astype(bool) if "declared" in dataset else None
    known = declared is not None and declared.any()
    space = declared if known else np.ones(inside.shape, bool)
    out: dict[str, Any] = {
        "poses": int(inside.size), "inside": int(inside.sum()),
        "declared": None if declared is None else int(declared.sum()),
        "reached": float((inside & space).sum() / space.sum()) if known else None,
        "in_the_way": {}, "worst": {},
    }  # fmt: skip
    out_there = space & ~inside
    if "limit" in dataset and out_there.any():
        numbers, counts = np.unique(dataset["limit"].values[out_there], return_counts=True)
        shares = sorted(zip(counts / out_there.sum(), numbers, strict=True), reverse=True)
        out["in_the_way"] = {name_of(dataset, "limit", int(number)): float(share) for share, number in shares}
    where = inside & space if (inside & space).any() else inside
    for name, least in WORST.items():
        if name not in dataset:
            continue
        values = np.where(where, dataset[name].values, np.nan)
        if not np.isfinite(values).any():
            continue
        place = np.unravel_index(int((np.nanargmin if least is min else np.nanargmax)(values)), values.shape)
        row = {"value": float(values[place]), "unit": dataset[name].attrs["units"], "pose": pose_of(dataset, place),
               "is": "least" if least is min else "greatest"}  # fmt: skip
        if np.nanmax(values) - np.nanmin(values) <= EVERYWHERE * abs(row["value"]) and np.isfinite(values).sum() > 1:
            row["everywhere"] = True  # the pose is one of all
        flag = "limit" if name == "reserve" else f"{name}_limit"
        if flag in dataset:
            row["limit"] = name_of(dataset, flag, int(dataset[flag].values[place]))
        out["worst"][name] = row
    return out


def name_of(dataset, flag: str, number: int) -> str:
    """What a number of a variable of flags stands for."""
    return dataset[flag].attrs["flags"].split("; ")[number] if number >= 0 else "no joint coordinates have the pose"


def pose_of(dataset, place) -> dict[str, float]:
    """The coordinates of an entry: those that run and those that stand, m and rad."""
    runs = {str(dim): float(dataset[dim].values[i]) for dim, i in zip(dataset.dims, place, strict=False)}
    fixed = json.loads(dataset.attrs["gough"])["fixed"]
    return {name: (runs | fixed)[name] for name in ("x", "y", "z", "a", "b", "c") if name in runs or name in fixed}


# variable: what it is called beside a number
LABELS = {
    "reserve": "reserve of the nearest limit", "condition": "condition number", "singular_least": "singular value",
    "feed": "feed in the worst direction", "turn_rate": "angular rate about the worst axis",
    "acceleration": "acceleration in the worst direction", "angular_acceleration": "angular acceleration, worst axis",
    "force": "force in the worst direction", "holding": "drive force of the weight",
    "holding_share": "the same by the drive's limit", "stiffness_least": "stiffness, softest direction",
    "stiffness_x": "stiffness along x", "stiffness_y": "stiffness along y", "stiffness_z": "stiffness along z",
    "frequency": "first natural frequency", "sag": "sag under gravity", "depth": "depth free of chatter",
    "depth_here": "depth free of chatter at this speed", "chatter_frequency": "frequency of the chatter",
    "singular_greatest": "greatest singular value",
}  # fmt: skip


def text_of(found: dict[str, Any]) -> str:
    """The findings as lines for a terminal."""
    lines = [f"{found['inside']} of {found['poses']} poses are within all limits of the machine"]
    if found["reached"] is not None:
        share = f"{100 * found['reached']:.4g} %"
        lines.append(f"of the declared workspace ({found['declared']} poses) {share} is reached")
    for name, share in list(found["in_the_way"].items())[:5]:
        lines.append(f"  in the way at {100 * share:5.1f} % of the rest: {name}")
    if found["worst"]:
        width = max(len(LABELS[name]) for name in found["worst"])
        for name, row in found["worst"].items():
            value = f"{row['is']:8} {show(row['value'], row['unit'], 4):>12}"
            limit = f"  ({row['limit']})" if "limit" in row else ""
            where = "everywhere" if row.get("everywhere") else f"at {place_text(row['pose'])}{limit}"
            lines.append(f"{LABELS[name]:{width}}  {value}  {where}")
    return "\n".join(lines)


def place_text(pose: dict[str, float]) -> str:
    """A pose for people: mm and degrees; angles of 0 are left out."""
    parts = [f"{name} {1e3 * value:.4g}" for name, value in pose.items() if name in "xyz"]
    turned = [f"{name} {np.degrees(value):.4g}" for name, value in pose.items() if name in "abc" and value]
    return " ".join(parts) + " mm" + (f", {' '.join(turned)} deg" if turned else "")
