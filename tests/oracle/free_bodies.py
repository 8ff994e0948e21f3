"""Tubes, sleeves and platform of a hexapod as free bodies: what their motion needs, by differentiating positions.

No formula of gough.machine is used: positions and rotations are written down, the universal joint by its two angles,
and every velocity and acceleration is a derivative by time.
"""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca
import numpy as np

from .lagrange import axial, rotation, rotation_abc, universal_frame


class Body(NamedTuple):
    """What a rigid body's motion needs: force and moment about its centre of mass, without weight; and the centre."""

    force: np.ndarray
    moment: np.ndarray
    center: np.ndarray


class StrutState(NamedTuple):
    """One strut at one instant, all in W."""

    A: np.ndarray
    B: np.ndarray
    n: np.ndarray
    l: float
    ldd: float
    cross: np.ndarray  # the second axis of the cross
    turn: float  # second derivative of the angle about the axis fixed in the base
    w: np.ndarray
    moving: Body
    fixed: Body


def skewed(u):
    return np.array([[0, -u[2], u[1]], [u[2], 0, -u[0]], [-u[1], u[0], 0]])


class FreeBodies:
    """The free bodies of a machine; `at(x, V, Vd)` gives the platform and the six struts."""

    def __init__(self, m):
        self.m = m
        t, x, V, Vd = ca.SX.sym("t"), *(ca.SX.sym(name, 6) for name in ("x", "V", "Vd"))

        def skew(u):
            return ca.vertcat(ca.horzcat(0, -u[2], u[1]), ca.horzcat(u[2], 0, -u[0]), ca.horzcat(-u[1], u[0], 0))

        # a motion with this twist and twist rate at t = 0; terms of t^3 do not reach a second derivative there
        turned = skew(V[3:] * t + Vd[3:] * t**2 / 2)
        R = (ca.SX.eye(3) + turned + turned @ turned / 2) @ rotation_abc(x[3:])
        p = x[:3] + V[:3] * t + Vd[:3] * t**2 / 2
        R_P, p_P = R, p
        if m.tool is not None:
            R_P = R @ rotation_abc(ca.DM(m.tool.angles)).T
            p_P = p - R_P @ ca.DM(m.tool.position)

        def d(f):
            return ca.reshape(ca.jacobian(ca.vec(f), t), f.shape)

        def body(mass, center, I, R):
            w = axial(d(R) @ R.T)
            return [mass * d(d(center)), d(R @ I @ R.T @ w), center]

        out = [*body(m.platform.mass, p_P + R_P @ ca.DM(m.platform.center), ca.DM(m.platform.inertia), R_P), p]
        for i in range(6):
            A = ca.SX(ca.DM(m.joints.base[i]))
            B = p_P + R_P @ ca.DM(m.joints.platform[i])
            s = B - A
            l = ca.sqrt(ca.dot(s, s))
            R_WU = ca.DM(universal_frame(m, i))
            e = R_WU.T @ s / l
            alpha, beta = ca.atan2(-e[1], e[2]), ca.atan2(e[0], ca.sqrt(e[1] ** 2 + e[2] ** 2))
            R_C = R_WU @ rotation(0, alpha)
            R_S = R_C @ rotation(1, beta)
            n = R_S[:, 2]
            out += [A, B, n, l, d(d(l)), R_C[:, 1], d(d(alpha)), axial(d(R_S) @ R_S.T)]
            for part, middle in (
                (m.strut.moving, B - m.strut.moving.center * n),
                (m.strut.fixed, A + m.strut.fixed.center * n),
            ):
                I = part.inertia
                if I is None:
                    I = np.diag([part.transverse, part.transverse, part.axial or 0.0])
                ox, oy = (0.0, 0.0) if part.offset is None else part.offset
                out += body(part.mass, middle + R_S[:, 0] * ox + R_S[:, 1] * oy, ca.DM(I), R_S)
        self._f = ca.Function("bodies", [t, x, V, Vd], out)

    def at(self, x, V, Vd) -> tuple[Body, np.ndarray, list[StrutState]]:
        """Platform, its tip, struts."""
        found = [np.array(value).ravel() for value in self._f(0, x, V, Vd)]
        struts = []
        for i in range(6):
            A, B, n, l, ldd, cross, turn, w, *bodies = found[4 + 14 * i : 18 + 14 * i]
            struts.append(StrutState(A, B, n, l[0], ldd[0], cross, turn[0], w, Body(*bodies[:3]), Body(*bodies[3:])))
        return Body(*found[:3]), found[3], struts
