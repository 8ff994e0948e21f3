"""The adaptive sliding-mode laws written once more, in NumPy and from energies: nothing of gough but the numbers.

The hexapod with slender struts is its kinetic and potential energy in the chart (p, r), R = exp([r]) R_0, whose rates
at r = 0 are the twist.  M and its derivatives come from there, by complex steps (exact to rounding), and C, with
M' - 2 C skew, from Christoffel's symbols; at r = 0 a rate x_s' = V_s has x_s'' = V_s' - [0; w x w_s / 2].
Normal forces are three balances of free bodies a strut, solved as they stand.
"""

from __future__ import annotations

import numpy as np

STEP = 1e-30  # of complex steps


def cross_matrix(a):
    """[a] with [a] b = a x b."""
    return np.array([[0 * a[0], -a[2], a[1]], [a[2], 0 * a[0], -a[0]], [-a[1], a[0], 0 * a[0]]])


def exponential(S, first=1):
    """The power series of exp S; with first = 2 that of its left Jacobian, sum S^k / (k + 1)!."""
    total = term = np.eye(3, dtype=complex)
    for k in range(first, first + 20):
        term = term @ S / k
        total = total + term
    return total


def rotation(abc):
    """First a about x, then b about y, then c about z, all axes fixed."""
    turns = [exponential(cross_matrix(angle * axis)).real for angle, axis in zip(abc, np.eye(3), strict=True)]
    return turns[2] @ turns[1] @ turns[0]


def rotation_vector(R):
    """The rotation vector of R, below half a turn."""
    v = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
    sine = np.linalg.norm(v)
    return v if sine == 0 else v * np.arctan2(sine, (np.trace(R) - 1) / 2) / sine


class Model:
    """A hexapod with slender struts whose nine numbers of eq. (3) of the paper are times `factors`."""

    def __init__(self, machine, factors):
        moving, fixed, drive = machine.strut.moving, machine.strut.fixed, machine.drive
        self.machine, self.gravity = machine, np.array(machine.gravity)
        self.reflected = factors[0] * drive.inertia * (2 * np.pi / drive.lead) ** 2
        self.viscous = factors[1] * machine.friction.viscous_offset
        self.mass, self.center = factors[2] * machine.platform.mass, np.array(machine.platform.center)
        self.m, self.c = factors[3] * moving.mass, moving.center
        self.m_f, self.c_f = factors[4] * fixed.mass, fixed.center
        self.I, self.I_f = factors[5] * moving.transverse, factors[5] * fixed.transverse + self.m_f * self.c_f**2
        self.inertia = np.array(machine.platform.inertia)
        self.inertia[np.diag_indices(3)] *= factors[6:]

    def _legs(self, p, R):
        for A, p_TB in zip(self.machine.joints.base, self.machine.joints.platform, strict=True):
            b = R @ p_TB
            s = p + b - A
            l = np.sqrt(s @ s)
            yield A, b, l, s / l

    def energies(self, p, r, R_0):
        """M of T = x'' M x' / 2 with x = (p, r), and U.  Complex where p or r is."""
        turned = cross_matrix(r)
        R, E = exponential(turned) @ R_0, exponential(turned, 2)

        def velocity(arm):  # of a point at `arm` from the tip, on x'
            return np.hstack([np.eye(3), -cross_matrix(arm) @ E])

        center, w = R @ self.center, np.hstack([np.zeros((3, 3)), E])
        M = self.mass * velocity(center).T @ velocity(center) + w.T @ (R @ self.inertia @ R.T) @ w
        U = -self.mass * self.gravity @ (p + center)
        for A, b, l, n in self._legs(p, R):
            v_B = velocity(b)
            nu = (np.eye(3) - np.outer(n, n)) @ v_B / l
            v_m = v_B - self.c * nu
            M = M + self.m * v_m.T @ v_m + (self.I + self.I_f) * nu.T @ nu + self.reflected * np.outer(n @ v_B, n @ v_B)
            U -= self.gravity @ (self.m * (p + b - self.c * n) + self.m_f * (A + self.c_f * n))
        return M, U

    def force(self, x, V, V_s, A_s):
        """M A_s + C(V) V_s + g + J' F_v J V_s at the pose x.  (6,)."""
        R_0, p = rotation(x[3:]), np.array(x[:3], complex)
        M, slopes = self.energies(p, np.zeros(3), R_0)[0].real, []
        for e in 1j * STEP * np.eye(6):
            slopes.append([part.imag / STEP for part in self.energies(p + e[:3], e[3:], R_0)])
        dM, dU = np.array([s[0] for s in slopes]), np.array([s[1] for s in slopes])
        C = (np.einsum("kij,k->ij", dM, V) + np.einsum("jik,k->ij", dM, V) - np.einsum("ijk,k->ij", dM, V)) / 2
        acceleration = A_s - np.append(np.zeros(3), np.cross(V[3:], V_s[3:]) / 2)
        J = self.jacobian(x)
        return M @ acceleration + C @ V_s + dU + J.T @ (self.viscous * (J @ V_s))

    def jacobian(self, x):
        """Strut speeds on the twist.  (6, 6)."""
        return np.array([np.append(n, np.cross(b, n)) for _, b, _, n in self._legs(x[:3], rotation(x[3:]))])

    def normal(self, x, V, A):
        """|N_a| + |N_b| of every strut: across n the tube's force and moment and the sleeve's moment balance.  (6,)."""
        found, w, guide = [], V[3:], self.machine.strut
        for _, b, l, n in self._legs(x[:3], rotation(x[3:])):
            v_B = V[:3] + np.cross(w, b)
            a_B = A[:3] + np.cross(A[3:], b) + np.cross(w, np.cross(w, b))
            rate = n @ v_B
            nu = (v_B - rate * n) / l
            nu_rate = (a_B - (n @ a_B + l * nu @ nu) * n - 2 * rate * nu) / l
            across, none, turn = np.eye(3) - np.outer(n, n), np.zeros((3, 3)), cross_matrix(n)
            s_a, s_b = l - guide.sleeve, guide.tube
            rows = [  # of R_B, N_a, N_b
                np.hstack([across, across, across]),
                np.hstack([self.c * turn, (self.c - s_a) * turn, (self.c - s_b) * turn]),
                np.hstack([none, -(l - s_a) * turn, -(l - s_b) * turn]),
                *(np.eye(3)[k][:, None] @ np.kron(np.eye(3)[k], n)[None] for k in range(3)),  # all of them across n
            ]
            right = [
                across @ (self.m * (a_B - self.c * nu_rate - self.gravity)),
                self.I * np.cross(n, nu_rate),
                self.I_f * np.cross(n, nu_rate) - self.c_f * np.cross(n, self.m_f * self.gravity),
                np.zeros(9),
            ]
            solved = np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=None)[0]
            found.append(np.linalg.norm(solved[3:6]) + np.linalg.norm(solved[6:]))
        return np.array(found)


class Step:
    """One sample of either law: equations (1) to (11), then `modelled` (12), (13) or `fuzzy` (14) to (17)."""

    def __init__(self, law, state, r, now, before, saturated):
        self.law, self.state, self.r, self.now = law, state, r, now
        R = rotation(now[3:])
        V = np.append(now[:3] - before[:3], rotation_vector(R @ rotation(before[3:]).T)) / law.period
        e = np.append(r.x[:3] - now[:3], rotation_vector(rotation(r.x[3:]) @ R.T))  # (1)
        V_s, A_s = r.xd + law.slope * e, r.xdd + law.slope * (r.xd - V)
        self.sigma = V_s - V  # (2)
        self.seconds = 0.0 if saturated else law.period
        self.model = Model(law.machine, state.parameters)
        self.J = self.model.jacobian(now)
        self.s = self.J @ self.sigma
        self.speed = r.qd if law.friction_speed == "reference" else self.J @ V
        W = np.append(np.ones(3), np.full(3, law.length**2))
        self.size = np.sqrt(W @ self.sigma**2)
        slide = law.sliding * W * self.sigma / (self.size if self.size > law.boundary else law.boundary)  # (9)
        force = self.model.force(now, V, V_s, A_s) + law.K_D @ self.sigma + slide + state.started  # (7), (8)
        self.pushed = np.linalg.solve(self.J.T, force)  # (10), less friction
        at = (V, V_s, A_s) if law.regressor == "actual" else (r.xd, r.xd, r.xdd)
        nothing = Model(law.machine, np.zeros(9)).force(now, *at)
        per = [Model(law.machine, one).force(now, *at) - nothing for one in np.eye(9)]
        low, high = law.bounds
        self.parameters = self._learned(state.parameters, np.array(per) @ self.sigma, law.inertia_rate, low, high)

    def leak(self, estimates):
        """The switching sigma of a group of estimates, by the three cases of Ioannou and Sun."""
        size, M_0 = np.linalg.norm(estimates), self.law.leakage_norm * np.sqrt(len(estimates))
        if size <= M_0:
            return 0.0
        return self.law.leakage * (size / M_0 - 1 if size <= 2 * M_0 else 1.0)

    def _learned(self, estimates, y, rate, low, high):
        free = estimates + self.seconds * rate * (y - self.leak(estimates) * estimates)
        return np.minimum(np.maximum(free, low), high)

    def modelled(self):
        """CDAC: joint forces, and the next Coulomb and viscous factors."""
        law, state, friction = self.law, self.state, self.law.machine.friction
        N = self.model.normal(self.now, self.r.xd, self.r.xdd)
        coulomb = (friction.coulomb_offset + friction.coulomb * N) * np.tanh(self.speed / law.friction_smoothing)
        viscous = friction.viscous * N * self.speed
        low, high = law.friction_bounds
        c = self._learned(state.coulomb, coulomb * self.s, law.coulomb_rate, low, high)
        d = self._learned(state.viscous, viscous * self.s, law.viscous_rate, low, high)
        return self.pushed + coulomb * state.coulomb + viscous * state.viscous, c, d

    def fuzzy(self):
        """FCDAC: joint forces, and the next weights."""
        law, feed, count = self.law, self.law.machine.feed, self.law.accelerations
        centers, widths = np.asarray(law.centers), np.asarray(law.widths)
        rates = np.broadcast_to(law.friction_rate, 6)
        A = np.reshape(self.state.weights, (6, len(centers), 3 + count))  # joint, rule, entry of z
        scale = np.repeat([feed.acceleration, feed.angular_acceleration], 3)
        lost, after = np.zeros(6), np.zeros_like(A)
        for i, speed in enumerate(self.speed):
            x = min(max(speed, centers[0]), centers[-1])
            member = np.exp(-(((x - centers) / widths) ** 2))
            zeta = member / member.sum()
            sign = np.tanh(speed / law.friction_smoothing)
            z = np.concatenate([[1, x / 0.1, sign], (self.r.xdd / scale)[:count]])
            lost[i] = sum(share * (rule @ z) for share, rule in zip(zeta, A[i], strict=True))
            G = rates[i] * np.concatenate([np.ones(3), np.full(count, law.acceleration_rate)])
            after[i] = np.clip(A[i] + self.seconds * self.s[i] * np.outer(zeta, G * z), -law.strength, law.strength)
        return self.pushed + lost, after.ravel()
