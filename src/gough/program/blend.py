"""Blends: a quintic in place of a corner, as far beside the corner as the tolerance P allows.

From d before the corner C to d behind it, with tangents T and curvature vectors K there
(docs/theory/course.md, eqs. (4) to (6)):

    p(0) = p_0,  p'(0) = 2d T_0,  p''(0) = 4d^2 K_0,   p(1) = p_1,  p'(1) = 2d T_1,  p''(1) = 4d^2 K_1           (1)

Between two lines that turn by phi
    p = C - d T_0 g(t) + d T_1 g(1 - t),   g = 1 - 2t + 2t^3 - t^4                                                 (2)
    |p(1/2) - C| = 2 d g(1/2) sin(phi/2) = 0.375 d sin(phi/2)                                                      (3)
and the middle is where corner and blend are farthest apart, so P gives d.  For all others d is found by measuring:
the blend's distance from the path, and the corner's from the blend.

The angles a b c of a blend are quintics of its length with the values, rates and bends of the path at its ends; the
tool axis stays within its own tolerance of the path's axis at the closest point.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..frames import rotation_of_abc_np
from .blocks import LINE, REST
from .curves import Curves, hermite
from .segments import cross, dot, norm

CUSP = np.radians(150)  # a sharper turn is no corner to round: the tool nearly comes back
SMALLEST = 1e-6  # m, of d: a shorter blend is nothing a machine can follow
_KINK = 1e-7  # rad, of a turn that counts: above the rounding of directions of moves of 10 um
_ARM = 0.1  # m up the tool, as in feed.py: where a kink of the angles is seen
_LONGEST = 7.5  # m per rad of turn: the curvature of such a blend is 0.1 1/m, there is no use in a longer one
_JUMP = 1e-3  # 1/m, of a curvature that counts: a radius of a kilometre
_SAMPLES = 16
_BUMP = 0.8  # of the tolerance: bumps rise by up to 3 % of it between the samples, ridges between both legs by more
_FINER = 3  # times four
_SAFE = 0.99  # of the tolerance, for what is missed between the places measured
_ROUNDS = 40
_ROWS = 8192


class Blends(NamedTuple):
    """Blends of n junctions, in order."""

    after: np.ndarray  # (n,) the block before the junction
    back: np.ndarray  # (n,) m cut off its end
    ahead: np.ndarray  # (n,) m cut off the start of the next
    curves: Curves  # n curves
    angles: np.ndarray  # (n, 6, 3) coefficients of a b c by length / whole length
    turn: np.ndarray  # (n,) rad, of the direction at the junction

    def chosen(self, k) -> Blends:
        """The blends k (n,) alone."""
        return Blends(*(column.chosen(k) if isinstance(column, Curves) else column[k] for column in self))


def blend(base, sharp, tolerance, axis_tolerance, smooth: bool = False) -> Blends:
    """The blends at the junctions of the path `base`.

    `sharp` is the programmed path, block for block: what deviations are measured against.  tolerance (m,) m and
    axis_tolerance (m,) rad belong to the junctions behind the blocks; 0: none.  With `smooth` a jump of the curvature
    is a corner too.
    """
    i, wanted, turn = _wanted(base, tolerance, axis_tolerance, smooth)
    d = np.zeros(len(base) + 1)
    d[i + 1] = wanted
    back = _shared(d, base.length)[i]
    keep = back >= SMALLEST
    i, back, turn = i[keep], back[keep], turn[keep]
    measured = (base.kind[i] != LINE) | (base.kind[i + 1] != LINE)
    turning = _turns(base, i) | _turns(base, i + 1)
    rows = np.flatnonzero(measured | turning)
    for k in range(0, len(rows), _ROWS):
        part = rows[k : k + _ROWS]
        back[part] = _shrunk(base, sharp, i[part], back[part], turning[part], tolerance, axis_tolerance)
    keep = back >= SMALLEST
    i, back, turn = i[keep], back[keep], turn[keep]
    back, ahead = _meeting(base, i, back)
    curves = Curves(_curves(base, i, back, ahead))
    return Blends(i, back, ahead, curves, _angles(base, i, back, ahead, curves.length), turn)


def _wanted(base, tolerance, axis_tolerance, smooth):
    """Junctions with a corner that may be blended, the d that eq. (3) and its likes give, and the turn.  (n,) each."""
    moving = (base.kind != REST) & (base.length > 2 * SMALLEST)
    same_tool = (base.tool[1:] == base.tool[:-1]).all(1)
    i = np.flatnonzero(moving[:-1] & moving[1:] & same_tool & (tolerance[:-1] > 0))
    ends, starts = base.length[i], np.zeros(len(i))
    T0, T1 = base.tangent(i, ends), base.tangent(i + 1, starts)
    turn = np.arctan2(norm(cross(T0, T1)), dot(T0, T1))
    kink = base.angle_rate(i + 1, starts) - base.angle_rate(i, ends)
    P, axis = tolerance[i], axis_tolerance[i]
    with np.errstate(divide="ignore"):
        d = P / (0.375 * np.sin(turn / 2))
        # the angles' blend has the form of (2): its middle is 0.1875 d times the jump of the rate away
        d = np.minimum(d, axis / (0.1875 * _axis_rate(base, i, kink)))
    kinked = norm(kink) * _ARM > _KINK
    corner, longest = (turn > _KINK) | kinked, np.where(kinked, np.inf, _LONGEST * turn)
    curved = np.flatnonzero((base.kind[i] != LINE) | (base.kind[i + 1] != LINE))
    if len(curved):
        K0, K1 = base.bend(i[curved], ends[curved]), base.bend(i[curved] + 1, starts[curved])
        jump, most = norm(K1 - K0), np.maximum(norm(K0), norm(K1))
        if smooth:
            corner[curved] |= jump > _JUMP
            longest[curved] = np.where(jump > _JUMP, np.inf, longest[curved])
        with np.errstate(divide="ignore"):
            # where the search begins: a jump of the curvature alone leaves the path by jump d^2 / 93, as measured,
            # and beyond half a radian of an arc the quintic is no longer like it
            d[curved] = np.minimum(1.25 * d[curved], np.minimum(np.sqrt(93 * P[curved] / jump), 0.5 / most))
    d = np.minimum(d, longest)
    keep = corner & (turn <= CUSP)
    i, turn = i[keep], turn[keep]
    return i, np.minimum(d[keep] * (1 - 1e-9), np.minimum(base.length[i], base.length[i + 1])), turn


def _axis_rate(base, i, rate):
    """How fast the tool axis turns at the end of the blocks i when a b c change at `rate`.  (n,) rad/m."""
    out = np.zeros(len(i))
    rows = np.flatnonzero(rate.any(1))
    abc = base.angles(i[rows], base.extent[i[rows]])
    h = 1e-6 / norm(rate[rows])[:, None]  # rad: central differences err by h^2, rounding by 1e-16 / h
    step = _axis(abc + h * rate[rows]) - _axis(abc - h * rate[rows])
    out[rows] = norm(step) / (2 * h[:, 0])
    return out


def _axis(abc):
    return rotation_of_abc_np(abc)[..., 2]


def _shared(d, length):
    """What each junction may take of both its blocks: what it wants, d (m + 1,), the next junctions willing.  (m,).

    A block long enough for both its junctions gives both what they want; else one that wants less than half gets it
    and the other the rest; else each gets half.
    """
    front, rear = d[:-1], d[1:]
    half = length / 2
    fits = front + rear <= length
    for_rear = np.where(fits | (rear <= half), rear, np.where(front <= half, length - front, half))
    for_front = np.where(fits | (front <= half), front, np.where(rear <= half, length - rear, half))
    return np.minimum(for_rear, np.append(for_front[1:], 0.0))


def _meeting(base, i, d):
    """Where less than 10 nm of a block would be left its blends meet, or take it whole.  back, ahead (n,) m."""
    front, rear = np.zeros(len(base)), np.zeros(len(base))
    rear[i], front[i + 1] = d, d
    left = base.length - front - rear
    near = left < 1e-8
    front = np.where(near & (front > 0), np.where(rear > 0, front + left / 2, base.length), front)
    rear = np.where(near & (rear > 0), base.length - front, rear)
    return rear[i], front[i + 1]


def _curves(base, i, back, ahead):
    """Coefficients of eq. (1).  (n, 6, 3)."""
    p0, T0, K0 = base.frame(i, base.length[i] - back)
    p1, T1, K1 = base.frame(i + 1, ahead)
    a, b = 2 * back[:, None], 2 * ahead[:, None]
    return hermite(p0, p1, a * T0, b * T1, a * a * K0, b * b * K1)


def _angles(base, i, back, ahead, length):
    u, L = base.length[i] - back, length[:, None]
    k = hermite(
        base.angles(i, u), base.angles(i + 1, ahead),
        base.angle_rate(i, u) * L, base.angle_rate(i + 1, ahead) * L,
        base.angle_bend(i, u) * L**2, base.angle_bend(i + 1, ahead) * L**2,
    )  # fmt: skip
    # angles that stand still do so exactly
    k[:, 1:] *= (base.turn[i].any(1) | base.turn[i + 1].any(1))[:, None, None]
    return k


def _turns(base, i):
    bent = np.zeros(len(i), bool) if base.bent is None else base.bent[i] >= 0
    return base.turn[i].any(1) | bent


def _shrunk(base, sharp, i, d, turning, tolerance, axis_tolerance):
    """The largest d, up to a per cent or so, with which tip and axis stay in their tolerances; 0 where none does."""
    d, going = d.copy(), np.arange(len(i))
    for _ in range(_ROUNDS):
        part = i[going]
        share = _share(base, sharp, part, d[going], turning[going], tolerance[part], axis_tolerance[part]) / _SAFE
        wrong = np.flatnonzero(~(share <= 1))
        if not len(wrong):
            return d
        going, share = going[wrong], share[wrong]
        # between d, as a corner's deviation grows, and d^2, as that of a jump of the curvature
        d[going] *= np.where(share < 4, share**-0.7 * 0.995, 0.4)
    d[going] = 0.0
    return d


def _share(base, sharp, i, d, turning, tolerance, axis_tolerance):
    """How much of their tolerances the blends behind the blocks i use: the blend's distance from the path, the
    corner's from the blend, the angle of the tool axis to the path's at the closest point.  (n,)."""
    every = np.arange(len(i))
    curves = Curves(_curves(base, i, d, d))
    angles = _angles(base, i, d, d, curves.length)
    corner = sharp.point(i, sharp.length[i])
    lo, hi = np.maximum(sharp.length[i] - 1.5 * d, 0.0), np.minimum(1.5 * d, sharp.length[i + 1])

    def at(n, t):
        """The shares that the places t (k,) of the blends n (k,) use, and how far the corner is from there."""
        j, p, end, zero = i[n], curves.at(n, t), sharp.length[i[n]], np.zeros(len(n))
        u, v = sharp.closest(j, p, lo[n], end, end), sharp.closest(j + 1, p, zero, hi[n], zero)
        before, behind = norm(p - sharp.point(j, u)), norm(p - sharp.point(j + 1, v))
        least = np.minimum(before, behind)
        share = least / tolerance[n]
        k = np.flatnonzero(turning[n])
        if len(k):
            axis = _axis(_polynomial(angles[n[k]], curves.arc_length(n[k], t[k]) / curves.length[n[k]]))
            close = least[k] + 0.02 * tolerance[n[k]]  # where two places are about as near, both count
            for block, along, distance in ((j, u, before), (j + 1, v, behind)):
                angle = norm(axis - _axis(sharp.angles(block[k], along[k])))
                twist = np.where(distance[k] <= close, angle, 0.0) / axis_tolerance[n[k]]
                share[k] = np.maximum(share[k], twist)
        return share, norm(p - corner[n])

    samples = [at(every, np.full(len(i), k / _SAMPLES)) for k in range(1, _SAMPLES)]
    shares = np.stack([np.zeros(len(i)), *(share for share, _ in samples), np.zeros(len(i))], 1)
    most = np.maximum(shares.max(1), np.min([away for _, away in samples], 0) / tolerance)
    # bumps between the samples, where what is found may otherwise pass
    bump = (shares[:, 1:-1] >= shares[:, :-2]) & (shares[:, 1:-1] >= shares[:, 2:]) & (shares[:, 1:-1] > _BUMP)
    n, k = np.nonzero(bump & (most <= _SAFE)[:, None])
    top, best, step = (k + 1) / _SAMPLES, shares[n, k + 1], 1 / _SAMPLES
    for _ in range(_FINER if len(n) else 0):
        step, middle = step / 4, top
        for side in (-3, -2, -1, 1, 2, 3):
            t = middle + side * step
            share = at(n, t)[0]
            top, best = np.where(share > best, t, top), np.maximum(share, best)
    np.maximum.at(most, n, best)
    return most


def _polynomial(c, x):
    """Values (n, 3) of the quintics c (n, 6, 3) at x (n,)."""
    x = x[:, None]
    return c[:, 0] + x * (c[:, 1] + x * (c[:, 2] + x * (c[:, 3] + x * (c[:, 4] + x * c[:, 5]))))
