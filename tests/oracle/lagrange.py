"""Lagrange's equations of a 6-UPS machine: slow, obviously right, and derived from energies alone.

Generalised coordinates y = (x, y, z, a, b, c) of the tool T.  Nineteen rigid bodies: the platform, two a strut, and
the cross of each base joint.
The base joint of a strut is a universal joint with two angles: alpha about its axis fixed in the base, beta about the
second axis of the cross; both follow from y, and with them the whole rotation of the strut, spin included.  Every
velocity is a derivative of a position or of a rotation matrix along y', every force a derivative of L = T - U:

    d/dt (dL/dy') - dL/dy = (dl/dy)' u + E' w,      (v, w) = E y'

Nothing here is taken from gough but the numbers of the machine: no formula of its frames, mechanics or machine.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np


def rotation(axis: int, angle):
    """Right-handed turn about one axis of the frame."""
    c, s = ca.cos(angle), ca.sin(angle)
    R = ca.SX.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R[i, i], R[i, j], R[j, i], R[j, j] = c, -s, s, c
    return R


def rotation_abc(abc):
    """First a about x, then b about y, then c about z, all axes fixed."""
    return rotation(2, abc[2]) @ rotation(1, abc[1]) @ rotation(0, abc[0])


def axial(S):
    """The vector of an antisymmetric matrix."""
    return ca.vertcat(S[2, 1] - S[1, 2], S[0, 2] - S[2, 0], S[1, 0] - S[0, 1]) / 2


@dataclass(frozen=True)
class Oracle:
    """CasADi functions of y, y', y'' (columns of 6): energies, strut lengths, twist, and forces on the coordinates."""

    lengths: ca.Function  # y -> l, or the places of carriages
    length_rate: ca.Function  # y -> dl/dy (6, 6)
    twist: ca.Function  # y, y' -> [v; w] of T in W
    twist_matrix: ca.Function  # y -> E (6, 6)
    twist_drift: ca.Function  # y, y' -> E' y', so that V' = E y'' + E' y'
    kinetic: ca.Function  # y, y' -> T
    potential: ca.Function  # y -> U
    mass: ca.Function  # y -> d2T/dy'2
    force: ca.Function  # y, y', y'' -> d/dt (dL/dy') - dL/dy
    christoffel: (
        ca.Function
    )  # y, y' -> C (6, 6) from Christoffel's symbols of `mass`: d/dt (dT/dy') - dT/dy = M y'' + C y'

    def coordinates(self, x, V, Vd):
        """y, y', y'' of a pose, a twist and its rate, (6,) each."""
        E = np.array(self.twist_matrix(x))
        yd = np.linalg.solve(E, V)
        return x, yd, np.linalg.solve(E, Vd - np.array(self.twist_drift(x, yd)).ravel())

    def joint_forces(self, x, V, Vd, wrench):
        """Strut forces of the motions x, V, V', with `wrench` on the tool, in W.  (n, 6) each."""
        out = np.empty_like(V)
        for k in range(len(x)):
            y, yd, ydd = self.coordinates(x[k], V[k], Vd[k])
            Q = np.array(self.force(y, yd, ydd)).ravel() - np.array(self.twist_matrix(y)).T @ wrench[k]
            out[k] = np.linalg.solve(np.array(self.length_rate(y)).T, Q)
        return out


def oracle(machine, spring: float = 0.0, spring_length=0.0) -> Oracle:
    """The oracle of a machine's numbers.

    `spring` N/m in each strut, at rest at `spring_length` (6,) m, counts as potential energy.
    """
    y, yd, ydd = (ca.SX.sym(name, 6) for name in ("y", "yd", "ydd"))
    gravity = ca.DM(machine.gravity)

    def along(f):  # d/dt of a function of y
        return ca.reshape(ca.jtimes(ca.vec(f), y, yd), f.shape)

    def kinetic(m, c, I, R):
        v = along(c)
        w = axial(R.T @ along(R))  # angular velocity in the axes of the body
        return m * ca.dot(v, v) / 2 + ca.dot(w, I @ w) / 2

    R_WT = rotation_abc(y[3:])
    p_WT = y[:3]
    tool = machine.tool
    if tool is None:
        R_WP, p_WP = R_WT, p_WT
    else:  # T sits on P: R_WT = R_WP R_PT, p_WT = p_WP + R_WP p_PT
        R_WP = R_WT @ rotation_abc(ca.DM(tool.angles)).T
        p_WP = p_WT - R_WP @ ca.DM(tool.position)

    body = machine.platform
    center = p_WP + R_WP @ ca.DM(body.center)
    T = kinetic(body.mass, center, ca.DM(body.inertia), R_WP)
    U = -body.mass * ca.dot(gravity, center)

    turn = 2 * np.pi / machine.drive.lead  # rad of the screw a metre
    screw = 0.0 if machine.drive.inertia is None else machine.drive.inertia
    lengths = []
    for i in range(6):
        A = ca.DM(machine.joints.base[i])
        B = p_WP + R_WP @ ca.DM(machine.joints.platform[i])
        s = B - A
        l = ca.sqrt(ca.dot(s, s))
        lengths.append(l)
        T += screw * (turn * along(l)) ** 2 / 2
        U += spring * (l - np.broadcast_to(spring_length, 6)[i]) ** 2 / 2
        if machine.strut is None:
            continue
        R_WU = ca.DM(universal_frame(machine, i))
        d = R_WU.T @ s / l  # direction of the strut seen from the fork of the base joint
        alpha, beta = ca.atan2(-d[1], d[2]), ca.atan2(d[0], ca.sqrt(d[1] ** 2 + d[2] ** 2))
        R_WS = R_WU @ rotation(0, alpha) @ rotation(1, beta)
        n = R_WS[:, 2]
        moving, fixed = machine.strut.moving, machine.strut.fixed
        for part, middle in ((moving, B - moving.center * n), (fixed, A + fixed.center * n)):
            if part.inertia is None:
                I = ca.diag(ca.DM([part.transverse, part.transverse, part.axial or 0.0]))
            else:
                I = ca.DM(part.inertia)
            if part.offset is not None:
                middle = middle + R_WS[:, 0] * part.offset[0] + R_WS[:, 1] * part.offset[1]
            T += kinetic(part.mass, middle, I, R_WS)
            U -= part.mass * ca.dot(gravity, middle)
        if machine.joints.cross is not None:  # it turns by alpha alone, about the axis fixed in the base
            T += kinetic(0.0, A, ca.diag(ca.DM([machine.joints.cross, 0.0, 0.0])), R_WU @ rotation(0, alpha))

    return functions((y, yd, ydd), T, U, ca.vertcat(*lengths), R_WT)


def functions(motion, T, U, lengths, R_WT) -> Oracle:
    """The oracle of energies T, U and joint coordinates `lengths`, expressions of `motion` = (y, y', y''), 6 each."""
    y, yd, ydd = motion

    def along(f):  # d/dt of a function of y
        return ca.reshape(ca.jtimes(ca.vec(f), y, yd), f.shape)

    V = ca.vertcat(yd[:3], axial(along(R_WT) @ R_WT.T))
    momentum = ca.gradient(T, yd)
    M = ca.jacobian(momentum, yd)
    force = M @ ydd + ca.jtimes(momentum, y, yd) - ca.gradient(T, y) + ca.gradient(U, y)

    # Christoffel's symbols of M alone: C_ij = sum_k (dM_ij/dy_k + dM_ik/dy_j - dM_jk/dy_i) y'_k / 2
    dM = ca.jacobian(ca.vec(M), y)
    C = ca.SX(6, 6)
    for i in range(6):
        for j in range(6):
            for k in range(6):
                C[i, j] += (dM[i + 6 * j, k] + dM[i + 6 * k, j] - dM[j + 6 * k, i]) * yd[k] / 2

    return Oracle(
        lengths=ca.Function("lengths", [y], [lengths]),
        length_rate=ca.Function("length_rate", [y], [ca.jacobian(lengths, y)]),
        twist=ca.Function("twist", [y, yd], [V]),
        twist_matrix=ca.Function("twist_matrix", [y], [ca.jacobian(V, yd)]),
        twist_drift=ca.Function("twist_drift", [y, yd], [ca.jtimes(V, y, yd)]),
        kinetic=ca.Function("kinetic", [y, yd], [T]),
        potential=ca.Function("potential", [y], [U]),
        mass=ca.Function("mass", [y], [M]),
        force=ca.Function("force", [y, yd, ydd], [force]),
        christoffel=ca.Function("christoffel", [y, yd], [C]),
    )


def universal_frame(machine, i: int) -> np.ndarray:
    """R_WU of base joint i: first axis the one fixed in the base, second that of the cross at alpha = 0.

    Without a base axis the struts have no axial inertia and their spin does not matter: any axis across the strut at
    home serves.
    """
    home = machine.home
    R = np.array(ca.DM(rotation_abc(ca.DM(home[3:]))))
    if machine.tool is None:
        B = home[:3] + R @ machine.joints.platform[i]
    else:
        R_WP = R @ np.array(ca.DM(rotation_abc(ca.DM(machine.tool.angles)))).T
        B = home[:3] + R_WP @ (machine.joints.platform[i] - machine.tool.position)
    n = B - machine.joints.base[i]
    if machine.joints.base_axis is None:
        a = np.cross(n, [1.0, 0.0, 0.0] if abs(n[0]) < abs(n[1]) else [0.0, 1.0, 0.0])
    else:
        a = machine.joints.base_axis[i]
    a = a / np.linalg.norm(a)
    third = n - (n @ a) * a  # alpha = 0 at home: far from the jump of atan2
    third /= np.linalg.norm(third)
    return np.stack([a, np.cross(third, a), third], 1)
