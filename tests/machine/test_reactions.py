"""Forces in the joints against free bodies in equilibrium (oracle/free_bodies.py), and the friction they make."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from gough.errors import ExperimentError, SheetError, WorkspaceError
from gough.frames import quaternion_of_abc_np
from gough.machine.hexapod_parts import JointFriction
from gough.machine.workspace import random_poses
from oracle.free_bodies import FreeBodies
from oracle.machines import MACHINES

GUIDED = ["nist-octahedral", "full-nist-octahedral", "full-okuma-pm600", "full-general"]
IN_JOINTS = JointFriction(coefficient=0.3, platform_radius=0.05, base_radius=0.08, smoothing=0.02)
# forces of 1e4 N from sums of 1e5 N solved with J of condition below 100: 1e-16 * 1e2 * 10, and a decade more
EXACT = 1e-11


@pytest.fixture(params=GUIDED, scope="module")
def guided(request):
    m = MACHINES[request.param]().replace(**{"joints.friction": IN_JOINTS})
    return m, FreeBodies(m)


def motions(m, count=40):
    rng = np.random.default_rng(5)
    x = random_poses(m, count, rng)
    V, Vd, wrench = (rng.normal(size=(count, 6)) * scale for scale in (1.0, [10] * 3 + [30] * 3, [1e3] * 3 + [1e2] * 3))
    return x, V, Vd, wrench


def coordinates(x):
    return np.concatenate([x[:3], quaternion_of_abc_np(x[3:])])


def residuals(m, bodies, x, V, Vd, wrench, net, found, t_B=None, t_A=None):
    """What is missing to equilibrium: of the platform, tubes and sleeves, N and N m; and the largest force.

    `found`: reactions; t_B, t_A (6, 3) torques of joint friction on the struts, at B and at A.
    """
    t_B, t_A = (np.zeros((6, 3)) if t is None else t for t in (t_B, t_A))
    platform, tip, struts = bodies.at(x, V, Vd)
    g, missing = m.gravity, []
    m_r = 0.0 if m.drive.inertia is None else m.drive.inertia * (2 * np.pi / m.drive.lead) ** 2
    force, moment = platform.force - m.platform.mass * g - wrench[:3], platform.moment - wrench[3:]
    moment = moment - np.cross(tip - platform.center, wrench[:3])
    for i, s in enumerate(struts):
        R_B, R_A = found.platform_joint[i], found.base_joint[i]
        N_a, N_b = found.mouth[i], found.end[i]
        force = force + R_B
        moment = moment + np.cross(s.B - platform.center, R_B) + t_B[i]
        # the tube: platform joint, two bushings, drive less friction less what turns the screw; a couple about n
        drive = (net[i] - m_r * s.ldd) * s.n
        mouth, end = s.A + m.strut.sleeve * s.n, s.B - m.strut.tube * s.n
        missing.append(s.moving.force - m.strut.moving.mass * g - R_B - N_a - N_b - drive)
        on_tube = sum(
            np.cross(at - s.moving.center, F) for at, F in ((s.B, R_B), (mouth, N_a), (end, N_b), (s.B, drive))
        )
        short = s.moving.moment - on_tube - t_B[i]
        couple = (s.n @ short) * s.n
        missing.append(short - couple)
        # the sleeve: the same forces back, the base joint; its cross gives no moment about its own axis, and about the
        # axis in the base only what turns the cross
        missing.append(s.fixed.force - m.strut.fixed.mass * g - R_A + N_a + N_b + drive)
        on_sleeve = sum(
            np.cross(at - s.fixed.center, F) for at, F in ((s.A, R_A), (mouth, -N_a), (end, -N_b), (s.B, -drive))
        )
        from_cross = s.fixed.moment - on_sleeve + couple - t_A[i]
        a = m.joints.base_axis[i]
        missing.append([from_cross @ s.cross, from_cross @ a + (m.joints.cross or 0.0) * s.turn])
        missing.append([s.n @ N_a, s.n @ N_b])  # bushings push across only
    scale = np.abs(np.concatenate([np.ravel(found.platform_joint), np.ravel(found.mouth)])).max()
    return np.concatenate([force, moment, *missing]), scale


@pytest.mark.quick("full-general")
def test_platform_tubes_and_sleeves_are_in_equilibrium_under_the_reactions(guided):
    m, bodies = guided
    x, V, Vd, wrench = motions(m)
    found, net = m.reactions(x, V, Vd, wrench), m.inverse_dynamics(x, V, Vd, wrench)
    for k in range(len(x)):
        row = type(found)(*(piece[k] for piece in found))
        missing, scale = residuals(m, bodies, x[k], V[k], Vd[k], wrench[k], net[k], row)
        assert np.abs(missing).max() < EXACT * scale
    sizes = [np.linalg.norm(piece, axis=-1) for piece in (found.mouth, found.end)]
    assert_allclose(found.normal, sizes[0] + sizes[1], rtol=1e-12)


@pytest.mark.quick("full-general")
def test_equilibrium_holds_with_the_friction_of_the_joints_and_it_takes_power_only(guided):
    """Net forces from the equations of motion with joint friction, reactions from the free bodies: both must agree."""
    m, bodies = guided
    p, theta = m.symbols
    z, v, vd, w, loads = (ca.SX.sym(*s) for s in (("z", 7), ("v", 6), ("vd", 6), ("w", 6), ("loads", m.load_count)))
    pi = {key: value for key, (value, _) in m.inertial(p).items()}
    extra = m.joint_friction(p, z, v, loads)
    net = ca.solve(m.jacobian_of(p, z).T, m.inverse_force(p, pi, z, v, vd) - w - extra)
    found = m.reactions_of(p, z, v, vd, net, loads)
    f = ca.Function("f", [theta, z, v, vd, w, loads], [net, extra, *(ca.vec(piece) for piece in found)])
    law, rng = m.joints.friction, np.random.default_rng(8)
    for x, V, Vd, wrench in zip(*motions(m, 15), strict=True):
        given = rng.uniform(500, 3000, m.load_count)
        net_n, extra_n, *pieces = (np.array(o).ravel() for o in f(m.theta, coordinates(x), V, Vd, wrench, given))
        row = type(found)(*(piece.reshape(6, 3) for piece in pieces[:4]), pieces[4])
        slow = law.smoothing
        _, _, struts = bodies.at(x, V, Vd)
        t_B, t_A, power = np.zeros((6, 3)), np.zeros((6, 3)), 0.0
        for i, s in enumerate(struts):
            slip = V[3:] - s.w
            t_B[i] = 0.3 * 0.05 * given[-12 + i] * slip / np.hypot(np.linalg.norm(slip), slow)
            t_A[i] = -0.3 * 0.08 * given[-6 + i] * s.w / np.hypot(np.linalg.norm(s.w), slow)
            power += t_B[i] @ slip - t_A[i] @ s.w
        missing, scale = residuals(m, bodies, x, V, Vd, wrench, net_n, row, t_B, t_A)
        assert np.abs(missing).max() < EXACT * scale
        assert -extra_n @ V == pytest.approx(power, rel=1e-10) and power > 0


@pytest.mark.quick("full-general")
def test_loads_are_the_reactions_of_the_motion_they_are_asked_for(guided):
    """`loads_of` at the forces and accelerations of a motion: normal forces and sizes of the reactions, in order."""
    m, _ = guided
    m = m.replace(friction={"kind": "load_stribeck", "coulomb": 0.0})
    p, theta, z, v, memory, vd, u = (
        *m.symbols, *(ca.SX.sym(*s) for s in (("z", 7), ("v", 6), ("memory", 0), ("vd", 6), ("u", 6)))
    )  # fmt: skip
    f = ca.Function("f", [theta, z, v, vd, u], [m.loads_of(p, z, v, vd, memory, u)])
    x, V, Vd, wrench = motions(m, 10)
    found, net = m.reactions(x, V, Vd, wrench), m.inverse_dynamics(x, V, Vd, wrench)
    wanted = np.concatenate(
        [found.normal, *(np.linalg.norm(r, axis=-1) for r in (found.platform_joint, found.base_joint))], -1
    )
    loads = [np.array(f(m.theta, coordinates(x[k]), V[k], Vd[k], net[k])).ravel() for k in range(10)]
    assert_allclose(loads, wanted, rtol=1e-10)


def test_at_rest_bushings_carry_the_tube_like_a_beam_on_two_supports():
    """One force across, at the middle of a tube without inertia of its own: supports by the law of the lever."""
    m = gk.load_machine("nist-octahedral")
    rest, q = np.zeros(6), m.inverse_kinematics(m.home)
    r, n, g = m.reactions(m.home, rest, rest), m.jacobian(m.home)[:, :3], 9.81
    for i in range(6):
        level = np.hypot(n[i, 0], n[i, 1])  # share of a weight that acts across
        overlap = 2.0 - q[i]
        # by moments of the strut about its base joint
        P = (55 * (q[i] - 0.5) + 95 * 0.35) * g * level / q[i]
        N_a = (55 * g * level * (1.0 - 0.5) - P * 1.0) / overlap  # moments about the tube's end, 1 m from B
        N_b = 55 * g * level - P - N_a
        assert np.linalg.norm(r.mouth[i]) == pytest.approx(abs(N_a), rel=1e-9)
        assert np.linalg.norm(r.end[i]) == pytest.approx(abs(N_b), rel=1e-9)


def test_along_the_published_circle_loads_are_those_of_the_calibration():
    """MACHINES.md 1.3: 0.89 to 2.87 kN, Coulomb friction 160 to 516 N, struts 1.533 to 1.834 m."""
    m = gk.load_machine("nist-octahedral")
    motion = gk.Circle(radius=0.2, feed=0.05, start=np.radians(240.0)).plan(m)
    row = motion.sample(50, motion.count(0.01) - 50, 0.01)  # at constant speed: it starts and stops with 2 m/s2
    normal = m.reactions(row.x, row.xd, row.xdd).normal
    assert (round(normal.min()), round(normal.max())) == (888, 2868)
    assert (round(0.18 * normal.min()), round(0.18 * normal.max())) == (160, 516)
    assert (round(row.q.min(), 3), round(row.q.max(), 3)) == (1.533, 1.834)


def test_strut_reactions_without_a_guide_know_no_bushings():
    m = MACHINES["okuma-pm600"]()
    r = m.reactions(m.home, np.zeros(6), np.zeros(6))
    assert r.mouth is None and r.normal is None and r.platform_joint.shape == (6, 3)
    assert_allclose(r.platform_joint.sum(0), m.platform.mass * m.gravity, atol=1e-9)


def test_forces_of_a_tube_that_has_left_its_sleeve_are_refused():
    short = gk.load_machine("nist-octahedral").replace(**{"strut.tube": 0.68})
    x = np.stack([short.home, short.home - [0, 0, 0.05, 0, 0, 0]])
    message = r"index \[1\]: strut 1: the tube has left its sleeve, got 1.71\d+ m \(limit 1.679 m\); lengthen"
    with pytest.raises(WorkspaceError, match=message):
        short.reactions(x, np.zeros(6), np.zeros(6))
    bare = short.replace(**{"strut.tube": None, "strut.sleeve": None})
    assert bare.reactions(x, np.zeros(6), np.zeros(6)).normal is None
    with pytest.raises(ExperimentError, match="friction.kind: load_lugre needs the normal force between the tubes"):
        gk.simulate(bare, gk.PID(bandwidth=9.0), gk.Circle(radius=0.02, feed=0.05))
    with pytest.raises(ExperimentError, match=r"limits.length: the tube leaves its sleeve .* longest strut 1.9 m"):
        gk.simulate(short, gk.PID(bandwidth=9.0), gk.Circle(radius=0.02, feed=0.05))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"strut.tube": None}, "strut.tube: strut.sleeve and strut.tube belong together; give both or neither"),
        (
            {"joints.base_axis": None},
            "joints.friction: needs joints.base_axis, which fixes the spin of the struts; give joints.base_axis or "
            "leave joints.friction out",
        ),
        ({"strut.moving.offset": [0.01, 0.0], "joints.base_axis": None}, "strut.moving.offset: needs joints.base_axis"),
        ({"joints.cross": -1.0}, "joints.cross: must be at least 0 kg m2, got -1 kg m2"),
        (
            {"strut.moving.inertia": np.eye(3)},
            "strut.moving.transverse: inertia already says it; leave transverse or inertia out",
        ),
        ({"strut.fixed.transverse": None}, "strut.fixed.transverse: is missing; give transverse, or the full inertia"),
        (
            {"strut.fixed.transverse": None, "strut.fixed.inertia": np.diag([1.0, 1.0, 5.0])},
            "strut.fixed.inertia: inertia violates the triangle inequality",
        ),
        ({"joints.friction.base_radius": -0.1}, "joints.friction.base_radius: must be at least 0 m, got -0.1 m"),
    ],
)
def test_p4_struts_and_joints_that_cannot_be_are_refused(changes, message):
    with pytest.raises(SheetError, match=message) as caught:
        gk.load_machine("nist-octahedral").replace(**changes)
    assert caught.value.exit_status == 2
