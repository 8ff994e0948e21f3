"""Faults of sensors that rows alone betray: encoders that stand or jump, counters that ran over, wrong forces.

The sign test compares the forces of slow rows with what holds the weight of the believed machine there.  Six readings
on six freedoms contradict nobody; a force with the other sign, or of another joint, contradicts the weight.
"""

from __future__ import annotations

import itertools

import numpy as np

from ...errors import RunError
from .findings import Finding, Findings

FROZEN = 0.2  # s without a change
MOVED = 5e-3  # m that another joint moves in that time
SLOW = 0.02  # m/s, below which inertia is no matter
ROWS = 2000  # rows for the sign test
_WRAPS = (16, 24, 32)  # bits of counters


class Detector:
    """Looks at samples as they come."""

    def __init__(self, machine, period: float, findings: Findings):
        self.machine, self.period, self.findings = machine, period, findings
        n = machine.joints_count
        self.last: np.ndarray | None = None
        self.stands = np.zeros(n, int)  # samples since a joint's reading changed
        self.since = np.zeros((n, n))  # readings of all, when it did
        self.rows: list[tuple[np.ndarray, np.ndarray]] = []
        self.count, self.tested = 0, False

    def look(self, t, q, u, good) -> None:
        """Samples t (N,), q, u (N, n), good (N,); NaN where not good."""
        rows = np.flatnonzero(good)
        if len(rows) < 2:
            return
        self._jumps(t[rows], q[rows], rows)
        self._frozen(t[rows], q[rows])
        self._collect(q[rows], u[rows], np.diff(rows))

    def _jumps(self, t, q, rows) -> None:
        limit = getattr(self.machine.limits, "speed", None)
        if limit is None:
            return
        step = np.diff(q, axis=0)
        allowed = limit * self.period * np.diff(rows)
        for row, joint in np.argwhere(np.abs(step) > allowed[:, None])[:1000]:
            size, at = float(step[row, joint]), float(t[row + 1])
            name, grain = self.machine.joint_names[joint], self.machine.drive.encoder
            bits = 0 if grain is None else next((b for b in _WRAPS if abs(abs(size) / grain / 2**b - 1) < 1e-3), 0)
            if bits:
                self.findings.add(Finding("counter", f"{name}: the counter of {bits} bits ran over", None, at, at))
            else:
                text = f"{name}: the reading jumps farther than the joint can move"
                self.findings.add(Finding("jump", text, None, at, at), 10 * self.period)

    def _frozen(self, t, q) -> None:
        """Readings that stand for FROZEN while another joint moves by MOVED."""
        before = q[:1] if self.last is None else self.last[None]
        changed = np.diff(np.concatenate([before, q]), axis=0) != 0
        if self.last is None:
            self.since[:] = q[0]
        least = max(2, round(FROZEN / self.period))
        for joint, name in enumerate(self.machine.joint_names):
            ends = np.flatnonzero(changed[:, joint])
            edges = np.concatenate([[0], ends, [len(q)]])
            lengths = np.diff(edges)
            lengths[0] += self.stands[joint]  # of what began in the rows before
            for k in np.flatnonzero((lengths >= least) & (np.diff(edges) > 0)):
                start, stop, length = edges[k], edges[k + 1], int(lengths[k])
                moved = np.abs(q[stop - 1] - (self.since[joint] if k == 0 else q[start])).max()
                if moved > MOVED:
                    begin = float(t[stop - 1] - (length - 1) * self.period)
                    text = f"{name}: the reading stands while others move"
                    self.findings.add(Finding("frozen", text, None, begin, float(t[stop - 1]), length), self.period)
            if len(ends):
                self.stands[joint], self.since[joint] = len(q) - ends[-1], q[ends[-1]]
            else:
                self.stands[joint] += len(q)
        self.last = q[-1]

    # -- forces against the weight --------------------------------------------------------------------------------

    def _collect(self, q, u, apart) -> None:
        if self.tested:
            return
        speed = np.abs(np.diff(q, axis=0)).max(1) / (apart * self.period)
        slow = np.flatnonzero(speed < SLOW)[:: max(1, len(speed) // 200)]
        self.rows.append((q[slow], u[slow]))
        self.count += len(slow)
        if self.count >= ROWS:
            self.finish()

    def finish(self) -> None:
        """The sign test on what was collected, once."""
        if self.tested or not self.count:
            return
        self.tested = True
        q, u = (np.concatenate(parts) for parts in zip(*self.rows, strict=True))
        self.rows = []
        try:
            x, status = self.machine.forward_kinematics(q, on_fail="nan")
            x, u = x[status == 0], u[status == 0]
            zero = np.zeros(x.shape[-1])
            weight = self.machine.inverse_dynamics(x, zero, zero)
        except RunError:
            return
        if len(x) < 10:
            return
        size = np.sqrt((weight**2).mean())
        if size <= 0 or _distance(u, weight) < 0.15 * size:
            return
        told = self._better(u, weight, _distance(u, weight))
        if told is not None:
            self.findings.add(Finding(*told))

    def _better(self, u, weight, wrong: float) -> tuple[str, str] | None:
        """What would bring the forces to less than a third of their distance from the weight."""
        names, n = self.machine.joint_names, u.shape[1]
        found = [(_distance(-u, weight), "sign", "all forces have the other sign")]
        for i in range(n):
            flipped = u * np.where(np.arange(n) == i, -1, 1)
            found.append((_distance(flipped, weight), "sign", f"{names[i]}: the force has the other sign"))
        for i, j in itertools.combinations(range(n), 2):
            order = np.arange(n)
            order[[i, j]] = j, i
            found.append((_distance(u[:, order], weight), "order", f"{names[i]} and {names[j]}: forces interchanged"))
        best = min(found, key=lambda one: one[0])
        return (best[1], f"{best[2]}, to judge by the weight") if best[0] < wrong / 3 else None


def _distance(u, weight) -> float:
    return float(np.sqrt(np.nanmean((u - weight) ** 2)))
