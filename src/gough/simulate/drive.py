"""Drive and sensor: what becomes of a command, and what is read of a joint.

    u    = clip(u_c one sample ago or now, -u_max, u_max),    u_max = force_limit, or torque_limit 2 pi / lead       (1)
    q_m  = res floor((q + noise) / res + 1/2)                                                                        (2)

The delay is that of the computation: the force worked out from sample k acts over [k + 1, k + 2).  A command that is
not a number stays one, also through the limit, and stops the run.
"""

from __future__ import annotations

import casadi as ca

from ..machine.drives import force_limit
from ..mechanics.linear import clip


def drive(machine, p, u_c, waiting):
    """Applied force, whether it was limited, and the command that waits.  (n,) N, (n,) 0/1, (n,) N.  Eq. (1)."""
    asked = waiting if machine.drive.delay else u_c
    limit = force_limit(p.drive)
    if limit is None:
        return asked, ca.SX.zeros(asked.shape), u_c
    u = clip(asked, -limit, limit)
    return u, ca.fabs(asked) > limit, u_c


def encoder(machine, p, q, normal):
    """Encoder reading of joints q (n,) m; `normal` (n,) standard normal numbers.  (n,) m.  Eq. (2)."""
    if machine.drive.noise is not None:
        q = q + p.drive.noise * normal
    if machine.drive.encoder is not None:
        q = p.drive.encoder * ca.floor(q / p.drive.encoder + 0.5)
    return q
