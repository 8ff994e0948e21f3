"""Adaptive laws: estimates that are learned from an error, and stay where they may be.

An estimate is a factor theta on what is believed, 1 at first.  With the regressor's share in the power of the error,
y = d(sigma' f)/d theta in W,

    theta' = g (y - s theta) + Pr                                                                                  (1)

    s = 0                              where |theta| <= M_0                                                        (2)
      = s_0 (|theta| / M_0 - 1)        where M_0 < |theta| <= 2 M_0
      = s_0                            beyond

    Pr = -v  where theta >= theta_max and v > 0, or theta <= theta_min and v < 0,  with v = g (y - s theta)        (3)
       = 0   elsewhere

(2) is the switching sigma modification: it pulls back only estimates that are larger than the true ones can be, so it
costs nothing where the model is right.  (3) is the projection on a box.  Both only lower theta~' g^-1 theta~ / 2
further when the true theta is inside.  One Euler step of (1) with (3) ends in the box for every step size: it is

    theta+ = clip(theta + Ts g (y - s theta), theta_min, theta_max)                                                (4)

Source: Garagic and Srinivasan, ACC 2004, eqs. (11)-(13), who only cite both; the forms are those of Ioannou and Sun,
Robust Adaptive Control, 1996, ch. 8.4 and 4.4.  Here g is 1/J: what is learned per joule of work done on the error.
"""

from __future__ import annotations

import casadi as ca

from ..errors import ExperimentError
from ..mechanics.linear import clip


def leak(theta, norm, strength):
    """s of eq. (2), W, for estimates theta (k,), the norm M_0 and the strength s_0 in W."""
    size = ca.sqrt(ca.dot(theta, theta) + 1e-300) / norm  # smooth at 0, where it is far from switching
    return strength * clip(size - 1, 0, 1)


def learned(theta, y, rate, low, high, step, leakage=0):
    """The estimates a sample later, eq. (4).  (k,).

    `y` (k,) W, `rate` g 1/J, `leakage` s W; `step` the sample period in s, 0 to hold.
    """
    return clip(theta + step * rate * (y - leakage * theta), low, high)


def check_bounds(bounds, key: str) -> None:
    """Refuse bounds the wrong way round, or that do not hold the first estimate, 1."""
    low, high = (float(b) for b in bounds)
    text = f"[{low:g}, {high:g}]"
    if not low < high:
        cure = f"write [{high:g}, {low:g}]" if high < low else "leave room on both sides of 1"
        raise ExperimentError("the lower bound must be below the upper", key=key, value=text, cure=cure)
    if not low <= 1 <= high:
        raise ExperimentError(
            "bounds are factors on the believed numbers and must hold the first estimate, 1", key=key, value=text
        )
