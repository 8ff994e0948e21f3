"""A multibody engine's tree with closed loops, brought to the six velocities of the tool.

An engine gives, on its own 24 velocities y' = [p', R' w, fork, cross, slide, ...], the mass matrix M, the bias c, the
constraint Jacobian G (18, 24) and its drift G' y' of the loops.  With G y' = 0 split into platform and struts,

    y' = N V,        N = [E; -G_s^-1 G_p E],      E = diag(1, R_WT')                                             (1)
    y'' = N V' + n,  n = [0; -G_s^-1 G' y']       (E V' is the platform's part: E' V has R' (w x w) = 0)         (2)
    N' M N V' + N' (M n + c) = N' Q                                                                              (3)

and, without a projection, the forces of the loops as unknowns,

    [M G'; G 0] [y''; -f] = [Q - c; -G' y']                                                                      (4)

A 3-PRS has 12 velocities y' = [p', R' w, S_1', theta_1', S_2', ...]; there the independent ones are p'.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

PLATFORM = slice(0, 6)
SLIDES = np.arange(8, 24, 3)
CARRIAGES = np.arange(6, 24, 3)
SLIDERS = np.arange(6, 12, 2)


class Tree(NamedTuple):
    """What an engine says at one state."""

    M: np.ndarray  # (24, 24)
    c: np.ndarray  # (24,)
    G: np.ndarray  # (18, 24)
    drift: np.ndarray  # (18,) G' y'


def spread(G, R_WT):
    """N of eq. (1), (24, 6); of a 3-PRS for the velocity of its tip, (12, 3)."""
    if G.shape[1] == 12:
        return np.concatenate([np.eye(3), -np.linalg.solve(G[:, 3:], G[:, :3])])
    E = np.eye(6)
    E[3:, 3:] = R_WT.T
    return np.concatenate([E, -np.linalg.solve(G[:, 6:], G[:, PLATFORM] @ E)])


def on_the_twist(tree: Tree, R_WT):
    """Mass matrix (6, 6) and bias (6,) of eq. (3); of a 3-PRS (3, 3) and (3,), at its tip."""
    N = spread(tree.G, R_WT)
    d = N.shape[1]
    n = np.concatenate([np.zeros(d), -np.linalg.solve(tree.G[:, d:], tree.drift)])
    return N.T @ tree.M @ N, N.T @ (tree.M @ n + tree.c)


def forces(R_WT, u, wrench, slides=SLIDES):
    """Q: forces u of the drives on the slides, the wrench [f; m] (6,) in W on the tool.  (24,), or (12,) of a 3-PRS."""
    Q = np.zeros(24 if len(u) == 6 else 12)
    Q[:6] = wrench
    Q[3:6] = R_WT.T @ wrench[3:]
    Q[slides] = u
    return Q


def twist_rate(tree: Tree, R_WT, Q):
    """Rate of the tool's twist of eq. (4), the loops' forces among the unknowns.  (6,)."""
    size = len(tree.drift)
    # rows scaled: masses of 1e2 kg beside a Jacobian of 1
    K = np.block([[tree.M, tree.G.T], [tree.G, np.zeros((size, size))]])
    ydd = np.linalg.solve(K, np.concatenate([Q - tree.c, -tree.drift]))[:6]
    return np.concatenate([ydd[:3], R_WT @ ydd[3:]])
