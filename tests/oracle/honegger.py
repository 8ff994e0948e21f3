"""Equations (1)-(17) of Honegger, Nonlinear adaptive control of a 6 DOF parallel manipulator, 1998, in NumPy.

A second derivation of the hexaglide without leg mass, in the paper's own coordinates: x = (x y z alpha beta gamma),
R = Rx Ry Rz.  Repairs of print and scan, each shown by a test of test_hexaglide_published.py:

    (5)    E+ = diag(1, E_r); the scan ran its blocks together
    (9)    the first column is q'', not q'
    (13)   the printed matrix is the skew matrix of a, the equation needs its negative

Only the rows of (3) are taken from the machine: where its rails, joints and legs are.  Derivatives by t are taken by
complex steps, exact to rounding; the paper differentiates numerically, too.
"""

from __future__ import annotations

import numpy as np

STEP = 1e-30  # of a complex step: no difference is formed, so it can be as small as numbers go


def rotation(angles):
    """Eq. (2): Rx(alpha) Ry(beta) Rz(gamma); also of complex angles.  (3,) -> (3, 3)."""
    (ca, cb, cg), (sa, sb, sg) = np.cos(angles), np.sin(angles)
    Rx = np.array([[1, 0, 0], [0, ca, -sa], [0, sa, ca]])
    Ry = np.array([[cb, 0, sb], [0, 1, 0], [-sb, 0, cb]])
    Rz = np.array([[cg, -sg, 0], [sg, cg, 0], [0, 0, 1]])
    return Rx @ Ry @ Rz


def rate_matrix(angles):
    """Eq. (17), E_r+: angular velocity in the base of rates of alpha, beta, gamma.  (3, 3)."""
    (ca, cb, _), (sa, sb, _) = np.cos(angles), np.sin(angles)
    return np.array([[1, 0, sb], [0, ca, -cb * sa], [0, sa, cb * ca]])


def angles_of(R):
    """alpha, beta, gamma of eq. (2).  (3, 3) -> (3,)."""
    return np.array([np.arctan2(-R[1, 2], R[2, 2]), np.arcsin(R[0, 2]), np.arctan2(-R[0, 1], R[0, 0])])


class Paper:
    """The model at the geometry of a machine whose rails run along x."""

    def __init__(self, machine):
        self.P_T = np.array(machine.joints.platform)
        self.S_yz = np.array(machine.rails.point)[:, 1:]
        self.l = float(machine.legs.length)
        self.g = -machine.gravity[2]

    def joints(self, x):
        """Eq. (3), with i from 1.  (6,) -> (6,) m."""
        P = x[:3] + self.P_T @ rotation(x[3:]).T
        d = self.S_yz - P[:, 1:]
        i = np.arange(1, 7)
        return P[:, 0] + (-1.0) ** i * np.sqrt(self.l**2 - d[:, 0] ** 2 - d[:, 1] ** 2)

    def joint_rate(self, x, xd):
        """q' as the derivative of (3) along xd: the inverse of the paper's J."""
        return self.joints(x + 1j * STEP * xd).imag / STEP

    def J_0T(self, x):
        """Eq. (5): twist of the TCP over joint rates.  (6, 6)."""
        J = np.linalg.inv(np.stack([self.joint_rate(x, e) for e in np.eye(6)], 1))  # of the representation
        E = np.block([[np.eye(3), np.zeros((3, 3))], [np.zeros((3, 3)), rate_matrix(x[3:])]])
        return E @ J

    def psi_motors(self, qd, qdd):
        """Eq. (9), repaired: columns m, f_c 1-6, f_v 1-6.  (6, 13)."""
        return np.hstack([qdd[:, None], np.diag(np.sign(qd)), np.diag(qd)])

    def psi_platform(self, x, v, vd, w, wd, printed=False):
        """Eqs. (11)-(15): columns m7, m7 r_x, m7 r_y, m7 r_z, Ixx, Iyy, Izz.  (6, 7).

        w, wd (3,) in T, eq. (16) and its derivative; `printed` takes eq. (13) as it stands in the paper.
        """
        R = rotation(x[3:])
        a = vd + [0, 0, self.g]  # (12)
        minus_skew = np.array([[0, a[2], -a[1]], [-a[2], 0, a[0]], [a[1], -a[0], 0]])  # (13), repaired
        if printed:
            minus_skew = -minus_skew
        (wx, wy, wz), (ax, ay, az) = w, wd
        Lambda = np.array(
            [
                [-(wy**2) - wz**2, -az + wx * wy, ay + wx * wz],
                [az + wx * wy, -(wx**2) - wz**2, -ax + wy * wz],
                [-ay + wx * wz, ax + wy * wz, -(wx**2) - wy**2],
            ]
        )  # fmt: skip  (14)
        Psi_w = np.array([[ax, -wy * wz, wy * wz], [wx * wz, ay, -wx * wz], [-wx * wy, wx * wy, az]])  # (15)
        upper = np.hstack([a[:, None], R @ Lambda, np.zeros((3, 3))])
        lower = np.hstack([np.zeros((3, 1)), minus_skew @ R, R @ Psi_w])
        return self.J_0T(x).T @ np.vstack([upper, lower])  # (11)

    def psi(self, x, xd, xdd, printed=False):
        """Eq. (8): tau = psi @ p.  x, x', x'' (6,) in the paper's coordinates.  (6, 20)."""

        def twist(x, xd):  # (16), in T
            E = rate_matrix(x[3:])
            return rotation(x[3:]).T @ (E @ xd[3:])

        later = x + 1j * STEP * xd, xd + 1j * STEP * xdd
        w, wd = twist(x, xd), twist(*later).imag / STEP
        qd = self.joint_rate(x, xd)
        qdd = self._joint_acceleration(x, xd, xdd)
        return np.hstack([self.psi_motors(qd, qdd), self.psi_platform(x, xd[:3], xdd[:3], w, wd, printed)])

    def _joint_acceleration(self, x, xd, xdd):
        """d/dt of the exact q' by a difference of sixth order: 1e-12 of rounding, and (h 10 1/s)^6 / 140 of truth."""
        h = 2e-4
        at = [self.joint_rate(x + t * xd + t * t / 2 * xdd, xd + t * xdd) for t in h * np.arange(-3, 4)]
        return np.array([-1, 9, -45, 0, 45, -9, 1]) / (60 * h) @ np.array(at)
