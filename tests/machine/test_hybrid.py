"""The hybrid machine: where it stands, what it needs at the poses of the paper, what its joints carry."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from gough.machine.hybrid_parts import stands
from gough.machine.sheet import load_machine
from gough.machine.workspace import check_poses, margin_names, margins, random_poses
from gough.mechanics import constrained
from gough.simulate import tick

START, END = np.array([0.0, 1.2, 0.0]), np.array([-0.315, 1.83, 0.55])  # m; Bouzgarrou et al. 2001, section 4


@pytest.fixture(scope="module")
def hsm():
    return load_machine("ifma-hsm")


@pytest.fixture(scope="module")
def x(hsm):
    return random_poses(hsm, 300, np.random.default_rng(2))


# -- where it stands --------------------------------------------------------------------------------------------


def test_both_ends_of_the_reference_move_are_where_the_data_page_says(hsm):
    """MACHINES.md 4.3: phi 10.2 deg, s21 1.2 -> 1.697 m, s65 1.2 -> 2.016 m."""
    start, end = hsm.coordinates([START, END])
    assert_allclose(start, [1.2, 1.2, 0, 1.8, 0, 0], rtol=0, atol=1e-15)
    assert_allclose(end[:3], [1.697, 2.016, 0.55], rtol=0, atol=5e-4)
    assert_allclose(np.degrees(end[4]), 10.2, atol=0.05)
    assert end[4] == end[5]


def test_coordinates_close_the_loop_and_the_tool_is_where_it_was_asked(hsm, x):
    p, theta, z, _, _ = tick.symbols_of(hsm)
    f = ca.Function("f", [theta, z], [hsm.closure_of(p, z), hsm.task_of(p, z)]).map(len(x))
    phi, tip = (np.array(part).T for part in f(hsm.theta, hsm.coordinates(x).T))
    assert np.abs(phi).max() < 1e-15  # m, rounding of 2 m
    assert_allclose(tip, x, rtol=0, atol=1e-15)


def test_the_closure_of_the_chains_is_that_of_the_data_page_where_the_arms_are_parallel(hsm):
    """Phi of MACHINES.md 4.3, at coordinates that close nothing but have phi60 = phi10, with its derivative by them."""
    p, theta, z, _, _ = tick.symbols_of(hsm)
    phi = hsm.closure_of(p, z)
    f = ca.Function("f", [theta, z], [phi, ca.jacobian(phi, z)])
    rng, b = np.random.default_rng(3), hsm.base.half_width
    for s21, s65, s54, a in rng.uniform([0.5, 0.5, 1, -1], [2, 2, 2, 1], size=(50, 4)):
        found, slope = (np.array(part) for part in f(hsm.theta, [s21, s65, 0.3, s54, a, a]))
        assert_allclose(found.ravel(), [s21 - s65 + 2 * b * np.sin(a), s54 - 2 * b * np.cos(a), 0], rtol=0, atol=1e-14)
        along = [[1, -1, 0, 0, 2 * b * np.cos(a)], [0, 0, 0, 1, 2 * b * np.sin(a)]]
        # by phi10 and phi60 together, which is all that parallel arms allow
        assert_allclose(np.column_stack([slope[:2, :4], slope[:2, 4:].sum(1)]), along, rtol=0, atol=1e-14)


def test_the_joints_of_numpy_and_of_the_kernel_are_one(hsm, x):
    assert_allclose(stands(hsm, x), hsm.coordinates(x), rtol=0, atol=1e-15)


def test_det_j_is_that_of_its_closed_form_and_phi_b_is_singular_only_with_it(hsm, x):
    """Eq. (6) of hybrid.py."""
    z, b = hsm.coordinates(x), hsm.base.half_width
    assert_allclose(np.linalg.det(hsm.jacobian(x)), 2 * b * np.cos(z[:, 4]) / z[:, 0], rtol=1e-13)
    p, theta, zs, _, _ = tick.symbols_of(hsm)
    f = ca.Function("f", [theta, zs], [ca.det(hsm.closed(p, zs).phi_b)]).map(len(x))
    assert_allclose(np.abs(np.array(f(hsm.theta, z.T)).ravel()), 4 * b * b * np.cos(z[:, 4]), rtol=1e-13)


def test_the_whole_workspace_is_within_all_limits(hsm):
    space, middle = hsm.limits.workspace, hsm.home + hsm.limits.workspace.middle
    half = np.append(space.size, space.height) / 2
    corners = middle + half * np.array(np.meshgrid([-1, 0, 1], [-1, 0, 1], [-1, 0, 1])).reshape(3, -1).T
    check_poses(hsm, corners)
    assert (margins(hsm, hsm.coordinates(corners)) >= 0).all()
    assert (margins(hsm, hsm.coordinates(np.array([START, END]))) > 0).all()


def test_a_workspace_beside_home_is_left_where_its_own_middle_says(hsm):
    """Half of 0.85 m above 1.2 + 0.275 m is 1.9 m: a millimetre more is outside, and is said so."""
    names = margin_names(hsm)
    inside, outside = margins(hsm, hsm.coordinates([[0.0, 1.9, 0.25], [0.0, 1.901, 0.25]]))
    assert (inside >= 0).all()
    assert [names[k] for k in np.flatnonzero(outside < 0)] == ["beyond the width of the workspace"]
    assert outside.min() == pytest.approx(-1e-3, abs=1e-8)  # the edge itself is 1e-9 m wide
    x = random_poses(hsm, 2000, np.random.default_rng(8))
    assert_allclose([x.min(0), x.max(0)], [[-0.35, 1.05, -0.1], [0.35, 1.9, 0.6]], rtol=0, atol=0.005)


# -- what it needs ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("place", "mass", "static"),
    [
        (START, [[706, -316, 0], [-316, 711, 0], [0, 0, 316]], [3.8e3, 3.9e3, 0]),
        (END, [[1123, -737, 0], [-737, 1137, 0], [0, 0, 316]], [5.4e3, 2.2e3, 0]),
    ],
    ids=["start", "end"],
)
def test_mass_and_gravity_forces_at_both_ends_are_those_of_the_data_page(hsm, place, mass, static):
    """MACHINES.md 4.3, to its digits."""
    assert_allclose(hsm.velocity_mass(place), mass, rtol=0, atol=0.5)
    assert_allclose(hsm.inverse_dynamics(place, 0 * place, 0 * place), static, rtol=0, atol=50)


def test_at_rest_with_the_arms_upright_the_slides_carry_all_that_they_lift(hsm):
    """phi = 0: along y are motors, links and ram; the arms stand on their pivots."""
    u = hsm.inverse_dynamics(START, np.zeros(3), np.zeros(3))
    lifted = 2 * hsm.slide.mass + hsm.link2.mass + hsm.link5.mass + hsm.ram.mass
    assert u[:2].sum() == pytest.approx(9.81 * lifted, rel=1e-14)


def test_a_payload_rides_on_the_ram(hsm):
    loaded = gk.Plant(machine=hsm, payload=30.0, payload_center=[0.0, 0.0, 0.1]).true_machine
    M = loaded.velocity_mass(START) - hsm.velocity_mass(START)
    J = np.linalg.inv(hsm.jacobian(START))  # of the tip; at phi = 0 the payload before it moves as it does
    assert_allclose(M, 30 * J.T @ J, rtol=0, atol=1e-11)


# -- what its joints carry ----------------------------------------------------------------------------------------


def test_the_pivots_hold_the_whole_machine_at_rest(hsm, x):
    """Forces and moments about the third axis of W of pivots, weights and wrench vanish; pivots pass no moment."""
    w = np.random.default_rng(5).normal(size=(len(x), 6)) * 500
    found = hsm.reactions(x, 0 * x, 0 * x, w)
    weights, moment = weight(hsm, x)
    total = found.pivot.sum(1) + w[:, :2] + weights
    assert np.abs(total).max() < 1e-10 * np.abs(weights).max()
    b = hsm.base.half_width
    turning = -b * found.pivot[:, 0, 1] + b * found.pivot[:, 1, 1] + moment + w[:, 5] + cross(x, w)
    assert np.abs(turning).max() < 1e-10 * np.abs(moment).max()


def test_along_the_passive_slide_nothing_is_carried(hsm, x):
    rng = np.random.default_rng(6)
    found = hsm.reactions(x, rng.normal(size=x.shape), rng.normal(size=x.shape) * 10)
    phi = hsm.coordinates(x)[:, 4]
    along = np.cos(phi) * found.passive[:, 0] + np.sin(phi) * found.passive[:, 1]
    assert np.abs(along).max() < 1e-11 * np.abs(found.passive).max()


@pytest.mark.full
def test_the_multipliers_of_a_run_are_in_its_log(hsm):
    smooth, circle = hsm.replace(drive=hsm.drive.perfect()), gk.Circle(radius=0.02, feed=0.2)
    log = gk.simulate(smooth, gk.ComputedTorque(bandwidth=16.0), circle, signals=["plant.multiplier", "x"])
    assert log["plant.multiplier"].shape == (len(log["t"]), 3)
    still = hsm.reactions(log["x"][-1, :3], np.zeros(3), np.zeros(3)).multiplier
    assert_allclose(log["plant.multiplier"][-1], still, rtol=0, atol=1e-3 * np.abs(still).max())


def cross(x, f):
    return x[:, 0] * f[:, 1] - x[:, 1] * f[:, 0]


def weight(m, x):
    """Force (N, 2) and moment about the third axis of W (N,) of all weights, from coordinates written out."""
    z, b, g = m.coordinates(x), m.base.half_width, m.gravity[:2]
    c, s = np.cos(z[:, 4]), np.sin(z[:, 4])

    def at(pivot, along, across):
        return np.stack([pivot + c * across - s * along, s * across + c * along], -1)

    parts = [
        (m.arm.mass, at(-b, m.arm.center, 0)), (m.slide.mass, at(-b, z[:, 0], 0)),
        (m.link2.mass, at(-b, z[:, 0] + m.link2.center[1], m.link2.center[0])),
        (m.ram.mass, at(-b, z[:, 0] + m.ram.center[1], b + m.ram.center[0])),
        (m.arm.mass, at(b, m.arm.center, 0)), (m.slide.mass, at(b, z[:, 1], 0)),
        (m.link5.mass, at(b, z[:, 1] + m.link5.center[1], m.link5.center[0])),
    ]  # fmt: skip
    total = sum(mass for mass, _ in parts)
    return np.tile(total * g, (len(x), 1)), sum(mass * (p[:, 0] * g[1] - p[:, 1] * g[0]) for mass, p in parts)


# -- the elimination ----------------------------------------------------------------------------------------------


def test_the_elimination_of_all_six_coordinates_gives_the_same_masses_and_forces(hsm, x):
    """T' M T and T' (M (0, b'') + q) of `whole_dynamics`: M has no mass along s54, so it cannot be inverted first."""
    p, theta, z, v, _ = tick.symbols_of(hsm)
    pi = {key: value for key, (value, _) in hsm.inertial(p).items()}
    M, q, phi_x, g = hsm.whole_dynamics(p, pi, z, v)
    c = constrained.Closure(ca.SX(3, 1), phi_x[:, :3], phi_x[:, 3:], g)
    B = constrained.dependent(c)
    bd = constrained.dependent_acceleration(c, B, ca.SX(3, 1))
    T = ca.vertcat(ca.SX.eye(3), B)
    h = T.T @ (M @ ca.vertcat(ca.SX(3, 1), bd) + q)
    f = ca.Function("f", [theta, z, v], [M, T.T @ M @ T, h, *hsm.mass_and_bias(p, pi, z, v)])
    rng = np.random.default_rng(7)
    for row in hsm.coordinates(x[::20]):
        all_of, M_a, h_a, M_own, h_own = (np.array(part) for part in f(hsm.theta, row, rng.normal(size=3)))
        assert np.abs(all_of[3]).max() == 0
        assert_allclose(M_a, M_own, rtol=0, atol=1e-12 * np.abs(M_own).max())
        assert_allclose(h_a, h_own, rtol=0, atol=1e-12 * np.abs(h_own).max())
