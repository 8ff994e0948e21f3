"""Figure 6 and Table 1: the parameters learned while the machine moves, from first estimates that are half of them.

The true machine is that of Table 1, so what is asked is whether the law finds what was planted.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...control import linear_model
from ...simulate.plant import Plant
from ...simulate.run import simulate
from ..study import Tick
from .exercise import Exercise
from .setup import LEARNED, PERIOD, computed_torque, machine

TIME, MEAN = 600.0, 60.0  # s: of learning, and over the last of which the mean is taken
FIRST = 0.5  # first estimates over the true parameters
RATE = 0.1  # 1/s, learning factors
EVERY = 100  # samples a row of the log
WITHIN = 0.05  # of the truth


class Learned(NamedTuple):
    """The estimates of one run, over time."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    t: np.ndarray  # (n,) s
    p: np.ndarray  # (n, k)
    true: np.ndarray  # (n, k), friction as it drifts
    shown: np.ndarray  # (k,) root mean square of what each does to the joints, of its own size, m/s2
    information: np.ndarray  # singular values of the motion's columns, each scaled to 1 where it is not 0, rising

    @property
    def last(self) -> np.ndarray:
        """Mean of every estimate over the last MEAN s.  (k,)."""
        return self.p[self.t > self.t[-1] - MEAN].mean(0)

    @property
    def last_true(self) -> np.ndarray:
        """The same of the truth."""
        return self.true[self.t > self.t[-1] - MEAN].mean(0)

    def of(self, name: str) -> int:
        """The column of a parameter."""
        return self.names.index(name)

    def settled(self, names) -> float:
        """The time from which on the mean over the last MEAN s of every one of `names` stays WITHIN of the truth, s.

        NaN where that is never so.
        """
        columns = [self.of(name) for name in names]
        width = int(round(MEAN / (self.t[1] - self.t[0])))
        sums = np.cumsum(self.p[:, columns] / self.true[:, columns] - 1, axis=0)
        off = np.abs((sums[width:] - sums[:-width]) / width).max(1) > WITHIN
        if off[-1]:
            return float("nan")
        return float(self.t[width + (np.flatnonzero(off)[-1] + 1 if off.any() else 0)])


def learned(tick: Tick | None = None, *, turn=0.0, time=TIME, first=FIRST, drift=0.0, **options) -> Learned:
    """Learn for about `time` s on Exercise(turn=...), from `first` times the truth; friction drifts by `drift` 1/s.

    Raises
    ------
    RunError
        the run ended early.
    """
    true = machine()
    one = Exercise(turn=turn, settle=0.0).plan(true)
    program = Exercise(turn=turn, rounds=max(1, round(time / one.duration)))
    rows = one.sample(0, one.count(1e-3), 1e-3)
    columns = linear_model.indices(true, list(LEARNED))
    E = linear_model.excitation(true, rows.x, rows.xd, rows.xdd)[columns]
    law = computed_torque(
        learn=list(LEARNED), learning=RATE, excitation=np.where(E > 1e-12, E, 0), estimates=first, physical=True,
        **options,
    )  # fmt: skip
    plant = Plant(machine=true, friction_drift=drift or None)
    log = simulate(
        true, law, program, plant=plant, period=PERIOD, log_every=EVERY, progress=tick, on_fail="raise",
        signals=["controller.parameters"],
    )  # fmt: skip
    names, values, units = true.parameters_of(friction=True)
    of_friction = np.array([name.startswith("friction") for name in names])
    grown = 1 + drift * log.t[:, None] * of_friction
    return Learned(
        tuple(names[j] for j in columns), tuple(units[j] for j in columns), log.t,
        log["controller.parameters"][:, columns], (values * grown)[:, columns], np.sqrt(E),
        _information(true, rows, columns, E),
    )  # fmt: skip


def _information(true, rows, columns, E) -> np.ndarray:
    """Singular values of M_q^-1 Psi over the motion, columns scaled to a root mean square of 1."""
    Y = true.regressor(rows.x, rows.xd, rows.xdd, friction=True)[..., columns] * linear_model.sizes(true)[columns]
    J, M = true.jacobian(rows.x), true.mass_matrix(rows.x)
    W = J @ np.linalg.solve(M, np.swapaxes(J, -1, -2) @ Y) / np.where(E > 1e-12, np.sqrt(E), 1)
    mean = np.mean(np.swapaxes(W, -1, -2) @ W, axis=0)
    return np.sqrt(np.maximum(np.linalg.eigvalsh(mean), 0))
