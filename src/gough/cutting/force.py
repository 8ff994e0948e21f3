"""Force of an end mill, exact along its helix: no slices.

Frame C at the tool: x along the feed, z along the tool from tip to spindle, y = z x x, left of the feed.  A tooth at
the angle phi, counted clockwise from y, stands at (sin phi, cos phi) D / 2; on an element dz of its edge eq. (1) of
coefficients.py makes the force on the tool

    dF_x = -dF_t cos phi - dF_r sin phi,   dF_y = dF_t sin phi - dF_r cos phi,   dF_z = dF_a                        (2)

and the moment (D / 2) dF_t about z.  The chip of a tooth whose radius is greater by d than that of the tooth before,
on a tool that went on by (a, b) in x and y since then, is

    h = a sin phi + b cos phi + d,      a = f, b = 0 for a feed of f a tooth on a rigid machine                     (3)

cut where the tooth is within the stock, phi_1 <= phi <= phi_2 (mod 2 pi).  At height z, phi = theta - k z with theta
the angle at the tip: with z from z_1 to z_2, dz = z_2 - z_1 and m = theta - k (z_1 + z_2) / 2, the integrals are

    S_n = integral of sin(n phi) = dz sin(n m) sinc(n k dz / 2),   C_n with cos,   S_0 := 0, C_0 = dz               (4)

    H_c = a S_2 / 2 + b (C_0 + C_2) / 2 + d C_1, H_s = a (C_0 - C_2) / 2 + b S_2 / 2 + d S_1, H = a S_1 + b C_1 + d C_0
    F_x = -K_tc H_c - K_te C_1 - K_rc H_s - K_re S_1,     F_z = K_ac H + K_ae C_0
    F_y =  K_tc H_s + K_te S_1 - K_rc H_c - K_re C_1,     M_z = (D / 2) (K_tc H + K_te C_0)                         (5)

sinc(x) = sin(x) / x keeps (4) exact down to straight flutes.  Without runout (5) is all.  With runout a tooth may miss:
then the next one cuts what it left.  The tooth m places before left the wall at m f sin phi + R_j - R_j-m, so

    h = max(0, min over m = 1 ... N of  m f sin phi + R_j - R_j-m)                                                  (6)

in f sin phi a chain of straight pieces; each is (3) on the angles between its ends.  docs/theory/milling.md derives
(2)-(6).  The functions take `xp`, NumPy or CasADi, and numbers or symbols alike.
"""

from __future__ import annotations

import math

import numpy as np

from .numeric import ARRAYS, clip, sinc

TURNS = 2  # of the flutes within the depth are looked at: `Cutting` refuses more than one
_STRAIGHT = 1e-6  # rad/m: a helix of less is one of so much; over 0.1 m it turns by 1e-7 rad


def lag(xp, tool):
    """k of eq. (4), rad/m: how far a flute turns over a metre of height."""
    return 2 * xp.sin(tool.helix) / (xp.cos(tool.helix) * tool.diameter)


def window(xp, tool, depth, side):
    """phi_1, phi_2 of a radial depth, m, on the side of the wall: -1 right of the feed (down), +1 left (up)."""
    reach = xp.acos(clip(xp, 1 - 2 * depth / tool.diameter, -1.0, 1.0))
    return (math.pi - reach, math.pi + 0.0 * reach) if side < 0 else (0.0 * reach, reach)


def pieces(xp, tool, teeth: int, feed, first, last):
    """Where each tooth cuts which chip, eq. (6): per tooth a list of (a, d, phi_from, phi_to); phi_to < phi_from: none.

    `tool` is the end mill or a view of it, `feed` f in m a tooth, `first` and `last` the angles within the stock.
    """
    if tool.runout is None:
        return [[(feed, 0.0 * feed, first, last)] for _ in range(teeth)]
    pitch = 2 * math.pi / teeth
    # the tooth before stands at the next greater angle: it passed a pitch earlier
    R = [tool.runout * xp.cos(tool.runout_angle - j * pitch) for j in range(teeth)]
    f = xp.fmax(feed, 1e-12)
    out = []
    for j in range(teeth):
        d = {m: R[j] - R[(j + m) % teeth] for m in range(1, teeth + 1)}
        each = []
        for m in range(1, teeth + 1):
            low = xp.fmax(0.0 * f, -d[m] / m)
            high = f + 0.0 * d[m]
            for n in range(1, teeth + 1):
                if n > m:
                    low = xp.fmax(low, (d[m] - d[n]) / (n - m))
                elif n < m:
                    high = xp.fmin(high, (d[n] - d[m]) / (m - n))
            none = high <= low
            rise = [xp.asin(clip(xp, x / f, 0.0, 1.0)) for x in (low, high)]
            for phi_from, phi_to in ((rise[0], rise[1]), (math.pi - rise[1], math.pi - rise[0])):
                phi_from, phi_to = xp.fmax(phi_from, first), xp.fmin(phi_to, last)
                each.append((m * feed, d[m], phi_from, xp.if_else(none, phi_from - 1.0, phi_to)))
        out.append(each)
    return out


def force(xp, tool, K, teeth: int, height, cuts, angle, sideways=0.0):
    """Force on the tool in C and moment about its axis, eqs. (4), (5): F_x, F_y, F_z, M_z in N and N m.

    `cuts` as `pieces` gives it, `height` the axial depth, `angle` that of the spindle; `sideways` is b of eq. (3).
    """
    k = xp.fmax(lag(xp, tool), _STRAIGHT)
    total = [0.0, 0.0, 0.0, 0.0]
    for j, each in enumerate(cuts):
        theta = angle + j * (2 * math.pi / teeth)
        theta = theta - 2 * math.pi * xp.floor(theta / (2 * math.pi))
        for a, d, phi_from, phi_to in each:
            for n in range(TURNS):
                top = clip(xp, (theta + 2 * math.pi * n - phi_from) / k, 0.0, height)
                bottom = clip(xp, (theta + 2 * math.pi * n - phi_to) / k, 0.0, height)
                dz = xp.fmax(top - bottom, 0.0)
                parts = _element(xp, tool, K, a, sideways, d, theta - k * (top + bottom) / 2, dz, k)
                total = [x + y for x, y in zip(total, parts, strict=True)]
    return total


def _element(xp, tool, K, a, b, d, middle, dz, k):
    """Eq. (5) on one stretch of edge of height dz about the angle `middle`."""
    one, two = dz * sinc(xp, k * dz / 2), dz * sinc(xp, k * dz)
    S1, C1 = one * xp.sin(middle), one * xp.cos(middle)
    S2, C2 = two * xp.sin(2 * middle), two * xp.cos(2 * middle)
    along = a * S2 / 2 + b * (dz + C2) / 2 + d * C1  # of h cos phi
    across = a * (dz - C2) / 2 + b * S2 / 2 + d * S1  # of h sin phi
    chip = a * S1 + b * C1 + d * dz  # of h
    return (
        -K.tangential * along - K.tangential_edge * C1 - K.radial * across - K.radial_edge * S1,
        K.tangential * across + K.tangential_edge * S1 - K.radial * along - K.radial_edge * C1,
        K.axial * chip + K.axial_edge * dz,
        tool.diameter / 2 * (K.tangential * chip + K.tangential_edge * dz),
    )


def mean_force(tool, K, height, feed, depth, side: float = -1.0) -> np.ndarray:
    """Mean over a turn of F_x, F_y, F_z, M_z, in closed form: any helix, any runout.  (..., 4) N, N m.

    `feed` m a tooth and radial depth m broadcast.  The mean over a turn of an element does not know where its tooth
    started, so the helix has no part in it: the height over 2 pi times the integral of eqs. (2), (3) over the angles
    of each tooth; docs/theory/milling.md, eq. (7).
    """
    feed, depth = np.broadcast_arrays(np.asarray(feed, float), np.asarray(depth, float))
    total = np.zeros((*feed.shape, 4))
    for each in pieces(ARRAYS, tool, tool.teeth, feed, *window(ARRAYS, tool, depth, side)):
        for a, d, first, last in each:
            on = last > first
            total += np.where(on[..., None], _up_to(tool, K, a, d, last) - _up_to(tool, K, a, d, first), 0.0)
    return height / (2 * np.pi) * total


def _up_to(tool, K, a, d, phi):
    """Integral over phi of eq. (2) with the chip (3), b = 0, a unit of height.  (..., 4)."""
    s1, c1 = np.sin(phi), np.cos(phi)
    # integrals of sin, cos, sin^2, sin cos
    S, C, SS, SC = -c1, s1, phi / 2 - np.sin(2 * phi) / 4, s1 * s1 / 2
    along, across, chip = a * SC + d * C, a * SS + d * S, a * S + d * phi  # of h cos phi, h sin phi, h
    return np.stack(
        [
            -K.tangential * along - K.tangential_edge * C - K.radial * across - K.radial_edge * S,
            K.tangential * across + K.tangential_edge * S - K.radial * along - K.radial_edge * C,
            K.axial * chip + K.axial_edge * phi,
            tool.diameter / 2 * (K.tangential * chip + K.tangential_edge * phi),
        ],
        -1,
    )


def forces(tool, K, height, feed, depth, angle, side: float = -1.0) -> np.ndarray:
    """F_x, F_y, F_z, M_z on arrays that broadcast: feed m a tooth, radial depth m, spindle angle rad.  (..., 4)."""
    feed, depth, angle = np.broadcast_arrays(*(np.asarray(x, float) for x in (feed, depth, angle)))
    cuts = pieces(ARRAYS, tool, tool.teeth, feed, *window(ARRAYS, tool, depth, side))
    return np.stack([x * np.ones(feed.shape) for x in force(ARRAYS, tool, K, tool.teeth, height, cuts, angle)], -1)
