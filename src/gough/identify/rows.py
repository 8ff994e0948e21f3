"""Rows: the regressor and the forces of a motion, thinned to what is independent, with the names of the columns.

    u = Y pi + noise,   Y (N, joints, p): inertial parameters, then Coulomb, viscous (and offset) of every joint   (1)

Friction that scales with the normal forces N in the joints (load_stribeck, load_lugre) has columns N sign(q') and N q'
of its coefficients besides, with N of the sheet's masses on this motion.

Neighbouring samples of a log hold the same news twice.  Y and u are averaged over blocks as long as half a period of
the filter's cutoff: the same average on both sides keeps (1), and the noise of two blocks is no longer one noise.
Theory: docs/theory/identification.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import casadi as ca
import numpy as np

from ..declare import Shape
from ..errors import ExperimentError, LogError
from ..kernel.rows import compile_rows
from ..machine.base import Machine
from . import joint_torque
from .signals import CUTOFF, Signals, signals_of

SLOW = 0.02  # of a joint's greatest speed: below it friction is not Coulomb's but sticks, creeps or has no sign
CREEP = 1e-4  # m/s; the same on any machine tool, whose Stribeck speeds are millimetres a second
_CHUNK = 8192  # samples whose regressor is held at once
FRICTION = ("coulomb", "viscous", "offset", joint_torque.KIND)
_LOADED = {"coulomb": "1", "viscous": "s/m"}  # of coefficients of a normal force
_UNITS = {"coulomb": "N", "viscous": "N s/m", "offset": "N", joint_torque.KIND: "N m"}


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
    t: np.ndarray | None = None  # (N,) s, where it is known
    speed: np.ndarray | None = None  # (N, n) of the joints, m/s or rad/s, where it is known


def rows_of_motion(
    machine: Machine, x, xd, xdd, u, friction: Sequence[str] = ("coulomb", "viscous"), used=None
) -> Rows:
    """The rows of a motion whose derivatives are known: x, xd, xdd (N, d), u (N, n).

    `friction`: which of coulomb, viscous and offset have columns for every joint.

    Raises
    ------
    ExperimentError
        no such kind of friction, or shapes that do not fit.
    """
    friction = in_order(friction)
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

    friction="known" takes the log's own friction off the forces; no column of it is left.  With columns of it, rows are
    left out of a joint that is slower than CREEP, or `slow` times its greatest speed, anywhere in their block; and
    always those of a drive at its limit.

    Raises
    ------
    LogError
        as `signals_of`; no friction in the log; or nothing moves fast enough.
    """
    known = friction == "known"
    kinds = () if known else in_order(friction)
    names, units, values = columns_of(machine, kinds)
    stretches = signals_of(log, machine, cutoff, hold)
    if known and stretches[0].friction is None:
        raise LogError("the log has no friction that is known", key="friction", cure="leave friction to be estimated")
    fastest = np.max([np.abs(s.qd).max(0) for s in stretches], axis=0)
    least = np.maximum(slow * fastest, CREEP) if kinds else 0 * fastest
    Ts = stretches[0].Ts
    block = 1 if cutoff is None else max(1, round(0.5 / (cutoff * Ts)))
    parts = [_averaged(machine, s, block, kinds, least, known) for s in stretches]
    Y, u, used, t, speed = (np.concatenate([part[i] for part in parts]) for i in range(5))
    if not used.any():
        raise LogError(
            "no joint moves faster than friction sticks", value=f"greatest speed {fastest.max():.3g} m/s",
            limit=f"{CREEP:g} m/s",
            cure="log a motion, for example that of gough.identify.excite",
        )  # fmt: skip
    samples = sum(len(s.t) for s in stretches)
    return Rows(Y, u, used, names, units, values, machine.joint_names, block * Ts, samples, t, speed)


def joined(parts: Sequence[Rows]) -> Rows:
    """The rows of several logs of one machine, one log behind the other; times go on where the former ended.

    Raises
    ------
    LogError
        their rows are not as far apart, or have not the same columns.
    """
    first = parts[0]
    if any(part.names != first.names or abs(part.step - first.step) > 1e-9 * first.step for part in parts):
        steps = ", ".join(f"{part.step:g} s" for part in parts)
        raise LogError("logs that are taken together need one sample period", value=steps)
    arrays = {key: np.concatenate([getattr(part, key) for part in parts]) for key in ("Y", "u", "used", "speed")}
    t, begin = [], 0.0
    for part in parts:
        t.append(part.t - part.t[0] + begin)
        begin = t[-1][-1] + part.step
    return replace(first, **arrays, t=np.concatenate(t), samples=sum(part.samples for part in parts))


def columns_of(machine: Machine, friction: Sequence[str]) -> tuple[tuple[str, ...], tuple[str, ...], np.ndarray]:
    """Names, units and the sheet's values of the columns."""
    wrong = [kind for kind in friction if kind not in FRICTION]
    if wrong:
        raise ExperimentError(
            "no such column of friction", key="friction", value=repr(wrong[0]), cure=f"there is {', '.join(FRICTION)}"
        )
    if joint_torque.KIND in friction:
        joint_torque.check(machine)
    own, n = machine.parameters, machine.joints_count
    names, units, values = list(own.names), list(own.units), list(own.values)
    for kind in loaded_kinds(machine, friction):
        number = np.atleast_1d(getattr(machine.friction, kind))
        names += [f"friction.load.{kind}" + (f"[{i}]" if len(number) > 1 else "") for i in range(len(number))]
        units += [_LOADED[kind]] * len(number)
        values += list(number)
    every = machine.parameters_of(friction=True)
    sheet = dict(zip(every.names, every.values, strict=True))
    for kind in friction:
        for i in range(n):
            name = f"friction.{kind}[{i}]"
            names.append(name)
            units.append(_UNITS[kind])
            values.append(sheet.get(name, 0.0))
    return tuple(names), tuple(units), np.array(values)


def in_order(friction: Sequence[str]) -> tuple[str, ...]:
    """The kinds with the torques of base joints last, where their columns stand."""
    return tuple(sorted(friction, key=lambda kind: kind == joint_torque.KIND))


def loaded_kinds(machine: Machine, friction: Sequence[str]) -> tuple[str, ...]:
    """The kinds of friction that scale with normal forces, among those that have columns."""
    loaded = machine.friction is not None and machine.friction.loaded
    return tuple(kind for kind in _LOADED if loaded and kind in friction)


def friction_columns(machine: Machine, friction: Sequence[str], sign, speed, loads) -> list:
    """The columns behind the inertial ones, as matrices (n, k) by `columns_of`; diagonals (n,) in and SX or NumPy out.

    sign, speed (n,) of the joints; loads (n,) the normal forces, or None.
    """
    out = []
    of = {"coulomb": sign, "viscous": speed}
    for kind in loaded_kinds(machine, friction):
        one = np.ndim(getattr(machine.friction, kind)) == 0
        out.append((loads * of[kind], one))
    return out + [(of.get(kind), False) for kind in friction if kind != joint_torque.KIND]


@lru_cache(maxsize=16)
def _load_rows(shape: Shape):
    """(theta, x, xd, xdd) -> normal forces (n,), on arrays."""
    m = shape.part
    p, theta = m.symbols
    x, xd, xdd = (ca.SX.sym(name, len(m.task)) for name in ("x", "xd", "xdd"))
    return compile_rows(ca.Function("normal_forces", [theta, x, xd, xdd], [normal_forces(m, p, x, xd, xdd)]))


def normal_forces(machine, p, x, xd, xdd):
    """The normal forces that scale the joints' friction on a motion, of the view `p`.  (n,) N, SX."""
    pi = {key: value for key, (value, _) in machine.inertial(p).items()}
    return machine.friction_load(p, pi, machine.coordinates_of(p, x), xd, xdd)


def _regressor(machine, x, xd, xdd, friction, sign=None) -> np.ndarray:
    """Y of eq. (1), with signs (N, n) of the speeds in place of its own.  (N, n, p)."""
    own, n = len(machine.parameters.names), machine.joints_count
    full = machine.regressor(x, xd, xdd, friction=bool(friction))
    if not friction:
        return full
    diagonal = np.arange(n)
    speed = full[..., diagonal, own + n + diagonal]
    sign = full[..., diagonal, own + diagonal] if sign is None else sign
    loads = _load_rows(Shape(machine))(machine.theta, x, xd, xdd)[0] if loaded_kinds(machine, friction) else None
    eye, out = np.eye(n), [full[..., :own]]
    for value, one in friction_columns(machine, friction, sign, speed, loads):
        value = np.ones_like(speed) if value is None else value
        out.append(value[..., None] if one else eye * value[..., None, :])
    if joint_torque.KIND in friction:
        out.append(joint_torque.columns(machine, x, xd))
    return np.concatenate(out, -1)


def _averaged(machine, s: Signals, block: int, friction, least, known: bool):
    """Y, u, used, t and speed of one stretch, averaged over blocks of as many samples."""
    u = s.u - s.friction if known else s.u
    good = s.good & (np.abs(s.qd) >= least)
    # a joint that turns back between two samples of a block has been slow there
    count = len(u) // block
    out = []
    step = max(1, _CHUNK // block)
    for k in range(0, count, step):
        rows = slice(k * block, min(k + step, count) * block)
        Y = _regressor(machine, s.x[rows], s.xd[rows], s.xdd[rows], friction, s.sign[rows])
        out.append(Y.reshape(-1, block, *Y.shape[1:]).mean(1))
    m = count * block
    n = u.shape[1]
    sign = np.sign(s.qd[:m]).reshape(-1, block, n)
    same = (sign == sign[:, :1]).all(1) if friction else True
    used = good[:m].reshape(-1, block, n).all(1) & same
    u, t, speed = (a[:m].reshape(-1, block, *a.shape[1:]).mean(1) for a in (u, s.t, s.qd))
    return np.concatenate(out), u, used, t, speed
