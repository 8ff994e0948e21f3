"""RELIABILITY S8: the forces contradict an encoder that is at fault, and nothing else does."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

import gough as gk
from gough.machine.workspace import random_poses
from gough.observe import encoders


@pytest.fixture(scope="module", params=["nist-octahedral", "okuma-pm600"])
def machine(request):
    return gk.load_machine(request.param)


def numbers(value) -> np.ndarray:
    return np.array(ca.DM(ca.evalf(ca.SX(value)))).squeeze()


def explained(m, x, V, Vd, qdd):
    return [numbers(part) for part in encoders.explained(m, m, *(ca.DM(part) for part in (x, V, Vd, qdd)))]


@pytest.mark.quick("okuma-pm600")
def test_what_forces_explain_is_what_forward_dynamics_make_of_them(machine):
    """Eq. (1) from any reference that passes through pose and twist, against forward dynamics and joint motion."""
    rng = np.random.default_rng(3)
    for x in random_poses(machine, 20, rng):
        V, Vd, u = rng.normal(size=6), 10 * rng.normal(size=6), 1000 * rng.normal(size=6)
        a0, G = explained(machine, x, V, Vd, machine.joint_motion(x, V, Vd)[2])
        expected = machine.joint_motion(x, V, machine.forward_dynamics(x, V, u))[2]
        scale = np.abs(G) @ np.abs(u) + np.abs(a0)
        assert (np.abs(a0 + G @ u - expected) < 1e-11 * scale).all()
        assert_allclose(G, G.T, atol=1e-12 * np.abs(G).max())


def test_readings_of_a_joint_under_held_forces_leave_a_residual_of_third_order():
    """q from q'' = a_0 + b t with one force up to t = 0 and another from there: (2) sees b Ts^3 only."""
    nist = gk.load_machine("nist-octahedral").replace(**{"drive.encoder": None})
    G, jerk = np.diag(np.arange(1.0, 7.0)) * 1e-3, np.array([30.0, -20, 10, 5, 0, 1])
    old, new = 1e3 * np.array([1.0, -2, 3, 0, 1, 2]), 1e3 * np.array([2.0, 1, -1, 1, 0, 0])

    def at(t):
        force = np.where(t < 0, old, new)
        return 0.3 * t + G @ force * t**2 / 2 + jerk * t**3 / 6 * np.sign(t)

    found = []
    for h in (1e-3, 5e-4):
        r, allowed = encoders.residual(
            nist, ca.DM(G @ (old + new) / 2), ca.DM(G), ca.DM(at(h)), 0, ca.DM(at(-h)), 50, h
        )
        found.append(numbers(r))
        assert_allclose(numbers(allowed), h**2 * 50 * np.arange(1.0, 7.0) * 1e-3, rtol=1e-12)
    assert_allclose(found[0], jerk * 1e-9 / 3, atol=1e-18)  # the cubic's own second difference, by hand
    assert_allclose(found[0], 8 * found[1], atol=1e-17)


def test_the_bound_grows_by_two_counts_and_eight_deviations(machine):
    m = machine.replace(**{"drive.encoder": 1e-6, "drive.noise": 2e-6})
    zero = ca.DM.zeros(6)
    _, allowed = encoders.residual(m, zero, ca.DM.zeros(6, 6), zero, zero, zero, 1e3, 1e-3)
    assert_allclose(numbers(allowed), 2e-6 + 8 * np.sqrt(6) * 2e-6, rtol=1e-14)
    # three readings, each rounded by half a count at most, the middle one counting twice: no more than two counts
    rng = np.random.default_rng(0)
    q = rng.uniform(size=(100_000, 3))
    rounded = np.floor(q + 0.5) - q
    assert 1.9 < np.abs(rounded @ [1, -2, 1]).max() <= 2


def test_a_joint_is_followed_by_its_forces_only_while_its_encoder_is_in_doubt():
    h, zero = 1e-3, np.zeros(6)
    q, qd, a, d = 0.5 + zero, 0.1 + zero, 2.0 + zero, -0.5 + zero
    q_m, before, qd_r = np.full(6, 0.6), np.full(6, 0.59), np.full(6, 0.2)
    flagged = np.array([0, 3, 0, 0, 0, 0])
    before[2:4], qd_r[3] = 0.6, 0  # joint 3 stands while its reference moves, joint 4 with its reference
    r = np.full(6, 4e-6)
    given = (ca.DM(v) for v in (q_m, before, qd_r, q, qd, a, d, r, flagged))
    q_next, qd_next, d_next = (numbers(v) for v in encoders.followed(*given, h))
    assert_allclose(q_next, [0.6, 0.5 + 1e-4 + 0.75e-6, 0.6, 0.6, 0.6, 0.6], rtol=1e-15)
    assert_allclose(qd_next, [0.2, 0.1015, 0.1015, 0, 0.2, 0.2], rtol=1e-14)
    assert_allclose(d_next, [-0.275, -0.5, -0.5, -0.275, -0.275, -0.275], rtol=1e-14)  # a 20th of the way to 4
