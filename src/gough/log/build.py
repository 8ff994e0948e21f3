"""From the arrays of a run to a labelled dataset: one table says dimensions, units and meaning of each variable.

    builder = LogBuilder(t, task=machine.task, joints=6)
    builder.add("q_r", q_r)                                  a variable of VARIABLES
    builder.add("controller.integral", z, units="N")         a state: owner.name
    log = builder.build(info, status="failed", reason="...")

A state has the dimensions (t, joint) if it has as many entries as there are joints, else (t, task) if as many as task
coordinates, else one of its own; where that guess is wrong (on a hexapod both are six) `dims` tells better.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr

from ..errors import LogError, did_you_mean
from ..measure.tree import columns, told

if TYPE_CHECKING:
    from .log import Log

SCHEMA = "gough-log-1"
PREFIX = "metrics."  # of the variables of a batch that hold metrics
DIMENSIONS = ("t", "joint", "task", "twist", "wrench_axis", "run")
OWNERS = ("controller", "observer", "plant")


class Variable(NamedTuple):
    """What is known of a variable before it has values."""

    dims: tuple[str, ...]  # behind t (and run)
    units: str  # "task" and "task/s" stand for the units of the machine's task coordinates
    long_name: str
    dtype: str = "f8"


VARIABLES: dict[str, Variable] = {
    "x_r": Variable(("task",), "task", "reference of the task coordinates, tool in W"),
    "x": Variable(("task",), "task", "true task coordinates, tool in W"),
    "xd_r": Variable(("twist",), "task/s", "reference of the task rate"),
    "xd": Variable(("twist",), "task/s", "true task rate"),
    "q_r": Variable(("joint",), "m", "reference of the joint coordinates"),
    "q": Variable(("joint",), "m", "true joint coordinates"),
    "q_m": Variable(("joint",), "m", "measured joint coordinates"),
    "u_c": Variable(("joint",), "N", "commanded joint forces"),
    "u": Variable(("joint",), "N", "applied joint forces"),
    "friction": Variable(("joint",), "N", "friction forces in the joints"),
    "saturated": Variable(("joint",), "1", "drive at its limit", "i1"),
    "encoder_flag": Variable(("joint",), "1", "encoder found to read what no force explains", "i1"),
    "stopping": Variable((), "1", "on the way to rest, or at rest, after a safe stop began", "i1"),
    "wrench": Variable(("wrench_axis",), "N, N m", "wrench on the tool, at the tip, in W"),
    "cutting_force": Variable(("wrench_axis",), "N, N m", "mean wrench of the cut over the last sample, as wrench"),
    "wrench_hat": Variable(("wrench_axis",), "N, N m", "estimated wrench on the tool, at the tip, in W"),
    "s_r": Variable((), "m", "path length of the reference"),
    "line": Variable((), "1", "line of the NC program, 0: none", "i4"),
    "block": Variable((), "1", "block of the motion", "i4"),
    "counted": Variable((), "1", "feed move, counted in the metrics", "i1"),
    "contour_error": Variable((), "m", "distance of the tool tip to the programmed path"),
    "orientation_error": Variable((), "rad", "angle between true and programmed tool axis"),
    "lag": Variable((), "m", "path length the tool is behind the reference"),
    "circle": Variable((), "1", "number of the circle, 0: not on a circle", "i2"),
    "radial_error": Variable((), "m", "signed error of the radius, outside +, 0 off circles"),
}

_STATE = re.compile(rf"({'|'.join(OWNERS)})\.([A-Za-z_][A-Za-z0-9_]*(?:\.[A-Za-z_][A-Za-z0-9_]*)*)")


class LogBuilder:
    """Collects the arrays of one run (or of a batch of `runs`) and makes the Log.

    Parameters
    ----------
    t : (n,) s
        times of the rows, rising.
    task : names and units of the task coordinates, as `machine.task`.
    joints : number of joints.
    runs : number of runs of a batch; arrays are then (n, runs, ...), else (n, ...).

    What is the same in all runs of a batch is given once, `add(..., shared=True)`, and has no axis of the runs.
    """

    def __init__(self, t: Any, task: Sequence[tuple[str, str]], joints: int, runs: int | None = None):
        self.t = np.asarray(t, float)
        self.task = tuple((str(name), str(unit)) for name, unit in task)
        self.sizes = {"joint": joints, "task": len(task), "twist": len(task), "wrench_axis": 6}
        self.runs = runs
        self.variables: dict[str, tuple] = {}
        if self.t.ndim != 1:
            raise LogError("t must be one column of times", key="t", value=f"shape {self.t.shape}")

    def add(
        self,
        name: str,
        values: Any,
        dims: Sequence[str] | None = None,
        units: str = "",
        long_name: str = "",
        shared: bool = False,
    ) -> None:
        """Give a variable its values, (n, ...) or (n, runs, ...); in a batch (n, ...) where `shared`.

        `dims` (behind t and run), `units` and `long_name` are for states; variables of the table have theirs.

        Raises
        ------
        LogError
            the name is neither in the table nor `owner.state`; the shape is wrong; a whole number is not finite.
        """
        values = np.asarray(values)
        known = VARIABLES.get(name)
        lead = (len(self.t),) if self.runs is None or shared else (len(self.t), self.runs)
        if known is None:
            known = self._state(name, values.shape[len(lead) :], dims, units, long_name)
        shape = lead + tuple(self.sizes[dim] for dim in known.dims)
        if values.shape == shape[:-1] and shape[-1] == 1 and name not in VARIABLES:
            values = values[..., None]  # a state of an only joint came as a single number
        if values.shape != shape:
            raise LogError("the shape is wrong", key=name, value=str(values.shape), limit=str(shape))
        if known.dtype != "f8" and values.dtype.kind == "f" and not np.all(np.isfinite(values)):
            raise LogError("a variable of whole numbers must be finite", key=name, value="nan or inf")
        attrs = {"units": self._units(known.units), "long_name": known.long_name}
        attrs |= self._components(known)
        dims_all = ("t", "run")[: len(lead)] + known.dims
        self.variables[name] = (dims_all, values.astype(known.dtype, copy=False), attrs)

    def add_runs(self, metrics: Sequence[Mapping[str, Any]], failed: Any) -> None:
        """Give a batch what each run came to: `failed` (runs,), and metrics as variables "metrics.<name>" (run,)."""
        for name, values in columns(metrics).items():
            unit, meaning = told(name)
            self.variables[f"{PREFIX}{name}"] = (("run",), values, {"units": unit, "long_name": meaning})
        self.variables["failed"] = (
            ("run",), np.asarray(failed, "i1"), {"units": "1", "long_name": "whether the run failed"},
        )  # fmt: skip

    def build(self, info: Mapping[str, Any], status: str = "done", reason: str = "") -> Log:
        """The Log.  `info` becomes the JSON attribute "gough" (numbers that are not finite become null).

        Raises
        ------
        LogError
            status is neither "done" nor "failed", or a failure gives no reason.
        """
        from .log import Log

        if status not in ("done", "failed"):
            raise LogError("status is done or failed", key="status", value=repr(status))
        if status == "failed" and not reason:
            raise LogError("a failed run must give its reason", key="reason")
        time = ("t", self.t, {"units": "s", "long_name": "time"})
        # HDF5 texts hold neither NUL nor half a surrogate pair; in the JSON both are escaped
        reason = reason.replace("\0", "").encode(errors="replace").decode()
        text = json.dumps(plain(info), allow_nan=False)
        attrs = {"status": status, "reason": reason, "schema": SCHEMA, "gough": text}
        return Log(xr.Dataset(self.variables, coords={"t": time}, attrs=attrs))

    def _state(self, name: str, size: tuple, dims: Sequence[str] | None, units: str, long_name: str) -> Variable:
        match = _STATE.fullmatch(name)
        if not match:
            raise LogError(
                "no such variable",
                key=name,
                cure=f"{did_you_mean(name, VARIABLES)} States are named owner.name, "
                f"the owner one of {', '.join(OWNERS)}",
            )
        if dims is None:
            dims = tuple(self._dimension(name, i, n) for i, n in enumerate(size))
        for dim, n in zip(dims, size or (1,) * len(dims), strict=False):
            self.sizes.setdefault(dim, n)
        return Variable(tuple(dims), units or "1", long_name or f"state {match[2]} of the {match[1]}")

    def _dimension(self, name: str, axis: int, size: int) -> str:
        if axis == 0 and size in (self.sizes["joint"], self.sizes["task"]):
            return "joint" if size == self.sizes["joint"] else "task"
        return f"{name.replace('.', '_')}_{'ijkl'[axis]}"

    def _units(self, units: str) -> str:
        return ", ".join(dict.fromkeys(self._task_units(units))) if units.startswith("task") else units

    def _task_units(self, units: str) -> list[str]:
        return [unit + units.removeprefix("task") for _, unit in self.task]

    def _components(self, known: Variable) -> dict[str, str]:
        """Names and units of the entries of a row, where they differ."""
        names: Sequence[str]
        if known.units.startswith("task"):
            names, units = [name for name, _ in self.task], self._task_units(known.units)
            if known.dims == ("twist",):  # w are no rates of a b c
                names = ("vx", "vy", "vz", "wx", "wy", "wz") if len(names) == 6 else [f"v{name}" for name in names]
        elif known.dims == ("wrench_axis",):
            names, units = ("fx", "fy", "fz", "mx", "my", "mz"), ["N"] * 3 + ["N m"] * 3
        else:
            return {}
        return {"components": ", ".join(names), "component_units": ", ".join(units)}


def plain(value: Any) -> Any:
    """`value` in the types of JSON: arrays as lists, numbers that are not finite as None, keys as text."""
    if isinstance(value, Mapping):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(inner) for inner in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, str | bool | int):
        return value
    return str(value)
