"""A hybrid machine by Lagrange's equations, twice; nothing here is taken from gough but the numbers of the machine.

`Lagrange`: three coordinates s = (s21, s65, s32).  The arms turn by asin((s65 - s21) / 2 b), so places of the centres
of mass are written down, energies follow, and d/dt dL/ds' - dL/ds = u by differentiating them.

`Partitioned`: the paper's own way (Bouzgarrou et al. 2001, eqs. (2)-(6)): six coordinates q = (s21 s65 s32 s54 phi10
phi60), mass matrix and Christoffel's C of the open chains, Phi of its own, multipliers eliminated block by block.
"""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca
import numpy as np


def rotation(phi):
    return ca.vertcat(
        ca.horzcat(ca.cos(phi), -ca.sin(phi), 0), ca.horzcat(ca.sin(phi), ca.cos(phi), 0), ca.horzcat(0, 0, 1)
    )


def masses(m, s21, s65, s32, phi10, phi60):
    """(mass, centre in W, inertia about the third axis, angle) of all seven bodies."""
    b, z0 = m.base.half_width, m.base.overhang
    out = []
    for side, phi, s, links in (
        (-1, phi10, s21, ((m.link2, (0, 0, 0)), (m.ram, (b, 0, s32 + z0)))),
        (1, phi60, s65, ((m.link5, (0, 0, 0)),)),
    ):
        pivot, R = ca.vertcat(side * b, 0, -z0), rotation(phi)
        out.append((m.arm.mass, pivot + R @ ca.vertcat(0, m.arm.center, 0), m.arm.inertia, phi))
        out.append((m.slide.mass, pivot + R @ ca.vertcat(0, s, 0), m.slide.inertia, phi))
        for body, at in links:
            place = ca.vertcat(*at) + ca.DM(body.center)
            out.append((body.mass, pivot + R @ (ca.vertcat(0, s, 0) + place), float(body.inertia[2, 2]), phi))
    return out


def energies(m, q, qd, bodies):
    """T and V for bodies that are expressions of q."""
    T, V = 0, 0
    for mass, center, inertia, phi in bodies:
        speed, turn = ca.jtimes(center, q, qd), ca.jtimes(phi, q, qd)
        T += mass * ca.dot(speed, speed) / 2 + inertia * turn * turn / 2
        V -= mass * ca.dot(ca.DM(m.gravity), center)
    return T, V


class Lagrange:
    """u (3,) of s, s', s''; and the tool tip."""

    def __init__(self, m):
        s, sd, sdd = (ca.SX.sym(name, 3) for name in ("s", "sd", "sdd"))
        b = m.base.half_width
        phi = ca.asin((s[1] - s[0]) / (2 * b))
        T, V = energies(m, s, sd, masses(m, s[0], s[1], s[2], phi, phi))
        p = ca.jacobian(T, sd).T
        u = ca.jtimes(p, s, sd) + ca.jtimes(p, sd, sdd) - ca.jacobian(T, s).T + ca.jacobian(V, s).T
        tip = ca.vertcat(-b, 0, -m.base.overhang) + rotation(phi) @ ca.vertcat(b, s[0], s[2] + m.base.overhang)
        self._force = ca.Function("force", [s, sd, sdd], [u])
        self._tip = ca.Function("tip", [s], [tip, ca.jacobian(tip, s)])
        self._energy = ca.Function("energy", [s, sd], [T, V])

    def force(self, s, sd, sdd):
        return np.array(self._force(s, sd, sdd)).ravel()

    def tip(self, s):
        place, J = self._tip(s)
        return np.array(place).ravel(), np.array(J)

    def energy(self, s, sd):
        return tuple(float(part) for part in self._energy(s, sd))


class Reduced(NamedTuple):
    """M_S s'' + C_S s' + G_S = u, with C_S as printed and repaired."""

    M: np.ndarray
    C: np.ndarray
    printed: np.ndarray
    G: np.ndarray


class Partitioned:
    """Eqs. (2)-(6) of the paper."""

    def __init__(self, m):
        q, qd = ca.SX.sym("q", 6), ca.SX.sym("qd", 6)
        b = m.base.half_width
        T, V = energies(m, q, qd, masses(m, q[0], q[1], q[2], q[4], q[5]))
        M, _ = ca.hessian(T, qd)
        C = ca.SX(6, 6)
        for k in range(6):
            for j in range(6):
                for i in range(6):
                    c = ca.jacobian(M[k, j], q[i]) + ca.jacobian(M[k, i], q[j]) - ca.jacobian(M[i, j], q[k])
                    C[k, j] += c / 2 * qd[i]
        Phi = ca.vertcat(q[0] - q[1] + 2 * b * ca.sin(q[4]), q[3] - 2 * b * ca.cos(q[4]), q[5] - q[4])
        Phi_q = ca.jacobian(Phi, q)
        Phi_dot = ca.reshape(ca.jtimes(ca.vec(Phi_q), q, qd), 3, 6)
        self._all = ca.Function("all", [q, qd], [M, C, ca.jacobian(V, q).T, Phi_q, Phi_dot])

    def at(self, q, sd) -> Reduced:
        """At coordinates q (6,) and speeds s' (3,)."""
        _, _, _, Phi_q, _ = (np.array(part) for part in self._all(q, np.zeros(6)))
        inverse = np.linalg.inv(Phi_q[:, 3:])
        A = inverse @ Phi_q[:, :3]  # phi' = -A s'
        M, C, g, Phi_q, Phi_dot = (np.array(part) for part in self._all(q, np.concatenate([sd, -A @ sd])))
        M_ss, M_sp, M_pp = M[:3, :3], M[:3, 3:], M[3:, 3:]
        C_ss, C_sp, C_ps, C_pp = C[:3, :3], C[:3, 3:], C[3:, :3], C[3:, 3:]
        rate = Phi_dot[:, :3] - Phi_dot[:, 3:] @ A
        out = []
        for factor in (inverse, np.eye(3)):
            inner = M_pp @ factor @ rate - C_ps + C_pp @ A
            out.append(-M_sp @ inverse @ rate + C_ss - C_sp @ A + A.T @ inner)
        g = g.ravel()
        return Reduced(M_ss - M_sp @ A - A.T @ M_sp.T + A.T @ M_pp @ A, *out, g[:3] - A.T @ g[3:])
