"""The same closed loop in MuJoCo and in Pinocchio, from the file that `gough export` writes.

nist-octahedral with viscous friction only, a PD law on the strut lengths at 1 kHz, 2 s of a circle at 12 m/min.  The
pose error of a row is the largest distance, over the samples, of the tool tip from that of gough's RK4 at 15 us, or
the turning of the platform times its radius, whichever is larger.  Every engine is driven from Python by the same
three lines of NumPy once a millisecond, whose time is measured apart and taken off the peers' bill; gough's figure
holds its own law, encoder, limits and log rows.  Pinocchio has no integrator: its Runge-Kutta step is NumPy, and
"alone" is what its own calls would reach if that cost nothing.

    rows()      one dict a setting: engine, setting, step, error, speed, ratio, alone
    lines()     the same as a table in Markdown
"""

from __future__ import annotations

import statistics
import tempfile
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import gough as gk
from gough import kernel as kernels
from gough.control.base import Command, Controller
from gough.export.mjcf import mjcf, positions, stiffness
from gough.frames import quaternion_of_abc_np, rotation_of_quaternion_np
from gough.program.reference import Reference
from gough.simulate import tick

PERIOD, SAMPLES = 1e-3, 2000
KP, KD = 4e6, 5.6e4  # N/m, N s/m: 100 rad/s and 0.7 on the 400 kg that a strut moves
RADIUS = 0.35  # m, of the platform: what makes a length of its turning
CLOSE = 0.1e-6  # m; the largest pose error of a setting that may compete
TARGETS = {"MuJoCo": 15.0, "Pinocchio": 30.0}  # how many times gough is to be faster (issue 4)


class _Before(NamedTuple):
    q: Any
    u_rest: Any


class JointPD(Controller):
    """u = u_rest + Kp (q_r - q) + Kd (q'_r - difference of q)."""

    kind: str = "joint_pd"

    def init(self, r0, u0):
        """Nothing is behind; u0 (n,) N is the force at rest."""
        return _Before(np.array(r0.q, float), np.array(u0, float))

    def step(self, state, r, y, theta):
        """One sample."""
        u = state.u_rest + KP * (r.q - y.q) + KD * (r.qd - (y.q - state.q) / PERIOD)
        return Command(u), _Before(y.q, state.u_rest)


def machine():
    """nist-octahedral, 930 N s/m on every strut and no other friction, ideal encoders and drives."""
    m = gk.load_machine("nist-octahedral")
    bare = {"drive.encoder": None, "drive.torque_limit": None}
    if m.joints.friction is not None:
        bare["joints.friction"] = None
    viscous = {"kind": "stribeck", "coulomb": 0.0, "viscous": 930.0, "smoothing": 1e-3}
    return m.replace(friction=viscous, **bare)


class Loop:
    """What all engines share: machine, reference, forces at rest."""

    def __init__(self):
        self.machine = machine()
        self.table = gk.Circle(radius=0.1, feed=0.2).plan(self.machine).sample(0, SAMPLES, PERIOD)
        self.first = Reference(*(column[0] for column in self.table))
        self.u_rest = self.machine.inverse_dynamics(self.first.x, np.zeros(6), np.zeros(6))

    def force(self, k: int, q, before):
        """The law of JointPD in NumPy, for the peers."""
        return self.u_rest + KP * (self.table.q[k] - q) + KD * (self.table.qd[k] - (q - before) / PERIOD)

    def law_time(self) -> float:
        """CPU seconds that the peers' law takes for all samples."""
        q = before = self.table.q[0].copy()
        start = time.process_time()
        for k in range(SAMPLES):
            now = q.copy()
            self.force(k, now, before)
            before = now
        return time.process_time() - start


class Gough:
    """The kernel, one lane."""

    engine = "gough"

    def __init__(self, loop: Loop, substeps: int):
        self.loop, self.setting, self.step = loop, f"RK4, {substeps} a sample", PERIOD / substeps
        m = loop.machine
        law = JointPD().on(m, PERIOD)
        state = law.init(loop.first, loop.u_rest)
        schedule = tick.build(m, law, state, loop.first, PERIOD, substeps)
        self.kernel = kernels.compile(schedule, lanes=1)
        z = np.concatenate([loop.first.x[:3], quaternion_of_abc_np(loop.first.x[3:])])
        self.states = tick.first_states(schedule, z, state, loop.u_rest)
        self.parameters = {"theta_plant": m.theta, "theta_law": law.theta, "wrench": np.zeros(6)}
        self.columns = np.concatenate(loop.table, axis=1)

    def run(self):
        """Positions and quaternions of the samples (n, 7), and CPU seconds."""
        simulation = self.kernel.start(self.parameters, self.states, runs=1)
        start = time.process_time()
        log = simulation.advance(SAMPLES, {"reference": self.columns})
        return log[:, 0, self.kernel.columns["z"]], time.process_time() - start


class MuJoCo:
    """MuJoCo's own stepping; `stiff` gives the loops springs for the step, else they are MuJoCo's own."""

    engine = "MuJoCo"

    def __init__(self, loop: Loop, step: float, integrator: str, stiff: bool):
        import mujoco

        self.mujoco, self.loop, self.step = mujoco, loop, step
        self.setting = f"{integrator}, {'stiff' if stiff else 'default'} loops"
        self.model = mujoco.MjModel.from_xml_string(mjcf(loop.machine))
        self.model.opt.timestep = step
        self.model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
        self.model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE  # faster here than sparse
        off = mujoco.mjtDisableBit
        self.model.opt.disableflags |= int(off.mjDSBL_CONTACT | off.mjDSBL_SENSOR | off.mjDSBL_LIMIT)  # not needed
        if stiff:
            for name, target in (("solref", self.model.eq_solref), ("solimp", self.model.eq_solimp)):
                target[:] = np.array(stiffness(step)[name].split(), float)

    def run(self):
        """Positions and quaternions of the samples (n, 7), and CPU seconds; errors NaN where it was unstable."""
        mujoco, model, loop = self.mujoco, self.model, self.loop
        data = mujoco.MjData(model)
        data.qpos[:] = positions(loop.machine, loop.first.x)
        mujoco.mj_forward(model, data)
        lengths, before = data.qpos[9::3], data.qpos[9::3].copy()
        out, many = np.empty((SAMPLES, 7)), round(PERIOD / self.step)
        start = time.process_time()
        for k in range(SAMPLES):
            out[k] = data.qpos[:7]
            q = lengths.copy()
            data.ctrl[:] = loop.force(k, q, before)
            before = q
            mujoco.mj_step(model, data, many)
            if data.warning.number.any():
                out[k:] = np.nan
                break
        return out, time.process_time() - start


class Pinocchio:
    """Pinocchio's accelerations of the closed chain (LCABA, or constraintDynamics) under a Runge-Kutta step."""

    engine = "Pinocchio"

    def __init__(self, loop: Loop, step: float, algorithm: str):
        import pinocchio as pin

        self.pin, self.loop, self.step, self.setting = pin, loop, step, f"RK4, {algorithm}"
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "machine.xml"
            path.write_text(mjcf(loop.machine))
            self.model, loops, _ = pin.buildModelAndConstraintsFromMJCF(str(path))
        self.model.gravity.linear = np.array(loop.machine.gravity)
        self.data = self.model.createData()
        self.rigid, self.rigid_data = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
        for one in loops:
            self.rigid.append(pin.convertToRigidConstraintModel(self.model, one))
            self.rigid_data.append(self.rigid[-1].createData())
        if algorithm == "lcaba":
            pin.computeJointMinimalOrdering(self.model, self.data, self.rigid)
            self.solver, self.exact = pin.lcaba, pin.ProximalSettings(1e-14, 1e-10, 10)
        else:
            pin.initConstraintDynamics(self.model, self.data, self.rigid, self.rigid_data)
            self.solver, self.exact = pin.constraintDynamics, pin.ProximalSettings(1e-14, 0.0, 1)
        self.damping = np.array(self.model.damping)

    def run(self):
        """Positions and quaternions of the samples (n, 7), and CPU seconds."""
        integrate, model, loop, h = self.pin.integrate, self.model, self.loop, self.step
        q = positions(loop.machine, loop.first.x)
        q[3:7] = q[[4, 5, 6, 3]]
        v, tau = np.zeros(24), np.zeros(24)
        before = q[9::3].copy()
        out, many = np.empty((SAMPLES, 7)), round(PERIOD / h)

        def rate(q, v):
            return self.solver(
                model, self.data, q, v, tau - self.damping * v, self.rigid, self.rigid_data, self.exact
            ).copy()

        start = time.process_time()
        for k in range(SAMPLES):
            out[k] = q[:7]
            now = q[9::3].copy()
            tau[8::3] = loop.force(k, now, before)
            before = now
            for _ in range(many):
                a1 = rate(q, v)
                v2 = v + (h / 2) * a1
                a2 = rate(integrate(model, q, (h / 2) * v), v2)
                v3 = v + (h / 2) * a2
                a3 = rate(integrate(model, q, (h / 2) * v2), v3)
                v4 = v + h * a3
                a4 = rate(integrate(model, q, h * v3), v4)
                q = integrate(model, q, (h / 6) * (v + 2 * v2 + 2 * v3 + v4))
                v = v + (h / 6) * (a1 + 2 * a2 + 2 * a3 + a4)
        spent = time.process_time() - start
        return out[:, [0, 1, 2, 6, 3, 4, 5]], spent

    def alone(self) -> float:
        """Simulated s a CPU s of Pinocchio's calls alone: four accelerations and four integrations a step."""
        q = positions(self.loop.machine, self.loop.first.x)
        q[3:7] = q[[4, 5, 6, 3]]
        v, tau = np.zeros(24), np.zeros(24)
        tau[8::3] = self.loop.u_rest
        start = time.process_time()
        for _ in range(4 * SAMPLES):
            self.solver(self.model, self.data, q, v, tau, self.rigid, self.rigid_data, self.exact)
            self.pin.integrate(self.model, q, v)
        return SAMPLES * self.step / (time.process_time() - start)


def pose_error(found, right) -> float:
    """Largest distance of the tips, or turning times RADIUS, over the samples (n, 7), m; NaN if one is NaN."""
    tip = np.linalg.norm(found[:, :3] - right[:, :3], axis=1)
    if not np.isfinite(found).all():
        return float("nan")
    R = rotation_of_quaternion_np(found[:, 3:]) - rotation_of_quaternion_np(right[:, 3:])
    turning = np.linalg.norm(R, axis=(1, 2)) / np.sqrt(2)  # |R - R_r| = 2 sqrt(2) sin(angle / 2)
    return float(max(tip.max(), RADIUS * turning.max()))


def candidates(loop: Loop) -> list:
    """Every setting that is tried: each engine's, from the coarsest."""
    out: list = [Gough(loop, n) for n in (1, 2, 4)]
    out += [MuJoCo(loop, step, "Euler", False) for step in (1e-3, 0.25e-3)]
    for integrator in ("Euler", "implicitfast", "RK4"):
        out += [MuJoCo(loop, step, integrator, True) for step in (1e-3, 0.5e-3, 0.25e-3)]
    out += [MuJoCo(loop, 15.625e-6, "Euler", True)]  # as small a step as could compete, and still too far off
    for algorithm in ("lcaba", "constraintDynamics"):
        out += [Pinocchio(loop, step, algorithm) for step in (1e-3, 0.5e-3)]
    return out


def rows(rounds: int = 5) -> list[dict[str, Any]]:
    """The table, one dict a setting: engine, setting, step s, error m, speed (simulated s a CPU s, median), ratio.

    `ratio` is the median, over interleaved rounds, of the speed of gough's fastest competing setting against the
    row's; `alone` is Pinocchio's speed without NumPy's share, else None; `competes` says that the error is below
    CLOSE; `fastest` marks the engine's fastest competing setting.
    """
    loop = Loop()
    right, _ = Gough(loop, 67).run()  # 14.9 us
    settings = candidates(loop)
    table = []
    for one in settings:
        error = pose_error(one.run()[0], right)
        row = {"engine": one.engine, "setting": one.setting, "step": one.step, "error": error}
        table.append(row | {"speeds": [], "alones": []})
    for _ in range(rounds):
        law = loop.law_time()
        for one, row in zip(settings, table, strict=True):
            spent = one.run()[1] - (0.0 if one.engine == "gough" else law)
            row["speeds"].append(SAMPLES * PERIOD / spent if np.isfinite(row["error"]) else float("nan"))
            if one.engine == "Pinocchio":
                row["alones"].append(one.alone())
    for row in table:
        row["speed"] = statistics.median(row["speeds"])
        row["alone"] = statistics.median(row["alones"]) if row["alones"] else None
        row["competes"] = bool(row["error"] < CLOSE)
    fastest = {}
    for engine in ("gough", "MuJoCo", "Pinocchio"):
        able = [row for row in table if row["engine"] == engine and row["competes"]]
        fastest[engine] = max(able, key=lambda row: row["speed"])
    for row in table:
        row["fastest"] = row is fastest[row["engine"]]
        pairs = zip(fastest["gough"]["speeds"], row["speeds"], strict=True)
        row["ratio"] = statistics.median(a / b for a, b in pairs)
    return [{key: value for key, value in row.items() if key not in ("speeds", "alones")} for row in table]


def lines(table: list[dict[str, Any]]) -> list[str]:
    """The table as lines of Markdown."""
    heads = ("engine", "setting", "step", "pose error", "simulated s a CPU s", "its calls alone", "gough is faster by")
    out = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    for row in table:
        mark = "**" if row["fastest"] else ""
        alone = "" if row["alone"] is None else f"{row['alone']:.3g}"
        error = f"{row['error'] * 1e6:.2g} um" if np.isfinite(row["error"]) else "unstable"
        out.append(
            f"| {row['engine']} | {mark}{row['setting']}{mark} | {row['step'] * 1e3:.4g} ms | {error} "
            f"| {row['speed']:.3g} | {alone} | {row['ratio']:.3g} |"
        )
    return out


if __name__ == "__main__":
    print("\n".join(lines(rows())))
