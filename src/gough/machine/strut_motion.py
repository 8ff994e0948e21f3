"""How one strut of a hexapod moves: its turning, its spin and the frame S that the universal joint gives it.

With n along the strut, nu = n' and a the axis of the universal joint fixed in the base (equations (2)-(4), (6) of
machine/hexapod.py):

    w_s = n x nu + sigma n,    w_s' = n x P nu' + sigma' n + sigma nu                                            (1)
    w_s = A v_B,   A = [n]/l + n G';   a torque t on the strut is the force A' t = (t x n)/l + (t.n) G at B       (2)
    S:  third axis n, second y = n x a / |n x a|, first x = y x n                                                (3)

Without a base axis the spin is not known and taken as none: sigma = 0, G = 0.
"""

from __future__ import annotations

import casadi as ca


def point_motion(b, v, vd):
    """Velocity and acceleration of the platform joint at b (3,) from T, all in W.  eqs. (2), (4) of hexapod.py."""
    w, wd = v[3:], vd[3:]
    wxb = ca.cross(w, b)
    return v[:3] + wxb, vd[:3] + ca.cross(wd, b) + ca.cross(w, wxb)


class StrutMotion:
    """One strut at one instant.  `a` (3,) the axis fixed in the base, or None; b, n, twist, its rate: in W."""

    def __init__(self, a, b, l, n, v, vd):
        self.a, self.b, self.l, self.n = a, b, l, n
        self.v_B, self.a_B = point_motion(b, v, vd)
        self.ld = ca.dot(n, self.v_B)
        self.nu = (self.v_B - self.ld * n) / l
        axial = ca.dot(n, self.a_B)
        self.ldd = axial + l * ca.dot(self.nu, self.nu)
        P_nud = (self.a_B - axial * n - 2 * self.ld * self.nu) / l
        self.w, self.wd = ca.cross(n, self.nu), ca.cross(n, P_nud)
        self.G = None
        if a is None:
            return
        ka, kad, tau, taud = ca.dot(a, n), ca.dot(a, self.nu), ca.dot(a, self.w), ca.dot(a, self.wd)
        D = 1 - ka * ka
        sigma = ka * tau / D
        sigmad = (kad * tau + ka * taud + 2 * ka * ka * kad * tau / D) / D
        self.w += sigma * n
        self.wd += sigmad * n + sigma * self.nu
        self.G = spin(a, ka, l, n)

    def at_B(self, torque):
        """The force at B that does the work of a torque (3,) on the strut, eq. (2).  (3,)."""
        return torque_at_B(torque, self.l, self.n, self.G)

    def frame(self):
        """R_WS of eq. (3).  (3, 3)."""
        return frame(self.a, self.n)


def spin(a, ka, l, n):
    """G of eq. (6) of hexapod.py.  (3,)."""
    return ka / (1 - ka * ka) / l * ca.cross(a, n)


def torque_at_B(torque, l, n, G):
    """A' t of eq. (2).  (3,)."""
    F = ca.cross(torque, n) / l
    return F if G is None else F + ca.dot(torque, n) * G


def frame(a, n):
    """R_WS of eq. (3).  (3, 3)."""
    y = ca.cross(n, a)
    y = y / ca.norm_2(y)
    return ca.horzcat(ca.cross(y, n), y, n)
