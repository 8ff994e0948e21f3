"""What each block of a path allows the feed: speed, acceleration and jerk along it.

With the angles turning by w_k = E(abc) d(abc)/du, u the extent,

    V <= feed, rapid for G0;   V |w_k| <= angular rate;   V^2 |p''| <= a  (towards the centre, as tangentially)
    V^3 |p'''| <= J  (steady motion on a curve)
    A <= a,   A |w_k| + V^2 |w_k'| <= angular acceleration                                                         (2)

A turn at rest runs along its angles: its V and A are those of the angles alone, and its jerk is J times the ratio of
the angular acceleration to a.  docs/theory/feed.md, section 2.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .path import Path


class Limits(NamedTuple):
    """What bounds the feed: rapid m/s, acceleration m/s2, angular_rate rad/s, angular_acceleration rad/s2, jerk m/s3.

    Without a jerk (None) the jerk is not bounded.
    """

    rapid: float
    acceleration: float
    angular_rate: float
    angular_acceleration: float
    jerk: float | None = None


def block_limits(path: Path, limits: Limits) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Speed, acceleration and jerk each block may use, eq. (2).  (m,): m/s, m/s2, m/s3; rad for turns at rest."""
    angular, angular_change = path.turning()
    rest = path.turning_at_rest
    # a turn at rest has no limit along the path, only that of its angles
    speed = np.where(rest, np.where(path.rapid, np.inf, path.feed), np.where(path.rapid, limits.rapid, path.feed))
    acceleration = np.where(rest, np.inf, limits.acceleration)
    jerk = np.full(len(path), np.inf)
    with np.errstate(divide="ignore"):
        speed = np.minimum(speed, limits.angular_rate / angular)
        speed = np.minimum(speed, np.sqrt(limits.acceleration / path.sharpest()))
        if limits.jerk is not None:
            jerk = limits.jerk * np.where(rest, limits.angular_acceleration / limits.acceleration, 1.0)
            speed = np.minimum(speed, np.cbrt(limits.jerk / path.third()))
        # two axes turning at once accelerate each other; half of the angular acceleration is kept for that
        speed = np.minimum(speed, np.sqrt(limits.angular_acceleration / (2 * angular_change)))
        spare = limits.angular_acceleration - np.where(angular_change > 0, speed**2 * angular_change, 0.0)
        acceleration = np.minimum(acceleration, spare / angular)
    still = path.extent == 0
    return np.where(still, 0.0, speed), np.where(still, 1.0, acceleration), jerk
