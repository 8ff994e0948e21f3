"""Energy of a machine let go: kept without friction, and with it lost to the last joule that friction took.

The equations of motion are the machine's, the step is the sub-step of the plant (ARCHITECTURE.md) written out once
more, and the energy is that of oracle/lagrange.py (lagrange_hexaglide.py): kinetic and potential energy of thirteen
bodies, the screws, and a spring in each joint.
"""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from gough.frames import abc_of_rotation_np, rotation_of_quaternion_np
from gough.kernel import Schedule, Signal, Task, compile
from gough.machine.hexapod_parts import JointFriction
from gough.mechanics.friction import LuGre, Stribeck
from gough.mechanics.linear import solve_spd
from gough.mechanics.load_friction import LoadLuGre, LoadStribeck
from oracle import lagrange, lagrange_hexaglide
from oracle.hexaglides import HEXAGLIDES
from oracle.machines import MACHINES

SPRING = 2e5  # N/m in each joint, at rest at home: oscillations of some 3 to 10 Hz, and 4 to 9 cm under gravity
KICK = np.array([0.1, -0.2, 0.05, 0.3, -0.2, 0.1])  # m/s, rad/s
OFFSET = np.array([0.02, -0.01, 0.03, 0.05, -0.04, 0.06])  # m, rad, from home


def sub_step(m, friction=True):
    """(h, z, v, memory, a, work) -> the same after h: memory half a step, mechanics one of RK4, memory half a step.

    a: mean acceleration of the sub-step before, which with the forces of now gives what loads the joints.
    work: what friction took, J, by the same RK4.
    """
    p = m.at(ca.SX(ca.DM(m.theta)))
    pi = {key: value for key, (value, _) in m.inertial(p).items()}
    rest = ca.DM(m.inverse_kinematics(m.home))
    friction = friction and m.friction is not None
    h, work = ca.SX.sym("h"), ca.SX.sym("work")
    z, v, memory, a = (ca.SX.sym(name, n) for name, n in (("z", 7), ("v", 6), ("memory", 6), ("a", 6)))

    def spring(z):
        return -SPRING * (m.joints_of(p, z) - rest)

    loads = m.loads_of(p, z, v, a, memory, spring(z)) if m.load_count else None

    def rate(z, v, memory):
        M, bias = m.mass_and_bias(p, pi, z, v)
        J = m.jacobian_of(p, z)
        qd = J @ v
        lost = m.strut_friction(p, qd, memory, loads) if friction else ca.SX(6, 1)
        in_joints = m.joint_friction(p, z, v, loads) if m.load_count else ca.SX(6, 1)
        u = spring(z) - lost
        return m.rate(p, z, v), solve_spd(M, J.T @ u + in_joints - bias), ca.dot(lost, qd) - ca.dot(in_joints, v)

    def half(z, v, memory):
        return m.memory_advanced(p, m.jacobian_of(p, z) @ v, memory, h / 2, loads) if friction else memory

    held = half(z, v, memory)
    k1 = rate(z, v, held)
    k2 = rate(z + h / 2 * k1[0], v + h / 2 * k1[1], held)
    k3 = rate(z + h / 2 * k2[0], v + h / 2 * k2[1], held)
    k4 = rate(z + h * k3[0], v + h * k3[1], held)
    z1, v1, w1 = (
        s + h / 6 * (a + 2 * b + 2 * c + d) for s, a, b, c, d in zip((z, v, work), k1, k2, k3, k4, strict=True)
    )
    z1 = m.normalised(m, z1)
    ends = [z1, v1, half(z1, v1, held), (v1 - v) / h, w1]
    return ca.Function("sub_step", [h, z, v, memory, a, work], ends)


class Release:
    """The machine let go from OFFSET with KICK.  `every`: sub-steps between two rows."""

    def __init__(self, m, friction=True, every=1):
        self.m, self.every = m, every
        names = ("z", "v", "memory", "acceleration", "work")
        signals = [Signal("h", 1, "parameter"), Signal("z", 7, "state"), Signal("v", 6, "state")]
        signals += [Signal("memory", 6, "state"), Signal("acceleration", 6, "state"), Signal("work", 1, "state")]
        task = Task("sub_step", sub_step(m, friction), ("h", *names), names)
        self.kernel = compile(Schedule(tuple(signals), substep=task, substeps=every, log=("z", "v", "work")))

    def run(self, duration, h, offset=OFFSET, kick=KICK):
        """Rows of (z, v, work) with steps of h seconds, (n + 1, 14)."""
        z0 = np.array(self.m.coordinates_of(self.m, ca.DM(self.m.home + offset))).ravel()
        zero = np.zeros(6)
        start = {"z": z0, "v": kick, "memory": zero, "acceleration": zero, "work": np.zeros(1)}
        ticks = round(duration / h / self.every) + 1
        rows = self.kernel.start(parameters={"h": np.array([h])}, states=start).advance(ticks)[:, 0]
        assert len(rows) == ticks and np.isfinite(rows).all()
        return rows


def energies(m, rows):
    """Kinetic and total energy of rows of (z, v, ...), J, by the oracle."""
    oracle = {"hexapod": lagrange.oracle, "hexaglide": lagrange_hexaglide.oracle}[m.kind]
    o = oracle(m, SPRING, m.inverse_kinematics(m.home))
    x = np.concatenate([rows[:, :3], abc_of_rotation_np(rotation_of_quaternion_np(rows[:, 3:7]))], -1)
    T, U = np.empty(len(x)), np.empty(len(x))
    for k in range(len(x)):
        T[k] = float(o.kinetic(x[k], np.linalg.solve(np.array(o.twist_matrix(x[k])), rows[k, 7:13])))
        U[k] = float(o.potential(x[k]))
    return T, T + U


LONG = (
    "eth-hexaglide",
    "hexaglide-with-legs",
    "full-nist-octahedral",
    "full-okuma-pm600",
    "loaded, smooth",
    "joints alone",
)


def quick_and_slow(names):
    marks = dict.fromkeys(LONG, pytest.mark.slow) | {"general-hexaglide": pytest.mark.full}
    return [pytest.param(name, marks=marks[name]) if name in marks else name for name in names]


@pytest.mark.quick("nist-octahedral")
@pytest.mark.parametrize("name", quick_and_slow([*MACHINES, *HEXAGLIDES]))
def test_energy_drifts_by_less_than_1e_8_in_ten_seconds_without_friction(name):
    m = (MACHINES | HEXAGLIDES)[name]().frictionless()
    # RK4 takes (w h)^5 / 72 of a mode's energy a radian: at h w = 0.016 and 310 rad (hexapods, w = 31 rad/s) 4e-9, at
    # 0.011 and 430 rad (hexaglides, w = 43 rad/s) 1e-9
    h = 5e-4 if m.kind == "hexapod" else 2.5e-4
    rows = Release(m, every=round(0.02 / h)).run(10.0, h)
    T, E = energies(m, rows)
    assert np.ptp(rows[:, :3], axis=0).max() > 0.05, "the machine must move to prove anything"
    assert np.abs(E - E[0]).max() < 1e-8 * T.max()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["nist-octahedral", "okuma-pm600", "general"])
def test_energy_drifts_by_less_than_1e_8_in_ten_seconds_from_each_of_twenty_starts(name):
    release = Release(MACHINES[name]().replace(friction=None, **{"joints.friction": None}), every=40)
    rng = np.random.default_rng(20)
    for _ in range(20):
        offset, kick = (base * rng.uniform(-1, 1, 6) for base in (np.abs(OFFSET), np.abs(KICK)))
        T, E = energies(release.m, release.run(10.0, 5e-4, offset, kick))
        assert np.abs(E - E[0]).max() < 1e-8 * T.max()


def test_steps_converge_with_fourth_order():
    """The differences of the end states of h, h/2, h/4, ... fall by 2^4."""
    release = Release(MACHINES["general"](), friction=False)
    ends = np.array([release.run(0.4, h)[-1, :13] for h in (2e-3, 1e-3, 5e-4, 2.5e-4)])
    change = np.linalg.norm(np.diff(ends, axis=0), axis=1)
    slopes = np.log2(change[:-1] / change[1:])
    assert np.all(np.abs(slopes - 4.0) < 0.1), slopes


STEADY = {"coulomb": 300.0, "static": 400.0, "stribeck": 0.02, "viscous": 500.0}
LOADED = {"coulomb": 0.2, "static": 0.25, "stribeck": 0.02, "viscous": 0.3, "viscous_offset": 200.0}
BRISTLES = {"stiffness": 1e7, "damping": 5e4}
LAWS = {
    "smooth": ("general", Stribeck(**STEADY, smoothing=0.01)),
    "memory": ("general", LuGre(**STEADY, **BRISTLES)),
    "loaded, smooth": ("full-general", LoadStribeck(**LOADED, smoothing=0.01)),
    "loaded, memory": ("full-general", LoadLuGre(**LOADED, **BRISTLES)),
    "joints alone": ("full-general", None),
}
IN_JOINTS = JointFriction(coefficient=0.1, platform_radius=0.05, base_radius=0.08, smoothing=0.02)


def machine_with(name):
    """A library machine with the friction of its sheet, or one of the general ones with a law of LAWS."""
    if name not in LAWS:
        return (MACHINES | HEXAGLIDES)[name]()
    base, law = LAWS[name]
    m = MACHINES[base]().replace(friction=law)
    return m.replace(**{"joints.friction": IN_JOINTS}) if base == "full-general" else m


@pytest.mark.quick("nist-octahedral")
@pytest.mark.parametrize("name", quick_and_slow([*LAWS, "nist-octahedral", "okuma-pm600", "eth-hexaglide"]))
def test_energy_lost_is_the_work_of_friction(name):
    m = machine_with(name)
    rows = Release(m, every=1000).run(1.0, 2e-5)  # a hundredth of the time of a reversal through v_0
    T, E = energies(m, rows)
    work = rows[:, 13]
    assert work[-1] > (0.2 if m.friction else 0.01) * T.max(), "friction must have taken something"
    assert np.abs(E - E[0] + work).max() < 1e-7 * T.max()
