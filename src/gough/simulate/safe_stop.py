"""The safe stop: the tool brakes to rest along the circle that its path turns on, and then the drives are off.

    tau = t - t^2 / 2T,   s = tau' = 1 - t / T                   for t < T;  T / 2 and 0 behind                     (1)
    p   = p_0 + sin(W tau) / W v_0 + (1 - cos(W tau)) / W |v_0| n                                                    (2)
    R   = exp(w_0 tau) R_0                                                                                           (3)
    T   = max(|v_0| / a, |w_0| / alpha, Ts)                                                                          (4)

t counts from the sample at which the stop began, where the reference had p_0, R_0, the twist [v_0; w_0] and, across
v_0, the acceleration W |v_0| n.  On lines and arcs this is the path.  The tool slows down by |v_0| / T <= a along it,
the turning by |w_0| / T <= alpha; what it accelerates across falls with s^2.  docs/theory/encoders.md.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from .. import frames

REST = 0.1  # s for which the reference stands still before the drives are off, where every joint is measured
REST_UNSEEN = 0.01  # s; where an encoder is flagged: without it a joint can be followed for a short time only
_NO_SPEED = 1e-6  # m/s; below it a path has no direction to turn from


class Origin(NamedTuple):
    """Where a stop began: what eqs. (1)-(4) need of the reference there."""

    x: Any  # task coordinates, (d,)
    twist: Any  # [v_0; w_0], (6,), or v_0 alone where tilt follows from the place
    bend: Any  # W n |v_0|, (3,) m/s2
    s: Any  # length driven, (1,) m


def origin(row) -> Origin:
    """The Origin in a row of the reference (program.reference.Reference)."""
    v, a = row.xd[:3], row.xdd[:3]
    along = ca.dot(a, v) / (ca.dot(v, v) + _NO_SPEED**2)
    return Origin(row.x, row.xd, a - along * v, row.s)


def duration(start: Origin, a, alpha, period):
    """T of eq. (4), s, at a path acceleration a m/s2 and an angular one alpha rad/s2."""
    v, w = start.twist[:3], _turning(start)
    return ca.fmax(ca.fmax(_size(v) / a, _size(w) / alpha), period)


def ramp(machine, p, row, start: Origin, t, T):
    """The row of the reference t s after the stop began, in place of the program's `row`.  Eqs. (1)-(3).

    `p` is the view of the believed `machine`.  The length driven and the directions along the path go on with it.
    """
    braking = t < T
    tau = ca.if_else(braking, t - t * t / (2 * T), T / 2)
    s, sd = ca.if_else(braking, 1 - t / T, 0), ca.if_else(braking, -1 / T, 0)
    v, w = start.twist[:3], _turning(start)
    speed = _size(v)
    turn = start.bend / ca.sqrt(speed * speed + _NO_SPEED**2)  # W n, rad/s
    sine, versine, cosine = _series(tau, ca.dot(turn, turn))
    x = ca.vertcat(start.x[:3] + sine * v + versine * speed * turn, start.x[3:])
    here = cosine * v + sine * speed * turn  # dp / dtau
    bent = cosine * speed * turn - ca.dot(turn, turn) * sine * v  # d2p / dtau2
    d = start.x.numel()
    xd, xdd = ca.vertcat(here * s, w * s)[:d], ca.vertcat(bent * s * s + here * sd, w * sd)[:d]
    z = machine.coordinates_of(p, x)
    if d == 6:
        z = ca.vertcat(z[:3], frames.quaternion_product(frames.quaternion_of_rotation_vector(w * tau), z[3:]))
        R = frames.rotation_of_quaternion(z[3:])
        x, axis = ca.vertcat(x[:3], _near(frames.abc_of_rotation(R), start.x[3:])), R[:, 2]
    else:
        axis = row.axis
    V = machine.velocity_of(p, z, xd)
    Vd = machine.acceleration_of(p, z, V, xdd)
    unit = 1 / ca.sqrt(ca.dot(here, here) + _NO_SPEED**2)
    return row._replace(
        x=x, xd=xd, xdd=xdd,
        q=machine.joints_of(p, z), qd=machine.jacobian_of(p, z) @ V, qdd=machine.joint_acceleration(p, z, V, Vd),
        s=start.s + speed * tau, sd=speed * s, tangent=unit * here, normal=_direction(bent),
        curvature=_size(turn) * unit, axis=axis,
    )  # fmt: skip


def _turning(start: Origin):
    """w_0, 0 where the tool does not turn by itself.  (3,)."""
    return start.twist[3:] if start.twist.numel() == 6 else ca.SX.zeros(3)


def _series(tau, W2):
    """sin(W tau) / W, (1 - cos(W tau)) / W^2 and cos(W tau), also at W = 0."""
    angle2 = W2 * tau * tau
    small = angle2 < 1e-8  # the series are exact to rounding there
    angle = ca.sqrt(ca.if_else(small, 1, angle2))
    sine = ca.if_else(small, 1 - angle2 / 6, ca.sin(angle) / angle)
    half = ca.sin(angle / 2) / angle  # (1 - cos x) / x^2 = 2 (sin(x/2) / x)^2, which nothing cancels in
    versine = ca.if_else(small, 0.5 - angle2 / 24, 2 * half * half)
    return tau * sine, tau * tau * versine, ca.if_else(small, 1 - angle2 / 2, ca.cos(angle))


def _near(abc, before):
    """The angles of the turn nearest those `before`."""
    return abc + 2 * np.pi * ca.floor((before - abc) / (2 * np.pi) + 0.5)


def _size(u):
    return ca.sqrt(ca.dot(u, u))


def _direction(u):
    """u / |u|; 0 where u is."""
    size = _size(u)
    return u * ca.if_else(size > 0, 1 / ca.if_else(size > 0, size, 1), 0)
