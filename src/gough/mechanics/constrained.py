"""Equations of motion of bodies in closed loops: dependent coordinates, their elimination, and the forces of closing.

Coordinates x = (a, b) with the closure phi(x) = 0, as many rows as entries of b, phi_b not singular; rigid bodies whose
twists V_k = J_k(x) x' are given as expressions linear in x'.  w_k is what body k needs (`bodies.rigid_wrench`).

    b' = B a',   B = -phi_b^-1 phi_a                                                                               (1)
    b'' = B a'' - phi_b^-1 g,   g = (phi_x x')_x x'                                                                (2)
    F = sum of J_k' w_k(V_k, J_k x'' + J_k' x') = M x'' + q                                                        (3)
    M_a a'' + h_a = T' tau,   T = [1; B],   M_a = T' M T,   h_a = T' F at a'' = 0                                  (4)
    phi_b' l = (tau - F)_b                              the multipliers l of F + phi_x' l = tau                    (5)
    b <- b - phi_b^-1 phi                               back onto the closure                                      (6)

(4) and (5) are what is left of Lagrange's equations when the multipliers are eliminated; the same elimination with the
inverse of the whole mass matrix, as Chen and Tsai 2008 write it in eqs. (4)-(12), is

    M_2 = phi_x M^-1 phi_x',   l = M_2^-1 (g - phi_x M^-1 q + phi_x M^-1 tau)                                       (7)
    x'' = f + G_1 tau,   G_1 = M^-1 - M^-1 phi_x' M_2^-1 phi_x M^-1,   f = -G_1 q - M^-1 phi_x' M_2^-1 g             (8)

docs/theory/constrained.md shows that both are one.  The elements of phi are lengths in metres: (6) and the multipliers
(N) are then what they say.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import casadi as ca

from ..frames import skew
from .bodies import rigid_wrench
from .linear import solve_spd, solve_square


class Moving(NamedTuple):
    """A rigid body of a closed mechanism: inertia about its point O and the twist of O, in axes of W."""

    m: Any  # kg
    mc: Any  # (3,) m times the centre of mass from O
    I: Any  # (3, 3) about O
    twist: Any  # (6,) [v_O; w], linear in x'


class Closure(NamedTuple):
    """The closure of a mechanism at a state: of eqs. (1), (2)."""

    phi: Any  # (m,) m
    phi_a: Any  # (m, n)
    phi_b: Any  # (m, m)
    g: Any  # (m,) m/s2; None where no x' was given


def closure(phi, x, n: int, xd=None) -> Closure:
    """phi (m,), an expression in the symbols x (n + m,), with its derivatives; g for the rate xd of the symbols."""
    phi_x = ca.jacobian(phi, x)
    g = None if xd is None else ca.jtimes(phi_x @ xd, x, xd)
    return Closure(phi, phi_x[:, :n], phi_x[:, n:], g)


def dependent(c: Closure):
    """B of eq. (1).  (m, n)."""
    return -solve_square(c.phi_b, c.phi_a)


def dependent_acceleration(c: Closure, B, ad):
    """b'' of eq. (2) for a'' = `ad` (n,).  (m,)."""
    return B @ ad - solve_square(c.phi_b, c.g)


def projected(c: Closure, b):
    """b after one step of eq. (6).  (m,)."""
    return b - solve_square(c.phi_b, c.phi)


class Rates(NamedTuple):
    """J_k of a body and the part J_k' x' of its acceleration, at symbols x, x'."""

    J: Any  # (6, n + m)
    drift: Any  # (6,)


def rates(body: Moving, x, xd) -> Rates:
    """Of a body whose twist is an expression in the symbols x and xd."""
    return Rates(ca.jacobian(body.twist, xd), ca.jtimes(body.twist, x, xd))


def spatial_inertia(body: Moving):
    """(6, 6) with V' (.) V / 2 the kinetic energy of a twist V of the body's point O."""
    S = skew(body.mc)
    return ca.vertcat(ca.horzcat(body.m * ca.SX.eye(3), -S), ca.horzcat(S, body.I))


def needed(body: Moving, twist, acceleration, gravity):
    """w_k: force and moment at O that a body needs to move so, in a field of gravity (3,).  (6,)."""
    lifted = acceleration[:3] - gravity
    return rigid_wrench(body.m, body.mc, body.I, twist[3:], lifted, acceleration[3:])


def multipliers(c: Closure, force_b):
    """l of eq. (5); `force_b` (m,) is (tau - F)_b.  (m,) N."""
    return solve_square(c.phi_b.T, force_b)


def eliminated(M, q, phi_x, g):
    """f (n + m,), G_1 and M_2 of eqs. (7), (8): x'' = f + G_1 tau."""
    Mi = solve_spd(M, ca.horzcat(ca.SX.eye(M.shape[0]), ca.SX(q)))
    Mi, Mq = Mi[:, :-1], Mi[:, -1]
    held = phi_x @ Mi  # phi_x M^-1
    M_2 = held @ phi_x.T
    G_1 = Mi - held.T @ solve_spd(M_2, held)
    q_2 = g - phi_x @ Mq
    return -held.T @ solve_spd(M_2, q_2) - Mq, G_1, M_2
