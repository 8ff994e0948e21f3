"""The hybrid machine with elastic slides a second time: all 17 coordinates, five constraints with multipliers.

q = (s21 s65 s32, phi10 phi60, d_2, d_5).  Link 5 slides on link 2 along its x: two components of its place and three of
its turn are 0, held by

    M q'' + h + dV/dq + D q' + Phi_q' l = [u; 0],   Phi_q q'' = -(Phi_q q')_q q' - 2 a Phi' - a^2 Phi              (1)

From MACHINES.md 4.3 and numbers of the sheet, with kinematics, inertias and laws of its own, in continuous time;
nothing of gough but the sheet's numbers.  CasADi differentiates.
"""

from __future__ import annotations

from functools import cached_property

import casadi as ca
import numpy as np
from scipy.linalg import null_space

PULL = 1000.0  # a of eq. (1), 1/s: above the loop's poles, far below 1 / STEP
STEP = 4e-5  # s; dampers and the law on 40 kg of motor have poles up to 3e4 1/s, Runge-Kutta's limit is 2.78 / STEP
GRAVITY = 9.81


def exponential(w):
    """exp of a small turn: what is left out, w^4 / 24, is 1e-14 of a turn of a milliradian."""
    W = ca.skew(w)
    return ca.SX.eye(3) + W + W @ W / 2 + W @ W @ W / 6


def about_z(a):
    return ca.vertcat(
        ca.horzcat(ca.cos(a), -ca.sin(a), 0), ca.horzcat(ca.sin(a), ca.cos(a), 0), ca.horzcat(0, 0, 1)
    )  # fmt: skip


class ElasticHybrid:
    """The machine of a sheet with arm 1 at -x; K (12,) of both slides, beta (s) of its dampers."""

    def __init__(self, sheet, K, beta):
        self.b, self.z0, self.K, self.beta = float(sheet.base.half_width), float(sheet.base.overhang), K, beta
        q = self.q = ca.SX.sym("q", 17)
        b, e_y = self.b, ca.DM([0, 1, 0])
        R1, R6 = about_z(q[3]), about_z(q[4])
        P1, P6 = ca.DM([-b, 0, -self.z0]), ca.DM([b, 0, -self.z0])
        c1, c6 = P1 + q[0] * (R1 @ e_y), P6 + q[1] * (R6 @ e_y)
        A2, R2 = c1 + R1 @ q[5:8], R1 @ exponential(q[8:11])
        A5, R5 = c6 + R6 @ q[11:14], R6 @ exponential(q[14:17])
        self.tip = A2 + R2 @ ca.vertcat(b, 0, q[2] + self.z0)
        arm, slide = np.diag([0, 0, float(sheet.arm.inertia)]), np.diag([0, 0, float(sheet.slide.inertia)])
        bodies = [
            (sheet.arm.mass, P1 + float(sheet.arm.center) * (R1 @ e_y), R1, arm),
            (sheet.arm.mass, P6 + float(sheet.arm.center) * (R6 @ e_y), R6, arm),
            (sheet.slide.mass, c1, R1, slide), (sheet.slide.mass, c6, R6, slide),
            (sheet.link2.mass, A2 + R2 @ ca.DM(sheet.link2.center), R2, sheet.link2.inertia),
            (sheet.ram.mass, self.tip + R2 @ ca.DM(sheet.ram.center), R2, sheet.ram.inertia),
            (sheet.link5.mass, A5 + R5 @ ca.DM(sheet.link5.center), R5, sheet.link5.inertia),
        ]  # fmt: skip
        self.M, self.weight = 0, 0
        for mass, p, R, inertia in bodies:
            J, turned = ca.jacobian(p, q), ca.jacobian(ca.vec(R), q)
            spins = [R.T @ ca.reshape(turned[:, k], 3, 3) for k in range(17)]
            w = ca.horzcat(*[ca.vertcat(S[2, 1], S[0, 2], S[1, 0]) for S in spins])
            self.M += float(mass) * J.T @ J + w.T @ ca.DM(inertia) @ w
            self.weight += float(mass) * GRAVITY * p[1]
        self.energy = self.weight + ca.dot(q[5:], K * q[5:]) / 2
        R, gap = R2.T @ R5, R2.T @ (A5 - A2)
        self.phi = ca.vertcat(gap[1], gap[2], R[2, 1], R[0, 2], R[1, 0])

    # -- rest and small motions ---------------------------------------------------------------------------------------

    @cached_property
    def _static(self):
        l = ca.SX.sym("l", 5)
        H, g = ca.hessian(self.energy + ca.dot(l, self.phi), self.q)
        J = ca.jacobian(self.phi, self.q)
        return ca.Function("static", [self.q, l], [H, g, self.phi, J, self.M, self.tip])

    def unbent(self, x):
        """q with the tip at x (3,), no spring bent."""
        b = self.b
        s = np.sqrt((x[0] + b) ** 2 + x[1] ** 2 - b * b)
        phi = np.arctan2(x[1], x[0] + b) - np.arctan2(s, b)
        return np.r_[s, s + 2 * b * np.sin(phi), x[2], phi, phi, np.zeros(12)]

    def rest(self, x):
        """q, multipliers and the drives' forces under gravity, the slides where the unbent tip is at x."""
        q, l = self.unbent(x), np.zeros(5)
        for _ in range(8):
            H, g, phi, J, _, _ = (np.array(one) for one in self._static(q, l))
            A = np.block([[H[3:, 3:], J[:, 3:].T], [J[:, 3:], np.zeros((5, 5))]])
            step = np.linalg.solve(A, -np.r_[g[3:, 0], phi[:, 0]])
            q[3:], l = q[3:] + step[:-5], l + step[-5:]
        return q, l, np.array(self._static(q, l)[1])[:3, 0]

    def sag(self, x):
        """Displacement of the tip at rest, m."""
        q, l, _ = self.rest(x)
        return np.array(self._static(q, l)[5])[:, 0] - x

    def loop_poles(self, x, mass, gains):
        """Poles of the loop u = mass (k_d e' + k_p e + k_i int e) at the rest of x, 1/s; `mass` (3, 3) or None: M_S."""
        q, l, _ = self.rest(x)
        H, _, _, J, M, _ = (np.array(one) for one in self._static(q, l))
        N = null_space(J)
        D = np.diag(np.r_[np.zeros(5), self.beta * self.K])
        M, H, D, S = N.T @ M @ N, N.T @ H @ N, N.T @ D @ N, N[:3]
        W = np.array(self._rigid(self.unbent(x)[:3], np.zeros(3))[0]) if mass is None else mass
        k_d, k_p, k_i = gains
        n = len(M)
        A = np.zeros((2 * n + 3, 2 * n + 3))
        A[:n, n : 2 * n], A[2 * n :, :n] = np.eye(n), S
        A[n : 2 * n] = -np.linalg.solve(M, np.hstack([H + k_p * S.T @ W @ S, D + k_d * S.T @ W @ S, k_i * S.T @ W]))
        return np.linalg.eigvals(A)

    # -- the move -----------------------------------------------------------------------------------------------------

    @cached_property
    def _rigid(self):
        """s, s' -> M_S, C_S s' + G_S: phi is a closed form of s."""
        s, sd = ca.SX.sym("s", 3), ca.SX.sym("sd", 3)
        phi = ca.asin((s[1] - s[0]) / (2 * self.b))
        q = ca.vertcat(s, phi, phi, ca.SX.zeros(12, 1))
        J = ca.jacobian(q, s)
        M = J.T @ ca.substitute(self.M, self.q, q) @ J
        V = ca.substitute(self.weight, self.q, q)
        h = ca.jacobian(M @ sd, s) @ sd - ca.gradient(ca.dot(sd, M @ sd) / 2, s) + ca.gradient(V, s)
        return ca.Function("rigid", [s, sd], [M, h])

    @cached_property
    def _motion(self):
        """q, q', u -> the matrix and the right side of eq. (1)."""
        q, v, u = self.q, ca.SX.sym("v", 17), ca.SX.sym("u", 3)
        J = ca.jacobian(self.phi, q)
        h = ca.jacobian(self.M @ v, q) @ v - ca.gradient(ca.dot(v, self.M @ v) / 2, q)
        force = ca.vertcat(u, ca.SX.zeros(14, 1)) - h - ca.gradient(self.energy, q)
        force -= ca.vertcat(ca.SX.zeros(5, 1), self.beta * self.K * v[5:])
        held = -ca.jacobian(J @ v, q) @ v - 2 * PULL * (J @ v) - PULL**2 * self.phi
        A = ca.vertcat(ca.horzcat(self.M, J.T), ca.horzcat(J, ca.SX.zeros(5, 5)))
        return ca.Function("motion", [q, v, u], [A, ca.vertcat(force, held)])

    def reference(self, start, end, amplitude):
        """Function t -> s_d, s_d', s_d'' of a move with one sine of the acceleration each axis."""
        x, xd, xdd = (ca.SX.sym(name, 3) for name in ("x", "xd", "xdd"))
        s1 = ca.sqrt((x[0] + self.b) ** 2 + x[1] ** 2 - self.b**2)
        phi = ca.atan2(x[1], x[0] + self.b) - ca.atan2(s1, self.b)
        s = ca.vertcat(s1, s1 + 2 * self.b * ca.sin(phi), x[2])
        J = ca.jacobian(s, x)
        joints = ca.Function("joints", [x, xd, xdd], [s, J @ xd, J @ xdd + ca.jacobian(J @ xd, x) @ xd])
        way = end - start
        T = np.sqrt(2 * np.pi * np.abs(way) / amplitude)
        w, a = 2 * np.pi / T, np.sign(way) * amplitude

        def at(t):
            on, tau = t < T, np.minimum(t, T)
            place = start + a * (tau / w - np.sin(w * tau) / w**2)
            speed = np.where(on, a / w * (1 - np.cos(w * tau)), 0)
            return [np.array(one)[:, 0] for one in joints(place, speed, np.where(on, a * np.sin(w * tau), 0))]

        return at

    def computed_torque(self, start, end, amplitude, gains, loaded, until):
        """s_d - s of the move, a row each STEP until `until` s; from rest, or let go with no spring bent."""
        reference, (k_d, k_p, k_i) = self.reference(start, end, amplitude), gains
        q = self.rest(start)[0] if loaded else self.unbent(start)

        def rate(t, y):
            s_d, sd_d, sdd_d = reference(t)
            M, h = (np.array(one) for one in self._rigid(y[:3], y[17:20]))
            e = s_d - y[:3]
            u = M @ (sdd_d + k_d * (sd_d - y[17:20]) + k_p * e + k_i * y[34:]) + h[:, 0]
            A, right = self._motion(y[:17], y[17:34], u)
            return np.r_[y[17:34], np.linalg.solve(np.array(A), np.array(right)[:, 0])[:17], e]

        y, errors = np.r_[q, np.zeros(20)], []
        for k in range(round(until / STEP)):
            t = k * STEP
            errors.append(reference(t)[0] - y[:3])
            k1 = rate(t, y)
            k2 = rate(t + STEP / 2, y + STEP / 2 * k1)
            k3 = rate(t + STEP / 2, y + STEP / 2 * k2)
            y = y + STEP / 6 * (k1 + 2 * k2 + 2 * k3 + rate(t + STEP, y + STEP * k3))
        return np.array(errors)
