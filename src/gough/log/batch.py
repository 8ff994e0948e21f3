"""Batches: what a log with the dimension `run` says of each run, and the log of one of them.

    metrics.contour_error.max (run,)      every metric is a variable; NaN where nothing was measured
    failed (run,)                         whether the run failed
    info["runs"]                          per run: label, status, reason, seed, rows, and what its plant and its law
                                          have that the first run's have not

What the reference alone decides (x_r, q_r, s_r, line, block, counted) has no axis of the runs.  Rows of a run behind
its end are NaN, whole numbers there 0.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..errors import LogError, did_you_mean
from ..measure.tree import WHOLE, leaves, nested
from .build import PREFIX, plain


def changes(table: Mapping[str, Any], first: Mapping[str, Any]) -> dict[str, Any]:
    """Dotted keys of `table` whose values are not those of `first`; None where it has none.  Sources do not count."""
    old, new = ({k: v for k, v in leaves(one) if "source." not in k} for one in (first, table))
    return {k: new.get(k) for k in dict.fromkeys([*new, *old]) if new.get(k) != old.get(k)}


def merged(first: Mapping[str, Any], changed: Mapping[str, Any]) -> dict[str, Any]:
    """The table whose `changes` against `first` are `changed`."""
    out = {k: merged(v, {}) if isinstance(v, Mapping) else v for k, v in first.items()}
    for name, value in changed.items():
        *path, last = name.split(".")
        inner = out
        for part in path:
            inner = inner.setdefault(part, {})
        if value is None:
            inner.pop(last, None)
        else:
            inner[last] = value
    return out


def metrics(dataset: Any) -> dict[str, Any]:
    """The metrics of all runs: nested as those of one run, each an array (runs,)."""
    found = {
        name.removeprefix(PREFIX): dataset[name].values
        for name in map(str, dataset.data_vars)
        if name.startswith(PREFIX)
    }
    return nested(found)


def metrics_of(dataset: Any, index: int) -> dict[str, Any]:
    """The metrics of one run, as it had them alone."""
    found = {}
    for name, values in leaves(metrics(dataset)):
        value = float(values[index])
        whole = name.rpartition(".")[2] in WHOLE
        found[name] = None if not math.isfinite(value) else int(value) if whole else value
    return nested(found)


def number(runs: Sequence[Mapping[str, Any]], count: int, which: Any) -> int:
    """The number of a run, from 0, of its number or label.

    Raises
    ------
    LogError
        there is no such run.
    """
    names = [str(run.get("label")) for run in runs]
    if isinstance(which, str):
        if which in names:
            return names.index(which)
        raise LogError("the log has no such run", key="run", value=repr(which), cure=did_you_mean(which, names))
    if isinstance(which, bool) or not isinstance(which, int | np.integer):
        raise LogError("a run goes by its number or its label", key="run", value=repr(which))
    if not -count <= which < count:
        raise LogError("the log has no such run", key="run", value=str(which), limit=f"{count} runs")
    return int(which) % count


def one(log: Any, which: Any) -> Any:
    """The Log of one run of a batch: its rows up to its end, its metrics, status and reason."""
    import json

    from .log import Log

    if not log.batch:
        raise LogError("the log holds one run", key="run", cure="it is that log itself")
    dataset, info = log.dataset, dict(log.info)
    runs = info.pop("runs", None) or []
    i = number(runs, dataset.sizes["run"], which)
    told = runs[i] if i < len(runs) else {}
    inner = dataset.drop_vars([v for v in map(str, dataset.data_vars) if v == "failed" or v.startswith(PREFIX)])
    inner = inner.isel(run=i) if "run" in inner.dims else inner
    if told.get("rows") is not None:
        inner = inner.isel(t=slice(0, told["rows"]))
    for name in ("plant", "controller"):
        if name in info:
            info[name] = merged(info[name], told.get(name) or {})
    info |= {name: told[name] for name in ("label", "reversals", "simulated_time") if name in told}
    if "run" in info and "seed" in told:
        info["run"] = info["run"] | {"seed": told["seed"]}
    info["metrics"] = metrics_of(dataset, i)
    inner.attrs = dataset.attrs | {
        "status": told.get("status", "done"),
        "reason": told.get("reason", ""),
        "gough": json.dumps(plain(info), allow_nan=False),
    }
    return Log(inner)
