"""Normal force along a path out of a recorded run, and the tilts that it asks for, place by place.

Only rows in which the tool moves on at an even speed count: where it starts and stops its own inertia is in the
estimate.  What is in the air of the same run is subtracted; means are taken over `window` m; what is below `least` is
no cut.  The profile of tilts is then thinned to the corners of a chain of straight lines (Douglas and Peucker), so
that a wall of one depth is one line.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..errors import ExperimentError, LogError
from ..program.path import Path
from ..program.segments import cross, dot, norm

STEP = 0.5e-3  # m, of the profile
EVEN = 0.02  # share of the speed about it, by which a row may move slower or faster
WAIT = 0.1  # s behind an uneven row, in which the estimate still settles
AHEAD = 0.01  # s before one


class Profile(NamedTuple):
    """Normal force along a path: y of the feed's frame, to the left of the feed."""

    s: np.ndarray  # (n,) m
    force: np.ndarray  # (n,) N, tared, 0 where nothing is cut
    air: float  # N, what was subtracted
    vector: np.ndarray  # (n, 3) N, the whole force in x y z of the feed's frame, tared alike; `force` is its y


def profile_of(
    path: Path, t, s_r, force_W, *, air: tuple[float, float] | None, least: float = 10.0, window: float = 4e-3
) -> Profile:
    """The profile of forces on the tool force_W (n, 3) N at times t (n,) s and places s_r (n,) m of `path`, as placed.

    `air` is where the tool cuts air for sure, m; None: nothing is subtracted.

    Raises
    ------
    LogError
        nothing moves at an even speed; the air is not in the run; the force never rises above `least`.
    """
    t, s_r, force_W = (np.asarray(a, float) for a in (t, s_r, force_W))
    good = _even(t, s_r)
    if good.sum() < 2:
        raise LogError("the tool never moves at an even speed: no force can be told", value=f"{len(t)} rows")
    local = np.stack([dot(force_W, e) for e in frame(path, s_r)], -1)
    offset = np.zeros(3)
    if air is not None:
        in_air = good & (s_r >= air[0]) & (s_r <= air[1])
        if not in_air.any():
            raise ExperimentError(
                "no row of the log lies in the air cut at an even speed", key="--air",
                value=f"{1e3 * air[0]:g} to {1e3 * air[1]:g} mm", limit=f"{1e3 * s_r.max():g} mm of path",
            )  # fmt: skip
        offset = local[in_air].mean(0)
    s = np.arange(0.0, path.s0[-1] + STEP / 2, STEP)
    order = np.argsort(s_r[good], kind="stable")
    place, value = s_r[good][order], local[good][order] - offset
    total = np.concatenate([np.zeros((1, 3)), np.cumsum(value, 0)])
    low, high = np.searchsorted(place, s - window / 2), np.searchsorted(place, s + window / 2)
    count = (high - low)[:, None]
    vector = np.where(count > 0, (total[high] - total[low]) / np.maximum(count, 1), 0.0)
    vector[np.abs(vector[:, 1]) < least] = 0.0
    mean = vector[:, 1]
    if not mean.any():
        most = float(np.abs(value[:, 1]).max())
        raise LogError(
            "the force never rises: there is nothing to compensate", value=f"at most {most:.3g} N in a row",
            limit=f"a mean of {least:g} N over {1e3 * window:g} mm",
        )  # fmt: skip
    return Profile(s, mean, float(offset[1]), vector)


def frame(path: Path, s) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x, y of the feed's frame and the tool's axis at path lengths s (n,) m.  (n, 3) each; 0 along the tool."""
    i, u = path.locate(np.clip(s, 0.0, path.s0[-1]))
    u = np.minimum(u, path.extent[i])
    axis = path.rotation(path.angles(i, u))[..., 2]
    tangent = path.tangent(i, np.minimum(u, path.length[i]))
    x = tangent - dot(tangent, axis)[:, None] * axis
    size = norm(x)[:, None]
    x = np.where(size > 1e-9, x / np.where(size > 1e-9, size, 1.0), 0.0)
    return x, cross(axis, x), axis


def _even(t, s_r) -> np.ndarray:
    """Rows in which the tool moves on as fast as in all of the time WAIT before and AHEAD behind.  (n,) bool."""
    speed = np.gradient(s_r, t)
    period = float(np.median(np.diff(t)))
    back, ahead = (max(1, round(span / period)) for span in (WAIT, AHEAD))
    padded = np.concatenate([np.zeros(back), speed, np.zeros(ahead)])
    near = np.lib.stride_tricks.sliding_window_view(padded, back + 1 + ahead)
    return (speed > 0) & (near.min(1) >= (1 - EVEN) * speed) & (near.max(1) <= (1 + EVEN) * speed)


def thinned(s, value, tolerance: float) -> np.ndarray:
    """Rows (k,) of a chain of straight lines that leaves value (n,) over s (n,) by `tolerance` >= 0 at most."""
    keep = np.zeros(len(s), bool)
    keep[[0, -1]] = True
    todo = [(0, len(s) - 1)]
    while todo:
        a, b = todo.pop()
        if b - a < 2:
            continue
        line = value[a] + (value[b] - value[a]) * (s[a : b + 1] - s[a]) / (s[b] - s[a])
        off = np.abs(value[a : b + 1] - line)
        k = int(np.argmax(off))
        if off[k] > tolerance:
            keep[a + k] = True
            todo += [(a, a + k), (a + k, b)]
    return np.flatnonzero(keep)
