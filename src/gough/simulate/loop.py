"""A closed loop at rest as a discrete linear system: one sample of the law, linearised.

The tick itself (tick.py), sense, control, drive and the plant's sub-steps, taken over one sample of the law without
encoder counts and torque limits, and without friction: neither the plant's nor what the law does against it.  Central
differences at rest give

    s[k+1] = A s[k] + B d_r[k],   d[k] = C s[k]                                                                    (1)

d_r = [dp; rotation vector] in axes of W is the displacement of the reference pose while the rates of the reference
stay 0, d that of the tool when the sample is taken; s holds every state of the tick: coordinates, velocities, the law's
states, forces that wait in a delay.  What a sample leaves as it is, and what adaptation learns where it is frozen, is
no state.

In the continuous limit, for a law that knows the machine, d/d_r of each axis is

    computed torque     (K_P s + K_I) / (s^3 + K_D s^2 + K_P s + K_I)                                              (2)
    sliding surface     L k / (s^2 + (L + k) s + L k)            L its slope, k = K_D / M                          (3)

(V_r = 0 in both: what is fed forward of a moving reference adds nothing here.)
"""

from __future__ import annotations

import math
from functools import cached_property, lru_cache

import casadi as ca
import numpy as np

from ..declare import Shape
from ..kernel.pack import fields, flatten
from ..machine.arrays import column
from . import law_tasks, tick
from .drift import scaled
from .linear import StateSpace, plant_jacobians

STEP = 1e-6  # of the differences, m, rad and relative: errors of 1e-12 by curvature, 1e-10 by rounding
NOTHING = 1e-9  # factor on friction that a law believes in: laws with bristles refuse none at all


def closed_loop(machine, law, period: float, substeps: int, x=None, frozen: bool = True) -> StateSpace:
    """The loop of `law` on `machine` at rest at the pose x (d,) (default: home) as A, B, C, D a sample, eq. (1).

    Input: displacement of the reference, [dp; rotation vector] in axes of W, (d,) m and rad; output: that of the tool.
    One step is `law.period`, a multiple of `period`, which has `substeps` steps of the plant; of a law with tasks it is
    the time after which all are due together again (law_tasks.cycle), the reference held over it.  `frozen`: what an
    adaptive law learns stays as it is at the start.
    """
    x = machine.home if x is None else column(x, len(machine.task), "pose")
    loop = Loop(machine, law.on(machine.rigid, period), period, substeps, x)
    A, B = loop.jacobians()
    C = np.zeros((loop.S.shape[1], len(A)))
    C[:, loop.rows["z"]] = np.linalg.pinv(loop.S)  # dz = S d
    B, C = (
        B @ np.linalg.inv(loop.asked),
        loop.shown @ C,
    )  # from displacements of its own velocities to those of the tool
    # 1e-8: a hundred times the rounding of the differences
    constant = (np.abs(A - np.eye(len(A))).max(1) < 1e-8) & (np.abs(B).max(1) < 1e-8)
    kept = ~(constant | loop.learned if frozen else constant)
    return StateSpace(A[np.ix_(kept, kept)], B[kept], C[:, kept], np.zeros((len(C), B.shape[1])))


def loop_eigenvalues(machine, law, period: float, substeps: int) -> np.ndarray:
    """Eigenvalues of A at home, one a state, with all states and adaptation going on; the law is bound by `law.on`."""
    return np.linalg.eigvals(Loop(machine, law, period, substeps, machine.home).jacobians(inputs=False)[0])


class Loop:
    """One sample of the tick as a function of states and reference, and the point at rest."""

    def __init__(self, machine, law, period: float, substeps: int, x):
        self.machine = machine.frictionless().with_perfect_drives()
        if law.machine is not None and law.machine.friction is not None:
            law = law.believing(scaled(law.machine, NOTHING))
        self.law, self.x, self.rest = law, x, tick.rest_row(self.machine, x)
        z, u0 = self.machine.at_rest(x)
        self.state = law.init(self.rest, u0)
        self.sample = _kept(_Sample(self.machine, law, self.state, self.rest, period, substeps))
        self.numbers = ca.DM(self.machine.theta), ca.DM(law.theta)
        states = tick.first_states(self.sample.schedule, z, self.state, u0)
        self.states = {name: value for name, value in states.items() if value.size}
        cuts = np.cumsum([0, *(value.size for value in self.states.values())])
        self.rows = {name: slice(a, b) for name, a, b in zip(self.states, cuts[:-1], cuts[1:], strict=True)}
        self.S, _, self.shown = self._ways(self.machine, z, u0)
        believed = self.machine.rigid  # a reference is a pose of the machine that nothing bends
        z_r, u_r = (z, u0) if believed is self.machine else believed.at_rest(x)
        _, self.T, self.asked = self._ways(believed, z_r, u_r)

    @staticmethod
    def _ways(machine, z, u0):
        """S of z' = S v, T: task coordinates of a displacement, and the task rate by v."""
        still = np.zeros(len(machine.velocities))
        found = plant_jacobians(Shape(machine))(machine.theta, z, still, [], u0, [])
        S = np.array(found[0])[: len(z), len(z) :]
        return S, np.array(found[3]) @ S, np.array(found[4])

    def step(self, points, wrench=None) -> np.ndarray:
        """(s; reference), (n,) or in columns (n, N), wrenches (6, N) on the tool -> s a sample later, in columns."""
        points = np.reshape(points, (len(points), -1))
        count = points.shape[1]
        wrench = np.zeros((6, count)) if wrench is None else wrench
        numbers = (ca.repmat(n, 1, count) for n in self.numbers)
        return np.array(self.sample.function.map(count)(points, wrench, *numbers))

    def jacobians(self, inputs: bool = True) -> tuple[np.ndarray, np.ndarray]:
        """A (s, s) and B (s, d) of eq. (1), with all states; B (s, 0) without `inputs`."""
        s0, r0 = np.concatenate(list(self.states.values())), flatten(self.rest)
        small = STEP * np.maximum(np.abs(s0), 1e-2)
        moved = np.pad(np.diag(small), ((0, 0), (0, len(r0))))
        plus, minus, at = [], [], np.concatenate([s0, r0])
        for sign, points in ((1, plus), (-1, minus)):
            points += list(at + sign * moved)
            for dx in STEP * self.T.T if inputs else ():
                points.append(np.concatenate([s0, flatten(tick.rest_row(self.machine, self.x + sign * dx))]))
        after = self.step(np.array(plus + minus).T)
        half = len(plus)
        slopes = (after[:, :half] - after[:, half:]) / (2 * np.r_[small, np.full(half - len(small), STEP)])
        return slopes[:, : len(s0)], slopes[:, len(s0) :]

    def pushed(self, size: float) -> np.ndarray:
        """B_w (s, 6): the states a sample later by the wrench on the tool, in W; differences of `size` N and N m."""
        s0, r0 = np.concatenate(list(self.states.values())), flatten(self.rest)
        forces = size * np.concatenate([np.eye(6), -np.eye(6)], 1)
        after = self.step(np.tile(np.concatenate([s0, r0])[:, None], 12), forces)
        return (after[:, :6] - after[:, 6:]) / (2 * size)

    @property
    def learned(self) -> np.ndarray:
        """Which states adaptation moves.  (s,) bool."""
        found, start = np.zeros(sum(value.size for value in self.states.values()), bool), self.rows["law"].start
        for name, where in fields(self.state).items():
            if self.law.learns(name):
                found[start + where.start : start + where.stop] = True
        return found


class _Sample:
    """One sample as a function of states, reference and the numbers of machine and law.

    A key too, equal where only numbers differ: of a thousand laws of one kind it is made once.
    """

    def __init__(self, machine, law, state, rest, period: float, substeps: int):
        self.parts = machine, law, state, rest, period, substeps
        self._key = Shape(machine), Shape(law), law_tasks.rates(law, period), period, substeps

    def __hash__(self) -> int:
        return hash(self._key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Sample) and self._key == other._key

    @cached_property
    def schedule(self):
        return tick.build(*self.parts)

    @cached_property
    def function(self) -> ca.Function:
        """(s; reference), wrench on the tool, theta of the machine, theta of the law -> s a sample later."""
        machine, law, state, rest, _, substeps = self.parts
        schedule, values, s0 = self.schedule, {}, 0
        sizes = {signal.name: signal.size for signal in schedule.of_kind("state")}
        both = ca.MX.sym("both", sum(sizes.values()) + len(flatten(rest)))
        for name, size in sizes.items():
            values[name], s0 = both[s0 : s0 + size] if size else ca.MX(0, 1), s0 + size
        states = list(sizes)
        numbers = ca.MX.sym("machine", len(machine.theta)), ca.MX.sym("law", len(law.theta))
        wrench = ca.MX.sym("wrench", 6)
        values |= {"reference": both[s0:], "wrench": wrench}
        values |= dict(zip(("theta_plant", "theta_law"), numbers, strict=True))
        for k in range(math.lcm(*(task.every for task in schedule.tasks))):
            for task in (*schedule.tasks, *(schedule.substep * substeps)):
                if k % task.every == 0:
                    out = task.function(*[values[name] for name in task.reads])
                    values.update(zip(task.writes, out if isinstance(out, tuple) else (out,), strict=True))
        return ca.Function("step", [both, wrench, *numbers], [ca.vertcat(*[values[name] for name in states])])


@lru_cache(maxsize=32)
def _kept(sample: _Sample) -> _Sample:
    return sample
