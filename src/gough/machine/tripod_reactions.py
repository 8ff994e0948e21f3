"""Forces in the joints of a 3-PRS, out of the multipliers of its closure.

The platform and what closes its triangle are functions of the spherical joints T_i alone (eqs. (2)-(4) of tripod.py),
so what they need at T_i, for any displacement of T_i and not only for those the links allow, is

    F_i = (dV / dT_i')' W + (dphi / dT_i)' l,   W = platform's own wrench - w                                      (7)

with V the platform's twist by (4), w the wrench on the tool and l the multipliers.  The link carries it: the platform
pushes the link with -F_i, and what the link needs beyond comes through the hinge,

    R_B,i = f_i + F_i,   f_i = m_l (a - g) of the link's centre                                                     (8)

with a moment across the hinge that this does not tell.  docs/theory/tripod.md, section "Forces in the joints".
"""

from __future__ import annotations

from typing import Any, NamedTuple

import casadi as ca

from ..mechanics import constrained


class ClosedReactions(NamedTuple):
    """Forces in the joints, N, vectors in W."""

    platform_joint: Any  # (..., 3, 3) on each link, from the platform
    base_joint: Any  # (..., 3, 3) on each link, from its slider
    multiplier: Any  # (..., 3) of the closure: what presses the joints of each side of the platform apart


def reactions_of(m, p, z, v, vd, w) -> ClosedReactions:
    """Eqs. (7), (8) of tripod `m` at z, v, v' under a wrench w on the tool: (3, 3) N each, multipliers (3,)."""
    pi = {key: value for key, (value, _) in m.inertial(p).items()}
    parts = m.moved(p, pi, z, v).bodies
    needs = [constrained.needed(body, body.twist, J @ vd + drift, p.gravity) for body, J, drift, _ in parts]
    l = m.multipliers_of(p, z, v, vd, w)
    T, speeds = ca.SX.sym("T", 3, 3), ca.SX.sym("Td", 3, 3)
    twist = m.twist_of(p, m.rotation_of(p, T), speeds)
    V_T, phi_T = ca.jacobian(twist, ca.vec(speeds)), ca.jacobian(m.sides_of(p, T), ca.vec(T))
    V_T, phi_T = ca.substitute([V_T, phi_T], [T], [m.joints_in_W(p, z)])
    F = ca.reshape(V_T.T @ (needs[0] - w) + phi_T.T @ l, 3, 3)
    heavy = p.link.mass is not None
    f = [needs[2 + 2 * i][:3] if heavy else ca.SX(3, 1) for i in range(3)]
    return ClosedReactions(platform_joint=-F, base_joint=ca.horzcat(*f) + F, multiplier=l)
