"""One closed loop in three engines: a PD law on the strut lengths at 1 kHz, on a circle.

The peers get the law in NumPy and their model from the exported file; gough runs it through gk.simulate.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

import gough as gk
from gough.control.base import Command, Controller
from gough.export.mjcf import mjcf, positions
from gough.frames import rotation_of_abc_np, rotation_of_quaternion_np

PERIOD, SAMPLES = 1e-3, 500
KP, KD = 4e6, 5.6e4
PROGRAM = gk.Circle(radius=0.1, feed=0.2)
R_PLATFORM = 0.35  # m


class Before(NamedTuple):
    q: Any
    u_rest: Any


class JointPD(Controller):
    """u = u_rest + Kp (q_r - q) + Kd (q'_r - difference of q)."""

    kind: str = "joint_pd"

    def init(self, r0, u0):
        return Before(np.array(r0.q, float), np.array(u0, float))

    def step(self, state, r, y, theta):
        u = state.u_rest + KP * (r.q - y.q) + KD * (r.qd - (y.q - state.q) / PERIOD)
        return Command(u), Before(y.q, state.u_rest)


def machine():
    """nist-octahedral with viscous friction only, ideal encoders and drives."""
    m = gk.load_machine("nist-octahedral")
    bare = {"drive.encoder": None, "drive.torque_limit": None}
    if m.joints.friction is not None:
        bare["joints.friction"] = None
    return m.replace(friction={"kind": "stribeck", "coulomb": 0.0, "viscous": 930.0, "smoothing": 1e-3}, **bare)


class Law:
    """JointPD in NumPy, sample after sample."""

    def __init__(self, m):
        self.table = PROGRAM.plan(m).sample(0, SAMPLES, PERIOD)
        self.x0 = self.table.x[0]
        self.u_rest = m.inverse_dynamics(self.x0, np.zeros(6), np.zeros(6))
        self.before, self.k = self.table.q[0], 0

    def __call__(self, q):
        u = self.u_rest + KP * (self.table.q[self.k] - q) + KD * (self.table.qd[self.k] - (q - self.before) / PERIOD)
        self.before, self.k = q.copy(), self.k + 1
        return u


def gough(m, substeps: int):
    """Tip (n, 3) and rotation (n, 3, 3) of every sample."""
    log = gk.simulate(m, JointPD(), PROGRAM, period=PERIOD, substeps=substeps)
    x = log.dataset["x"].values[:SAMPLES]
    return x[:, :3], rotation_of_abc_np(x[:, 3:])


def mujoco(m, loops: str, step: float):
    """The same by MuJoCo's own steps."""
    import mujoco as mj

    model = mj.MjModel.from_xml_string(mjcf(m, loops, timestep=step))
    data, law = mj.MjData(model), Law(m)
    data.qpos[:] = positions(m, law.x0)
    out = np.empty((SAMPLES, 7))
    for k in range(SAMPLES):
        out[k] = data.qpos[:7]
        data.ctrl[:] = law(data.qpos[9::3].copy())
        mj.mj_step(model, data, round(PERIOD / step))
    return out[:, :3], rotation_of_quaternion_np(out[:, 3:])  # home of this machine is not turned


def pinocchio(m, engine, step: float):
    """The same by Runge-Kutta on Pinocchio's constraintDynamics; `engine` an engines.Pinocchio of m."""
    pin, model, law = engine.pin, engine.model, Law(m)
    q, v, Q = engine.positions(law.x0), np.zeros(24), np.zeros(24)
    damping = np.array(model.damping)
    out = np.empty((SAMPLES, 7))

    def rate(q, v):
        return engine.accelerations(q, v, Q - damping * v).copy()

    for k in range(SAMPLES):
        out[k] = q[:7]
        Q[8::3] = law(q[9::3].copy())
        for _ in range(round(PERIOD / step)):
            a = rate(q, v)
            v2 = v + step / 2 * a
            a2 = rate(pin.integrate(model, q, step / 2 * v), v2)
            v3 = v + step / 2 * a2
            a3 = rate(pin.integrate(model, q, step / 2 * v2), v3)
            v4 = v + step * a3
            a4 = rate(pin.integrate(model, q, step * v3), v4)
            q = pin.integrate(model, q, step / 6 * (v + 2 * v2 + 2 * v3 + v4))
            v = v + step / 6 * (a + 2 * a2 + 2 * a3 + a4)
    return out[:, :3], rotation_of_quaternion_np(out[:, [6, 3, 4, 5]])


def apart(one, other) -> float:
    """Largest distance of the tips, or of points of the platform by its turning, m."""
    tip = np.linalg.norm(one[0] - other[0], axis=1).max()
    # |R - R'| = 2 sqrt(2) sin(angle / 2)
    return float(max(tip, R_PLATFORM * np.linalg.norm(one[1] - other[1], axis=(1, 2)).max() / np.sqrt(2)))
