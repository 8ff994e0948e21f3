"""Friction of a moving machine, told from its motion alone.

    F_i  = g(q'_i) tanh(q'_i / v_0) + f_v q'_i                                                                      (1)
    t_B, t_A of machine/reactions.py, eq. (5), at the reactions of the motion                                       (2)
    F_A  = -(t_0 / l) v_p / sqrt(|v_p|^2 + v_0^2),   v_p = v_B - l' n                                               (3)

(1) is the sliding level of the believed law of friction (mechanics/friction.py) at the normal force of this motion;
what bristles remember is not known to whoever only sees encoders.  (3) is a torque t_0 in each base joint as a force
on the platform joint: Okuda, Ibaraki, Kakino, Nakagawa, Matsushita 2006, eq. (13), with the part of d(L l)/dt across
the strut, as their text has it; the printed one also has the part along it.  Below v_0 nobody knows the direction: the
forces fade, and what may hide there is at most

    D_k  = sum_i |(T J')_ki| g(0) (1 - tanh^2(q'_i / v_0))                                                          (4)

on the k-th component of the wrench on the tool, with T of observe/wrench.py.  docs/theory/disturbance.md derives (3)
and (4).
"""

from __future__ import annotations

import casadi as ca

from ..mechanics.friction import level


def numbers_at(machine, p, pi, z, v, vd):
    """The believed friction's numbers on a motion, with the loads that scale them; None without friction."""
    if machine.friction is None:
        return None
    if not machine.friction.loaded:
        return p.friction
    return machine.friction.at_load(p.friction, machine.friction_load(p, pi, z, v, vd))


def drive_friction(numbers, qd, rest):
    """Eq. (1): friction of the joints against their speeds qd (n,) m/s.  (n,) N."""
    if numbers is None:
        return ca.SX.zeros(qd.shape)
    return level(numbers, qd) * ca.tanh(qd / rest) + numbers.viscous * qd


def hidden(numbers, TJ, qd, rest):
    """D of eq. (4), (6,): how much force and moment unknown friction may hide or feign; `TJ` is T J' (6, n)."""
    if numbers is None:
        return ca.SX.zeros(6)
    faded = 1 - ca.tanh(qd / rest) ** 2
    return ca.fabs(TJ) @ (level(numbers, ca.SX.zeros(qd.shape)) * faded)


def passive_friction(machine, p, z, v, vd, net, base_torque, rest):
    """What friction of the passive joints adds to J' (u - F), eqs. (2), (3), on v.

    `net` (n,) N is drive less friction (1); `base_torque` t_0, one or (n,) N m, or None.
    """
    total = ca.SX.zeros(v.shape)
    joints = getattr(machine, "joints", None)
    if getattr(joints, "friction", None) is not None:
        found = machine.reactions_of(p, z, v, vd, net)
        R_B, R_A = (_sizes(R) for R in (found.platform_joint, found.base_joint))
        total += machine.joint_friction(p, z, v, ca.vertcat(R_B, R_A))
    if base_torque is not None:
        t_0 = ca.repmat(base_torque, 6, 1) if ca.SX(base_torque).numel() == 1 else base_torque
        total += base_torques(machine, p, z, v, rest) @ t_0
    return total


def base_torques(machine, p, z, v, rest):
    """What a torque of 1 N m in each base joint of a machine of struts does on v, eq. (3).  (6, 6), joint by joint."""
    b, _, l, n = machine.struts(p, z)
    columns = []
    for i in range(6):
        v_B = v[:3] + ca.cross(v[3:], b[:, i])
        across = v_B - ca.dot(n[:, i], v_B) * n[:, i]
        F = -across / l[i] / ca.sqrt(ca.dot(across, across) + rest * rest)
        columns.append(ca.vertcat(F, ca.cross(b[:, i], F)))
    return ca.horzcat(*columns)


def _sizes(vectors):
    """Lengths of the columns (3, n), smooth at 0.  (n,)."""
    return ca.sqrt(ca.sum1(vectors * vectors) + 1e-12).T
