"""Laws of friction held against one another, by the error on motion that none of them has seen.

    u = Y pi + F,   F_i = F_c sign(q') + f_v q'                                     "coulomb, viscous"             (1)
    + o                                                                             "offset": F_c differs by direction
    + o + f_a |q'|                                                                  "asymmetric": f_v does, too    (2)
    + o + F_s sign(q') exp(-(q' / v_s)^2)                                           "stribeck": a rise at rest     (3)

An offset of the drive and a Coulomb friction that differs by direction are one and the same number.  v_s of (3) is the
one of SPEEDS, shares of the joint's greatest speed, with the least residual.  A law with more numbers always fits what
it was fitted to better; that its error on the parts held out (regress.py) is less is what speaks for it.
Theory of the estimate itself: identification.md.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..errors import ExperimentError
from .regress import Estimate, estimate
from .rows import Rows

NEAR = 0.01  # of an error: nearer is no reason for another number
SPEEDS = (0.02, 0.04, 0.07, 0.12, 0.2, 0.35)  # of the greatest speed
LAWS = ("coulomb, viscous", "offset", "asymmetric", "stribeck")


@dataclass(frozen=True)
class Compared:
    """One law: its estimate, and v_s of each joint where it has one."""

    law: str
    found: Estimate
    v_s: np.ndarray | None = None  # (n,) m/s

    def to_json(self) -> dict:
        """Law, errors, and what was found, SI."""
        kept = self.found.base.kept
        return {
            "law": self.law,
            "held_out_rms": self.found.held_out_rms,
            "residual_rms": self.found.residual_rms,
            "parameters": [
                {"name": self.found.rows.names[k], "value": float(v), "std": float(s), "unit": self.found.rows.units[k]}
                for k, v, s in zip(kept, self.found.values, self.found.std, strict=True)
            ],
            "stribeck_speed": None if self.v_s is None else self.v_s.tolist(),
        }


def compare(rows: Rows) -> list[Compared]:
    """All LAWS on rows that have Coulomb and viscous columns of every joint, and no others of friction.

    Raises
    ------
    ExperimentError
        the rows have other columns.
    LogError
        as `estimate`.
    """
    n = len(rows.joints)
    sign, speed = (_diagonal(rows, kind, n) for kind in ("coulomb", "viscous"))
    ones = np.ones_like(speed)
    offset = _with(rows, "offset", "N", ones)
    laws = [
        Compared(LAWS[0], estimate(rows)),
        Compared(LAWS[1], estimate(offset)),
        Compared(LAWS[2], estimate(_with(offset, "asymmetric", "N s/m", np.abs(speed)))),
    ]
    fastest = np.abs(np.where(rows.used, speed, 0)).max(0)
    tried = []
    for share in SPEEDS:
        v_s = share * fastest
        column = sign * np.exp(-((speed / np.maximum(v_s, 1e-12)) ** 2))
        tried.append(Compared(LAWS[3], estimate(_with(offset, "stribeck", "N", column)), v_s))
    return [*laws, min(tried, key=lambda one: one.found.residual_rms)]


def best(compared: list[Compared]) -> Compared:
    """The first law whose error on what was held out is within NEAR of the least: of equals that of fewer numbers."""
    least = min(one.found.held_out_rms for one in compared)
    return next(one for one in compared if one.found.held_out_rms <= (1 + NEAR) * least)


def text(compared: list[Compared]) -> str:
    """A table, the best law marked."""
    chosen = best(compared)
    width = max(len(one.law) for one in compared)
    lines = [f"{'friction':{width}}  held out [N rms]  learned from [N rms]"]
    for one in compared:
        mark = " *" if one is chosen else ""
        extra = ""
        if one.v_s is not None:
            extra = f"  v_s {', '.join(f'{1e3 * v:.3g}' for v in one.v_s)} mm/s"
        errors = f"{one.found.held_out_rms:16.4g}  {one.found.residual_rms:20.4g}"
        lines.append(f"{one.law:{width}}  {errors}{extra}{mark}")
    return "\n".join([*lines, f"* the fewest numbers within {100 * NEAR:g} % of the least error on motion held out"])


def _diagonal(rows: Rows, kind: str, n: int) -> np.ndarray:
    """The column of each joint of a kind of friction, where that joint has it.  (N, n)."""
    try:
        at = [rows.names.index(f"friction.{kind}[{i}]") for i in range(n)]
    except ValueError:
        raise ExperimentError(
            "laws are compared on rows with Coulomb and viscous friction of every joint", key="friction"
        ) from None
    return np.stack([rows.Y[:, i, k] for i, k in enumerate(at)], -1)


def _with(rows: Rows, kind: str, unit: str, column) -> Rows:
    """The rows with one more column for each joint, (N, n)."""
    n = len(rows.joints)
    more = np.eye(n) * column[:, :, None]
    names = tuple(f"friction.{kind}[{i}]" for i in range(n))
    return replace(
        rows, Y=np.concatenate([rows.Y, more], -1), names=rows.names + names, units=rows.units + (unit,) * n,
        values=np.concatenate([rows.values, np.zeros(n)]),
    )  # fmt: skip
