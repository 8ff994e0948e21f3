"""The hexaglide against the energies of oracle/lagrange_hexaglide.py, and its own: branches, reach, rails, legs.

What holds of every machine is in tests/contract/test_machine.py, Honegger's equations in tests/published.
"""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

from gough.frames import abc_of_rotation_np, quaternion_of_abc_np, rotation_of_abc_np
from gough.machine import forward
from gough.machine.workspace import random_poses
from oracle.hexaglides import HEXAGLIDES
from oracle.lagrange_hexaglide import oracle as make_oracle
from oracle.machines import elementary

AGREE = 1e-10  # relative, of forces; as in test_hexapod_dynamics.py

_made = lru_cache(lambda name: HEXAGLIDES[name]())
_oracles = lru_cache(lambda name: make_oracle(_made(name)))


@pytest.fixture(params=HEXAGLIDES)
def machine(request):
    return _made(request.param)


@pytest.fixture
def eth():
    return _made("eth-hexaglide")


@pytest.fixture
def legs():
    return _made("hexaglide-with-legs")


@pytest.fixture
def oracle(machine):
    return _oracles(machine.name)


@pytest.fixture
def states(machine):
    """x, V, V', wrench of 1000 random states."""
    rng = np.random.default_rng(20240612)
    x = random_poses(machine, 1000, rng)
    V = rng.normal(size=(1000, 6)) * [1, 1, 1, 1.5, 1.5, 1.5]
    Vd = rng.normal(size=(1000, 6)) * [10, 10, 10, 30, 30, 30]
    return x, V, Vd, rng.normal(size=(1000, 6)) * [1000, 1000, 1000, 100, 100, 100]


def relative(found, wanted):
    return (np.abs(found - wanted).max(-1) / np.abs(wanted).max(-1)).max()


# -- against energies -------------------------------------------------------------------------------------------------


@pytest.mark.quick("hexaglide-with-legs")
def test_inverse_dynamics_are_those_of_the_energies(machine, oracle, states):
    x, V, Vd, wrench = states
    assert relative(machine.inverse_dynamics(x, V, Vd, wrench), oracle.joint_forces(x, V, Vd, wrench)) < AGREE


def test_places_and_jacobian_are_those_of_the_oracle(machine, oracle, states):
    x, V, *_ = states
    q, qd, _ = machine.joint_motion(x, V, np.zeros(6))
    for k in range(0, 1000, 20):
        yd = np.linalg.solve(np.array(oracle.twist_matrix(x[k])), V[k])
        assert_allclose(q[k], np.array(oracle.lengths(x[k])).ravel(), atol=1e-14)
        assert_allclose(qd[k], np.array(oracle.length_rate(x[k])) @ yd, atol=1e-13)


@pytest.mark.quick("hexaglide-with-legs")
def test_kinetic_energy_is_half_V_M_V(machine, oracle, states):
    x, V, *_ = states
    T = np.einsum("ki,kij,kj->k", V, machine.mass_matrix(x), V) / 2
    wanted = [
        float(oracle.kinetic(x[k], np.linalg.solve(np.array(oracle.twist_matrix(x[k])), V[k]))) for k in range(1000)
    ]
    assert_allclose(T, wanted, rtol=1e-12)


def test_bias_is_that_of_christoffels_symbols_of_the_mass_matrix(machine, oracle, states):
    x, V, *_ = states
    y = ca.SX.sym("y", 6)
    dU = ca.Function("dU", [y], [ca.gradient(oracle.potential(y), y)])
    M_all, h_all = machine.arrays.run("mass", x, V)
    for k in range(0, 1000, 25):
        E = np.array(oracle.twist_matrix(x[k]))
        yd = np.linalg.solve(E, V[k])
        ours = E.T @ (h_all[k] + M_all[k].reshape(6, 6).T @ np.array(oracle.twist_drift(x[k], yd)).ravel())
        wanted = np.array(oracle.christoffel(x[k], yd)) @ yd + np.array(dU(x[k])).ravel()
        assert_allclose(ours, wanted, atol=1e-11 * np.abs(wanted).max())


@pytest.mark.quick("hexaglide-with-legs")
def test_power_of_the_forces_is_the_rate_of_the_energy(machine, oracle, states):
    """u . q' + wrench . V = d/dt (T + U), with T and U of the oracle differentiated along the motion."""
    x, V, Vd, wrench = states
    y, yd, ydd = (ca.SX.sym(name, 6) for name in ("y", "yd", "ydd"))
    E = oracle.kinetic(y, yd) + oracle.potential(y)
    rate = ca.Function("rate", [y, yd, ydd], [ca.jtimes(E, y, yd) + ca.jtimes(E, yd, ydd)])
    u, (_, qd, _) = machine.inverse_dynamics(x, V, Vd, wrench), machine.joint_motion(x, V, Vd)
    power, scale = (u * qd).sum(-1) + (wrench * V).sum(-1), np.abs(u * qd).sum(-1) + np.abs(wrench * V).sum(-1)
    wanted = np.array([float(rate(*oracle.coordinates(x[k], V[k], Vd[k]))) for k in range(1000)])
    assert (np.abs(power - wanted) / scale).max() < 1e-12


# -- what the legs weigh ----------------------------------------------------------------------------------------------


def test_a_leg_weighs_half_on_its_carriage_and_half_on_the_platform(eth, legs):
    """At rest six legs add 6 m g / 2 to the platform, at their joints: the moments of half a leg at every B."""
    x, rest = random_poses(eth, 20, np.random.default_rng(1)), np.zeros(6)
    added = legs.inverse_dynamics(x, rest, rest) - eth.inverse_dynamics(x, rest, rest)
    for k, pose in enumerate(x):
        b = eth.platform_joints_np() @ rotation_of_abc_np(pose[3:]).T
        weight = np.array([0, 0, -8.0 * 9.81 / 2])
        wrench = np.r_[6 * weight, np.cross(b, weight).sum(0)]
        assert_allclose(eth.jacobian(pose).T @ added[k], -wrench, atol=1e-10)  # of 400 N


def test_legs_add_what_a_carriage_and_a_platform_of_lumped_masses_miss(eth, legs):
    """Honegger lumps the legs: half of each into its carriage, half into the platform at its joint.

    Lumps have the weight of the legs, so at rest nothing is missed; but they have the moments of inertia of two points,
    m l^2 / 4 instead of m l^2 / 12 about the middle, so in motion they have more.
    """
    lumped = eth.replace(**{"carriage.mass": 97.6 + 4.0})
    for point in eth.joints.platform:
        lumped = lumped.replace(platform=lumped.platform.joined(4.0, point))
    rng = np.random.default_rng(2)
    x, V = random_poses(eth, 200, rng), rng.normal(size=(200, 6))
    zero = np.zeros(6)
    assert_allclose(legs.inverse_dynamics(x, zero, zero), lumped.inverse_dynamics(x, zero, zero), atol=1e-9)
    T = [np.einsum("ki,kij,kj->k", V, m.mass_matrix(x), V) for m in (eth, legs, lumped)]
    assert (T[0] < T[1]).all() and (T[1] <= T[2] + 1e-9).all()
    # a leg that only moves along itself with both ends: both models agree
    along = np.r_[1.0, np.zeros(5)]
    M_legs, M_lumped = (m.mass_matrix(eth.home) for m in (legs, lumped))
    assert along @ M_legs @ along == pytest.approx(along @ M_lumped @ along, rel=1e-14)


def test_momentum_along_parallel_rails_is_kept(legs):
    """No force acts along x on a machine let go: neither gravity nor rails.  Its momentum, body by body, stays."""
    m = legs.frictionless()
    p = m.at(ca.SX(ca.DM(m.theta)))
    pi = {key: value for key, (value, _) in m.inertial(p).items()}
    z, v = ca.SX.sym("z", 7), ca.SX.sym("v", 6)
    M, h = m.mass_and_bias(p, pi, z, v)
    rate = ca.Function("rate", [z, v], [m.rate(p, z, v), ca.solve(M, -h)])
    state = [np.array(m.coordinates_of(m, ca.DM(m.home))).ravel(), np.array([0.2, 0.1, 0.3, 0.4, -0.5, 0.3])]

    def slope(s):
        return [np.array(r).ravel() for r in rate(*s)]

    def momentum(s):
        """Along x: platform by its centre of mass, carriages by q', legs by the mean of their ends."""
        w = s[1][3:]
        a, b, c, d = s[0][3:]
        R = np.array([[1 - 2 * (c * c + d * d), 2 * (b * c - a * d), 2 * (b * d + a * c)],
                      [2 * (b * c + a * d), 1 - 2 * (b * b + d * d), 2 * (c * d - a * b)],
                      [2 * (b * d - a * c), 2 * (c * d + a * b), 1 - 2 * (b * b + c * c)]])  # fmt: skip
        v_B = (s[1][:3] + np.cross(w, m.joints.platform @ R.T))[:, 0]
        B = s[0][:3] + m.joints.platform @ R.T
        d2 = ((B - m.rails.point)[:, 1:] ** 2).sum(1)  # rails run along x
        v_yz = (s[1][:3] + np.cross(w, m.joints.platform @ R.T))[:, 1:]
        # q = x_B + side sqrt(1 - d2), differentiated here once more
        qd = v_B - m.rails.side * ((B - m.rails.point)[:, 1:] * v_yz).sum(1) / np.sqrt(1 - d2)
        center = (s[1][:3] + np.cross(w, R @ m.platform.center))[0]
        return m.platform.mass * center + m.carriage.mass * qd.sum() + m.legs.mass * (qd + v_B).sum() / 2

    before, step = momentum(state), 1e-3
    for _ in range(100):
        k1 = slope(state)
        k2 = slope([s + step / 2 * k for s, k in zip(state, k1, strict=True)])
        k3 = slope([s + step / 2 * k for s, k in zip(state, k2, strict=True)])
        k4 = slope([s + step * k for s, k in zip(state, k3, strict=True)])
        state = [s + step / 6 * (a + 2 * b + 2 * c + d) for s, a, b, c, d in zip(state, k1, k2, k3, k4, strict=True)]
    assert abs(state[0][2]) > 0.01 and abs(before) > 50  # it fell, and there is momentum to lose
    assert momentum(state) == pytest.approx(before, rel=1e-10)  # RK4: (10 1/s x 1e-3)^4 x 0.1 s x 10 1/s / 120 = 1e-10


# -- branches ---------------------------------------------------------------------------------------------------------


def test_carriages_at_home_are_where_a_person_works_them_out(eth):
    """d^2 of P1: (0.485 - 0.25)^2 + (0.79 - 0.2)^2 = 0.403325; of P3: 0.195^2 + 0.54^2; of P5: 0.22^2 + 0.59^2."""
    one, three, five = (np.sqrt(1 - d2) for d2 in (0.403325, 0.195**2 + 0.54**2, 0.22**2 + 0.59**2))
    wanted = [-0.08 - one, 0.08 + one, -0.08 - three, 0.08 + three, -0.16 - five, 0.16 + five]
    assert_allclose(eth.inverse_kinematics(eth.home), wanted, rtol=0, atol=1e-15)


def test_the_side_of_the_sheet_is_the_branch_of_every_leg(eth):
    """Eq. (3) of the paper: (-1)^i.  On the other side a carriage is as far beyond its joint; the other five stay."""
    m = eth.replace(**{"limits.gap": 0.0, "limits.travel": [-3.0, 3.0], "rails.side": [1, 1, -1, 1, -1, 1]})
    x = random_poses(eth, 50, np.random.default_rng(4))
    q, other = eth.inverse_kinematics(x), m.inverse_kinematics(x)
    B = x[:, :1] + np.einsum("kij,lj->kli", rotation_of_abc_np(x[:, 3:]), eth.joints.platform)[..., 0]
    assert_allclose(other[:, 0] - B[:, 0], B[:, 0] - q[:, 0], atol=1e-14)
    assert np.array_equal(other[:, 1:], q[:, 1:])
    assert (np.sign(q - B) == eth.rails.side).all()


@pytest.mark.quick("eth-hexaglide", "hexaglide-with-legs")
def test_legs_keep_their_length_on_the_branch_that_forward_kinematics_found(machine):
    x = random_poses(machine, 200, np.random.default_rng(5))
    q = machine.inverse_kinematics(x)
    found = machine.forward_kinematics(q)
    for pose, place in zip(found, q, strict=True):
        B = pose[:3] + machine.platform_joints_np() @ rotation_of_abc_np(pose[3:]).T
        S = machine.rails.point + machine.rails.direction * place[:, None]
        assert_allclose(np.linalg.norm(B - S, axis=1), machine.legs.length, rtol=0, atol=1e-12)


def test_newton_finds_a_pose_from_starts_that_no_carriage_reaches(eth):
    """The step is that of the legs' lengths, which every pose has; q(z) has no number there."""
    q = eth.inverse_kinematics(eth.home)
    near = eth.home + [0, 0, -0.45, 0, 0, 0]
    assert eth.unreachable(near[None]) is not None
    found, steps = forward.newton(eth, q[None], near[None], np.ones(1, bool))
    assert_allclose(found[0], [*eth.home[:3], *quaternion_of_abc_np(eth.home[3:])], atol=1e-12)
    assert steps[0] <= 10


def test_forces_do_not_depend_on_the_choice_of_W(machine, states):
    """Rails, gravity and motion turned together: the carriages notice nothing."""
    x, V, Vd, wrench = (piece[:100] for piece in states)
    Q = elementary(2, 0.7) @ elementary(1, -0.4) @ elementary(0, 0.3)

    def turned(v):
        return np.concatenate([v[:, :3] @ Q.T, v[:, 3:] @ Q.T], -1)

    def pose(x):
        return np.concatenate([x[..., :3] @ Q.T, abc_of_rotation_np(Q @ rotation_of_abc_np(x[..., 3:]))], -1)

    other = machine.replace(
        gravity=Q @ machine.gravity, home=pose(machine.home),
        **{"rails.point": machine.rails.point @ Q.T, "rails.direction": machine.rails.direction @ Q.T},
    )  # fmt: skip
    found = other.inverse_dynamics(pose(x), turned(V), turned(Vd), turned(wrench))
    assert relative(found, machine.inverse_dynamics(x, V, Vd, wrench)) < AGREE


def test_a_direction_with_a_digit_off_only_scales_q(eth):
    """A direction given with six digits is off by 1e-7: legs keep their length, and J is still the slope of q."""
    m = eth.replace(**{"rails.direction": eth.rails.direction * (1 + 5e-7)})
    x = random_poses(eth, 20, np.random.default_rng(7))
    assert_allclose(m.inverse_kinematics(x) * (1 + 5e-7), eth.inverse_kinematics(x), atol=1e-15)
    assert_allclose(m.jacobian(x) * (1 + 5e-7), eth.jacobian(x), atol=1e-14)
    assert_allclose(m.mass_matrix(x), eth.mass_matrix(x), rtol=0, atol=1e-11)


def test_neglected_legs_cost_a_tenth_of_the_force_and_lumped_ones_a_thirtieth(eth, legs):
    """docs/theory/hexaglide.md: legs of 8 kg, motions of 0.5 m/s and 5 m/s2 a component."""
    lumped = eth.replace(**{"carriage.mass": 97.6 + 4.0})
    for point in eth.joints.platform:
        lumped = lumped.replace(platform=lumped.platform.joined(4.0, point))
    rng = np.random.default_rng(0)
    x = random_poses(eth, 2000, rng)
    V = rng.normal(size=(2000, 6)) * [0.5, 0.5, 0.5, 0.3, 0.3, 0.3]
    Vd = rng.normal(size=(2000, 6)) * [5, 5, 5, 3, 3, 3]
    u = legs.inverse_dynamics(x, V, Vd)
    cost = [np.sqrt(((m.inverse_dynamics(x, V, Vd) - u) ** 2).mean() / (u**2).mean()) for m in (eth, lumped)]
    assert_allclose(cost, [0.10, 0.034], rtol=0.05)
