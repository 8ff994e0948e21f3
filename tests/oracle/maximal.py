"""A 3-PRS by Lagrange's equations with multipliers, in NumPy: every body free, every joint a constraint.

Coordinates y = (S_1..3, theta_1..3, pose of the platform), speeds y' = (S', theta', v_T, w).  A leg has the energies
of a point mass and an even rod, the platform Newton's and Euler's equations about its tool tip; nine constraints say
that link ends and platform joints are the same points:

    c_i = A_i + S_i d_i + L l_i(theta_i) - p - R t_i = 0,   M y'' + k + G' f = Q,   G y'' = -G' y'
    [M G'; G 0] [y''; f] = [Q - k; -G' y']

f_i pushes the platform through joint i, and -f_i the link.  Nothing here is taken from gough but the numbers of the
machine.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Solved(NamedTuple):
    """Accelerations y'' (12,) and forces on the links (3, 3) at one state."""

    acceleration: np.ndarray
    force: np.ndarray


class Leg(NamedTuple):
    """Where a link points and where its end goes with S and theta."""

    along: np.ndarray
    turned: np.ndarray


def skew(a):
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def turn(r):
    """exp of a rotation vector, Rodrigues."""
    angle = np.linalg.norm(r)
    if angle == 0:
        return np.eye(3)
    K = skew(r / angle)
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


class Maximal:
    """The equations of one machine."""

    def __init__(self, machine):
        self.m = machine
        self.A, self.d, self.c = machine.rails.point, machine.rails.direction, machine.rails.across
        self.t, self.L = machine.joints.platform, machine.link.length

    def leg(self, i, theta):
        c, d = self.c[i], self.d[i]
        return Leg(np.cos(theta) * c + np.sin(theta) * d, -np.sin(theta) * c + np.cos(theta) * d)

    def gaps(self, S, theta, p, R):
        return np.concatenate([
            self.A[i] + S[i] * self.d[i] + self.L * self.leg(i, theta[i]).along - p - R @ self.t[i] for i in range(3)
        ])  # fmt: skip

    def constraint(self, theta, R):
        """G (9, 12)."""
        G = np.zeros((9, 12))
        for i in range(3):
            rows = slice(3 * i, 3 * i + 3)
            G[rows, i] = self.d[i]
            G[rows, 3 + i] = self.L * self.leg(i, theta[i]).turned
            G[rows, 6:9] = -np.eye(3)
            G[rows, 9:12] = skew(R @ self.t[i])
        return G

    def stand(self, x):
        """S, theta, R with the tool tip at x: Newton's method on the nine constraints, from level."""
        S, theta, R = np.full(3, 0.37), np.full(3, 1.3), np.eye(3)
        for _ in range(60):
            G = self.constraint(theta, R)
            K = np.concatenate([G[:, :6], G[:, 9:]], axis=1)
            step = np.linalg.solve(K, -self.gaps(S, theta, x, R))
            step *= min(1.0, 0.2 / np.abs(step).max())
            S, theta, R = S + step[:3], theta + step[3:6], turn(step[6:]) @ R
        return S, theta, R

    def speeds(self, theta, R, v):
        """y' with the tool tip at speed v."""
        G = self.constraint(theta, R)
        K = np.concatenate([G[:, :6], G[:, 9:]], axis=1)
        rest = np.linalg.solve(K, -G[:, 6:9] @ v)
        return np.concatenate([rest[:6], v, rest[6:]])

    def solve(self, x, v, u, wrench) -> Solved:
        """The state with the tool tip at x, speed v, under slider forces u and a wrench on the tool."""
        S, theta, R = self.stand(x)
        assert np.abs(self.gaps(S, theta, x, R)).max() < 1e-13
        y = self.speeds(theta, R, v)
        m, g, L = self.m, self.m.gravity, self.L
        m_s, m_l, w = m.slider.mass, m.link.mass, y[9:]
        m_r = m.drive.inertia * (2 * np.pi / m.drive.lead) ** 2
        M, k, Q, drift = np.zeros((12, 12)), np.zeros(12), np.zeros(12), np.zeros(9)
        for i in range(3):
            leg, rate = self.leg(i, theta[i]), y[3 + i]
            M[i, i] = m_s + m_l + m_r
            M[i, 3 + i] = M[3 + i, i] = m_l * L / 2 * (self.d[i] @ leg.turned)
            M[3 + i, 3 + i] = m_l * L**2 / 3
            k[i] = -m_l * L / 2 * (self.d[i] @ leg.along) * rate**2
            Q[i] = u[i] + (m_s + m_l) * (g @ self.d[i])
            Q[3 + i] = m_l * L / 2 * (g @ leg.turned)
            drift[3 * i : 3 * i + 3] = -L * leg.along * rate**2 - np.cross(w, np.cross(w, R @ self.t[i]))
        c, mass = R @ m.platform.center, m.platform.mass
        I = R @ m.platform.inertia @ R.T
        I_T = I + mass * (c @ c * np.eye(3) - np.outer(c, c))
        M[6:9, 6:9], M[6:9, 9:], M[9:, 6:9], M[9:, 9:] = mass * np.eye(3), -mass * skew(c), mass * skew(c), I_T
        k[6:9], k[9:] = mass * np.cross(w, np.cross(w, c)), np.cross(w, I_T @ w)
        Q[6:9] = mass * g + wrench[:3]
        Q[9:] = np.cross(c, mass * g) + wrench[3:]
        G = self.constraint(theta, R)
        whole = np.block([[M, G.T], [G, np.zeros((9, 9))]])
        found = np.linalg.solve(whole, np.concatenate([Q - k, -drift]))
        return Solved(found[:12], -found[12:].reshape(3, 3))
