"""An observer on recorded rows, chunk by chunk: the step of the tick, in the same machine code.

A row has what a controller knows at a sample: readings of the joints, and the force that the drives applied in the
sample before.  Rows that are missing or not to be trusted are told so, and their numbers do not matter.
"""

from __future__ import annotations

import numpy as np

from .. import kernel as kernels
from ..kernel import Schedule, Signal, Task
from ..kernel.pack import flatten, names
from .base import Observer
from .tasks import fields_of, function_of


class Recorder:
    """An observer at work on rows; it begins with the machine at rest at the pose x0 (d,)."""

    def __init__(self, observer: Observer, x0):
        self.observer = observer
        n = observer.machine.joints_count
        state = observer.init(x0)
        told = fields_of(observer)
        width = max(part.stop for part in told.values())
        signals = [
            Signal("theta", len(observer.theta), "parameter"),
            Signal("state", len(names(state)), "state", names(state)),
            *(Signal(name, size, "input") for name, size in (("q", n), ("u", n), ("good", 1))),
            Signal("found", width, "wire"),
        ]
        task = Task("observe", function_of(observer), ("theta", "state", "q", "u", "good"), ("found", "state"))
        schedule = Schedule(tuple(signals), (task,), log=("found",), period=observer.period)
        self._kernel, self._told = kernels.compile(schedule), told
        self.restart(x0)

    def restart(self, x0) -> None:
        """Begin anew, at rest at the pose x0 (d,)."""
        state = self.observer.init(x0)
        self._simulation = self._kernel.start({"theta": self.observer.theta}, {"state": flatten(state)})

    def rows(self, q, u, good=None) -> dict[str, np.ndarray]:
        """What is found in the next rows: q, u (N, n), good (N,).  {name: (N, size) or (N,)}.

        Numbers that are not finite make a row as good as missing.
        """
        q, u = np.asarray(q, float), np.asarray(u, float)
        sound = np.isfinite(q).all(-1) & np.isfinite(u).all(-1)
        sound = sound if good is None else sound & np.asarray(good, bool)
        q, u = (np.where(sound[:, None], x, 0.0) for x in (q, u))
        out = self._simulation.advance(len(q), {"q": q, "u": u, "good": sound.astype(float)})[:, 0]
        return {
            name: out[:, part] if self.observer.found[name][0] else out[:, part.start]
            for name, part in self._told.items()
        }
