"""From the columns of a log to a motion with its derivatives and the force that belongs to it.

The joints' readings, the forces and the signs of the speeds are all filtered alike, by a low-pass that delays
nothing: the gain 1 / (1 + (f / f_c)^8), that of a Butterworth filter of fourth order run forwards and backwards.  What
it takes from a sudden force it takes from the acceleration that the force makes.  A spline of fifth order through the
readings gives q, q', q''.  Then, on the machine as believed,

    x from q by forward kinematics,   xd = J^-1 q',   xdd = J^-1 (q'' - J' xd)                                     (1)

with J' xd the joints' acceleration at xdd = 0.  A force held over [t, t + hold) acts at t + hold / 2 on the average:
the motion is taken there.  Where it is taken at t instead, half a millisecond of 400 kg at 5 Hz reads as 200 N s/m.
Theory: docs/theory/identification.md.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..errors import GoughError, LogError
from ..machine.workspace import space_names
from ..units import to_si

CUTOFF = 20.0  # Hz; ten times what a machine of a ton is moved at, a tenth of what its controllers do
_GAP = 1.5  # of the usual step of time, from which a step is a gap
_UNEVEN = 1e-3  # of a step: more is jitter, and derivatives of unevenly read joints are wrong
_PAD = 3.0  # periods of the cutoff by which columns are continued at both ends
_FEWEST = 64  # samples of a stretch worth keeping


class Signals(NamedTuple):
    """One stretch of a log without a gap: n rows, Ts s apart."""

    t: np.ndarray  # (n,) s
    x: np.ndarray  # (n, d) task coordinates
    xd: np.ndarray  # (n, d) task rate
    xdd: np.ndarray  # (n, d) its rate
    qd: np.ndarray  # (n, joints) speed of the joints
    sign: np.ndarray  # (n, joints) its sign, filtered as u is
    u: np.ndarray  # (n, joints) N
    good: np.ndarray  # (n, joints) bool: not at the drive's limit
    friction: np.ndarray | None  # (n, joints) N where the log has it
    Ts: float


def signals_of(log, machine, cutoff: float | None = CUTOFF, hold: float | None = None) -> list[Signals]:
    """The stretches of a log of one run, filtered at `cutoff` Hz (None: not at all) and trimmed at both ends.

    `hold` s is for how long a row's force is held; left out, the period that a log of gough tells, else 0.

    Raises
    ------
    LogError
        a batch, no q_m or u, other joints, a number that is not finite (with its row), time that does not rise, rows
        unevenly apart, no stretch that is long enough, or joints that no pose of the machine has.
    """
    t, q, u = _columns(log, machine)
    hold = _period(log) if hold is None else float(hold)
    saturated = log["saturated"] != 0 if "saturated" in log else np.zeros(u.shape, bool)
    steps = np.diff(t)
    Ts = float(np.median(steps)) if len(steps) else 0.0
    if cutoff is not None and Ts > 0 and not 0 < cutoff < 0.45 / Ts:
        raise LogError(
            "the filter must be below half the sample rate", key="cutoff", value=f"{cutoff:g} Hz",
            limit=f"{0.45 / Ts:.4g} Hz", cure="lower the cutoff, or log more rows",
        )  # fmt: skip
    trim = _FEWEST // 8 if cutoff is None else int(np.ceil(2 / (cutoff * Ts))) if Ts else 0
    cuts = np.concatenate([[0], np.flatnonzero(steps > _GAP * Ts) + 1, [len(t)]])
    near, friction = (log[name] if name in log else None for name in ("x_r", "friction"))  # noqa: SIM401
    found = []
    for a, b in zip(cuts[:-1], cuts[1:], strict=True):
        if b - a < 2 * trim + _FEWEST:
            continue
        part = slice(a + trim, b - trim)
        uneven = np.abs(np.diff(t[a:b]) - Ts)
        if uneven.max() > _UNEVEN * Ts:
            k = int(a + uneven.argmax())
            raise LogError("rows are unevenly apart", key="t", where=f"row {k}", value=f"{t[k + 1] - t[k]:.6g} s",
                           limit=f"{Ts:.6g} s", cure="resample the log evenly first")  # fmt: skip
        keep = slice(trim, b - a - trim)
        low = _low_pass(cutoff, Ts)
        motion = _derivatives(low(q[a:b]), Ts, hold)
        sign = low(np.sign(motion[1]))[keep]
        x, xd, xdd, qd = _poses(machine, *(m[keep] for m in motion), None if near is None else near[part])
        found.append(Signals(
            t[part] + hold / 2, x, xd, xdd, qd, sign, low(u[a:b])[keep], ~saturated[part],
            None if friction is None else low(_later(friction[a:b], hold / Ts / 2))[keep], Ts,
        ))  # fmt: skip
    if not found:
        raise LogError(
            "no stretch of the log is long enough", value=f"{len(t)} rows of {Ts:.4g} s",
            limit=f"{2 * trim + _FEWEST} rows without a gap", cure="raise the cutoff, or log a longer motion",
        )  # fmt: skip
    return found


def _columns(log, machine) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """t (N,), q_m and u (N, joints): all there, of this machine's joints, finite, in the order of time."""
    if log.batch:
        raise LogError("a batch is several runs", cure="identify one of them: log.run(0)")
    t = np.asarray(log.t, float)
    out = []
    for key in ("q_m", "u"):
        if key not in log:
            raise LogError("the log lacks what identification needs", key=key, cure="log it: signals must hold q_m, u")
        column = np.asarray(log[key], float)
        if column.ndim != 2 or column.shape[1] != machine.joints_count:
            raise LogError(
                f"{machine.name} has other joints", key=key, value=str(column.shape),
                limit=f"(rows, {machine.joints_count})", cure="name the machine that was logged with --machine",
            )  # fmt: skip
        bad = np.argwhere(~np.isfinite(column))
        if len(bad):
            k, j = map(int, bad[0])
            raise LogError("must be finite", key=key, where=f"row {k}, joint {j + 1}", value=str(column[k, j]))
        out.append(column)
    if not np.isfinite(t).all():
        raise LogError("must be finite", key="t", where=f"row {int(np.argmin(np.isfinite(t)))}")
    back = np.flatnonzero(np.diff(t) <= 0)
    if len(back):
        k = int(back[0])
        raise LogError("time must rise", key="t", where=f"row {k + 1}", value=f"{t[k + 1]:.9g} s after {t[k]:.9g} s")
    return t, *out


def _period(log) -> float:
    """The sample period of the controller that a log of gough tells, else 0.  s."""
    run = log.info.get("run")
    period = run.get("period") if isinstance(run, dict) else None
    return to_si(period, "s") if isinstance(period, str) else float(period or 0.0)


def _low_pass(cutoff: float | None, Ts: float):
    """The filter, on columns (n, joints); none where there is no cutoff."""
    if cutoff is None:
        return lambda columns: columns

    def filtered(columns):
        n = len(columns)
        pad = min(n - 1, int(np.ceil(_PAD / (cutoff * Ts))))
        first, last = columns[:1], columns[-1:]
        # turned over at both ends, so that neither value nor slope jumps there; about 0, to lose fewer digits
        long = np.concatenate([2 * first - columns[pad:0:-1], columns, 2 * last - columns[-2 : -pad - 2 : -1]])
        slope = np.linspace(0, 1, len(long))[:, None] * (long[-1:] - long[:1]) + long[:1]
        f = np.fft.rfftfreq(len(long), Ts)
        gain = 1 / (1 + (f / cutoff) ** 8)
        low = np.fft.irfft(np.fft.rfft(long - slope, axis=0) * gain[:, None], len(long), axis=0) + slope
        return low[pad : pad + n]

    return filtered


def _derivatives(q, Ts, hold):
    """q, q', q'' at hold / 2 behind every row.  (n, joints) each."""
    from scipy.interpolate import make_interp_spline

    t = np.arange(len(q)) * Ts
    spline = make_interp_spline(t, q, k=5)
    return tuple(spline(np.minimum(t + hold / 2, t[-1]), nu) for nu in range(3))


def _later(columns, share: float) -> np.ndarray:
    """Columns read at the rows' times (n, joints), `share` of a step later; the last row stays."""
    after = np.concatenate([columns[1:], columns[-1:]])
    return columns + share * (after - columns)


def _poses(machine, q, qd, qdd, near):
    """x, xd, xdd of eq. (1), and qd."""
    try:
        x = machine.forward_kinematics(q, near=near)
    except GoughError as error:
        problem = error.problems[0]
        cure = "name the machine that was logged with --machine"
        if problem.rule in space_names(machine):
            cure += ", or declare a larger limits.workspace"
        raise LogError(
            f"no pose of {machine.name} has these joints: {problem.rule}", key="q_m", where=problem.where,
            value=problem.value, cure=cure,
        ) from None  # fmt: skip
    J = machine.jacobian(x)
    solve = np.linalg.solve if J.shape[-1] == J.shape[-2] else lambda A, b: np.linalg.pinv(A) @ b
    xd = solve(J, qd[..., None])[..., 0]
    bias = machine.joint_motion(x, xd, np.zeros_like(xd))[2]
    xdd = solve(J, (qdd - bias)[..., None])[..., 0]
    return x, xd, xdd, qd
