"""A reference moved aside: the same motion of a tool that is displaced by d(t), for the law behind.

    p_c = p + d_p,   R_c = E R,   E = exp(d_w)                                                                      (4)
    v_c = v + d_p',  w_c = E w + g,   g = d_w' + d_w x d_w' / 2                                                     (5)
    v_c' = v' + d_p'',  w_c' = E w' + g x E w + g',   g' = d_w'' + d_w x d_w'' / 2                                  (6)

g is the rate of E; what is left out is of the order |d_w|^2 |d_w'|, and d_w is a thousandth.  The joints follow by the
rigid machine's kinematics, so that laws of joints and of the tool are told the same.  docs/theory/flexible_control.md.
"""

from __future__ import annotations

from typing import Any

import casadi as ca

from .. import frames
from ..machine.base import Machine
from ..program.reference import Reference


def shifted(machine: Machine, p: Any, r: Reference, d, dd, ddd) -> Reference:
    """The reference r moved by d (len(task),), with its rates dd and ddd; `p` a view of the rigid `machine`."""
    x, xd, xdd = (ca.SX(part) for part in (r.x, r.xd, r.xdd))
    if len(machine.task) == 6:
        w, wd, d_w, g, gd = xd[3:], xdd[3:], d[3:], dd[3:], ddd[3:]
        g, gd = g + ca.cross(d_w, g) / 2, gd + ca.cross(d_w, gd) / 2
        E = frames.rotation_of_quaternion(frames.quaternion_of_rotation_vector(d_w))
        turned = E @ w
        abc = frames.abc_of_rotation(E @ frames.rotation_of_abc(x[3:]))
        x = ca.vertcat(x[:3] + d[:3], abc)
        xd = ca.vertcat(xd[:3] + dd[:3], turned + g)
        xdd = ca.vertcat(xdd[:3] + ddd[:3], E @ wd + ca.cross(g, turned) + gd)
    else:
        x, xd, xdd = x + d, xd + dd, xdd + ddd
    z = machine.coordinates_of(p, x)
    v = machine.velocity_of(p, z, xd)
    vd = machine.acceleration_of(p, z, v, xdd)
    q, qd = machine.joints_of(p, z), machine.jacobian_of(p, z) @ v
    return r._replace(x=x, xd=xd, xdd=xdd, q=q, qd=qd, qdd=machine.joint_acceleration(p, z, v, vd))
