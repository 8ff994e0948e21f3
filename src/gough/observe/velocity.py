"""Speed of the joints from their places: the linear second-order observer, poles both at w_0.

    q^' = z + 2 w_0 (q - q^),    z' = q_r'' + a + w_0^2 (q - q^)                                                  (8)

a is what the feedback asks for beyond q_r'', and q^' is the speed.  With e = q_r - q, e^ = q_r - q^, eps = q_r' - z
the reference drops out,

    e^' = eps + 2 w_0 (e - e^),    eps' = -a + w_0^2 (e - e^)                                                     (9)

an observer of e'' = -a.  Held for a sample Ts, a moves e exactly by eps Ts - a Ts^2 / 2.  So, sampled ("exact"),

    i = e - e^,   e^' = eps + g i / Ts                                                                            (10)
    e^+ = e^ + g i + Ts eps+ + a Ts^2 / 2,   eps+ = eps + h i / Ts - a Ts
    g = 1 - b^2,   h = (1 - b)^2,   b = exp(-w_0 Ts)

whose error dies with both poles at b, whatever w_0 Ts and the reference; as Ts -> 0, g / Ts -> 2 w_0 and
h / Ts^2 -> w_0^2.

By Euler's method, as (8) is most easily programmed ("euler"),

    q^' = z + 2 w_0 (q - q^),   q^+ = q^ + Ts q^',   z+ = z + Ts (q_r'' + a + w_0^2 (q - q^))                     (11)

q^ lacks q'' Ts^2 / 2 a sample, so q^' is q'' Ts / 2 too fast; its poles are at 1 - w_0 Ts.

Source: Honegger 1998, eq. (23), for (8); derivations in docs/theory/desired_torque.md.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import casadi as ca
import numpy as np


class Speed(NamedTuple):
    """State of the observer: (e^, eps) of eq. (10), or (q^, z) of eq. (11)."""

    position: Any  # (n,) m
    rate: Any  # (n,) m/s


def start(q, kind: str) -> Speed:
    """The state at rest at the joints q (n,) m.  `kind` is "exact" or "euler"."""
    q = np.ravel(q)
    return Speed(np.zeros_like(q) if kind == "exact" else q, np.zeros_like(q))


def gains(pole, period):
    """g and h of eq. (10) for w_0 1/s and Ts s."""
    b = ca.exp(-pole * period)
    return 1 - b**2, (1 - b) ** 2


def speed_error(state: Speed, r, q_m, pole, period, kind: str):
    """q_r' - q^', the observed error of the speed, from the reference r and joints q_m (n,).  (n,) m/s."""
    if kind == "exact":
        g, _ = gains(pole, period)
        return state.rate + g * (r.q - q_m - state.position) / period
    return r.qd - (state.rate + 2 * pole * (q_m - state.position))


def advanced(state: Speed, r, q_m, a, pole, period, kind: str) -> Speed:
    """The state a sample later, when the feedback a (n,) m/s2 has acted."""
    if kind == "exact":
        g, h = gains(pole, period)
        i = r.q - q_m - state.position
        rate = state.rate + h * i / period - period * a
        return Speed(state.position + g * i + period * rate + period**2 / 2 * a, rate)
    i = q_m - state.position
    speed = state.rate + 2 * pole * i
    return Speed(state.position + period * speed, state.rate + period * (r.qdd + a + pole**2 * i))
