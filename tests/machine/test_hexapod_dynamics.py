"""The dynamics of the hexapod against the energies of oracle/lagrange.py, and against what mechanics promises."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

from gough.frames import abc_of_rotation_np, rotation_of_abc_np
from gough.mechanics.friction import Stribeck
from oracle.machines import elementary

# Rounding: forces are sums of some 100 products, solved with J of condition below 100 (limits.condition), so a relative
# 1e-16 * 100 * 100 = 1e-12 is what double precision leaves.  1e-10 is the promise; a wrong term is off by 1e-4 or more.
AGREE = 1e-10


def relative(found, wanted):
    """Largest difference of a row over the largest entry of the row wanted."""
    return (np.abs(found - wanted).max(-1) / np.abs(wanted).max(-1)).max()


# -- against energies -------------------------------------------------------------------------------------------------


@pytest.mark.quick("nist-octahedral", "full-general")
def test_inverse_dynamics_are_those_of_the_energies(machine, oracle, states):
    x, V, Vd, wrench = states
    assert relative(machine.inverse_dynamics(x, V, Vd, wrench), oracle.joint_forces(x, V, Vd, wrench)) < AGREE


def test_lengths_and_jacobian_are_those_of_the_oracle(machine, oracle, states):
    x, V, *_ = states
    q, qd, _ = machine.joint_motion(x, V, np.zeros(6))
    for k in range(0, 1000, 20):
        yd = np.linalg.solve(np.array(oracle.twist_matrix(x[k])), V[k])
        assert_allclose(q[k], np.array(oracle.lengths(x[k])).ravel(), rtol=1e-14)
        assert_allclose(qd[k], np.array(oracle.length_rate(x[k])) @ yd, atol=1e-13)  # a few m/s, rounding


@pytest.mark.quick("nist-octahedral", "full-general")
def test_kinetic_energy_is_half_V_M_V(machine, oracle, states):
    x, V, *_ = states
    T = np.einsum("ki,kij,kj->k", V, machine.mass_matrix(x), V) / 2
    wanted = [
        float(oracle.kinetic(x[k], np.linalg.solve(np.array(oracle.twist_matrix(x[k])), V[k]))) for k in range(1000)
    ]
    assert_allclose(T, wanted, rtol=1e-12)


@pytest.mark.quick("nist-octahedral", "full-general")
def test_power_of_the_forces_is_the_rate_of_the_energy(machine, oracle, states):
    """u . q' + wrench . V = d/dt (T + U), with T and U of the oracle differentiated along the motion."""
    x, V, Vd, wrench = states
    y, yd, ydd = (ca.SX.sym(name, 6) for name in ("y", "yd", "ydd"))
    E = oracle.kinetic(y, yd) + oracle.potential(y)
    rate = ca.Function("rate", [y, yd, ydd], [ca.jtimes(E, y, yd) + ca.jtimes(E, yd, ydd)])
    u, (_, qd, _) = machine.inverse_dynamics(x, V, Vd, wrench), machine.joint_motion(x, V, Vd)
    power = (u * qd).sum(-1) + (wrench * V).sum(-1)
    wanted = np.array([float(rate(*oracle.coordinates(x[k], V[k], Vd[k]))) for k in range(1000)])
    scale = np.abs(u * qd).sum(-1) + np.abs(wrench * V).sum(-1)
    assert (np.abs(power - wanted) / scale).max() < 1e-12


@pytest.mark.quick("nist-octahedral", "full-general")
def test_bias_is_that_of_christoffels_symbols_of_the_mass_matrix(machine, oracle, states):
    """Velocity terms follow from M alone.  Christoffel's C also makes M' - 2 C antisymmetric."""
    x, V, *_ = states
    y, yd_ = ca.SX.sym("y", 6), ca.SX.sym("yd", 6)
    Md = ca.Function("Md", [y, yd_], [ca.reshape(ca.jtimes(ca.vec(oracle.mass(y)), y, yd_), 6, 6)])
    dU = ca.Function("dU", [y], [ca.gradient(oracle.potential(y), y)])
    M_all, h_all = (piece for piece in machine.arrays.run("mass", x, V))
    for k in range(0, 1000, 10):
        E = np.array(oracle.twist_matrix(x[k]))
        yd = np.linalg.solve(E, V[k])
        C = np.array(oracle.christoffel(x[k], yd))
        M = M_all[k].reshape(6, 6).T
        ours = E.T @ (h_all[k] + M @ np.array(oracle.twist_drift(x[k], yd)).ravel())
        wanted = C @ yd + np.array(dU(x[k])).ravel()
        assert_allclose(ours, wanted, atol=1e-11 * np.abs(wanted).max())
        N = np.array(Md(x[k], yd)) - 2 * C
        assert_allclose(N, -N.T, atol=1e-12 * np.abs(C).max() + 1e-12)


# -- what holds of every machine --------------------------------------------------------------------------------------


def test_mass_matrix_is_symmetric_and_positive_definite(machine, states):
    M = machine.mass_matrix(states[0])
    assert np.abs(M - np.swapaxes(M, -1, -2)).max() <= 1e-13 * np.abs(M).max()
    assert np.linalg.eigvalsh(M).min() > 0


@pytest.mark.quick("nist-octahedral", "full-general")
def test_bias_does_no_work_but_that_of_gravity_and_of_the_changing_mass(machine, states):
    """V . (M' V / 2 - h(V) + h(0)) = 0, the passivity of M' - 2 C, from the machine's own M."""
    x, V, *_ = states
    p, theta = machine.symbols
    z, v = ca.SX.sym("z", 7), ca.SX.sym("v", 6)
    pi = {key: value for key, (value, _) in machine.inertial(p).items()}
    M, h = machine.mass_and_bias(p, pi, z, v)
    h0 = ca.substitute(h, v, ca.SX.zeros(6))
    Md = ca.reshape(ca.jtimes(ca.vec(M), z, machine.rate(p, z, v)), 6, 6)
    f = ca.Function("f", [theta, z, v], [ca.dot(v, Md @ v / 2 - h + h0), ca.dot(ca.fabs(v), ca.fabs(h - h0))])
    coordinates = ca.Function("z", [z_ := ca.SX.sym("x", 6)], [machine.coordinates_of(machine, z_)])
    for k in range(0, 1000, 5):
        found, scale = f(machine.theta, coordinates(x[k]), V[k])
        assert abs(float(found)) < 1e-12 * float(scale)


@pytest.mark.quick("full-general")
def test_forward_dynamics_undo_inverse_dynamics(machine, states):
    x, V, Vd, wrench = states
    u = machine.inverse_dynamics(x, V, Vd, wrench)
    assert relative(machine.forward_dynamics(x, V, u, wrench), Vd) < AGREE


def test_inverse_force_is_mass_times_acceleration_plus_bias(machine, states):
    x, V, Vd, _ = states
    M, h = machine.arrays.run("mass", x, V)
    tau = np.einsum("kij,kj->ki", M.reshape(-1, 6, 6), Vd) + h
    u = machine.inverse_dynamics(x, V, Vd)
    assert relative(np.einsum("kji,kj->ki", machine.jacobian(x), u), tau) < AGREE


@pytest.mark.quick("full-general")
def test_regressor_times_parameters_is_inverse_dynamics(machine, states):
    x, V, Vd, _ = states
    found = machine.regressor(x, V, Vd) @ machine.parameters.values
    assert relative(found, machine.inverse_dynamics(x, V, Vd)) < 1e-11


def test_regressor_of_one_machine_predicts_another_of_the_same_geometry(okuma):
    """Y knows nothing of the inertial numbers: with those of another machine it gives the other machine's forces."""
    other = okuma.replace(
        **{"platform.mass": 211.0, "strut.moving.center": 0.3, "strut.fixed.axial": 0.7, "drive.inertia": 5e-3}
    )
    rng = np.random.default_rng(1)
    x, V, Vd = okuma.home, rng.normal(size=(50, 6)), 10 * rng.normal(size=(50, 6))
    x = np.broadcast_to(x, V.shape)
    found = okuma.regressor(x, V, Vd) @ other.parameters.values
    assert relative(found, other.inverse_dynamics(x, V, Vd)) < 1e-11


def test_regressor_with_friction_adds_coulomb_and_viscous_forces(nist):
    nist = nist.replace(friction=Stribeck(coulomb=300.0, viscous=930.0))
    rng = np.random.default_rng(2)
    V, Vd = rng.normal(size=(20, 6)), rng.normal(size=(20, 6))
    x = np.broadcast_to(nist.home, V.shape)
    Y, pi = nist.regressor(x, V, Vd, friction=True), nist.parameters_of(friction=True)
    qd = nist.joint_motion(x, V, Vd)[1]
    assert Y.shape == (20, 6, len(pi.names))
    added = Y @ pi.values - nist.inverse_dynamics(x, V, Vd)
    assert_allclose(added, 300 * np.sign(qd) + 930 * qd, atol=1e-8)  # forces of 1e4 N, to 1e-12 relative


def test_regressor_with_friction_has_what_no_load_scales(nist):
    """CONTRACT.md 1: friction that scales with normal forces is not linear, so the coefficients are not in it."""
    pi = nist.parameters_of(friction=True)
    found = dict(zip(pi.names, pi.values, strict=True))
    assert [found[f"friction.coulomb[{i}]"] for i in range(6)] == [0] * 6
    assert [found[f"friction.viscous[{i}]"] for i in range(6)] == [94] * 6


def test_parameters_are_named_with_units_and_hold_the_steiner_moments(nist):
    pi = dict(zip(nist.parameters.names, zip(nist.parameters.values, nist.parameters.units, strict=True), strict=True))
    assert pi["platform.m"] == (300, "kg")
    assert pi["strut.moving.m c"] == (27.5, "kg m")
    assert pi["strut.moving.I"] == (pytest.approx(4.58 + 55 * 0.25, rel=1e-15), "kg m2")
    assert pi["drive.m"] == (pytest.approx(3e-3 * (2 * np.pi / 0.02) ** 2, rel=1e-15), "kg")


# -- limit cases ------------------------------------------------------------------------------------------------------


def test_rest_forces_carry_the_weight_of_platform_and_struts(slender_machine):
    """Force on the platform along the struts, and the part of each strut's weight that its base joint does not take."""
    machine, rng = slender_machine, np.random.default_rng(3)
    for x in machine.home + rng.normal(size=(20, 6)) * 0.02:
        u = machine.inverse_dynamics(x, np.zeros(6), np.zeros(6))
        q, J = machine.inverse_kinematics(x), machine.jacobian(x)
        n, mv, fx, g = J[:, :3], machine.strut.moving, machine.strut.fixed, machine.gravity
        total = n.T @ u + machine.platform.mass * g
        for i in range(6):
            # moments about the base joint: a force on the strut at B balances the weights; along n the moving part only
            moment = mv.mass * (q[i] - mv.center) + fx.mass * fx.center
            across = g - (n[i] @ g) * n[i]
            total += mv.mass * (n[i] @ g) * n[i] + moment / q[i] * across
        assert_allclose(total, 0, atol=1e-9 * machine.platform.mass * 9.81)


def massless(m):
    """The machine with struts and drives without inertia, and without gravity: a free body under six forces."""
    return m.replace(
        strut=None, friction=None, gravity=[0.0, 0.0, 0.0], **{"drive.inertia": None, "joints.cross": None}
    )


@pytest.mark.quick("nist-octahedral", "full-general")
def test_free_platform_keeps_its_momentum(machine):
    m = massless(machine)
    p, theta = m.symbols
    pi = {key: value for key, (value, _) in m.inertial(p).items()}
    z, v = ca.SX.sym("z", 7), ca.SX.sym("v", 6)
    M, h = m.mass_and_bias(p, pi, z, v)
    rate = ca.Function(
        "rate", [z, v], [ca.substitute(r, theta, ca.DM(m.theta)) for r in (m.rate(p, z, v), -ca.solve(M, h))]
    )
    step, state = (
        1e-3,
        [np.array(m.coordinates_of(m, ca.DM(m.home))).ravel(), np.array([0.1, -0.2, 0.3, 1.0, 2.0, -1.5])],
    )

    def slope(s):
        return [np.array(r).ravel() for r in rate(*s)]

    def momentum(s):
        """Linear momentum and spin about the centre of mass, from the body's own numbers."""
        w, x, y, z = s[0][3:]
        R = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                      [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                      [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])  # fmt: skip
        c_T, I_T = m.platform.center, m.platform.inertia
        if m.tool is not None:
            a, b, c = m.tool.angles
            R_TP = (elementary(2, c) @ elementary(1, b) @ elementary(0, a)).T
            c_T, I_T = R_TP @ (c_T - m.tool.position), R_TP @ I_T @ R_TP.T
        return np.r_[m.platform.mass * (s[1][:3] + np.cross(s[1][3:], R @ c_T)), R @ I_T @ R.T @ s[1][3:]]

    before = momentum(state)
    for _ in range(200):
        k1 = slope(state)
        k2 = slope([s + step / 2 * k for s, k in zip(state, k1, strict=True)])
        k3 = slope([s + step / 2 * k for s, k in zip(state, k2, strict=True)])
        k4 = slope([s + step * k for s, k in zip(state, k3, strict=True)])
        state = [s + step / 6 * (a + 2 * b + 2 * c + d) for s, a, b, c, d in zip(state, k1, k2, k3, k4, strict=True)]
    # RK4 over 0.2 s: (|w| h)^4 = (2.7e-3)^4 = 5e-11 times |w| t / 120
    assert_allclose(momentum(state), before, rtol=0, atol=1e-10 * np.abs(before).max())


def test_wrench_alone_accelerates_the_free_platform_as_newton_and_euler_say(nist):
    m = massless(nist)
    a = m.forward_dynamics(m.home, np.zeros(6), np.zeros(6), wrench=[30.0, 0, 0, 0, 0, 15.0])
    assert_allclose(a, [30 / 300, 0, 0, 0, 0, 15 / 15], atol=1e-15)


# -- symmetry and invariance ------------------------------------------------------------------------------------------


def turned(Q, x, *vectors):
    """A motion and its wrenches seen after everything, the machine too, was turned by Q about the origin of W."""
    pose = np.concatenate([x[:, :3] @ Q.T, abc_of_rotation_np(Q @ rotation_of_abc_np(x[:, 3:]))], -1)
    return pose, *(np.concatenate([v[:, :3] @ Q.T, v[:, 3:] @ Q.T], -1) for v in vectors)


def image(Q, x, *vectors):
    """The motion's image under a symmetry Q of the machine, a turn or a mirror: T is carried along as R -> Q R Q'.

    Angular velocity and moment are axial vectors: a mirror turns them round once more.
    """
    pose = np.concatenate([x[:, :3] @ Q.T, abc_of_rotation_np(Q @ rotation_of_abc_np(x[:, 3:]) @ Q.T)], -1)
    sense = np.linalg.det(Q)
    return pose, *(np.concatenate([v[:, :3] @ Q.T, sense * v[:, 3:] @ Q.T], -1) for v in vectors)


SYMMETRIES = {
    "turn by 120 deg": elementary(2, 2 * np.pi / 3),
    "turn by 240 deg": elementary(2, 4 * np.pi / 3),
    "mirror": np.diag([-1.0, 1.0, 1.0]),
}


@pytest.mark.parametrize("symmetry", SYMMETRIES)
def test_symmetry_of_the_machine_exchanges_its_struts(nist, symmetry):
    Q = SYMMETRIES[symmetry]
    rng = np.random.default_rng(4)
    V, Vd, wrench = (rng.normal(size=(50, 6)) for _ in range(3))
    x = nist.home + rng.normal(size=(50, 6)) * 0.03
    apart = np.linalg.norm((nist.joints.base @ Q.T)[:, None] - nist.joints.base, axis=-1)
    order = apart.argmin(0)  # strut j of the image is strut order[j] of the motion
    assert apart.min(0).max() < 1e-8 and sorted(order) == list(range(6))  # the sheet has nine digits
    assert (order != np.arange(6)).all()
    u = nist.inverse_dynamics(x, V, Vd, 1000 * wrench)
    found = nist.inverse_dynamics(*image(Q, x, V, Vd, 1000 * wrench))
    assert relative(found, u[:, order]) < 1e-7  # from joints symmetric to 1e-9 m, times cond(J)
    assert relative(found, u) > 0.1


def test_forces_do_not_depend_on_the_choice_of_W(machine, states):
    """Base, gravity, joint axes and motion turned together: the struts notice nothing."""
    x, V, Vd, wrench = (piece[:100] for piece in states)
    Q = elementary(2, 0.7) @ elementary(1, -0.4) @ elementary(0, 0.3)
    home = np.r_[Q @ machine.home[:3], abc_of_rotation_np(Q @ rotation_of_abc_np(machine.home[3:]))]
    changes = {"joints.base": machine.joints.base @ Q.T, "gravity": Q @ machine.gravity, "home": home}
    if machine.joints.base_axis is not None:
        changes["joints.base_axis"] = machine.joints.base_axis @ Q.T
    found = machine.replace(**changes).inverse_dynamics(*turned(Q, x, V, Vd, wrench))
    assert relative(found, machine.inverse_dynamics(x, V, Vd, wrench)) < AGREE


def test_forces_do_not_depend_on_where_the_tool_frame_sits(okuma):
    """The same motion of the same body, told of another T: R_PT and p_PT only change the words."""
    from gough.machine.hexapod_parts import Tool

    position, angles = np.array([0.1, -0.2, 0.3]), np.array([0.1, 0.2, -0.3])
    R_PT = elementary(2, angles[2]) @ elementary(1, angles[1]) @ elementary(0, angles[0])
    home = np.r_[okuma.home[:3] + position, abc_of_rotation_np(R_PT)]  # okuma stands upright at home
    other = okuma.replace(tool=Tool(position=position, angles=angles), home=home)
    rng = np.random.default_rng(6)
    x, V, Vd = okuma.home + rng.normal(size=(20, 6)) * 0.03, rng.normal(size=(20, 6)), rng.normal(size=(20, 6))
    R_WP = rotation_of_abc_np(x[:, 3:])
    r, w, wd = R_WP @ position, V[:, 3:], Vd[:, 3:]
    x_T = np.concatenate([x[:, :3] + r, abc_of_rotation_np(R_WP @ R_PT)], -1)
    V_T = np.concatenate([V[:, :3] + np.cross(w, r), w], -1)
    Vd_T = np.concatenate([Vd[:, :3] + np.cross(wd, r) + np.cross(w, np.cross(w, r)), wd], -1)
    assert relative(other.inverse_dynamics(x_T, V_T, Vd_T), okuma.inverse_dynamics(x, V, Vd)) < AGREE
