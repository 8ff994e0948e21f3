"""Okuda, Ibaraki, Kakino, Nakagawa, Matsushita 2006, eqs. (6)-(14), written in NumPy as they stand and as repaired.

Nothing of gough is used.  l_j points from base to platform joint, a drive's push is positive along it; B_j from the
platform's centre of mass.  Masses and lengths are the paper's: platform m_P, screw m_B, platform joint m_J, motor m_S.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

G = np.array([0.0, 0.0, -9.81])


class Numbers(NamedTuple):
    """The design of the paper's Fig. 3, with the values of the sheet okuma-pm600."""

    m_P: float = 150.0
    m_B: float = 12.0
    m_J: float = 4.0
    m_S: float = 18.0
    l1: float = 0.08
    l2: float = 0.12
    l3: float = 1.0
    center: tuple = (0.0, 0.0, 0.38)  # of m_P, in T


DESIGN = Numbers()


class Pose(NamedTuple):
    """What the equations ask of a pose: all in W, a row a strut."""

    A: np.ndarray
    b: np.ndarray  # platform joints from the tool tip
    c: np.ndarray  # centre of mass from the tool tip
    l: np.ndarray
    L: np.ndarray


def pose(A, B_T, p, R, numbers=DESIGN):
    """The struts at tool tip p and rotation R."""
    b = B_T @ R.T
    s = p + b - A
    L = np.linalg.norm(s, axis=1)
    return Pose(A, b, R @ np.array(numbers.center), s / L[:, None], L)


def gamma(at: Pose) -> np.ndarray:
    """The matrix of eq. (6): moments about the platform's centre of mass."""
    return np.vstack([at.l.T, np.cross(at.b - at.c, at.l).T])


def wrench(at: Pose, forces) -> np.ndarray:
    """[N; M] of forces (6, 3) on the platform joints, M about the centre of mass."""
    return np.concatenate([forces.sum(0), np.cross(at.b - at.c, forces).sum(0)])


def gravity(at: Pose, n=DESIGN, sign=1, m_T=None) -> np.ndarray:
    """g_hat of eqs. (7)-(10), the push that holds the weight; sign = -1 as printed."""
    m_T = n.m_B + n.m_J if m_T is None else m_T
    share = (n.m_B * (at.L - n.l2 - n.l3 / 2) + n.m_J * at.L - n.m_S * n.l1) / at.L
    across = share[:, None] * (G - (at.l @ G)[:, None] * at.l)
    load = wrench(at, across) + np.concatenate([n.m_P * G, np.zeros(3)])
    return np.linalg.solve(gamma(at), -load) - sign * m_T * at.l @ G


def friction(at: Pose, v_B, f_0, t_0, sign=1, along=False) -> np.ndarray:
    """f_hat of eqs. (11)-(13), at speeds v_B (6, 3) of the platform joints; sign = -1 and along=True as printed."""
    Ld = np.sum(v_B * at.l, 1)
    e = v_B if along else v_B - Ld[:, None] * at.l  # d(L l)/dt is v_B: the base joint stands
    e = e / np.linalg.norm(e, axis=1)[:, None]
    load = wrench(at, -(t_0 / at.L)[:, None] * e)
    return np.linalg.solve(gamma(at), -load) + sign * f_0 * np.sign(Ld)


def inertia(at: Pose, a, m_P) -> np.ndarray:
    """F_hat of eq. (14), with N_F = -m_P a: the push that accelerates the platform's mass by a (3,)."""
    return np.linalg.solve(gamma(at), np.concatenate([m_P * a, np.zeros(3)]))


def energy(at: Pose, p, n=DESIGN) -> float:
    """Energy of weight, body by body."""
    screw = at.A + (at.L - n.l2 - n.l3 / 2)[:, None] * at.l
    joint = at.A + at.L[:, None] * at.l
    motor = at.A - n.l1 * at.l
    return -float(n.m_P * G @ (p + at.c) + (n.m_B * screw + n.m_J * joint + n.m_S * motor).sum(0) @ G)
