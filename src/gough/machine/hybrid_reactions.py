"""Forces in the joints of a hybrid machine, out of the multipliers of its closure.

phi of hybrid.py, eq. (3), measures link 5 against link 2, so its multipliers l are what the passive slide carries:
link 2 pushes link 5 at A_5 with a force and a moment

    f_5 = R_2 (l_2, l_1, 0),   n_5 = -2 b l_3 about the third axis                                                 (7)

l_1 across the slide; l_2, along it, is 0, for nothing moves with s54 alone.  With what the bodies of a chain need, f_k,
and w_f the force on the tool, the base pushes the arms at their pivots in the plane with

    f_P1 = sum of f_k over arm 1, its motor, link 2, ram + f_5 - w_f,   f_P6 = sum over arm 6, its motor, link 5 - f_5
                                                                                                                    (8)
The motors push between arm and slide and cancel.  What lies across the plane is shared by arms, slides and the passive
slide in a way that rigid bodies do not tell: it is not given.  docs/theory/hybrid.md, eqs. (7) and (8).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import casadi as ca

from ..mechanics import constrained
from .hybrid_chain import chains


class HybridReactions(NamedTuple):
    """Forces in the joints, N."""

    pivot: Any  # (..., 2, 2) of the base on arms 1 and 6, x and y in W
    passive: Any  # (..., 3): force of link 2 on link 5 at A_5, x and y in W, N, and moment about the third axis, N m
    multiplier: Any  # (..., 3) N of the closure


def reactions_of(m, p, z, v, vd, w) -> HybridReactions:
    """Eqs. (7), (8) of hybrid machine `m` at z, v, v' under a wrench w on the tool: columns (2, 2), (3,), (3,)."""
    pi = {key: value for key, (value, _) in m.inertial(p).items()}
    parts = m.moved(p, pi, z, v).bodies
    f = [constrained.needed(body, body.twist, J @ vd + drift, p.gravity)[:2] for body, J, drift, _ in parts]
    l = m.multipliers_of(p, z, v, vd, w)
    R_2 = chains(p, z, ca.SX.zeros(6)).link_2.R
    f_5 = R_2[:2, :2] @ ca.vertcat(l[1], l[0])
    one, six = f[0] + f[1] + f[2] + f[3] + f_5 - w[:2], f[4] + f[5] + f[6] - f_5
    return HybridReactions(ca.horzcat(one, six), ca.vertcat(f_5, -2 * p.base.half_width * l[2]), l)
