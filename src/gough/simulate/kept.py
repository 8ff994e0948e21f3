"""The rows of a batch, in their place from the first chunk on: one array a variable, a column of it a run."""

from __future__ import annotations

import numpy as np


class Kept:
    """Rows of `runs` runs over `ticks` samples, one of `every`.  Behind the end of a run they are NaN, flags 0.

    `shared` are the variables that are the same in all runs.
    """

    def __init__(self, ticks: int, every: int, runs: int, shared: tuple[str, ...]):
        self.every, self.runs, self.shared = every, runs, shared
        self.total = -(-ticks // every)
        self._arrays: dict[str, np.ndarray] = {}

    def take(self, k: int, found: dict[str, np.ndarray], members: np.ndarray, ends: np.ndarray) -> None:
        """The thinned rows of a chunk from sample k: (rows, members, ...), shared ones (rows, ...).

        Member i has `ends[i]` samples in this chunk; what stands behind is dropped.
        """
        first = -(-k // self.every)
        rows = slice(first, first + len(found["t"]))
        past = (np.arange(rows.start, rows.stop) * self.every)[:, None] >= k + ends
        for name, values in found.items():
            shared, blank = name in self.shared, self._blank(name, values)
            if name not in self._arrays:
                lead = (self.total,) if shared else (self.total, self.runs)
                self._arrays[name] = np.full(lead + values.shape[len(lead) :], blank, values.dtype)
            if shared:
                self._arrays[name][rows] = values
            else:
                values[past] = blank
                self._arrays[name][rows, members] = values

    def until(self, rows: int) -> dict[str, np.ndarray]:
        """The first `rows` rows of every variable."""
        return {name: values[:rows] for name, values in self._arrays.items()}

    @staticmethod
    def _blank(name: str, values: np.ndarray) -> float:
        return 0 if name == "saturated" or values.dtype.kind != "f" else np.nan
