"""Rigid bodies: mass, centre of mass, inertia; checked for physical sense when they are made."""

from __future__ import annotations

import casadi as ca
import numpy as np
from pydantic import model_validator

from ..declare import Array, Part, quantity
from ..errors import InputError, SheetError
from ..frames import skew


class Body(Part):
    """A rigid body.  Its frame is named by whoever owns it."""

    input_error = SheetError

    mass: float = quantity("kg", "mass", above=0)
    center: Array = quantity("m", "centre of mass, in the body's frame", shape=(3,))
    inertia: Array = quantity("kg m2", "inertia about the centre of mass, axes of the body's frame", shape=(3, 3))

    @model_validator(mode="after")
    def _physical(self):
        check_inertia(self.inertia)
        return self

    def joined(self, mass: float, center: np.ndarray) -> Body:
        """This body with a point mass (kg) fixed at `center` (3,) m of its frame."""
        if mass == 0:
            return self  # to the last bit
        total = self.mass + mass
        middle = (self.mass * self.center + mass * np.asarray(center)) / total
        inertia = self.inertia + _steiner(self.mass, self.center - middle) + _steiner(mass, center - middle)
        return self.replace(mass=total, center=middle, inertia=inertia)


def check_inertia(inertia: np.ndarray) -> None:
    """Refuse an inertia (3, 3) that no distribution of mass has.

    Raises
    ------
    InputError
        not symmetric, not positive definite, or against the triangle inequality (A + B >= C).
    """
    if not np.allclose(inertia, inertia.T, rtol=0, atol=1e-9 * np.abs(inertia).max()):
        raise InputError("inertia must be symmetric", value=str(inertia.tolist()), cure="give Ixy = Iyx and so on")
    principal = np.linalg.eigvalsh(inertia)
    shown = ", ".join(f"{v:.4g}" for v in principal)
    if principal[0] <= 0:
        raise InputError("inertia must be positive definite", value=f"principal moments {shown} kg m2")
    a, b, c = principal
    if a + b < c * (1 - 1e-9):
        raise InputError(
            "inertia violates the triangle inequality A + B >= C",
            value=f"{a:.4g} + {b:.4g} < {c:.4g} kg m2",
            cure="it must be about the centre of mass",
        )


def _steiner(mass: float, offset: np.ndarray) -> np.ndarray:
    return mass * (offset @ offset * np.eye(3) - np.outer(offset, offset))


def first_moments(body) -> tuple:
    """Mass, first moments m c and inertia about the frame's origin: the ten numbers dynamics is linear in.

    `body` is a Body or its view.  m, (3,), (3, 3);   I_O = I_C - m skew(c) skew(c)
    """
    S = skew(body.center)
    return body.mass, body.mass * body.center, body.inertia - body.mass * S @ S


_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def named(name: str, m, mc, I) -> dict:
    """The ten numbers of a body as {name: (SX, unit)}: "platform.m", "platform.m cx", "platform.Ixx" ..."""
    out = {f"{name}.m": (m, "kg")}
    out |= {f"{name}.m c{axis}": (mc[i], "kg m") for i, axis in enumerate("xyz")}
    return out | {f"{name}.I{'xyz'[i]}{'xyz'[j]}": (I[i, j], "kg m2") for i, j in _PAIRS}


def turned(name: str, pi, R) -> tuple:
    """m, m c (3,) and I (3, 3) of the body `name` among the numbers pi = {name: SX}, turned by R (3, 3)."""

    def of(key):
        return pi[f"{name}.{key}"]

    mc = ca.vertcat(*[of(f"m c{axis}") for axis in "xyz"])
    I = ca.vertcat(
        ca.horzcat(of("Ixx"), of("Ixy"), of("Ixz")),
        ca.horzcat(of("Ixy"), of("Iyy"), of("Iyz")),
        ca.horzcat(of("Ixz"), of("Iyz"), of("Izz")),
    )
    return of("m"), R @ mc, R @ I @ R.T


def rigid_wrench(m, mc_W, I_W, w, a_O, wd):
    """Force and moment about the body's origin O that its motion needs, in W.  (6,).

        f = m a_O + w' x m c + w x (w x m c)
        n = I_O w' + w x I_O w + m c x a_O

    m, m c (3,) and I_O (3, 3) in axes of W; w angular velocity, a_O acceleration of O less gravity, wd = w'.
    """
    f = m * a_O + ca.cross(wd, mc_W) + ca.cross(w, ca.cross(w, mc_W))
    n = I_W @ wd + ca.cross(w, I_W @ w) + ca.cross(mc_W, a_O)
    return ca.vertcat(f, n)
