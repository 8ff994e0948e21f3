"""Rows: the regressor and the forces of a motion, thinned to what is independent, with the names of the columns.

    u = Y pi + noise,   Y (N, joints, p): inertial parameters, then Coulomb, viscous (and offset) of every joint   (1)

Neighbouring samples of a log hold the same news twice.  Y and u are averaged over blocks as long as half a period of
the filter's cutoff: the same average on both sides keeps (1), and the noise of two blocks is no longer one noise.
Theory: docs/theory/identification.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import ExperimentError, LogError
from ..machine.base import Machine
from .signals import CUTOFF, Signals, signals_of

SLOW = 0.02  # of a joint's greatest speed: below it friction is not Coulomb's but sticks, creeps or has no sign
_CHUNK = 8192  # samples whose regressor is held at once
FRICTION = ("coulomb", "viscous", "offset")
_UNITS = {"coulomb": "N", "viscous": "N s/m", "offset": "N"}


@dataclass(frozen=True)
class Rows:
    """Equation (1) of a motion, N rows of n joints and p columns."""

    Y: np.ndarray  # (N, n, p)
    u: np.ndarray  # (N, n) N, or N m
    used: np.ndarray  # (N, n) bool: what takes part
    names: tuple[str, ...]  # of the columns
    units: tuple[str, ...]
    values: np.ndarray  # (p,) what the machine's sheet says
    joints: tuple[str, ...]
    step: float = 0.0  # s between rows; 0: not known
    samples: int = 0  # of the log that they were made of


def rows_of_motion(machine: Machine, x, xd, xdd, u, friction: Sequence[str] = ("coulomb", "viscous"), used=None) -> Rows:
    """The rows of a motion whose derivatives are known: x, xd, xdd (N, d), u (N, n).

    `friction`: which of coulomb, viscous and offset have columns for every joint.

    Raises
    ------
    ExperimentError
        no such kind of friction, or shapes that do not fit.
    """
    names, units, values = columns_of(machine, friction)
    u = np.asarray(u, float)
    Y = _regressor(machine, np.asarray(x, float), np.asarray(xd, float), np.asarray(xdd, float), friction)
    if u.shape != Y.shape[:2]:
        raise ExperimentError("forces and motion must have one shape", value=str(u.shape), limit=str(Y.shape[:2]))
    used = np.ones(u.shape, bool) if used is None else np.asarray(used, bool)
    return Rows(Y, u, used, names, units, values, machine.joint_names, samples=len(u))


def rows_of_log(
    log,
    machine: Machine,
    friction: Sequence[str] | str = ("coulomb", "viscous"),
    cutoff: float | None = CUTOFF,
    hold: float | None = None,
    slow: float = SLOW,
) -> Rows:
    """The rows of a log, from its q_m and u; `cutoff` and `hold` as in `signals_of`.

    friction="known" takes the log's own friction off the forces; no column of it is left.  With columns of it, rows of
    a joint that is slower than `slow` times its greatest speed anywhere in their block are left out, and always those
    of a drive at its limit.

    Raises
    ------
    LogError
        as `signals_of`; no friction in the log; or nothing moves fast enough.
    """
    known = friction == "known"
    kinds = () if known else tuple(friction)
    names, units, values = columns_of(machine, kinds)
    stretches = signals_of(log, machine, cutoff, hold)
    if known and stretches[0].friction is None:
        raise LogError("the log has no friction that is known", key="friction", cure="leave friction to be estimated")
    least = slow * np.max([np.abs(s.qd).max(0) for s in stretches], axis=0) if kinds else np.zeros(machine.joints_count)
    Ts = stretches[0].Ts
    block = 1 if cutoff is None else max(1, round(0.5 / (cutoff * Ts)))
    parts = [_averaged(machine, s, block, kinds, least, known) for s in stretches]
    Y, u, used = (np.concatenate([part[i] for part in parts]) for i in range(3))
    if not used.any():
        raise LogError(
            "no joint moves faster than friction sticks", value=f"greatest speed {_fastest(stretches):.3g} m/s",
            cure="log a motion, for example that of gough.identify.excite",
        )  # fmt: skip
    return Rows(Y, u, used, names, units, values, machine.joint_names, block * Ts, sum(len(s.t) for s in stretches))


def columns_of(machine: Machine, friction: Sequence[str]) -> tuple[tuple[str, ...], tuple[str, ...], np.ndarray]:
    """Names, units and the sheet's values of the columns."""
    wrong = [kind for kind in friction if kind not in FRICTION]
    if wrong:
        raise ExperimentError(
            "no such column of friction", key="friction", value=repr(wrong[0]), cure=f"there is {', '.join(FRICTION)}"
        )
    own, n = machine.parameters, machine.joints_count
    names, units, values = list(own.names), list(own.units), list(own.values)
    every = machine.parameters_of(friction=True)
    sheet = dict(zip(every.names, every.values, strict=True))
    for kind in friction:
        for i in range(n):
            name = f"friction.{kind}[{i}]"
            names.append(name)
            units.append(_UNITS[kind])
            values.append(sheet.get(name, 0.0))
    return tuple(names), tuple(units), np.array(values)


def _regressor(machine, x, xd, xdd, friction) -> np.ndarray:
    """Y of eq. (1).  (N, n, p)."""
    own = len(machine.parameters.names)
    full = machine.regressor(x, xd, xdd, friction=bool(friction))
    n = machine.joints_count
    pieces = {"coulomb": full[..., own : own + n], "viscous": full[..., own + n :]}
    pieces["offset"] = np.broadcast_to(np.eye(n), (*full.shape[:-1], n))
    return np.concatenate([full[..., :own], *(pieces[kind] for kind in friction)], -1)


def _averaged(machine, s: Signals, block: int, friction, least, known: bool):
    """Y, u, used of one stretch, averaged over blocks of as many samples."""
    u = s.u - s.friction if known else s.u
    good = s.good & (np.abs(s.qd) >= least)
    # a joint that turns back between two samples of a block has been slow there
    count = len(u) // block
    out = []
    step = max(1, _CHUNK // block)
    for k in range(0, count, step):
        rows = slice(k * block, min(k + step, count) * block)
        Y = _regressor(machine, s.x[rows], s.xd[rows], s.xdd[rows], friction)
        out.append(Y.reshape(-1, block, *Y.shape[1:]).mean(1))
    m = count * block
    n = u.shape[1]
    sign = np.sign(s.qd[:m]).reshape(-1, block, n)
    same = (sign == sign[:, :1]).all(1) if friction else True
    return np.concatenate(out), u[:m].reshape(-1, block, n).mean(1), good[:m].reshape(-1, block, n).all(1) & same


def _fastest(stretches) -> float:
    return float(max(np.abs(s.qd).max() for s in stretches))
