"""Circles: radial error over the angle and what the circular tests of ISO 230-4 ask of it.

The names are those of the standard's circular tests (terminology of 2022), computed from their public definitions:

    radial error            signed distance from the programmed circle, outside +                       (1)
    mean radial error       its mean over the angle                                                      (2)
    circular error          range of the distances from the centre of the least-squares circle            (3)
    bi-directional          (3) over the clockwise and the counter-clockwise run together                (4)

Over the angle means: every part of the circle counts alike, however slowly the tool passed it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..errors import LogError
from ..program.segments import cross, dot, norm


class Circularity(NamedTuple):
    """One circle run by the tool.  Lengths in m, angles in rad."""

    id: int
    line: int
    radius: float  # programmed
    feed: float
    ccw: bool
    angle: np.ndarray  # (n,) in the circle's plane, from x towards y of W as near as the plane allows
    radial_error: np.ndarray  # (n,) (1)
    mean_radial_error: float  # (2)
    largest_radial_error: float
    smallest_radial_error: float
    circular_error: float  # (3)
    center_error: tuple[float, float]  # centre of the least-squares circle, in the plane
    radius_error: float  # radius of the least-squares circle less the programmed one


def circularity(p, circle: Mapping) -> Circularity:
    """Evaluate tool positions p (n, 3) m on a circle given by id, line, center (3,), radius, normal (3,), feed, ccw.

    Raises
    ------
    LogError
        fewer than three positions, or not finite.
    """
    p = np.asarray(p, float)
    if len(p) < 3 or not np.isfinite(p).all():
        raise LogError("a circle needs three or more finite positions", value=str(len(p)))
    first, second = plane_axes(np.asarray(circle["normal"], float))
    d = p - np.asarray(circle["center"], float)
    xy = np.stack([dot(d, first), dot(d, second)], -1)
    angle = np.arctan2(xy[:, 1], xy[:, 0])
    radial = np.hypot(xy[:, 0], xy[:, 1]) - circle["radius"]
    weight = _share_of_angle(angle)
    center, radius = least_squares_circle(xy, weight)
    about = np.hypot(*(xy - center).T)
    return Circularity(
        int(circle["id"]),
        int(circle["line"]),
        float(circle["radius"]),
        float(circle["feed"]),
        bool(circle["ccw"]),
        angle,
        radial,
        float(weight @ radial),
        float(radial.max()),
        float(radial.min()),
        float(about.max() - about.min()),
        (float(center[0]), float(center[1])),
        float(radius - circle["radius"]),
    )


def circles(log) -> list[Circularity]:
    """Every circle of a log that has at least three rows.

    Raises
    ------
    LogError
        the log does not say which rows are on a circle.
    """
    rows, p = log["circle"], log["x"][:, :3]
    return [circularity(p[rows == c["id"]], c) for c in log.info.get("circles", []) if (rows == c["id"]).sum() >= 3]


def bidirectional_error(runs: Sequence[Circularity]) -> float:
    """Circular error (4) of several runs of one circle taken together, m.

    Raises
    ------
    LogError
        the runs are not of one radius.
    """
    if len({round(run.radius, 9) for run in runs}) != 1:
        raise LogError("the runs of a bi-directional circular error have one radius")
    angle = np.concatenate([run.angle for run in runs])
    r = np.concatenate([run.radial_error + run.radius for run in runs])
    xy = r[:, None] * np.stack([np.cos(angle), np.sin(angle)], -1)
    weight = np.concatenate([_share_of_angle(run.angle) for run in runs]) / len(runs)
    center, _ = least_squares_circle(xy, weight)
    about = np.hypot(*(xy - center).T)
    return float(about.max() - about.min())


def least_squares_circle(xy, weight):
    """Centre (2,) and radius of the circle of least squared distances from xy (n, 2), by Gauss-Newton steps."""
    center, radius = np.zeros(2), float(weight @ np.hypot(*xy.T))
    for _ in range(30):
        d = xy - center
        r = np.hypot(*d.T)
        J = np.column_stack([d / r[:, None], np.ones(len(r))])  # of the fitted distance by centre and radius
        step = np.linalg.lstsq(J * np.sqrt(weight)[:, None], (r - radius) * np.sqrt(weight), rcond=None)[0]
        center, radius = center + step[:2], radius + step[2]
        if np.abs(step).max() <= 1e-15 * radius:
            break
    return center, radius


def plane_axes(normal):
    """Two unit axes of the plane with that normal: W's x laid into it, and the one a quarter turn on seen from W's +z.

    A circle run clockwise and one run counter-clockwise have the same axes, so their plots lie on each other.
    """
    up = normal if normal[2] >= 0 else -normal
    first = np.array([1.0, 0.0, 0.0]) - up[0] * up
    if norm(first) < 0.1:  # the plane stands across x
        first = np.array([0.0, 1.0, 0.0]) - up[1] * up
    first = first / norm(first)
    return first, cross(up, first)


def _share_of_angle(angle):
    """Share of each sample of the angle passed, summing to 1.  (n,)."""
    step = np.abs(np.diff(np.unwrap(angle)))
    share = np.concatenate([step, [0.0]]) + np.concatenate([[0.0], step])
    total = share.sum()
    return share / total if total > 0 else np.full(len(angle), 1 / len(angle))
