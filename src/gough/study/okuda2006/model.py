"""The paper's model of the forces of the drives, eqs. (6)-(13), with its signs repaired, linear in what it identifies.

l_j points from base to platform joint, a push of the drive is positive along it; b_j from the tool tip, all in W:

    G x = [sum x_j l_j; sum b_j x l_j x_j]                                                                          (6)
    G (g + g_s) = -[N_g; M_g],   g_sj = m_T g . l_j                                                       (7), (8), (10)
    N_gj = P_j s_j g,   s_j = (m_B (L_j - l_2 - l_3 / 2) + m_J L_j - m_S l_1) / L_j,   P = 1 - l l'                  (9)
    G (f + f_b) = -[N_c; M_c],   f_bj = -f_0j sgn L_j',   N_cj = -(t_0j / L_j) P_j v_j / |P_j v_j|      (11), (12), (13)

so the push without a load is u = g + f.  The paper's sign of g_s and f_b is the other one, its direction in (13) that
of v_j: theory page "disturbance", section "Okuda et al. 2006, repaired".  Moments are about the tool tip, theirs about
the platform's centre of mass: the same u.  m_B, m_J, m_P and lengths are the design's.

Friction of joints grows with the force in them, t_0j of (13) does not.  `loaded` puts t_j = c_j |u_j| in its place,
with the push u_j as it was read: c is the coefficient of friction times the radius on which it acts.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...identify.rows import Rows
from ...identify.signals import Signals
from ...machine.hexapod import Hexapod

M_B, M_J = 12.0, 4.0  # kg, ball screw and platform joint: MACHINES.md 5.3
L_1, L_2, L_3 = 0.08, 0.12, 1.0  # m
SLOW = 4e-3  # m/s: below it a strut's friction is not that of sliding (Stribeck rise of 2 mm/s)
BLOCK = 50  # samples that are averaged into a row: half a period of the filter
NAMES = ("m_T", "m_S", *(f"f_0[{j}]" for j in range(6)), *(f"t_0[{j}]" for j in range(6)))
ARMS = tuple(f"c[{j}]" for j in range(6))  # in the places of t_0j
UNITS = ("kg", "kg", *["N"] * 6, *["N m"] * 6)
GUESS = np.array([20.0, 10.0, *[60.0] * 6, *[4.0] * 6])  # what is believed before: the wrong side of each truth
ARM = 5e-3  # m, of c_j


class Struts(NamedTuple):
    """The struts at N poses, in W."""

    b: np.ndarray  # (N, 6, 3) from the tool tip, m
    l: np.ndarray  # (N, 6, 3)
    L: np.ndarray  # (N, 6) m
    inverse: np.ndarray  # (N, 6, 6) of G


def struts(machine: Hexapod, x) -> Struts:
    """The struts at poses x (N, 6)."""
    from ...frames import rotation_of_abc_np

    R = rotation_of_abc_np(x[:, 3:])
    b = np.einsum("nij,kj->nki", R, machine.joints.platform)
    s = x[:, None, :3] + b - machine.joints.base
    L = np.linalg.norm(s, axis=-1)
    l = s / L[..., None]
    G = np.concatenate([l, np.cross(b, l)], -1).swapaxes(-1, -2)
    return Struts(b, l, L, np.linalg.inv(G))


def push(at: Struts, forces) -> np.ndarray:
    """The pushes that hold forces (N, 6, 3) on the platform joints.  (N, 6) N."""
    load = np.concatenate([forces.sum(1), np.cross(at.b, forces).sum(1)], -1)
    return -np.einsum("nij,nj->ni", at.inverse, load)


def columns(machine: Hexapod, x, v_B, sign) -> tuple[np.ndarray, np.ndarray]:
    """u = known + Y @ (m_T, m_S, f_0, t_0): (N, 6) N, (N, 6, 14).

    Poses x (N, 6), speeds of the platform joints v_B (N, 6, 3), signs of L' (N, 6).
    """
    at, g, N = struts(machine, x), machine.gravity, len(x)
    across = g - (at.l @ g)[..., None] * at.l
    share = (M_B * (at.L - L_2 - L_3 / 2) + M_J * at.L) / at.L
    known = push(at, share[..., None] * across)
    weight = np.zeros((N, 6))
    weight[:, :3] = machine.platform.mass * g
    c = np.einsum("nij,j->ni", _rotation(x), machine.platform.center)
    weight[:, 3:] = np.cross(c, weight[:, :3])
    known -= np.einsum("nij,nj->ni", at.inverse, weight)
    Y = np.zeros((N, 6, 14))
    Y[:, :, 0] = -at.l @ g
    Y[:, :, 1] = push(at, (-L_1 / at.L)[..., None] * across)
    turning = v_B - np.sum(v_B * at.l, -1, keepdims=True) * at.l
    turning /= np.maximum(np.linalg.norm(turning, axis=-1, keepdims=True), 1e-12)
    for j in range(6):
        Y[:, j, 2 + j] = sign[:, j]
        force = np.zeros((N, 6, 3))
        force[:, j] = -turning[:, j] / at.L[:, j, None]
        Y[:, :, 8 + j] = push(at, force)
    return known, Y


def _rotation(x):
    from ...frames import rotation_of_abc_np

    return rotation_of_abc_np(x[:, 3:])


def joint_speeds(machine: Hexapod, x, xd) -> np.ndarray:
    """v of the platform joints at twists xd (N, 6).  (N, 6, 3) m/s."""
    b = np.einsum("nij,kj->nki", _rotation(x), machine.joints.platform)
    return xd[:, None, :3] + np.cross(xd[:, None, 3:], b)


def rows_of(machine: Hexapod, stretches: Sequence[Signals], loaded: bool = False) -> Rows:
    """The rows of circles in air for gough.identify.regress, averaged over BLOCK samples; `loaded`: c_j, not t_0j."""
    parts = []
    for s in stretches:
        known, Y = columns(machine, s.x, joint_speeds(machine, s.x, s.xd), s.sign)
        if loaded:
            Y[..., 8:] *= np.abs(s.u)[:, None, :]
        count = len(s.t) // BLOCK * BLOCK
        used = np.abs(s.qd[:count]).reshape(-1, BLOCK, 6).min(1) > SLOW
        mean = [a[:count].reshape(-1, BLOCK, *a.shape[1:]).mean(1) for a in (Y, s.u - known)]
        parts.append((*mean, used))
    Y, u, used = (np.concatenate(part) for part in zip(*parts, strict=True))
    samples = sum(len(s.t) for s in stretches)
    names, units, guess = (*NAMES[:8], *ARMS), (*UNITS[:8], *["m"] * 6), np.where(np.arange(14) < 8, GUESS, ARM)
    told = (names, units, guess) if loaded else (NAMES, UNITS, GUESS)
    return Rows(Y, u, used, *told, machine.joint_names, BLOCK * stretches[0].Ts, samples)
