"""Lagrange's equations of a 6-PUS machine, as lagrange.py for the 6-UPS one: derived from energies alone.

Generalised coordinates y = (x, y, z, a, b, c) of the tool T.  Thirteen rigid bodies: the platform, six carriages, six
legs.  A carriage is where a sphere of the leg's length about the platform joint cuts its rail; a leg is a body with a
rotation matrix of two angles, its middle halfway, m l^2 / 12 across it and nothing about it.

Nothing here is taken from gough but the numbers of the machine.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from .lagrange import Oracle, axial, functions, rotation, rotation_abc


def oracle(machine, spring: float = 0.0, spring_place=0.0) -> Oracle:
    """The oracle of a hexaglide's numbers; `spring` N/m on each carriage, at rest at `spring_place` (6,) m."""
    y, yd, ydd = (ca.SX.sym(name, 6) for name in ("y", "yd", "ydd"))
    gravity = ca.DM(machine.gravity)

    def along(f):  # d/dt of a function of y
        return ca.reshape(ca.jtimes(ca.vec(f), y, yd), f.shape)

    def kinetic(m, c, I, R):
        v, w = along(c), axial(R.T @ along(R))
        return m * ca.dot(v, v) / 2 + ca.dot(w, I @ w) / 2

    R_WT, p_WT, tool = rotation_abc(y[3:]), y[:3], machine.tool
    R_WP, p_WP = R_WT, p_WT
    if tool is not None:
        R_WP = R_WT @ rotation_abc(ca.DM(tool.angles)).T
        p_WP = p_WT - R_WP @ ca.DM(tool.position)
    body = machine.platform
    center = p_WP + R_WP @ ca.DM(body.center)
    T = kinetic(body.mass, center, ca.DM(body.inertia), R_WP)
    U = -body.mass * ca.dot(gravity, center)

    rails, places = machine.rails, []
    length, rest = np.broadcast_to(machine.legs.length, 6), np.broadcast_to(spring_place, 6)
    for i in range(6):
        A, e, l = ca.DM(rails.point[i]), ca.DM(rails.direction[i] / np.linalg.norm(rails.direction[i])), length[i]
        B = p_WP + R_WP @ ca.DM(machine.joints.platform[i])
        # |B - A - q e|^2 = l^2:  q^2 - 2 beta q + gamma = 0
        beta, gamma = ca.dot(e, B - A), ca.dot(B - A, B - A) - l**2
        q = beta + float(rails.side[i]) * ca.sqrt(beta**2 - gamma)
        places.append(q)
        S = A + q * e
        T += kinetic(machine.carriage.mass, S, ca.SX.zeros(3, 3), ca.SX.eye(3))
        U -= machine.carriage.mass * ca.dot(gravity, S)
        U += spring * (q - rest[i]) ** 2 / 2
        if machine.legs.mass is None:
            continue
        n = (S - B) / l  # legs hang from their carriages: n points up, away from the jump of atan2
        alpha, tip = ca.atan2(-n[1], n[2]), ca.atan2(n[0], ca.sqrt(n[1] ** 2 + n[2] ** 2))
        R = rotation(0, alpha) @ rotation(1, tip)
        across = machine.legs.mass * l**2 / 12
        T += kinetic(machine.legs.mass, (S + B) / 2, ca.diag(ca.DM([across, across, 0.0])), R)
        U -= machine.legs.mass * ca.dot(gravity, (S + B) / 2)
        frame = ca.Function("frame", [y], [R[:, 2] - n])
        assert float(ca.norm_inf(frame(machine.home + 0.01))) < 1e-12, "the leg's frame does not lie along the leg"
    return functions((y, yd, ydd), T, U, ca.vertcat(*places), R_WT)
