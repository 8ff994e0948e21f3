"""Elimination of multipliers: eqs. (1)-(8) of mechanics/constrained.py against the whole system, and on a linkage."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

from gough.mechanics import constrained


def numbers(*expressions):
    return [np.array(ca.DM(ca.evalf(ca.SX(e)))) for e in expressions]


@pytest.fixture(params=range(5))
def system(request):
    """M, q, phi_x, g, tau of six coordinates and three constraints, random."""
    rng = np.random.default_rng(request.param)
    A = rng.normal(size=(6, 6))
    return A @ A.T + 0.5 * np.eye(6), *(rng.normal(size=s) for s in (6, (3, 6), 3, 6))


def test_the_elimination_of_the_paper_solves_the_whole_system(system):
    """x'' and the multipliers of [M phi_x'; phi_x 0], of eqs. (7), (8)."""
    M, q, phi_x, g, tau = system
    whole = np.linalg.solve(np.block([[M, phi_x.T], [phi_x, np.zeros((3, 3))]]), np.concatenate([tau - q, -g]))
    f, G_1, M_2 = numbers(*constrained.eliminated(ca.DM(M), ca.DM(q), ca.DM(phi_x), ca.DM(g)))
    assert_allclose(f.ravel() + G_1 @ tau, whole[:6], rtol=0, atol=1e-9 * np.abs(whole).max())
    Mi = np.linalg.inv(M)
    l = np.linalg.solve(M_2, g - phi_x @ Mi @ q + phi_x @ Mi @ tau)
    assert_allclose(l, whole[6:], rtol=0, atol=1e-9 * np.abs(whole).max())


def test_eliminating_by_dependent_coordinates_gives_the_same_acceleration_and_multipliers(system):
    M, q, phi_x, g, tau = system
    tau = np.concatenate([tau[:3], np.zeros(3)])  # drives act on a
    f, G_1, _ = numbers(*constrained.eliminated(ca.DM(M), ca.DM(q), ca.DM(phi_x), ca.DM(g)))
    xdd = f.ravel() + G_1 @ tau
    c = constrained.Closure(None, ca.DM(phi_x[:, :3]), ca.DM(phi_x[:, 3:]), ca.DM(g))
    B = constrained.dependent(c)
    bdd, B = numbers(constrained.dependent_acceleration(c, B, ca.DM(xdd[:3])), B)
    # normal equations square the condition of phi_b, some 1e2 among these
    scale = np.abs(xdd).max() * np.linalg.cond(phi_x[:, 3:]) ** 2
    assert_allclose(bdd.ravel(), xdd[3:], rtol=0, atol=1e-12 * scale)
    T = np.concatenate([np.eye(3), B])
    F = M @ xdd + q
    assert_allclose(T.T @ F, tau[:3], rtol=0, atol=1e-11 * scale)
    (l,) = numbers(constrained.multipliers(c, ca.DM(tau[3:] - F[3:])))
    assert_allclose(F + phi_x.T @ l.ravel(), tau, rtol=0, atol=1e-11 * scale)


def test_the_null_space_of_g1_is_the_column_space_of_phi_x(system):
    """The lemma of Chen and Tsai, section III: G_1 phi_x' = 0, and the rank of G_1 leaves no more."""
    M, q, phi_x, g, _ = system
    _, G_1, _ = numbers(*constrained.eliminated(ca.DM(M), ca.DM(q), ca.DM(phi_x), ca.DM(g)))
    assert np.abs(G_1 @ phi_x.T).max() < 1e-12 * np.abs(G_1).max() * np.linalg.cond(M)
    assert np.linalg.matrix_rank(G_1, tol=1e-9 * np.abs(G_1).max()) == 3


def slider_crank():
    """Crank of length r (theta), rod of length L (psi): the slider's place s is a, the angles are b."""
    x, r, L = ca.SX.sym("x", 3), 0.3, 0.7
    s, theta, psi = x[0], x[1], x[2]
    phi = ca.vertcat(r * ca.cos(theta) + L * ca.cos(psi) - s, r * ca.sin(theta) - L * ca.sin(psi))
    return x, phi, r, L


def test_rates_and_accelerations_of_a_slider_crank_are_those_of_its_closed_form():
    """theta and psi of s by the law of cosines, differentiated in CasADi: no closure, no elimination."""
    x, phi, r, L = slider_crank()
    s, sd, sdd = ca.SX.sym("s"), 0.4, -1.7
    angles = ca.vertcat(ca.acos((s**2 + r**2 - L**2) / (2 * s * r)), ca.acos((s**2 + L**2 - r**2) / (2 * s * L)))
    first = ca.jacobian(angles, s)
    exact = ca.Function("exact", [s], [angles, first * sd, ca.jacobian(first, s) * sd**2 + first * sdd])
    b, bd, bdd = (np.array(v).ravel() for v in exact(0.8))
    rate = ca.SX.sym("xd", 3)
    found = constrained.closure(phi, x, 1, rate)
    at = ca.Function("at", [x, rate], [*found])
    c = constrained.Closure(*at(np.r_[0.8, b], np.r_[sd, bd]))
    B = constrained.dependent(c)
    assert np.abs(np.array(c.phi)).max() < 1e-15
    assert_allclose(np.array(ca.DM(B * sd)).ravel(), bd, rtol=1e-13)
    assert_allclose(np.array(ca.DM(constrained.dependent_acceleration(c, B, ca.DM([sdd])))).ravel(), bdd, rtol=1e-12)


def test_a_newton_step_back_onto_the_closure_squares_the_error():
    x, phi, _, _ = slider_crank()
    c = constrained.closure(phi, x, 1)
    step = ca.Function("step", [x], [constrained.projected(c, x[1:])])
    off = ca.Function("off", [x], [c.phi])
    b = np.array([0.95, 0.36])
    for _ in range(6):
        b = np.array(step(np.r_[0.8, b])).ravel()
    start = b + [2e-4, -1e-4]
    once = np.array(step(np.r_[0.8, start])).ravel()
    assert np.abs(np.array(off(np.r_[0.8, once]))).max() < 1e-7  # |b - b*|^2 times a curvature of the order of 1
    assert np.abs(once - b).max() < 1e-6 * 2e-4 / 1e-3


def test_multipliers_are_the_forces_that_hold_a_pendulum_on_its_circle():
    """A point mass in x, y on a circle of radius l: the multiplier is the tension, m v^2 / l + m g cos."""
    m, l, g = 2.0, 0.5, 9.81
    angle, speed = 0.4, 1.3
    x, xd = ca.SX.sym("x", 2), ca.SX.sym("xd", 2)
    phi = (ca.dot(x, x) - l**2) / (2 * l)
    body = constrained.Moving(m, ca.SX(3, 1), ca.SX(3, 3), ca.vertcat(xd[0], 0, xd[1], 0, 0, 0))
    rates = constrained.rates(body, x, xd)
    place = l * np.array([np.sin(angle), -np.cos(angle)])
    moving = speed * np.array([np.cos(angle), np.sin(angle)])
    acceleration = -g * np.sin(angle) * moving / speed - speed**2 / l * place / l
    at = ca.Function("at", [x, xd], [*constrained.closure(phi, x, 1, xd), rates.J])
    *c, J = at(place, moving)
    still = body._replace(twist=None)
    force = J.T @ constrained.needed(still, ca.DM(6, 1), J @ acceleration, ca.DM([0, 0, -g]))
    (found,) = numbers(constrained.multipliers(constrained.Closure(*c), -force[1:]))
    assert found.item() == pytest.approx(m * speed**2 / l + m * g * np.cos(angle), rel=1e-12)
