"""The 3-PRS: where it stands, how it moves, what it needs; against closed forms, differences and energies."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

from gough.frames import rotation_of_abc_np
from gough.machine.sheet import load_machine
from gough.machine.workspace import check_poses, random_poses
from gough.mechanics import constrained
from gough.simulate import tick


@pytest.fixture(scope="module")
def ccu():
    return load_machine("ccu-3prs")


@pytest.fixture(scope="module")
def x(ccu):
    return random_poses(ccu, 300, np.random.default_rng(2))


def dense(machine, z, v=None, wanted=()):
    """Numbers of expressions of z and v by name."""
    p, theta, zs, vs, _ = tick.symbols_of(machine)
    made = {
        "phi": lambda: machine.closure_of(p, zs),
        "phi_x": lambda: ca.horzcat(*machine.closed(p, zs)[1:3]),
        "rate": lambda: machine.rate(p, zs, vs),
        "tool": lambda: ca.vertcat(*machine.tool_pose_of(p, zs)),
        "twist": lambda: machine.tool_jacobian(p, zs) @ vs,
    }
    f = ca.Function("f", [theta, zs, vs], [made[name]() for name in wanted])
    out = f(machine.theta, z, np.zeros(3) if v is None else v)
    return [np.array(o) for o in (out if isinstance(out, tuple) else (out,))]


# -- where it stands --------------------------------------------------------------------------------------------


def test_the_published_circle_needs_the_strokes_and_angles_of_the_data_page(ccu):
    """MACHINES.md 3.3: S 0.349 to 0.400 m, theta 75.8 to 76.1 deg, tilt 8.1 to 8.4 deg, cond(J) 2.8."""
    phi = np.linspace(0, 2 * np.pi, 361)
    circle = np.stack([0.05 * np.cos(phi), 0.1745 + 0.05 * np.sin(phi), np.full(361, -1.4)], -1)
    z = ccu.standing(circle)
    assert_allclose([z[:, :3].min(), z[:, :3].max()], [0.349, 0.400], atol=5e-4)
    assert_allclose(np.degrees([z[:, 3:].min(), z[:, 3:].max()]), [75.8, 76.1], atol=0.05)
    axis = rotation_of_abc_np(ccu.tool_pose(circle)[:, 3:])[..., 2]
    tilt = np.degrees(np.arccos(axis[:, 2]))
    assert_allclose([tilt.min(), tilt.max()], [8.1, 8.4], atol=0.06)
    assert_allclose(np.linalg.cond(ccu.jacobian(circle)), 2.83, atol=0.02)


def test_coordinates_close_the_loops_and_the_tool_is_where_it_was_asked(ccu, x):
    for row in x[::10]:
        z = ccu.standing(row)
        phi, tool = dense(ccu, z, wanted=("phi", "tool"))
        assert np.abs(phi).max() < 1e-15  # m, rounding of 1.4 m
        assert_allclose(tool[:3, 0], row, rtol=0, atol=1e-15)


def test_the_parasitic_motion_is_that_of_a_platform_without_torsion(ccu, x):
    """The platform turns by tau about a horizontal axis, its normal at the azimuth phi; its centre leaves the axis by

    r / 2 (1 - cos tau) (sin 2 phi, cos 2 phi): derived in docs/theory/tripod.md, and not used by the machine.
    """
    R = rotation_of_abc_np(ccu.tool_pose(x)[:, 3:])
    axis = R[..., 2]
    tau, azimuth = np.arccos(axis[:, 2]), np.arctan2(axis[:, 1], axis[:, 0])
    k = np.stack([-np.sin(azimuth), np.cos(azimuth), 0 * tau], -1)
    K = np.zeros((len(x), 3, 3))
    K[:, 0, 2], K[:, 2, 0], K[:, 1, 2], K[:, 2, 1] = k[:, 1], -k[:, 1], -k[:, 0], k[:, 0]
    wanted = np.eye(3) + np.sin(tau)[:, None, None] * K + (1 - np.cos(tau))[:, None, None] * K @ K
    assert_allclose(R, wanted, rtol=0, atol=1e-13)
    center = x + R @ [0, 0, 0.35]  # of the platform's joints
    aside = 0.09 * (1 - np.cos(tau))[:, None] * np.stack([np.sin(2 * azimuth), np.cos(2 * azimuth)], -1)
    assert_allclose(center[:, :2] - [0, 0.1745], aside, rtol=0, atol=1e-13)


@pytest.mark.full
def test_forward_kinematics_finds_every_place_of_the_workspace_from_home(ccu, x):
    assert_allclose(ccu.forward_kinematics(ccu.inverse_kinematics(x)), x, rtol=0, atol=1e-14)


# -- how it moves -----------------------------------------------------------------------------------------------


def test_jacobian_speeds_and_accelerations_are_differences_of_the_inverse_kinematics(ccu, x):
    rng, h = np.random.default_rng(4), 1e-4
    xd, xdd = rng.normal(size=x.shape) * 0.3, rng.normal(size=x.shape) * 2
    near = [ccu.inverse_kinematics(x + k * h * xd + (k * h) ** 2 / 2 * xdd) for k in (-2, -1, 0, 1, 2)]
    q, qd, qdd = ccu.joint_motion(x, xd, xdd)
    first = (near[0] - 8 * near[1] + 8 * near[3] - near[4]) / (12 * h)
    second = (-near[0] + 16 * near[1] - 30 * near[2] + 16 * near[3] - near[4]) / (12 * h * h)
    assert_allclose(q, near[2], rtol=0, atol=1e-15)
    assert_allclose(qd, first, rtol=0, atol=1e-11)  # rounding 1e-16 / h
    assert_allclose(qdd, second, rtol=0, atol=1e-6)  # rounding 1e-16 / h^2
    assert_allclose(ccu.jacobian(x) @ xd[..., None], qd[..., None], rtol=0, atol=1e-14)


def test_the_twist_of_the_tool_is_the_derivative_of_its_pose(ccu, x):
    rng, h = np.random.default_rng(6), 1e-6
    for row in x[::30]:
        z, v = ccu.standing(row), rng.normal(size=3) * 0.2
        rate, twist = (piece.ravel() for piece in dense(ccu, z, v, ("rate", "twist")))
        before, after = (dense(ccu, z + s * h * rate, wanted=("tool",))[0].ravel() for s in (-1, 1))
        assert_allclose((after - before)[:3] / (2 * h), twist[:3], rtol=0, atol=1e-9)
        w, a, b = before[3:], after[3:], (before[3:] + after[3:]) / 2
        product = b[0] * (a - w)[1:] - (a - w)[0] * b[1:] + np.cross((a - w)[1:], -b[1:])
        assert_allclose(2 * product / (2 * h), twist[3:], rtol=0, atol=1e-9)


# -- what it needs ----------------------------------------------------------------------------------------------


def test_at_rest_the_sliders_carry_the_weight_and_nothing_else(ccu, x):
    u = ccu.inverse_dynamics(x, 0 * x, 0 * x)
    assert_allclose(u.sum(1), -9.81 * (45 + 3 * (12 + 6)), rtol=1e-13)


def test_a_wrench_on_the_tool_is_held_by_virtual_work(ccu, x):
    """u q' + w . V = 0 at rest without weight, for every speed: u = -J_tool' w."""
    rng = np.random.default_rng(8)
    light = ccu.replace(gravity=[0.0, 0.0, 0.0])
    for row in x[::30]:
        w, v = rng.normal(size=6) * 100, rng.normal(size=3)
        u = light.inverse_dynamics(row, np.zeros(3), np.zeros(3), w)
        (twist,) = dense(ccu, ccu.standing(row), v, ("twist",))
        assert u @ v + w @ twist.ravel() == pytest.approx(0, abs=1e-11)


def test_energy_changes_by_what_the_drives_and_gravity_do(ccu, x):
    """d/dt of x'' M x' / 2 along a motion of given forces, by differences over the true trajectory."""
    rng = np.random.default_rng(9)
    for row in x[::60]:
        xd, u = rng.normal(size=3) * 0.3, rng.normal(size=3) * 500
        h, energy = 1e-4, []
        xdd = ccu.forward_dynamics(row, xd, u)
        for s in (-1, 1):  # second order in s h: the third derivative cancels in the difference
            there, speed = row + s * h * xd + h * h / 2 * xdd, xd + s * h * xdd
            energy.append(speed @ ccu.mass_matrix(there) @ speed / 2)
        light = ccu.replace(gravity=[0.0, 0.0, 0.0])
        weight = ccu.inverse_dynamics(row, 0 * xd, 0 * xd) - light.inverse_dynamics(row, 0 * xd, 0 * xd)
        power = (u - weight) @ (ccu.jacobian(row) @ xd)
        assert (energy[1] - energy[0]) / (2 * h) == pytest.approx(power, abs=1e-4 * max(1, abs(power)))


def test_dynamics_are_linear_in_the_parameters_that_are_told(ccu, x):
    rng = np.random.default_rng(10)
    xd, xdd = rng.normal(size=x.shape) * 0.3, rng.normal(size=x.shape) * 3
    u = ccu.regressor(x, xd, xdd) @ ccu.parameters.values
    assert_allclose(u, ccu.inverse_dynamics(x, xd, xdd), rtol=0, atol=1e-11 * np.abs(u).max())
    assert ccu.parameters.names[-3:] == ("slider.m", "link.m", "drive.m")


def test_forward_undoes_inverse_dynamics(ccu, x):
    rng = np.random.default_rng(11)
    xd, xdd, w = rng.normal(size=x.shape) * 0.3, rng.normal(size=x.shape) * 3, rng.normal(size=(len(x), 6)) * 100
    u = ccu.inverse_dynamics(x, xd, xdd, w)
    assert_allclose(ccu.forward_dynamics(x, xd, u, w), xdd, rtol=0, atol=1e-12)


def whole(machine):
    """(theta, z, v) -> M, q, phi_x, g of all six coordinates, and M, h of the three independent ones."""
    p, theta, z, v, _ = tick.symbols_of(machine)
    pi = {key: value for key, (value, _) in machine.inertial(p).items()}
    M, q, phi_x, g = machine.whole_dynamics(p, pi, z, v)
    f, G_1, _ = constrained.eliminated(M, q, phi_x, g)
    return ca.Function("whole", [theta, z, v], [M, q, phi_x, g, f, G_1, *machine.mass_and_bias(p, pi, z, v)])


def test_the_elimination_of_chen_and_tsai_gives_the_same_motion_and_their_lemma_holds_over_the_workspace(ccu, x):
    """Eqs. (9)-(12): a'' = f_a + G u; N(G_1) = Col(phi_x'); G of full rank."""
    rng, function = np.random.default_rng(12), whole(ccu)
    for row in x[::6]:
        v, u = rng.normal(size=3) * 0.3, rng.normal(size=3) * 500
        out = [np.array(o) for o in function(ccu.theta, ccu.standing(row), v)]
        M_all, _, phi_x, _, f, G_1, M, h = out
        assert np.linalg.eigvalsh(M_all).min() > 0
        add = f[:3, 0] + G_1[:3, :3] @ u
        assert_allclose(add, np.linalg.solve(M, u - h.ravel()), rtol=0, atol=1e-10 * np.abs(add).max())
        assert np.abs(G_1 @ phi_x.T).max() < 1e-12 * np.abs(G_1).max()
        assert np.linalg.matrix_rank(G_1, tol=1e-9 * np.abs(G_1).max()) == 3
        assert np.linalg.cond(G_1[:, :3]) < 100


# -- what it refuses --------------------------------------------------------------------------------------------


def test_workspace_poses_are_within_all_limits(ccu, x):
    check_poses(ccu, x)
