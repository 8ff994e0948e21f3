"""Limits of a hybrid machine at its coordinates: ends of the slides, angles of the arms, singular poses."""

from __future__ import annotations

import casadi as ca
import numpy as np

from ..errors import InputError, Problem, WorkspaceError
from .hybrid_parts import stands
from .platform import SINGULAR

SLIDES = ("slide 1", "slide 6", "ram", "passive slide")
_GRAVITY, _SPAN = 30.0, 50.0  # m/s2, m: beyond these the unit was most likely wrong


def margins_of(m, p, z):
    """`Machine.margins` of a hybrid machine `m`.  phi_b is singular where det J = 0: arms along the base, hybrid.py."""
    limits = p.limits
    slides, low, high = z[:4], *(ca.vertcat(limits.travel[:, k], limits.passive[k]) for k in (0, 1))
    arms = z[4:]
    values = [slides - low, high - slides, arms - limits.angle[0], limits.angle[1] - arms]
    return names_of(), ca.vertcat(*values, m.determinant_of(p, z) - limits.determinant)


def names_of() -> tuple[str, ...]:
    """What each margin says when it is negative."""
    names = [f"{name}: beyond the {end} of its travel" for end in ("start", "end") for name in SLIDES]
    names += [f"arm {i}: angle beyond the {end}" for end in ("least", "greatest") for i in (1, 6)]
    return (*names, SINGULAR)


def told(m, index: int, margin: float) -> tuple[str, str, str]:
    """Rule, value and limit in words of the margin `index` that is `margin` < 0."""
    limits, name = m.limits, names_of()[index]
    if name == SINGULAR:
        return name, f"{limits.determinant + margin:.3g} of it", f"{limits.determinant:g}"
    upper = index // 4 == 1 if index < 8 else index >= 10
    ends = np.vstack([limits.travel, limits.passive])[index % 4] if index < 8 else limits.angle
    bound = ends[int(upper)]
    value = bound - margin if upper else bound + margin
    if index < 8:
        return name, f"{value:.8g} m", f"{bound:g} m"
    return name, f"{np.degrees(value):.4g} deg", f"{np.degrees(bound):g} deg"


def unreachable(m, x) -> tuple[int, WorkspaceError] | None:
    """The first of the places x (N, 3) nearer to pivot 1 than the tool can be, and the error that says so."""
    x, b = np.atleast_2d(x), abs(m.base.half_width)
    far = np.hypot(x[:, 0] + m.base.half_width, x[:, 1])
    rows = np.flatnonzero(~(far >= b))
    if not len(rows):
        return None
    row = int(rows[0])
    return row, WorkspaceError(
        f"slide 1: cannot reach: misses by {1e3 * (b - far[row]):.4g} mm",
        value=f"{far[row]:.6g} m from the axis of pivot 1", limit=f"at least {b:g} m",
        cure="check the place: position, units",
    )  # fmt: skip


def check_home(m) -> None:
    """Refuse a machine of strange numbers, or that cannot stand at home within its limits.

    Raises
    ------
    InputError
        a problem for each.
    """
    wrong, b = [], abs(m.base.half_width)
    for key, center in (("link2", m.link2.center), ("link5", m.link5.center), ("ram", m.ram.center)):
        if np.linalg.norm(center) > 5 * b:
            wrong.append(_far(f"{key}.center", np.linalg.norm(center), 5 * b))
    if abs(m.arm.center) > 5 * b:
        wrong.append(_far("arm.center", abs(m.arm.center), 5 * b))
    if np.abs(m.limits.travel).max() > _SPAN:
        value = f"{np.abs(m.limits.travel).max():g} m"
        wrong.append(Problem("spans a strange distance", key="limits.travel", value=value, cure="did you mean mm?"))
    if np.linalg.norm(m.gravity) > _GRAVITY:
        value = f"{np.linalg.norm(m.gravity):g} m/s2"
        wrong.append(Problem("gravity is no planet's", key="gravity", value=value, limit=f"{_GRAVITY:g} m/s2"))
    if wrong:
        raise InputError(problems=wrong)
    found = unreachable(m, m.home)
    if found is not None:
        rule, value, limit = (getattr(found[1].problems[0], name) for name in ("rule", "value", "limit"))
        raise InputError(f"at home, {rule}", key="home", value=value, limit=limit, cure="change home or the base")
    values = _margins_at_home(m)
    for index in np.flatnonzero(~(values >= 0)):
        rule, value, limit = told(m, int(index), float(values[index]))
        wrong.append(
            Problem(f"at home, {rule}", key="home", value=value, limit=limit, cure="change home or the limits")
        )
    if wrong:
        raise InputError(problems=wrong)


def _far(key: str, distance: float, limit: float) -> Problem:
    return Problem(
        "the centre of mass lies far outside the machine", key=key, value=f"{distance:g} m from its frame",
        limit=f"{limit:.3g} m", cure="did you mean mm?",
    )  # fmt: skip


def _margins_at_home(m) -> np.ndarray:
    """Values of `margins_of` at home, in NumPy: a machine is made without building an expression."""
    z, limits = stands(m, m.home)[0], m.limits
    ends = np.vstack([limits.travel, limits.passive])
    values = [z[:4] - ends[:, 0], ends[:, 1] - z[:4], z[4:] - limits.angle[0], limits.angle[1] - z[4:]]
    return np.concatenate([*values, [1 - limits.determinant]])
