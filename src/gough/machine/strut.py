"""One slender strut of a hexapod as its platform joint feels it: mass and force from the inertial parameters.

Equations (2) to (6) are those of machine/hexapod.py.  Struts whose parts are no slender bodies: strut_bodies.py.
"""

from __future__ import annotations

import casadi as ca

from .strut_motion import spin


class StrutLoad:
    """What one strut asks of its platform joint, eqs. (3), (5), (6), from the inertial parameters `pi`."""

    def __init__(self, pi):
        self.m, self.k, self.I = (pi.get(f"strut.moving.{key}", 0) for key in ("m", "m c", "I"))
        self.k_f, self.I_f = (pi.get(f"strut.fixed.{key}", 0) for key in ("m c", "I"))
        axial = [pi[key] for key in ("strut.moving.Iaxial", "strut.fixed.Iaxial") if key in pi]
        self.I_a = sum(axial) if axial else None
        self.m_r = pi.get("drive.m", 0)

    def force(self, p, i, l, n, v_B, a_B):
        """F of eq. (5), on B, in W.  (3,)."""
        ld = ca.dot(n, v_B)
        nu = (v_B - ld * n) / l
        nu2 = ca.dot(nu, nu)
        axial_a = ca.dot(n, a_B)
        P_nud = (a_B - axial_a * n - 2 * ld * nu) / l
        load = a_B - p.gravity
        axial = ca.dot(n, load)
        across = load - axial * n
        g_across = p.gravity - ca.dot(n, p.gravity) * n
        F = n * (self.m * axial + self.k * nu2 + self.m_r * (axial_a + l * nu2))
        F += (self.m - self.k / l) * across + ((self.I + self.I_f) / l - self.k) * P_nud - self.k_f / l * g_across
        if self.I_a is not None:
            a = p.joints.base_axis[i, :].T
            ka, kad, tau, taud = ca.dot(a, n), ca.dot(a, nu), ca.dot(a, ca.cross(n, nu)), ca.dot(a, ca.cross(n, P_nud))
            D = 1 - ka * ka
            sigma = ka * tau / D
            sigmad = (kad * tau + ka * taud + 2 * ka * ka * kad * tau / D) / D
            F += self.I_a * (sigma / l * ca.cross(nu, n) + spin(a, ka, l, n) * sigmad)
        return F

    def mass(self, p, i, l, n):
        """Mass at B: F = mass a_B + ... .  (3, 3)."""
        nn = n @ n.T
        across = self.m - 2 * self.k / l + (self.I + self.I_f) / (l * l)
        M = across * ca.SX.eye(3) + (self.m + self.m_r - across) * nn
        if self.I_a is not None:
            a = p.joints.base_axis[i, :].T
            G = spin(a, ca.dot(a, n), l, n)
            M += self.I_a * G @ G.T
        return M
