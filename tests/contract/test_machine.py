"""What every machine of the library promises, whatever it is made of (CONTRACT.md 1).  MACHINES: conftest.py."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

from gough.frames import abc_of_rotation_np, rotation_of_abc_np, rotation_of_vector_np
from gough.kernel import Schedule, Signal, Task, compile
from gough.machine.workspace import check_poses, margin_names, random_poses
from gough.mechanics.linear import solve_spd

# Forces are sums of some 100 products, solved with J of condition below 100: a relative 1e-12 is what double precision
# leaves.  A wrong term is off by 1e-4 or more.
AGREE = 1e-10
N = 500


@pytest.fixture(scope="module")
def states(machine):
    """x, V, V', wrench of random states: poses of the workspace, twists to 1 m/s and 1 rad/s and more."""
    rng, d = np.random.default_rng(20240611), len(machine.task)
    x = random_poses(machine, N, rng)
    V = (rng.normal(size=(N, 6)) * [1, 1, 1, 1.5, 1.5, 1.5])[:, :d]
    Vd = (rng.normal(size=(N, 6)) * [10, 10, 10, 30, 30, 30])[:, :d]
    return x, V, Vd, rng.normal(size=(N, 6)) * [1000, 1000, 1000, 100, 100, 100]


def relative(found, wanted):
    """Largest difference of a row over the largest entry of the row wanted."""
    return (np.abs(found - wanted).max(-1) / np.abs(wanted).max(-1)).max()


def moved(x, V, Vd, t):
    """Poses at times t (k,) of the motions with task rate V and its rate V' at 0, through x.  (k, N, d)."""
    t = np.asarray(t)[:, None, None]
    if x.shape[-1] == 3:
        return x + V * t + Vd * t**2 / 2
    turn = rotation_of_vector_np(V[:, 3:] * t + Vd[:, 3:] * t**2 / 2)
    p = x[:, :3] + V[:, :3] * t + Vd[:, :3] * t**2 / 2
    return np.concatenate([p, abc_of_rotation_np(turn @ rotation_of_abc_np(x[:, 3:]))], -1)


def angle_between(x, y):
    if x.shape[-1] == 3:  # the tilt follows from the place
        return np.zeros(1)
    turn = np.swapaxes(rotation_of_abc_np(x[..., 3:]), -1, -2) @ rotation_of_abc_np(y[..., 3:])
    # sine form: arccos of a trace loses half the digits near 0
    return np.linalg.norm(turn - np.swapaxes(turn, -1, -2), axis=(-1, -2)) / np.sqrt(8)


def twists(machine, x, V):
    """Of the tool at task rates V, by differences of its pose.  (N, 6)."""
    if x.shape[-1] == 6:
        return V
    h = 1e-3
    poses = [machine.tool_pose(x + k * h * V) for k in range(-3, 4)]
    R = [rotation_of_abc_np(pose[:, 3:]) for pose in poses]
    weights = np.array([-1, 9, -45, 0, 45, -9, 1]) / 60 / h
    S = sum(w * Rk for w, Rk in zip(weights, R, strict=True)) @ np.swapaxes(R[3], -1, -2)
    turn = np.stack([S[:, 2, 1] - S[:, 1, 2], S[:, 0, 2] - S[:, 2, 0], S[:, 1, 0] - S[:, 0, 1]], -1) / 2
    return np.concatenate([V, turn], -1)


# -- kinematics -------------------------------------------------------------------------------------------------------


def test_forward_kinematics_undo_inverse_kinematics(machine, states):
    x, rng = states[0], np.random.default_rng(1)
    q = machine.inverse_kinematics(x)
    near = x + (rng.normal(size=(N, 6)) * [0.005, 0.005, 0.005, 0.02, 0.02, 0.02])[:, : x.shape[1]]
    for start in (near, None):  # from 5 mm and 1 deg away, and from home
        found = machine.forward_kinematics(q, near=start)
        assert np.abs(found - x)[:, :3].max() < 1e-10 and angle_between(found, x).max() < 1e-10
        assert np.abs(machine.inverse_kinematics(found) - q).max() < 1e-10


def test_hostile_starts_are_answered_with_the_right_pose_or_none(machine, states):
    x, rng = states[0], np.random.default_rng(2)
    q = machine.inverse_kinematics(x)
    near = np.concatenate([machine.home[:3] + rng.normal(size=(N, 3)) * 0.5, rng.uniform(-np.pi, np.pi, (N, 3))], 1)
    near = near[:, : x.shape[1]]
    found, status = machine.forward_kinematics(q, near=near, on_fail="nan")
    ok = status == 0
    assert ok.any() and (not ok.all() or x.shape[1] == 3)  # three sliders say where the tool is from any start
    assert np.isnan(found[~ok]).all()
    assert np.abs(found[ok] - x[ok])[:, :3].max() < 1e-8 and angle_between(found[ok], x[ok]).max() < 1e-8


def test_joint_rates_and_accelerations_are_the_differences_of_joints(machine, states):
    x, V, Vd, _ = states
    h = 1e-3
    q = machine.inverse_kinematics(moved(x, V, Vd / 10, h * np.arange(-3, 4)))
    at, qd, qdd = machine.joint_motion(x, V, Vd / 10)
    assert_allclose(at, q[3], rtol=0, atol=1e-14)
    # central differences of sixth order; 7th and 8th derivatives of q of rates near 3 1/s: 1e-18 x 3^7 x 1e2 = 1e-13
    first = np.tensordot(np.array([-1, 9, -45, 0, 45, -9, 1]) / 60 / h, q, 1)
    second = np.tensordot(np.array([2, -27, 270, -490, 270, -27, 2]) / 180 / h**2, q, 1)
    assert_allclose(qd, first, rtol=0, atol=1e-7)
    assert_allclose(qdd, second, rtol=0, atol=1e-6)  # 1e-15 / h^2 of rounding alone is 1e-9


def test_jacobian_and_its_rate_are_those_of_the_joint_motion(machine, states):
    """q' = J V, and q'' - J V' = J' V with J' by differences along the motion."""
    x, V, Vd, _ = states
    _, qd, qdd = machine.joint_motion(x, V, Vd / 10)
    J = machine.jacobian(x)
    assert_allclose(np.einsum("kij,kj->ki", J, V), qd, rtol=0, atol=1e-13)
    h = 1e-3
    Jd = np.tensordot(
        np.array([-1, 9, -45, 0, 45, -9, 1]) / 60 / h, machine.jacobian(moved(x, V, Vd / 10, h * np.arange(-3, 4))), 1
    )
    rest = qdd - np.einsum("kij,kj->ki", J, Vd / 10)
    assert_allclose(np.einsum("kij,kj->ki", Jd, V), rest, rtol=0, atol=1e-7 * np.abs(rest).max())


def test_forces_in_the_joints_and_the_wrench_they_hold_have_one_power(machine, states):
    """u . q' = -w . V_T for a motion without mass: u(w) - u(0) at V' = 0 and any V, V_T the twist of the tool."""
    x, V, Vd, wrench = states
    twist = twists(machine, x, V)
    u = machine.inverse_dynamics(x, V, Vd, wrench) - machine.inverse_dynamics(x, V, Vd)
    qd = machine.joint_motion(x, V, Vd)[1]
    power = (u * qd).sum(-1) + (wrench * twist).sum(-1)
    # 1e-8: the twist by differences, where it is not the task rate itself
    assert (np.abs(power) / np.abs(u * qd).sum(-1)).max() < (1e-10 if x.shape[-1] == 6 else 1e-8)


# -- dynamics ---------------------------------------------------------------------------------------------------------


def test_mass_matrix_is_symmetric_and_positive_definite(machine, states):
    M = machine.mass_matrix(states[0])
    assert np.abs(M - np.swapaxes(M, -1, -2)).max() <= 1e-13 * np.abs(M).max()
    assert np.linalg.eigvalsh(M).min() > 0


def test_inverse_dynamics_are_mass_times_acceleration_plus_bias(machine, states):
    x, V, Vd, _ = states
    M, h = machine.arrays.run("mass", x, V)
    tau = np.einsum("kij,kj->ki", M.reshape(-1, len(machine.task), len(machine.task)), Vd) + h
    u = machine.inverse_dynamics(x, V, Vd)
    assert relative(np.einsum("kji,kj->ki", machine.jacobian(x), u), tau) < AGREE


def test_forward_dynamics_undo_inverse_dynamics(machine, states):
    x, V, Vd, wrench = states
    u = machine.inverse_dynamics(x, V, Vd, wrench)
    assert relative(machine.forward_dynamics(x, V, u, wrench), Vd) < AGREE


def test_regressor_times_parameters_is_inverse_dynamics(machine, states):
    x, V, Vd, _ = states
    found = machine.regressor(x, V, Vd) @ machine.parameters.values
    assert relative(found, machine.inverse_dynamics(x, V, Vd)) < 1e-11


def test_bias_does_no_work_but_that_of_gravity_and_of_the_changing_mass(machine, states):
    """V . (M' V / 2 - h(V) + h(0)) = 0: a Coriolis matrix C with M' - 2 C antisymmetric exists."""
    x, V, *_ = states
    p, theta = machine.symbols
    n, Z = len(machine.velocities), machine.coordinates(x)
    z, v = ca.SX.sym("z", machine.coordinate_count), ca.SX.sym("v", n)
    pi = {key: value for key, (value, _) in machine.inertial(p).items()}
    M, h = machine.mass_and_bias(p, pi, z, v)
    h0 = ca.substitute(h, v, ca.SX.zeros(n))
    Md = ca.reshape(ca.jtimes(ca.vec(M), z, machine.rate(p, z, v)), n, n)
    f = ca.Function("f", [theta, z, v], [ca.dot(v, Md @ v / 2 - h + h0), ca.dot(ca.fabs(v), ca.fabs(h - h0))])
    for k in range(0, N, 5):
        found, scale = f(machine.theta, Z[k], V[k])
        assert abs(float(found)) < 1e-12 * float(scale)


def test_the_coriolis_form_is_passive_and_says_the_same_as_inverse_dynamics(machine, states):
    """With C(v) s of `passive_force`: s . (M' s / 2 - C(v) s) = 0 for every s, and C(v) v is that of h."""
    x, V, Vd, other = states
    p, theta = machine.symbols
    n, Z = len(machine.velocities), machine.coordinates(x)
    z, v, s, vd = ca.SX.sym("z", machine.coordinate_count), *(ca.SX.sym(name, n) for name in ("v", "s", "vd"))
    pi = {key: value for key, (value, _) in machine.inertial(p).items()}
    rest = ca.SX(n, 1)
    Cs = machine.passive_force(p, pi, z, v, s, rest) - machine.inverse_force(p, pi, z, rest, rest)
    M, _ = machine.mass_and_bias(p, pi, z, v)
    Md = ca.reshape(ca.jtimes(ca.vec(M), z, machine.rate(p, z, v)), n, n)
    same = machine.passive_force(p, pi, z, v, v, vd) - machine.inverse_force(p, pi, z, v, vd)
    outputs = [
        ca.dot(s, Md @ s / 2 - Cs),
        ca.dot(ca.fabs(s), ca.fabs(Cs)),
        same,
        machine.inverse_force(p, pi, z, v, vd),
    ]
    f = ca.Function("f", [theta, z, v, s, vd], outputs)
    for k in range(0, N, 10):
        way = (other[k] / [1000, 1000, 1000, 100, 100, 100])[:n]
        power, scale, off, force = f(machine.theta, Z[k], V[k], way, Vd[k])
        assert abs(float(power)) < 1e-11 * float(scale)
        assert np.abs(np.array(off)).max() < 1e-11 * np.abs(np.array(force)).max()


SPRING = 2e5  # N/m at each joint, at rest at home: oscillations of some 3 to 10 Hz


@pytest.mark.quick("nist-octahedral", "eth-hexaglide")
def test_a_machine_let_go_on_springs_keeps_its_energy(machine):
    """Kinetic energy V' M V / 2 and that of the springs, over 2 s without gravity and friction."""
    m = machine.frictionless().replace(gravity=[0.0, 0.0, 0.0])
    p = m.at(ca.SX(ca.DM(m.theta)))
    pi = {key: value for key, (value, _) in m.inertial(p).items()}
    rest = m.inverse_kinematics(m.home)
    d, size, n = len(m.task), m.coordinate_count, len(m.velocities)
    z, v, h = ca.SX.sym("z", size), ca.SX.sym("v", n), ca.SX.sym("h")

    def rate(z, v):
        M, bias = m.mass_and_bias(p, pi, z, v)
        return m.rate(p, z, v), solve_spd(M, m.jacobian_of(p, z).T @ (-SPRING * (m.joints_of(p, z) - rest)) - bias)

    k1 = rate(z, v)
    k2 = rate(z + h / 2 * k1[0], v + h / 2 * k1[1])
    k3 = rate(z + h / 2 * k2[0], v + h / 2 * k2[1])
    k4 = rate(z + h * k3[0], v + h * k3[1])
    ends = [s + h / 6 * (a + 2 * b + 2 * c + d) for s, a, b, c, d in zip((z, v), k1, k2, k3, k4, strict=True)]
    step = ca.Function("step", [h, z, v], [m.normalised(p, ends[0]), ends[1]])
    signals = [Signal("h", 1, "parameter"), Signal("z", size, "state"), Signal("v", n, "state")]
    schedule = Schedule(
        tuple(signals), substep=Task("step", step, ("h", "z", "v"), ("z", "v")), substeps=10, log=("z", "v")
    )
    start = {
        "z": m.coordinates(m.home + np.array([0.02, -0.01, 0.03, 0.05, -0.04, 0.06])[:d]),
        "v": np.array([0.1, -0.2, 0.05, 0.3, -0.2, 0.1])[:n],
    }
    rows = compile(schedule).start(parameters={"h": np.array([2e-4])}, states=start).advance(1001)[:, 0]
    shown = ca.Function("shown", [z], [m.task_of(p, z), m.joints_of(p, z)]).map(len(rows))
    x, q = (np.array(part).T for part in shown(rows[:, :size].T))
    V = rows[:, size:]
    T = np.einsum("ki,kij,kj->k", V, m.velocity_mass(x), V) / 2
    E = T + SPRING / 2 * ((q - rest) ** 2).sum(1)
    assert np.ptp(x[:, :3], axis=0).max() > 0.03, "the machine must move to prove anything"
    # RK4 at w h = 60 x 2e-4 = 0.012 loses (w h)^5 / 72 a radian, over 120 rad: 4e-10
    assert np.abs(E - E[0]).max() < 1e-8 * T.max()


# -- limits and words -------------------------------------------------------------------------------------------------


def test_random_poses_of_the_workspace_are_inside_every_limit(machine, states):
    check_poses(machine, states[0])


def test_every_limit_says_in_words_that_it_is_exceeded(machine):
    names = machine.limit_names
    assert len(set(names)) == len(names) and len(set(margin_names(machine))) == len(margin_names(machine))
    for index, name in enumerate(names):
        rule, value, limit = machine.limit_told(index, -1e-3)
        assert rule.split(":")[0].split(" cannot")[0] in name and value != limit
        assert all(text and "nan" not in text for text in (rule, value, limit))


def test_the_last_limit_is_det_j(machine, states):
    """The kernel, forward kinematics and the messages rely on it."""
    x = states[0][:50]
    last = machine.arrays.run("margins", machine.coordinates(x))[0][:, -1]
    ratio = np.linalg.det(machine.jacobian(x)) / np.linalg.det(machine.jacobian(machine.home))
    assert_allclose(last, ratio - machine.limits.determinant, rtol=1e-10)


def test_every_parameter_has_a_name_a_value_and_a_unit(machine):
    for found in (machine.parameters, machine.parameters_of(friction=True)):
        assert len(found.names) == len(found.units) == len(found.values) == len(set(found.names))
        assert np.isfinite(found.values).all()
    one = np.ones(len(machine.task))
    Y = machine.regressor(machine.home, one, one, friction=True)
    assert Y.shape == (machine.joints_count, len(machine.parameters_of(friction=True).names))


def test_the_drawing_is_of_finite_points_in_W(machine):
    for part in machine.drawing(machine.home):
        points = np.array(part["points"])
        assert part["name"] and points.shape[1] == 3 and np.isfinite(points).all()
    names = [part["name"] for part in machine.drawing(machine.home)]
    assert len(set(names)) == len(names) and set(machine.joint_names) <= set(names)
