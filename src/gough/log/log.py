"""The Log: what happened in a run.  Labelled, with units, and it prints itself.

    log["contour_error"]      NumPy (n,)            log.dataset     xarray, every variable with units and long_name
    log.info                  what made it          log.metrics     the numbers over every sample
    log.save(path)            Log.load(path)        log.to_csv(path)    log.plot.contour()

Variables, dimensions and units: log/build.py.
"""

from __future__ import annotations

import functools
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ..errors import LogError, did_you_mean
from . import batch, export, file, text
from .build import DIMENSIONS, LogBuilder

_JOINT = re.compile(r"[A-Za-z][A-Za-z0-9 ._-]{0,39}")  # a name that no page and no template reads as more


class Log:
    """What happened in a run.

    Parameters
    ----------
    dataset : xarray.Dataset
        with the coordinate t in s, as `LogBuilder` makes it.

    Raises
    ------
    LogError
        there is no time, or a variable carries the name of a dimension.
    """

    def __init__(self, dataset: xr.Dataset):
        if not isinstance(dataset, xr.Dataset) or "t" not in dataset.coords:
            raise LogError("a log is made of an xarray.Dataset with the coordinate t", value=type(dataset).__name__)
        wrong = sorted(name for name in dataset.variables if name != "t" and name in {*DIMENSIONS, *dataset.dims})
        if wrong:
            raise LogError("a variable must not carry the name of a dimension", key=str(wrong[0]))
        self.dataset = dataset

    @staticmethod
    def build(
        t: Any,
        values: Mapping[str, Any],
        *,
        task: Sequence[tuple[str, str]],
        joints: int,
        info: Mapping[str, Any],
        status: str = "done",
        reason: str = "",
        runs: int | None = None,
    ) -> Log:
        """A log from arrays by name, in one go; see `LogBuilder` for the meaning of the arguments and errors."""
        builder = LogBuilder(t, task, joints, runs)
        for name, array in values.items():
            builder.add(name, array)
        return builder.build(info, status, reason)

    # -- what is in it ------------------------------------------------------------------------------------------

    def __getitem__(self, name: str) -> np.ndarray:
        """Values of a variable (or t), (n, ...), SI.

        Raises
        ------
        LogError
            the log has no such variable; the nearest name is said.
        """
        if name not in self.dataset.variables:
            raise LogError("the log has no such variable", key=name, cure=did_you_mean(name, map(str, self)))
        return self.dataset[name].values

    def __contains__(self, name: object) -> bool:
        return name in self.dataset.variables

    def __iter__(self) -> Iterator[str]:
        """Names of the variables."""
        return iter(map(str, self.dataset.data_vars))

    def __len__(self) -> int:
        """Number of rows."""
        return self.dataset.sizes["t"]

    @property
    def t(self) -> np.ndarray:
        """Times of the rows.  (n,) s."""
        return self["t"]

    @property
    def info(self) -> dict[str, Any]:
        """What made the log: inputs, versions, seed, hashes, metrics.  Shared: copy it before you change it.

        Raises
        ------
        LogError
            the attribute "gough" is not a JSON object.
        """
        return _parse(str(self.dataset.attrs.get("gough", "{}")))

    @property
    def metrics(self) -> dict[str, Any]:
        """The numbers of the run over every sample, SI; empty if the log was made without.

        Of a batch, each is an array (runs,), NaN where nothing was measured.
        """
        return batch.metrics(self.dataset) if self.batch else self.info.get("metrics") or {}

    @property
    def joint_names(self) -> list[str]:
        """What the machine calls its joints, "carriage 1"; struts in a log that does not say."""
        told, count = self.info.get("joint_names"), self.dataset.sizes.get("joint", 6)
        right = isinstance(told, list) and len(told) == count
        if right and all(isinstance(name, str) and _JOINT.fullmatch(name) for name in told):
            return told
        return [f"strut {i + 1}" for i in range(count)]

    @property
    def joint_word(self) -> str:
        """What the machine calls one of its joints, "carriage"; "joint" where they have no common word."""
        words = {name.rstrip("0123456789 ") for name in self.joint_names}
        return words.pop() if len(words) == 1 else "joint"

    @property
    def batch(self) -> bool:
        """Whether the log holds several runs, the dimension `run`."""
        return "run" in self.dataset.dims

    @property
    def runs(self) -> list[dict[str, Any]]:
        """Of a batch, what is known of each run: label, status, reason, seed, what differs.  Empty of one run."""
        return self.info.get("runs") or []

    def run(self, which: int | str) -> Log:
        """The Log of one run of a batch, by number from 0 or by label: up to its end, with its own metrics and status.

        Raises
        ------
        LogError
            there is no such run, or the log is no batch.
        """
        return batch.one(self, which)

    @property
    def status(self) -> str:
        """ "done" or "failed"."""
        return str(self.dataset.attrs.get("status", "done"))

    @property
    def failed(self) -> bool:
        """Whether the run failed; then `reason` says why and the rows end there."""
        return self.status != "done"

    @property
    def reason(self) -> str:
        """Why the run failed; empty if it did not."""
        return str(self.dataset.attrs.get("reason", ""))

    def units(self, name: str) -> str:
        """Units of a variable, SI, as its attribute says."""
        self[name]
        return str(self.dataset[name].attrs.get("units", "1"))

    # -- to files and back ----------------------------------------------------------------------------------------

    def save(self, path: str | Path) -> Path:
        """Write the log as NetCDF-4, at once or not at all.

        Raises
        ------
        StorageError
            the file could not be written; an old one of that name is intact.
        """
        return file.save(self.dataset, path)

    @classmethod
    def load(cls, path: str | Path) -> Log:
        """Read a log that `save` wrote.

        Raises
        ------
        LogError
            not there, no log of gough, truncated, damaged, or of another schema.
        """
        return cls(file.load(path))

    def to_csv(self, path: str | Path) -> Path:
        """Write a comment line, a header with units, and one line a row; see `export.to_csv`."""
        return export.to_csv(self, path)

    def to_mat(self, path: str | Path) -> Path:
        """Write a MATLAB 5 file; see `export.to_mat`."""
        return export.to_mat(self, path)

    def to_parquet(self, path: str | Path) -> Path:
        """Write Parquet, which needs pyarrow; see `export.to_parquet`."""
        return export.to_parquet(self, path)

    # -- to the eye -----------------------------------------------------------------------------------------------

    def __repr__(self) -> str:
        return text.text(self)

    def _repr_html_(self) -> str:
        return text.html(self)

    @property
    def plot(self) -> Plot:
        """Figures: `log.plot.contour()` and so on give matplotlib axes."""
        return Plot(self)


class Plot:
    """The figures of a log.  Each takes `ax=None` and gives matplotlib axes; `ax.figure.savefig(path)` writes them."""

    def __init__(self, log: Log):
        self._log = log

    def _draw(self, name: str, *args: Any, **options: Any) -> Any:
        from ..report import figures  # matplotlib only when something is drawn

        if self._log.batch:
            cure = "pick one: log.run(0).plot; log.plot.spread() and .contour() show all"
            raise LogError("holds a batch of runs", key="run", cure=cure)
        return getattr(figures, name)(self._log, *args, **options)

    def contour(self, ax: Any = None) -> Any:
        """Contour error over time, velocity reversals marked; of a batch `spread`."""
        if self._log.batch:
            return self.spread(ax)
        return self._draw("contour_error", ax=ax)

    def spread(self, ax: Any = None) -> Any:
        """Of a batch: largest and rms contour error of the runs, over the share of runs that stay below."""
        from ..report.spread import spread

        return spread(self._log, ax)

    def path(self, ax: Any = None) -> Any:
        """Tool path coloured by contour error."""
        return self._draw("path", ax=ax)

    def circle(self, number: int | None = None, ax: Any = None) -> Any:
        """Polar plot of a circle with magnified error; the first circle unless `number` is given."""
        return self._draw("circle", number, ax=ax)

    def forces(self, ax: Any = None) -> Any:
        """Forces of the joints over time."""
        return self._draw("forces", ax=ax)

    def velocities(self, ax: Any = None) -> Any:
        """Velocities of the joints over time."""
        return self._draw("velocities", ax=ax)

    def tracking(self, ax: Any = None) -> Any:
        """Tracking errors of the joints over time."""
        return self._draw("tracking", ax=ax)


@functools.lru_cache(maxsize=16)
def _parse(text: str) -> dict[str, Any]:
    try:
        info = json.loads(text)
    except ValueError as error:
        raise LogError("is not JSON", key="gough", value=str(error)) from None
    if not isinstance(info, dict):
        raise LogError("is not a JSON object", key="gough", value=type(info).__name__)
    return info
