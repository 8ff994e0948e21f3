"""Rows kept for plot and file: at most so many, however long the log; of each stretch the one of the largest force."""

from __future__ import annotations

import numpy as np

MOST = 400_000  # rows; 50 MB


class Thin:
    """Keeps rows {name: (N, ...)}; when the room is full half of them go, of two the one with the smaller `size`."""

    def __init__(self, most: int = MOST):
        self.most, self.every = most, 1
        self.parts: list[dict[str, np.ndarray]] = []
        self.count = 0
        self.rest: dict[str, np.ndarray] | None = None  # rows of a stretch that is not full

    def take(self, rows: dict[str, np.ndarray]) -> None:
        """Rows in order; `size` decides which are kept."""
        if self.rest is not None:
            rows = {name: np.concatenate([self.rest[name], value]) for name, value in rows.items()}
        whole = len(rows["size"]) // self.every * self.every
        self.rest = {name: value[whole:] for name, value in rows.items()}
        kept = largest({name: value[:whole] for name, value in rows.items()}, self.every)
        self.parts.append(kept)
        self.count += len(kept["size"])
        while self.count > self.most:
            self._halve()

    def rows(self) -> dict[str, np.ndarray]:
        """What is kept."""
        parts = list(self.parts)
        if self.rest is not None and len(self.rest["size"]):
            parts.append(largest(self.rest, len(self.rest["size"])))
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]} if parts else {}

    def _halve(self):
        joined = {name: np.concatenate([part[name] for part in self.parts]) for name in self.parts[0]}
        even = self.count // 2 * 2
        odd = {name: value[even:] for name, value in joined.items()}
        kept = largest({name: value[:even] for name, value in joined.items()}, 2)
        self.parts, self.every = [{name: np.concatenate([kept[name], odd[name]]) for name in kept}], 2 * self.every
        self.count = len(self.parts[0]["size"])


def largest(rows: dict[str, np.ndarray], every: int) -> dict[str, np.ndarray]:
    """Of every so many rows the one with the largest `size`."""
    if every == 1:
        return {name: value.copy() for name, value in rows.items()}
    count = len(rows["size"]) // every
    best = rows["size"].reshape(count, every).argmax(1) + every * np.arange(count)
    return {name: value[best] for name, value in rows.items()}
