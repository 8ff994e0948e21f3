"""A log as the force on the tool along a program's path: gough's own, or one that a control has recorded.

A recorded one has readings and drive forces and knows of no program.  Its poses are those that the readings have on the
believed machine; a pose belongs to the place of the path that is nearest within `AHEAD` m before the last one's, and
none is nearer than `NEAR` m where the machine is elsewhere: it waits, sets up, or comes to the part.  The path is
followed from where its first feed begins to its end, so a path that comes back over itself is told apart.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..errors import LogError
from ..log import Log
from ..observe.disturbance import DisturbanceObserver
from ..observe.recorded import Recorder
from ..program.path import Path
from ..program.segments import norm

EACH = 0.2e-3  # m between the places that are tried; then straight between them
AHEAD = 3e-3  # m of the path that the tool may go on from row to row: 3 m/s at 1 kHz
NEAR = 1e-3  # m beside the path


class Felt(NamedTuple):
    """Rows of a run: where on the path the tool was, and the force on it as its drives tell it."""

    t: np.ndarray  # (n,) s
    s: np.ndarray  # (n,) m
    force: np.ndarray  # (n, 3) N, in W


def felt(log: Log, machine, path: Path, bandwidth: float = 10.0) -> Felt:
    """The force along `path`, as placed in W, out of a log: its own wrench_hat and s_r, or what q_m and u tell.

    Raises
    ------
    LogError
        neither is there; rows do not come at one period; a recorded log is not of this path.
    """
    if "wrench_hat" in log and "s_r" in log:
        return Felt(log.t, log["s_r"], log["wrench_hat"][:, :3])
    for name in ("q_m", "u"):
        if name not in log:
            raise LogError(
                "has neither wrench_hat nor what it is made of", key=name, cure="log q_m and u, or an observer"
            )
    steps = np.diff(log.t)
    if np.ptp(steps) > 1e-3 * steps.mean():
        raise LogError(
            "rows must come at one period, without gaps", key="t",
            value=f"{steps.min():g} s to {steps.max():g} s from row to row",
        )  # fmt: skip
    observer = DisturbanceObserver(bandwidth=bandwidth).on(machine, float(steps.mean()))
    if "x_r" in log and "s_r" in log:
        first, s = log["x_r"][0], log["s_r"]
    else:
        poses, status = machine.forward_kinematics(log["q_m"], on_fail="nan")
        bad = np.flatnonzero(np.asarray(status) != 0)
        if len(bad):
            raise LogError(
                "readings that no pose of this machine has", key="q_m", value=f"row {bad[0] + 1} of {len(log.t)}",
                cure="is it the log of this machine, in these units?",
            )  # fmt: skip
        first, s = poses[0], followed(path, poses[:, :3])
    before = np.concatenate([log["u"][:1], log["u"][:-1]])
    return Felt(log.t, s, Recorder(observer, first).rows(log["q_m"], before)["wrench_hat"][:, :3])


def followed(path: Path, p) -> np.ndarray:
    """Places of `path` that a tool at points p (n, 3) m in W came by, never falling.  (n,) m.

    Raises
    ------
    LogError
        it does not come to where the first feed begins, or from there to the end.
    """
    p = np.asarray(p, float)
    feeds = np.flatnonzero(~path.rapid & (path.length > 0))
    total = float(path.s0[-1])
    begin = float(path.s0[feeds[0]]) if len(feeds) else 0.0
    s = np.linspace(begin, total, max(2, int(np.ceil((total - begin) / EACH)) + 1))
    i, u = path.locate(s)
    points = path.point(i, np.minimum(u, path.length[i]))
    off = norm(p - points[0])
    if not off.min() < NEAR:
        raise LogError(
            "the tool is never where this program's first feed begins", value=f"{1e3 * off.min():.3g} mm beside it",
            limit=f"{1e3 * NEAR:g} mm", cure="is it the log of this program, and its zero the machine's?",
        )  # fmt: skip
    # what stands at the place more than once stands there last before it goes on
    row, k, ahead = int(np.argmax(off < NEAR)), 0, max(2, round(AHEAD / (s[1] - s[0])))
    out = np.full(len(p), begin)
    for j in range(row, len(p)):
        away = norm(p[j] - points[k : k + ahead + 1])
        best = int(np.argmin(away))
        if away[best] < NEAR:
            k += best
        out[j] = s[k]
    if s[k] < total - NEAR:
        raise LogError(
            "the tool leaves this program's path, or the log ends before it", value=f"{1e3 * s[k]:.4g} mm along it",
            limit=f"{1e3 * total:.4g} mm", cure="is it the log of this program?",
        )  # fmt: skip
    return _between(s, points, out, p, row)


def _between(s, points, found, p, row) -> np.ndarray:
    """Places to better than their grid: along the straight lines between them."""
    k = np.searchsorted(s, found)
    a, b = points[np.maximum(k - 1, 0)], points[np.minimum(k + 1, len(s) - 1)]
    way = b - a
    size = np.maximum(norm(way), 1e-12)
    more = np.clip(((p - points[k]) * way).sum(1) / size, -(s[1] - s[0]), s[1] - s[0])
    near = norm(p - points[k]) < NEAR
    refined = np.where(near, found + more, found)
    refined[:row] = found[0]
    return np.clip(np.maximum.accumulate(refined), s[0], s[-1])
