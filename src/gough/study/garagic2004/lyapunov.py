"""The paper's Lyapunov function along a simulation in which its assumptions hold.

    V = sigma' M sigma / 2 + |theta - theta*|^2 / (2 g) + |c - c*|^2 / (2 g_c) + |d - d*|^2 / (2 g_d)                (1)

The proof (sliding.md of the theory pages) is of continuous time, so nothing is sampled here: machine and estimates are
one differential equation, integrated by RK4 at 20 us, and the law is `RobustAdaptive.step` itself.  It is handed the
pose as it is, and as pose of the sample before the one from which its velocity estimate is the true velocity.  Its
estimates' next values, less the present ones, over its period are their rates.

Friction is what the regressor can express: Coulomb and viscous, the same without a load, with the true sign (smoothed
in machine and law alike); no Stribeck, no friction in the joints; the force that would hold the unknown weight at the
start is taken away, the estimates must find it.  The motion has no jump of its velocity.
"""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca
import numpy as np

from ...control.base import Measurement
from ...control.robust_adaptive import RobustAdaptive
from ...kernel.pack import flatten, symbols
from ...machine.hexapod import Hexapod
from ...observe import forward
from ...program.reference import Reference
from ...program.standard.circle import Circle
from ...simulate import tick as plant
from ..study import Tick
from .setup import FAST, TRUTH, believed, machine

STEP = 2e-5  # s
DURATION = 0.5  # s; five sixths of the turn, with a reversal or two of every strut
SMOOTHING = 1e-3  # m/s, of friction's sign: at 20 us RK4 follows it, and the sign is the same in machine and law
COULOMB, VISCOUS = 270.0, 700.0  # N, N s/m: those of the sheet at 1.5 kN, with its offset
CHUNK = 500  # steps between two ticks of the progress


class Course(NamedTuple):
    """V along the simulation."""

    t: np.ndarray  # s, (n,)
    V: np.ndarray  # J, (n,)
    parts: np.ndarray  # J: of sigma, of the inertial, Coulomb and viscous estimates; (n, 4)

    @property
    def rise(self) -> float:
        """The largest change of V over a step as a share of V at the start; below 0 where it falls in every step."""
        return float(np.diff(self.V).max() / self.V[0])


def law(known: Hexapod) -> RobustAdaptive:
    """CDAC with FAST's gains as the proof wants it: the regressor and the friction's sign of the motion as it is."""
    return RobustAdaptive(
        **FAST.gains, regressor="actual", friction_speed="measured", friction_smoothing=SMOOTHING, leakage_norm=1.5,
        inertia_rate=0.3, coulomb_rate=10.0, viscous_rate=1.0,
    ).on(known, STEP)  # fmt: skip


def smooth(static: float | None = None) -> Hexapod:
    """The machine with friction that the law's regressor can express; with `static` (N) it also has Stribeck's rise."""
    bare = machine(torque_limit=None).replace(
        **{"drive.encoder": None, "joints.friction": None, "friction": None, "strut.sleeve": None, "strut.tube": None}
    )
    friction = {"kind": "stribeck", "coulomb": COULOMB, "viscous": VISCOUS, "smoothing": SMOOTHING}
    return bare.replace(friction=friction if static is None else {**friction, "static": static, "stribeck": 2e-3})


def course(tick: Tick | None = None, duration: float = DURATION, true: Hexapod | None = None) -> Course:
    """V of eq. (1) along the start of a circle of 5 mm at 0.05 m/s, from estimates 20 % off.

    `true` (default `smooth()`) may have friction that breaks the assumptions.
    """
    true = smooth() if true is None else true
    known = believed(smooth())
    control = law(known)
    motion = Circle(radius=5e-3, feed=0.05, profile="jerk_limited").plan(known)
    count = round(duration / STEP)
    rows = motion.sample(0, 2 * count + 1, STEP / 2)
    first = Reference(*(column[0] for column in rows))
    state = control.init(first, known.inverse_dynamics(first.x, np.zeros(6), np.zeros(6)))
    step, widths = _step(true, control, state, first)
    y = np.concatenate([true.coordinates(first.x), np.zeros(6), np.ones(sum(widths[2:]))])
    table, found = np.concatenate(rows, axis=1), np.zeros((count, 4))
    for k in range(count):
        y, parts = step(y, table[2 * k : 2 * k + 3].T)
        found[k] = np.array(parts).ravel()
        if tick is not None and k % CHUNK == 0:
            tick(k * STEP, duration)
    return Course(np.arange(count) * STEP, found.sum(1), found)


def _step(true: Hexapod, control: RobustAdaptive, state, first: Reference) -> tuple[ca.Function, list[int]]:
    """(y, three rows of the reference) -> (y a step later, the parts of V now); y = [z, v, theta, c, d], its widths."""
    widths = [7, 6, len(state.parameters), len(state.coulomb), len(state.viscous)]
    y, r = ca.SX.sym("y", sum(widths)), symbols(first)
    z, v, theta, c, d = ca.vertsplit(y, np.cumsum([0, *widths]).tolist())
    p = true.at(ca.SX(ca.DM(true.theta)))
    before = true.normalised(true, true.stepped(z, -v * STEP))  # from there to z in a period is v
    now = type(state)(forward.Pose(before), theta, c, d, ca.SX(6, 1))
    measured = Measurement(true.joints_of(p, z), ca.SX(true.joints_count, 1))
    command, after = control.step(now, r, measured, ca.SX(ca.DM(control.theta)))
    zd, vd = plant.rate(true, p, z, v, ca.SX(0, 1), command.u, ca.SX(6, 1))
    learned = [(new - old) / STEP for new, old in zip(after[1:4], (theta, c, d), strict=True)]
    pi = {key: value for key, (value, _) in true.inertial(p).items()}
    sigma = ca.SX(r.xd) + control.slope * true.target(true, r._replace(x=ca.SX(r.x)), z)[0] - v
    M, _ = true.mass_and_bias(p, pi, z, v)
    rates = (control.inertia_rate, control.coulomb_rate, control.viscous_rate)
    away = [ca.sumsqr(x - TRUTH) / (2 * g) for x, g in zip((theta, c, d), rates, strict=True)]
    V = ca.vertcat(ca.dot(sigma, M @ sigma) / 2, *away)
    f = ca.Function("f", [y, flatten(r)], [ca.vertcat(zd, vd, *learned), V])
    rows, h = ca.SX.sym("rows", flatten(r).shape[0], 3), STEP
    k1, V_now = f(y, rows[:, 0])
    k2, _ = f(y + h / 2 * k1, rows[:, 1])
    k3, _ = f(y + h / 2 * k2, rows[:, 1])
    k4, _ = f(y + h * k3, rows[:, 2])
    end = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    end = ca.vertcat(true.normalised(true, end[:7]), end[7:])
    return ca.Function("step", [y, rows], [end, V_now]), widths
