"""Limit cases of the law: what is exact, and what samples cost (eq. (12) of docs/theory/desired_torque.md).

The machine has no friction, its encoders no counts, its motors no limit, and the law knows it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ... import kernel as kernels
from ...control.base import Command, Controller
from ...control.desired_torque_adaptive import DesiredTorqueAdaptive
from ...frames import abc_of_rotation_np, rotation_of_quaternion_np
from ...observe import velocity
from ...program.reference import Reference
from ...simulate import start, tick
from ...simulate.run import simulate
from ..study import Tick
from .circle import RADIUS, program
from .setup import MODEL, OBSERVER_POLE, PERIOD, POLE, machine

SAMPLES = 400
PUSH = np.array([300.0, -200.0, 150.0, 100.0, -250.0, 200.0])  # N
SWING = 12.0  # Hz
SUBSTEPS = 2


class Nothing(NamedTuple):
    """A law that remembers nothing."""


class Given(Controller):
    """Forces that stand in the reference, in the place of q'': an open loop."""

    kind: str = "given"

    def init(self, r0, u0) -> Nothing:
        """Nothing."""
        return Nothing()

    def step(self, state, r, y, theta) -> tuple[Command, Any]:
        """The forces of this row."""
        return Command(r.qdd), state


class Limits(NamedTuple):
    """What the limit cases found.  m, 1/s."""

    exact: float  # following error with perfect parameters at equal rates, on a motion that held forces make
    moved: float  # how far the joints move on it
    pole: float  # of the observer's error, in the mean
    apart: float  # of its two poles, as a share
    equal: float  # following error on the circle at 0.4 m/s: everything every 300 us
    held: float  # the model every 900 us
    expected: tuple[float, float]  # the same by (12)


def ideal():
    """The machine without friction, counts and limits."""
    true = machine()
    return true.frictionless().replace(drive=true.drive.perfect())


def law(**options) -> DesiredTorqueAdaptive:
    """The law that knows all and learns nothing, its observer sampled exactly."""
    return DesiredTorqueAdaptive(pole=POLE, observer_pole=OBSERVER_POLE, learn=[], **options)


def reachable(true) -> tuple[Reference, np.ndarray]:
    """A reference that forces held for a sample bring about exactly, and those forces.

    It is a motion of the machine itself under such forces.  A row has its state when the sample begins, and the
    acceleration that the forces of this sample give it.
    """
    t, x0 = np.arange(SAMPLES) * PERIOD, true.home
    u = _weight(true, x0) + PUSH * np.sin(2 * np.pi * SWING * t)[:, None]
    rows = Reference(*(np.tile(part, (SAMPLES, 1)) for part in tick.rest_row(true, x0)))
    got = run(true, Given().on(true, PERIOD), Nothing(), rows._replace(qdd=u))
    x = np.concatenate([got["z"][:, :3], abc_of_rotation_np(rotation_of_quaternion_np(got["z"][:, 3:]))], -1)
    A = true.forward_dynamics(x, got["v"], u)
    q, qd, qdd = true.joint_motion(x, got["v"], A)
    return rows._replace(x=x, xd=got["v"], xdd=A, q=q, qd=qd, qdd=qdd), u


def followed(true, table: Reference, **options) -> dict[str, np.ndarray]:
    """The signals of a run under `law` on the rows of a reference."""
    control = law(**options).on(true, PERIOD)
    x0 = table.x[0]
    return run(true, control, control.init(tick.rest_row(true, x0), _weight(true, x0)), table)


def run(true, control, state, table: Reference) -> dict[str, np.ndarray]:
    """The tick on the rows of a reference, from rest at the first: the kernel's log by signal."""
    x0 = table.x[0]
    row = tick.rest_row(true, x0)
    schedule = tick.build(true, control, state, row, PERIOD, SUBSTEPS)
    kernel = kernels.compile(schedule)
    first = start.Start(true.coordinates(x0), state, _weight(true, x0))
    given = {"theta_plant": true.theta, "theta_law": control.theta, "wrench": np.zeros(6)}
    simulation = kernel.start(given, start.states(schedule, first, row))
    out = simulation.advance(len(table.x), start.inputs(table, 0, schedule))[:, 0]
    return {name: out[:, where] for name, where in kernel.columns.items()}


def late(true, x, u, time: float, period: float = PERIOD) -> np.ndarray:
    """The error of each joint from forces that are `time` s late, along rows `period` s apart; (12) of the theory.

    x (n, 6) poses, u (n, 6) the forces there.  (n, 6) m.
    """
    J, M = true.jacobian(x), true.mass_matrix(x)
    rate = np.gradient(u, period, axis=0)
    d = (J @ np.linalg.solve(M, np.swapaxes(J, -1, -2) @ rate[..., None]))[..., 0] * time
    return d * (1 + POLE * period) / POLE**2


def limits(progress: Tick | None = None) -> Limits:
    """All limit cases."""
    true = ideal()
    table, _ = reachable(true)
    exact = float(np.abs(followed(true, table)["q"] - table.q).max())
    found, expected = [], []
    for i, period in enumerate((PERIOD, MODEL)):
        log = simulate(true, law(model_period=period), program(0.4), period=PERIOD, on_fail="raise",
                       signals=["q", "q_r", "x_r", "s_r", "controller.force"])  # fmt: skip
        on = (log["s_r"] > 2 * np.pi * RADIUS) & (log["s_r"] < 4 * np.pi * RADIUS)
        found.append(float(np.abs(log["q_r"] - log["q"])[on].max()))
        if i == 0:
            forces = log["controller.force"]
            error = np.abs(late(true, log["x_r"], forces, PERIOD / 2)[on]).max()
            expected = [float(error), float(error) * MODEL / PERIOD]
        if progress is not None:
            progress(i + 1, 2)
    return Limits(exact, float(np.ptp(table.q, axis=0).max()), *observed(), *found, tuple(expected))


def observed() -> tuple[float, float]:
    """The poles of the observer's error by what it does from a wrong start: their mean, 1/s, and how far apart.

    The error of the next sample is A times this one's; A is fitted to the samples, and its poles are A's eigenvalues.
    """
    a = np.random.default_rng(0).uniform(-30, 30, 40)
    e, v, state, wrong = 2e-5, 0.01, velocity.Speed(0.0, 0.0), []
    for held in a:
        wrong.append((e - float(state.position), v - float(state.rate)))
        row = Reference(*([0.0] * len(Reference._fields)))
        state = velocity.advanced(state, row, -e, held, OBSERVER_POLE, PERIOD, "exact")
        e, v = e + PERIOD * v - PERIOD**2 / 2 * held, v - PERIOD * held
    wrong = np.array(wrong) / np.abs(wrong).max(0)
    A = np.linalg.lstsq(wrong[:-1], wrong[1:], rcond=None)[0]
    middle, product = np.trace(A) / 2, np.linalg.det(A)
    return float(-np.log(middle) / PERIOD), float(abs(1 - product / middle**2) ** 0.5)


def _weight(true, x) -> np.ndarray:
    still = np.zeros(len(x))
    return true.inverse_dynamics(x, still, still)
