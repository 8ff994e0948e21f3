"""The largest ball around a pose in which everything stays >= 0: the least first exit over all directions.

The ball of radius r is the union of the rays of length r, so it is free if and only if no ray leaves before r: its
radius is the minimum over directions d of the first exit along d.  Directions all over the sphere are sampled, and each
limit that is met near the minimum is followed from its best directions: with r(d) the root of its margin along d, and
two angles p of d,

    p <- p - H^-1 g,    g, H of the parabola through nine directions around d, ever closer                          (8)

until the least r stands to rounding (an error e of the direction is one of r e^2 / 2).  At last the way to the point
found is searched for its first exit as any other (first_exit.py).  A minimum that lies between samples of the sphere,
7 degrees apart, and is nowhere seen from them would be overlooked.  docs/theory/maps.md, section 5.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .first_exit import first_exits, possible_dips

DIRECTIONS = 600
_RADII = 12  # samples of a ray
_BEYOND = 1.15  # rays are looked at so much farther than the least exit known
_NEAR = 1.1  # limits met within so much of the least are followed
_STARTS = 2  # of each limit
_SEARCHED = 40  # rays on which a limit may dip between samples
_ROUNDS = 8
_ROOT = 1e-12  # margins are shares: what rounding leaves of one, some 1e-14, with room
_STENCIL = np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)], float)
# values at the nine -> 1, x, y, x^2, x y, y^2 by least squares
_FIT = np.linalg.pinv(
    np.stack([np.ones(9), *_STENCIL.T, _STENCIL[:, 0] ** 2, _STENCIL.prod(1), _STENCIL[:, 1] ** 2], 1)
)

# (directions (N, 3) unit, distance (N,)) -> margins (N, k)
Field = Callable[[np.ndarray, np.ndarray], np.ndarray]


def sphere(count: int) -> np.ndarray:
    """Directions (count, 3) evenly over the sphere, by the golden angle."""
    k = np.arange(count) + 0.5
    z, phi = 1 - 2 * k / count, np.pi * (1 + np.sqrt(5)) * k
    level = np.sqrt(1 - z * z)
    return np.stack([level * np.cos(phi), level * np.sin(phi), z], -1)


def largest_ball(field: Field, known: float, step: float) -> tuple[float, np.ndarray, np.ndarray]:
    """Radius, the direction (3,) in which it touches, and the margins (k,) just behind.

    `known` is an exit that some direction is known to have: the radius is not above it.
    """
    d = sphere(DIRECTIONS)
    r = known * _BEYOND * np.arange(1, _RADII + 1) / _RADII
    m = field(np.repeat(d, _RADII, 0), np.tile(r, len(d))).reshape(len(d), _RADII, -1)
    at_start = field(d[:1], np.zeros(1))
    starts, limits, radii = _starts(d, r, m)
    rays = [int(np.argmin(_crossing(r, m)[1].min(-1)))]
    # where a limit may dip between samples the ray is searched as a way
    rays += [i for i, row in enumerate(m) if len(possible_dips(np.concatenate([at_start, row])))][:_SEARCHED]
    best, touch, behind = min((_first(field, d[ray], known, step) for ray in rays), key=lambda one: one[0])
    if len(starts):
        d_end, r_end = _followed(field, starts, limits, radii)
        order = np.argsort(r_end)
        for k in order[:8]:
            if not r_end[k] < min(best, np.inf):
                break
            found = _first(field, d_end[k], known, step)
            if found[0] < best:
                best, touch, behind = found
    return best, touch, behind


def _first(field: Field, d, known, step):
    """The first exit along a direction."""
    s, behind = first_exits(lambda _, s: field(np.tile(d, (len(s), 1)), s), 1, step, known * _BEYOND)
    return float(s[0]), d, None if behind is None else behind[0]


def _crossing(r, m) -> tuple[np.ndarray, np.ndarray]:
    """Along each ray and for each limit: whether it is met, and where about; inf where not.  (N, k)."""
    negative = m < 0
    met, k = negative.any(1), negative.argmax(1)
    behind = np.take_along_axis(m, k[:, None], 1)[:, 0]
    before = np.take_along_axis(m, np.maximum(k - 1, 0)[:, None], 1)[:, 0]
    with np.errstate(invalid="ignore", divide="ignore"):
        part = np.where(k > 0, before / (before - behind), 1.0)
    where = r[np.maximum(k - 1, 0)] + np.nan_to_num(part, nan=1.0) * (r[1] - r[0])
    return met, np.where(met, np.where(k > 0, where, r[0]), np.inf)


def _starts(d, r, m):
    """Directions, limits and radii to start (8) from: the best rays of each limit that is met near the least."""
    met, where = _crossing(r, m)
    out = []
    for i in np.flatnonzero(met.any(0)):
        rays = np.argsort(where[:, i], kind="stable")
        taken = []
        for ray in rays[: DIRECTIONS // 4]:
            if not where[ray, i] <= _NEAR * where.min() or len(taken) == _STARTS:
                break
            if all(d[ray] @ d[other] < np.cos(0.5) for other in taken):
                taken.append(ray)
                out.append((d[ray], i, where[ray, i]))
    if not out:
        return np.zeros((0, 3)), np.zeros(0, int), np.zeros(0)
    starts, limits, radii = zip(*out, strict=True)
    return np.array(starts), np.array(limits), np.array(radii)


def _followed(field: Field, d, limit, r) -> tuple[np.ndarray, np.ndarray]:
    """Eq. (8) for all starts side by side.  Directions (n, 3) and radii (n,)."""
    width = np.full(len(d), 0.06)
    for _ in range(_ROUNDS):
        u, v = _tangents(d)
        angles = width[:, None, None] * _STENCIL
        around = _turned(d, u, v, angles)
        roots = _roots(field, around.reshape(-1, 3), np.repeat(limit, 9), np.repeat(r, 9)).reshape(-1, 9)
        c = roots @ _FIT.T
        step, trusted = _newton(c)
        ahead = _turned(d, u, v, (width[:, None] * step)[:, None])[:, 0]
        there = _roots(field, ahead, limit, r)
        lowest = np.nanargmin(np.where(np.isnan(roots), np.inf, roots), 1)
        least = roots[np.arange(len(d)), lowest]
        better = trusted & (there <= least)
        d = np.where(better[:, None], ahead, around[np.arange(len(d)), lowest])
        r = np.where(better, there, np.where(np.isnan(least), r, least))
        # closer where the parabola holds; no closer where the least is still at the rim
        width = np.maximum(np.where(better | (lowest == 4), 0.2 * width, width), 1e-5)
    return d, r


def _newton(c) -> tuple[np.ndarray, np.ndarray]:
    """The least of the parabolas c (n, 6) in units of the stencil, within 1.5 of it, and whether they have one."""
    g, xx, xy, yy = c[:, 1:3], 2 * c[:, 3], c[:, 4], 2 * c[:, 5]
    det = xx * yy - xy * xy
    sound = (det > 0) & (xx > 0)
    with np.errstate(invalid="ignore", divide="ignore"):
        step = -np.stack([yy * g[:, 0] - xy * g[:, 1], xx * g[:, 1] - xy * g[:, 0]], -1) / det[:, None]
    step = np.where(sound[:, None], step, 0.0)
    size = np.linalg.norm(step, axis=-1, keepdims=True)
    return np.where(size > 1.5, step * 1.5 / np.maximum(size, 1.5), step), sound


def _tangents(d) -> tuple[np.ndarray, np.ndarray]:
    helper = np.eye(3)[np.abs(d).argmin(-1)]
    u = np.cross(d, helper)
    u /= np.linalg.norm(u, axis=-1, keepdims=True)
    return u, np.cross(d, u)


def _turned(d, u, v, angles) -> np.ndarray:
    """d (n, 3) leaning by angles (n, j, 2) along u and v.  (n, j, 3), unit."""
    out = d[:, None] + angles[..., :1] * u[:, None] + angles[..., 1:] * v[:, None]
    return out / np.linalg.norm(out, axis=-1, keepdims=True)


def _roots(field: Field, d, limit, near) -> np.ndarray:
    """Where the margin `limit` is 0 along directions d (n, 3), by the secant from `near` (n,); NaN: not found."""
    index = np.arange(len(d))
    a, b = near * (1 - 1e-4), near.copy()
    fa, fb = field(d, a)[index, limit], field(d, b)[index, limit]
    for _ in range(8):
        with np.errstate(invalid="ignore", divide="ignore"):
            s = b - fb * (b - a) / (fb - fa)
        stays = (np.abs(fb) <= 1e-16) | (b == a) | (fb == fa)
        s = np.where(stays, b, np.clip(s, 0.5 * near, 1.5 * near))
        moved = np.abs(s - b) > 1e-15 * near
        a, fa = np.where(stays, a, b), np.where(stays, fa, fb)
        b, fb = s, field(d, s)[index, limit]
        if not moved.any():
            break
    return np.where(np.abs(fb) <= _ROOT, b, np.nan)
