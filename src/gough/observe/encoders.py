"""Encoders at fault: a reading that moves as no force could have moved the joint.

    a  = q''_r + J [M^-1 (J' u - h) - V'_r] = a_0 + G u,    G = J M^-1 J'                                            (1)
    r  = q_m - 2 q_m_ + q_m__ - Ts^2 (a_0 + G (u_ + u__) / 2)                                                        (2)
    |r_i| <= Ts^2 F sum_j |G_ij| + 2 res + 8 sqrt(6) sigma                                                           (3)

_ is the sample before, __ the one before that; J, M, h, q''_r and V'_r are those of the reference at the sample before,
u_ the force that the drives applied from it on.  F is the force on a joint that nobody knows: friction, cutting, what
is wrong with the masses.  An encoder is flagged at the first sample at which (3) does not hold; so is one that reads
no number.

Six encoders on six freedoms contradict nobody: forward kinematics finds a pose for whatever they read.  What can
contradict them are the forces; and where a joint without its encoder is, they alone tell:

    q_+ = q + Ts q' + Ts^2 a / 2,    q'_+ = q' + Ts a,    a = a_0 + G u + d                                          (4)
    d_+ = d + (Ts / 20 ms) (r / Ts^2 - d)                                                                            (5)

from the last reading that was not flagged; the speed is that of the reference when the reading changed last.  d is what
was unexplained until then, mostly friction.
docs/theory/encoders.md derives (2) and says what (3) sees.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from ..mechanics.linear import solve_spd

SPREADS = 8  # standard deviations of the noise; beyond them once in 1e15 readings
AT_REST = 1e-9  # m/s; a reference that is slower is at rest up to rounding
SMOOTHING = 20e-3  # s, eq. (5): some samples, and short against the time between two reversals


def explained(machine, p, x, V, Vd, qdd):
    """(a_0, G) of eq. (1): joint accelerations without joint forces, (n,) m/s2, and of each, (n, n) 1/kg.

    `p` is the view of the believed `machine`; task coordinates x, their rate, its rate and joint accelerations
    of the reference.
    """
    z = machine.coordinates_of(p, x)
    v = machine.velocity_of(p, z, V)
    vd = machine.acceleration_of(p, z, v, Vd)
    pi = {key: value for key, (value, _) in machine.inertial(p).items()}
    M, h = machine.mass_and_bias(p, pi, z, v)
    J = machine.jacobian_of(p, z)
    moved = J @ solve_spd(M, ca.horzcat(J.T, h))
    return qdd - moved[:, -1] - J @ vd, moved[:, :-1]


def residual(p, a, G, q_m, before, further, F, period):
    """r of eq. (2) and the bound of eq. (3), (n,) m each, at readings q_m, those `before` and those `further` back.

    `a` is (1) under the mean force of the last two samples, `F` N, `p` the view of the believed machine.
    """
    drive = p.drive
    grain = 0.0 if drive.encoder is None else 2 * drive.encoder
    noise = 0.0 if drive.noise is None else SPREADS * np.sqrt(6) * drive.noise
    r = q_m - 2 * before + further - period**2 * a
    return r, period**2 * F * ca.sum2(ca.fabs(G)) + grain + noise


def followed(q_m, before, qd_r, q, qd, a, d, r, flagged, period):
    """Joints, their speeds, and d one sample on, by eqs. (4), (5) where an encoder is in doubt.  (n,) m, m/s, m/s2.

    Readings q_m and those `before`; speeds qd_r of the reference now; q, qd, d of the sample before; a joint
    accelerations (1) since then; residuals r; for how many samples an encoder has been `flagged`.
    """
    lost = flagged > 0
    # a joint whose reading stands while the reference moves on may have an encoder that is stuck
    doubted = ca.logic_or(lost, ca.logic_and(q_m == before, ca.fabs(qd_r) > AT_REST))
    a = a + d
    return (
        ca.if_else(lost, q + period * qd + period**2 / 2 * a, q_m),
        ca.if_else(doubted, qd + period * a, qd_r),
        ca.if_else(doubted, d, d + min(1.0, period / SMOOTHING) * (r / period**2 - d)),
    )
