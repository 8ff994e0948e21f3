"""The feed along a path: trapezoids with look-ahead, in closed form.

Each block accelerates at a, runs at the speed v_p <= F and decelerates at a:

    v_p^2 = min(F^2, a L + (v_0^2 + v_1^2) / 2)                                  L the block's extent              (1)
    t_a = (v_p - v_0) / a,   t_d = (v_p - v_1) / a,   t_c = (L - (2 v_p^2 - v_0^2 - v_1^2) / 2a) / v_p             (2)

v_0 and v_1, the speeds at the junctions, are the largest that a forward and a backward pass with
v_1^2 <= v_0^2 + 2 a L leave.  At a junction the feed stops where the path has a corner; otherwise, and everywhere with
corner = "constant", it may pass at the lower of the two feeds.  With "constant" the velocity jumps at a corner:
"commanded velocity directions are changed without acceleration/deceleration limits" (the corner test of
garagic-srinivasan-2004).

A block's own limits, with the angles turning by k = d(abc)/ds:
    F <= feed, rapid for G0;  F |w_k| <= angular rate;  F^2 |p''| <= a  (towards the centre, as tangentially)
    a <= acceleration, and a |w_k| + F^2 |w_k'| <= angular acceleration                                            (3)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .path import Path
from .segments import norm

CORNER = np.radians(0.01)  # a change of direction that counts as a corner
_ARM = 0.1  # m up the tool: a turn begins or ends with a corner where a point there would see one


class Limits(NamedTuple):
    """What bounds the feed: rapid m/s, acceleration m/s2, angular_rate rad/s, angular_acceleration rad/s2."""

    rapid: float
    acceleration: float
    angular_rate: float
    angular_acceleration: float


class FeedState(NamedTuple):
    """Where the feed is at n times: block, extent travelled in it, its rate and the rate of that.  (n,)."""

    block: np.ndarray
    u: np.ndarray
    ud: np.ndarray
    udd: np.ndarray


class Feed:
    """The feed profile of a path: times (m + 1,) of the junctions, and for each block (1) and (2).  `duration` s."""

    def __init__(self, path: Path, limits: Limits, corner: str = "stop"):
        self.extent = path.extent
        self.speed, self.acceleration = block_limits(path, limits)
        ends = _junction_speeds(path, self.speed, self.acceleration, corner)
        v0, v1, a, L = ends[:-1], ends[1:], self.acceleration, self.extent
        self.v0, self.v1 = v0, v1
        moving = L > 0
        self.peak = np.minimum(self.speed, np.sqrt(a * L + (v0**2 + v1**2) / 2))
        self.t_up, self.t_down = (self.peak - v0) / a, (self.peak - v1) / a
        left = L - (self.t_up * (v0 + self.peak) + self.t_down * (v1 + self.peak)) / 2
        cruise = np.where(left > 1e-15 * L, left, 0.0)
        self.t_cruise = np.where(moving, cruise / np.where(moving, self.peak, 1.0), path.dwell)
        for name in ("t_up", "t_down"):
            setattr(self, name, np.where(moving & (getattr(self, name) > 0), getattr(self, name), 0.0))
        self.times = np.concatenate([[0.0], np.cumsum(self.t_up + self.t_cruise + self.t_down)])
        self.duration = float(self.times[-1])

    def at(self, t) -> FeedState:
        """Exact position, speed and acceleration at times t (n,).  Before the start and after the end: at rest."""
        i = np.searchsorted(self.times, t, "right") - 1
        after, before = i >= len(self.extent), i < 0
        i = np.where(after, len(self.extent) - 1, np.where(before, 0, i))
        since, until = t - self.times[i], self.times[i + 1] - t
        v0, v1, peak, a, L = (arr[i] for arr in (self.v0, self.v1, self.peak, self.acceleration, self.extent))
        up, down = since < self.t_up[i], until <= self.t_down[i]
        rush = since - self.t_up[i]  # time since the peak speed was reached
        u = np.where(
            up,
            since * (v0 + a * since / 2),
            # from the end backwards, so that a block ends exactly at its end
            np.where(down, L - until * (v1 + a * until / 2), self.t_up[i] * (v0 + peak) / 2 + peak * rush),
        )
        ud = np.where(up, v0 + a * since, np.where(down, v1 + a * until, peak))
        udd = np.where(up, a, np.where(down, -a, 0.0))
        still = after | before | (L == 0)
        u = np.where(after, L, np.where(before | (L == 0), 0.0, np.where(u > L, L, u)))
        return FeedState(i, u, np.where(still, 0.0, ud), np.where(still, 0.0, udd))


def block_limits(path: Path, limits: Limits):
    """Speed and acceleration each block may use, eq. (3).  (m,), (m,): m/s, m/s2; rad/s, rad/s2 for turns at rest."""
    angular, angular_change = path.turning()
    rest = path.turning_at_rest
    # a turn at rest has no limit along the path, only that of its angles
    speed = np.where(rest, np.where(path.rapid, np.inf, path.feed), np.where(path.rapid, limits.rapid, path.feed))
    acceleration = np.where(rest, np.inf, limits.acceleration)
    with np.errstate(divide="ignore"):
        speed = np.minimum(speed, limits.angular_rate / angular)
        speed = np.minimum(speed, np.sqrt(limits.acceleration / path.sharpest()))
        # two axes turning at once accelerate each other; half of the angular acceleration is kept for that
        speed = np.minimum(speed, np.sqrt(limits.angular_acceleration / (2 * angular_change)))
        spare = limits.angular_acceleration - np.where(angular_change > 0, speed**2 * angular_change, 0.0)
        acceleration = np.minimum(acceleration, spare / angular)
    still = path.extent == 0
    return np.where(still, 0.0, speed), np.where(still, 1.0, acceleration)


def _junction_speeds(path: Path, speed, acceleration, corner):
    """The speed at each junction, (m + 1,); zero at both ends."""
    v = np.zeros(len(path) + 1)
    v[1:-1] = np.where(_stops(path, corner), 0.0, np.minimum(speed[:-1], speed[1:]))
    squares, gain = (v * v).tolist(), (2 * acceleration * path.extent).tolist()
    for i in range(len(gain)):
        squares[i + 1] = min(squares[i + 1], squares[i] + gain[i])
    for i in reversed(range(len(gain))):
        squares[i] = min(squares[i], squares[i + 1] + gain[i])
    return np.sqrt(squares)


def _stops(path: Path, corner):
    """At which inner junctions the feed stops.  (m - 1,) bool."""
    every = np.arange(len(path))
    resting = path.length == 0
    stop = resting[:-1] | resting[1:] | (path.rapid[:-1] != path.rapid[1:])
    if corner == "constant":
        return stop
    arrive, leave = path.tangent(every, path.length)[:-1], path.tangent(every, 0 * path.length)[1:]
    sharp = norm(leave - arrive) > 2 * np.sin(CORNER / 2)
    twist = norm(path.turn[1:] - path.turn[:-1]) * _ARM > CORNER
    return stop | sharp | twist
