"""monitor(): a recorded log and a machine in, the force on its tool over time and what to look at out."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import ExperimentError, LogError
from ..log import Log
from ..log.outside import Record
from ..machine.base import Machine
from ..machine.record import RecordMap
from ..observe.disturbance import WAIT, DisturbanceObserver
from ..observe.recorded import Recorder
from ..quantities import brief
from . import levels
from .events import RISE, Event, Events
from .thin import Thin
from .watch import Sums, Watch

STEP = 1 << 14  # rows at a time
SETTLED = 5.0  # time constants of the low pass until the first force is told, to less than a hundredth


def monitor(
    log: Log | str | Path,
    machine: Machine,
    mapping: RecordMap | None = None,
    observer: DisturbanceObserver | None = None,
    *,
    alarm: float | None = None,
    collision: float | None = None,
    breakage: float | None = None,
    wait: Any = None,
    tell: Callable[[Event], None] | None = None,
    progress: Callable[[float], None] | None = None,
) -> Watch:
    """The force on the tool over a recorded log, from readings and drive forces, and the events in it.

    `log` is a Log of gough's, or a file (CSV, Parquet, MATLAB, NetCDF) whose columns `mapping`, or the machine's own
    sheet, tells; a file is streamed.  The `observer` (default: momentum form, 20 Hz) believes `machine`.  Events, N:
    `alarm` (none where left out), `collision` and `breakage` (default: what friction and encoders cannot feign,
    levels.py; events.py says what they are).  `tell(event)` hears of each as it is found; `wait` (a Patience) follows
    a text file that is still being written.

    Raises
    ------
    LogError
        the log cannot be read, or is not of this machine; a row and a cure are told.
    ExperimentError
        an argument is of another kind.
    """
    if not isinstance(machine, Machine):
        raise ExperimentError("must be a Machine", key="machine", value=brief(machine))
    record = _Rows(log, machine) if isinstance(log, Log) else Record(log, machine, mapping, wait)
    bound = (observer or DisturbanceObserver()).on(machine, record.period)
    job = _Job(bound, alarm, collision, breakage, tell)
    for part in record.parts():
        for start in range(0, len(part.t), STEP):
            rows = slice(start, start + STEP)
            job.take(part.t[rows], part.q[rows], part.u[rows], part.good[rows], part.anew and start == 0)
            if progress is not None:
                progress(float(part.t[rows][-1]))
    return job.finish(record)


class _Rows:
    """A log in memory, as Record gives a file."""

    def __init__(self, log: Log, machine: Machine):
        from ..log.outside.findings import Findings

        self.log, self.machine, self.findings = log, machine, Findings()
        if log.batch:
            raise LogError("is of many runs", cure="give one of them: log.run(0)")
        if len(log) < 2:
            raise LogError("has less than two rows")
        if log["q_m"].shape[1] != machine.joints_count:
            raise LogError(f"{machine.name} has {machine.joints_count} joints", value=str(log["q_m"].shape[1]))
        self.period = float(log.t[1] - log.t[0])
        self.clipped = self.missing = 0

    def parts(self):
        from ..log.outside.rows import Part

        u = np.concatenate([np.full((1, self.machine.joints_count), np.nan), self.log["u"][:-1]])
        self.samples = len(self.log)
        yield Part(self.log.t, self.log["q_m"], u, np.isfinite(u).all(1), True)


class _Job:
    """The observer at work, and what is kept of what it finds."""

    def __init__(self, observer, alarm, collision, breakage, tell):
        self.observer, self.tell = observer, tell
        self.asked = alarm, collision, breakage
        self.recorder: Recorder | None = None
        self.events: Events | None = None
        self.thin, self.sums = Thin(), Sums()
        self.begins, self.q, self.known = True, None, 0.0

    def take(self, t, q, u, good, anew: bool) -> None:
        self.begins = self.begins or anew
        if self.begins:
            rows = np.flatnonzero(good)
            if not len(rows):
                return
            self._begin(q[rows[0]])
            self.known = t[rows[0]] + WAIT * self.observer.period + SETTLED / (2 * np.pi * self.observer.bandwidth)
            t, q, u, good = (array[rows[0] :] for array in (t, q, u, good))
        found = self.recorder.rows(q, u, good)
        w = found["wrench_hat"]
        speed = self._speed(q)
        known = t >= self.known  # a force that acted before the record began is no blow at its begin
        events = self.events.look(t[known], w[known, :3], speed[known])
        if self.tell is not None:
            for event in events:
                self.tell(event)
        size = np.linalg.norm(w[:, :3], axis=1)
        clean = {name: np.where(np.isfinite(value), value, np.nan) for name, value in (("q_m", q), ("u", u))}
        rows = {"t": t, "size": size, "wrench_hat": w, "hidden": found["hidden"], "held": found["held"], **clean}
        self.thin.take(rows)
        self.sums.take(t, w, size, found["held"], found["hidden"])

    def _begin(self, q):
        x = self.observer.machine.forward_kinematics(q)
        if self.recorder is None:
            self.recorder = Recorder(self.observer, x)
            alarm, collision, breakage = self.asked
            level = levels.default_level(self.observer, x)
            self.level, self.noise = level, levels.noise_level(self.observer, x)
            self.events = Events(
                self.observer.period, alarm,
                levels.jump_level(self.observer, x, RISE) if collision is None else collision,
                level if breakage is None else breakage,
            )  # fmt: skip
        else:
            self.recorder.restart(x)
            self.events.restart()
        self.begins, self.q = False, q

    def _speed(self, q):
        """Speed of the joints together, the last known one where a reading is missing.  (N,) m/s."""
        step = np.linalg.norm(np.diff(q, axis=0, prepend=self.q[None]), axis=1) / self.observer.period
        known = np.isfinite(step)
        if not known.all():
            at = np.maximum.accumulate(np.where(known, np.arange(len(step)), -1))
            step = np.where(at >= 0, step[at], 0.0)
        sound = np.flatnonzero(np.isfinite(q).all(1))
        if len(sound):
            self.q = q[sound[-1]]
        return step

    def finish(self, record) -> Watch:
        if self.recorder is None:
            raise LogError("has no row that can be used")
        self.events.finish()
        return Watch(self.observer, record, self.events, self.sums, self.thin.rows(), self.thin.every, self.noise)
