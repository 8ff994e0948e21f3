"""Contour errors from algebraic equations of the path: F(p) = 0 of two functions of the tool tip p is the path.

    e_1, e_2 = F(p),   e' = F_p p',   e'' = F_p p'' + p' F_pp p'                                                   (1)
    conic      f = (X / a)^2 + (Y / b)^2 - 1,  X, Y, Z from its centre along its axes:   F = (f s, Z)              (2)
               s = 1 (dimensionless), a b (area: X^2 + Y^2 - r^2 of a circle, m2), 1 / |f_p| (distance, m)
    local      c = d - t (t.d) - n k |d|^2 / 2,  d = p - p_r:   F = (m_1.c, m_2.c)                                 (3)

(3) is in metres and holds for every smooth path: t, n, k are tangent, normal and curvature at the reference p_r, and
F = 0 is the circle that touches the path there to second order, so what (1) neglects, the change of this circle, is of
first order in the tangential error (docs/theory/equivalent_error.md).  m_1, m_2 complete t to a frame that turns with
the path as little as can be (`carried`): they have no jump where the path is straight or bends the other way.

Source: Chen and Tsai 2008, section IV and V, for (1) and (2) with s = 1 and, on the circle, s = r^2.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, Literal, NamedTuple

import casadi as ca
import numpy as np
from pydantic import model_validator

from ..declare import Array, Part, quantity
from ..errors import InputError


class PathEquations(Part):
    """Base of equations of a path.  One's own is a subclass in any file."""

    @abstractmethod
    def equations(self, view, p):
        """F (2,) at the tool tip p (3,) m in W, in CasADi's operations; `view` is this part on theta."""


class Conic(PathEquations):
    """A circle or an ellipse, eq. (2)."""

    kind: Literal["conic"] = "conic"
    center: Array = quantity("m", "centre, in W", shape=(3,))
    semi: Array = quantity("m", "half of both axes, a and b; equal for a circle", above=0, shape=(2,))
    first: Array = quantity("1", "direction of the axis of a, in W", default=[1.0, 0.0, 0.0], shape=(3,))
    second: Array = quantity("1", "direction of the axis of b, in W", default=[0.0, 1.0, 0.0], shape=(3,))
    form: Literal["dimensionless", "area", "distance"] = "distance"

    @model_validator(mode="after")
    def _square(self):
        gram = np.array([self.first @ self.first, self.second @ self.second, self.first @ self.second + 1])
        if np.abs(gram - 1).max() > 1e-6:
            raise InputError(
                "both axes must have length 1 and be square to each other", key="first",
                value=f"{self.first.tolist()}, {self.second.tolist()}",
            )  # fmt: skip
        return self

    def equations(self, view, p):
        first, second = ca.SX(view.first), ca.SX(view.second)
        d = p - ca.SX(view.center)
        X, Y, Z = ca.dot(d, first), ca.dot(d, second), ca.dot(d, ca.cross(first, second))
        a, b = view.semi[0], view.semi[1]
        f = (X / a) ** 2 + (Y / b) ** 2 - 1
        if self.form == "area":
            f = a * b * f
        if self.form == "distance":
            f = f / (2 * ca.sqrt((X / a**2) ** 2 + (Y / b**2) ** 2))
        return ca.vertcat(f, Z)


class Frame(NamedTuple):
    """t, m_1, m_2 of eq. (3), (3,) each."""

    tangent: Any
    first: Any
    second: Any


def frame_at(tangent) -> Frame:
    """The frame that a run starts with, NumPy; along the first axis of W where nothing moves yet."""
    t = np.ravel(tangent)
    t = t / np.linalg.norm(t) if np.linalg.norm(t) > 0.5 else np.array([1.0, 0.0, 0.0])
    across = np.eye(3)[np.argmin(np.abs(t))]
    first = np.cross(t, across)
    first /= np.linalg.norm(first)
    return Frame(t, first, np.cross(t, first))


def carried(frame: Frame, tangent) -> Frame:
    """The frame turned by the least angle so that its first axis is `tangent`, a unit vector or 0 (then it stays).

    Where the path turns back on itself m_1 and m_2 stay: any half turn about an axis across is as small.
    """
    moving = ca.dot(tangent, tangent) > 0.25
    t = ca.if_else(moving, tangent, frame.tangent)
    axis, cosine = ca.cross(frame.tangent, t), ca.dot(frame.tangent, t)
    back = cosine < -0.999999
    divisor = ca.if_else(back, 1, 1 + cosine)

    def turned(m):
        about = ca.cross(axis, m)
        return ca.if_else(back, m - t * ca.dot(t, m), m + about + ca.cross(axis, about) / divisor)

    first = turned(frame.first)
    first = first - t * ca.dot(t, first)  # rounding, sample by sample, would grow
    first = first / ca.norm_2(first)
    return Frame(t, first, ca.cross(t, first))


def local(p, frame: Frame, p_r, bend):
    """F of eq. (3); `bend` is n k, (3,) 1/m.  (2,) m."""
    d, t = p - p_r, frame.tangent
    c = d - t * ca.dot(t, d) - bend * (ca.dot(d, d) / 2)
    return ca.vertcat(ca.dot(frame.first, c), ca.dot(frame.second, c))


class Second(NamedTuple):
    """e, e' and the e'' that is there at p'' = 0, and F_p."""

    value: Any
    rate: Any
    drift: Any
    gradient: Any


def second_order(F, p, p_value, pd) -> Second:
    """Eq. (1) of F, an expression in the symbol p (3,), at p = p_value, p' = pd."""
    F_p = ca.jacobian(F, p)
    speed = ca.SX.sym("pd", 3)
    found = [F, F_p @ speed, ca.jtimes(F_p @ speed, p, speed), F_p]
    return Second(*ca.substitute(found, [p, speed], [ca.densify(ca.SX(value)) for value in (p_value, pd)]))
