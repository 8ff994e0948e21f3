"""Forces in the joints of a hexapod: at both ends of every strut, and between its tube and its sleeve.

Free bodies, all in W; (f, t) what the motion of a part needs (strut_bodies.py), F that of its eq. (1), u - f the drive
less the friction in the strut, t_B, t_A the torques of joint friction on the strut:

    R_B = F - n (u - f) - A' (t_A + t_B)             the platform on the strut, at B                              (1)
    R_A = f_m + f_f - R_B                            the base on the strut, at A                                  (2)

The moving tube runs in two bushings that give forces across n only: one at the sleeve's mouth, s_a = l - sleeve from B,
one at the tube's end, s_b = tube from B.  Forces and moments about B, across n, with o = s_b - s_a the overlap:

    N_a + N_b = P (f_m - R_B) = Q,      s_a N_a + s_b N_b = n x (t_m - t_B) = S                                   (3)
    N_a = (s_b Q - S) / o,   N_b = (S - s_a Q) / o,   |N_a| + |N_b| the normal force of the strut's friction      (4)

Friction of the joints is a torque about the axis on which the joint turns at that instant, smoothed near rest:

    t_B = mu r_B |R_B| e(w - w_s),   t_A = -mu r_A |R_A| e(w_s),   e(x) = x / sqrt(|x|^2 + w_0^2)                 (5)

and its power, t_B . (w_s - w) + t_A . w_s, is never positive.  Derivation: docs/theory/friction.md.
Source of the two bushings: MACHINES.md 1.3, after Garagic and Srinivasan, ACC 2004, eq. (5), in vectors.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from .strut_bodies import StrutBodies, cross_force
from .strut_motion import StrutMotion

_NO_FORCE = 1e-6  # N; |N| is sqrt(N.N + this^2), so that a derivative exists where nothing presses


class Reactions(NamedTuple):
    """Forces in the joints, N, vectors in W; None where a machine has no such force."""

    platform_joint: Any  # (..., n, 3) on the strut, from the platform
    base_joint: Any  # (..., n, 3) on the strut, from the base
    mouth: Any = None  # (..., n, 3) on the tube, from the sleeve's mouth
    end: Any = None  # (..., n, 3) on the tube's end, from the sleeve
    normal: Any = None  # (..., n) |mouth| + |end|
    multiplier: Any = None  # (..., m) of the closure, where coordinates depend on each other


def motions(m, p, z, v, vd) -> list[StrutMotion]:
    """How the struts of hexapod `m` move, with their spin where it has base axes."""
    b, _, l, n = m.struts(p, z)
    axes = p.joints.base_axis
    return [StrutMotion(None if axes is None else axes[i, :].T, b[:, i], l[i], n[:, i], v, vd) for i in range(6)]


def reactions_of(m, p, pi, z, v, vd, net, held=None) -> Reactions:
    """Eqs. (1)-(4), symbolic: each (3, 6), `normal` (6,).

    `net` (6,) N is drive less friction of the struts.  `held` = (|R_B|, |R_A|) (6,) each N turns on the friction of
    the joints, at these reactions; None leaves it out.
    """
    bodies, columns = StrutBodies(pi), [[] for _ in range(5)]
    for i, motion in enumerate(motions(m, p, z, v, vd)):
        n, l = motion.n, motion.l
        (f_m, t_m), (f_f, t_f) = bodies.wrenches(motion, p.gravity)
        R_B = f_m + motion.at_B(t_m + t_f) + n * (bodies.m_r * motion.ldd - net[i])
        if "joints.cross" in pi:
            R_B += cross_force(pi["joints.cross"], motion)
        if held is not None:
            t_B, t_A = joint_torques(p.joints.friction, motion.w, v[3:], held[0][i], held[1][i])
            R_B -= motion.at_B(t_A + t_B)
            t_m = t_m - t_B
        found = [R_B, f_m + f_f - R_B]
        if m.guided:
            Q, S = f_m - R_B, ca.cross(n, t_m)
            Q -= ca.dot(n, Q) * n
            s_a, s_b = l - p.strut.sleeve, p.strut.tube
            N_a, N_b = (s_b * Q - S) / (s_b - s_a), (S - s_a * Q) / (s_b - s_a)
            found += [N_a, N_b, magnitude(N_a) + magnitude(N_b)]
        for column, value in zip(columns, found, strict=False):
            column.append(value)
    *vectors, normal = columns
    joined = [ca.horzcat(*column) if column else None for column in vectors]
    return Reactions(*joined, ca.vertcat(*normal) if normal else None)


def joint_torques(law, w_s, w, R_B, R_A):
    """t_B and t_A of eq. (5), on the strut; R_B, R_A magnitudes.  2 x (3,) N m."""
    slip = w - w_s

    def direction(x):
        return x / ca.sqrt(ca.dot(x, x) + law.smoothing * law.smoothing)

    return (
        law.coefficient * law.platform_radius * R_B * direction(slip),
        -law.coefficient * law.base_radius * R_A * direction(w_s),
    )


def joint_friction_of(m, p, z, v, R_B, R_A):
    """What the friction of the joints adds to J' (u - f), on the twist, at reactions R_B, R_A (6,) N.  (6,)."""
    total = ca.SX(6, 1)
    for i, motion in enumerate(motions(m, p, z, v, ca.SX(6, 1))):
        t_B, t_A = joint_torques(p.joints.friction, motion.w, v[3:], R_B[i], R_A[i])
        F = motion.at_B(t_A + t_B)
        total += ca.vertcat(F, ca.cross(motion.b, F) - t_B)
    return total


def magnitude(x):
    """|x| of a force (3,) N, smooth at 0."""
    return ca.sqrt(ca.dot(x, x) + _NO_FORCE**2)


def unpacked(flat: np.ndarray, guided: bool) -> Reactions:
    """Reactions of rows (..., 36) or (..., 78): the vectors strut by strut, then the normal forces."""
    lead = flat.shape[:-1]
    count = 4 if guided else 2
    vectors = [flat[..., 18 * k : 18 * k + 18].reshape(*lead, 6, 3) for k in range(count)]
    return Reactions(*vectors, flat[..., 72:]) if guided else Reactions(*vectors)
