"""Limits of a hexaglide at a pose: reach of the legs, ends of the rails, carriages on one rail, cones, singular poses.

Equations (1) and (2) are those of machine/hexaglide.py.  The reach of the legs stands first: where one cannot reach,
what follows is no number.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

_SQUARE = "nearly square across its rail"


def rail_margins(m, p, z):
    """`Machine.margins` of a hexaglide `m`."""
    home = m.coordinates_of(p, p.home)
    _, e, q, u, c = m.reach(p, z)
    _, e_home, q_home, u_home, _ = m.reach(p, home)
    limits, carriages, legs = p.limits, m.joint_names, m.leg_names
    names = [f"{leg}: cannot reach" for leg in legs]
    names += [f"{carriage}: beyond the {end} of its rail" for end in ("start", "end") for carriage in carriages]
    names += [f"{leg}: {_SQUARE}" for leg in legs]
    values = [
        (m.lengths(p) - ca.sqrt(m.from_rails(p, z)[3])).T,
        q.T - limits.travel[0],
        limits.travel[1] - q.T,
        ca.fabs(c).T - ca.sin(limits.lean),
    ]
    for i, j in m.rails.pairs:
        names.append(f"carriages {i + 1} and {j + 1}: too close")
        apart = _apart(p, e, q, i, j)
        values.append(ca.sign(_apart(p, e_home, q_home, i, j)) * apart - limits.gap)
    for more, found in (
        m.cone_margins(p, legs, ("carriage", "platform"), z, home, u, u_home),
        m.singular_margin(p, z),
    ):
        names += more
        values += found
    return tuple(names), ca.vertcat(*values)


def _apart(p, e, q, i, j):
    """How far the joint of carriage j is ahead of that of carriage i on their rail, m."""
    offset = ca.SX(p.rails.point[j, :]) - ca.SX(p.rails.point[i, :])
    return ca.dot(ca.vec(offset), e[:, i]) + q[j] - q[i]


def rail_limit_told(m, index: int, margin: float) -> tuple[str, str, str] | None:
    """Rule, value and limit of `rail_margins` that is `margin` < 0 at `index`, in words; None: not of the rails."""
    limits, name = m.limits, m.limit_names[index]
    if index < 6:
        l = float(np.broadcast_to(m.legs.length, 6)[index])
        rule = f"{m.leg_names[index]} cannot reach: misses by {-1e3 * margin:.4g} mm"
        return rule, f"{l - margin:.6g} m from joint to rail", f"{l:g} m"
    if index < 18:
        bound = limits.travel[0 if index < 12 else 1]
        return name, f"{bound + margin if index < 12 else bound - margin:.8g} m", f"{bound:g} m"
    if index < 24:
        lean = np.degrees(np.arcsin(np.clip(np.sin(limits.lean) + margin, 0, 1)))
        return name, f"{lean:.4g} deg", f"{np.degrees(limits.lean):g} deg"
    if index < 24 + len(m.rails.pairs):
        return name, f"{limits.gap + margin:.6g} m", f"{limits.gap:g} m"
    return None


def possible_places(m, q):
    """Rows (N,) of places q (N, 6) m that some pose may have, and `why(row)` says what is wrong with another.

    Two legs and the platform between them close a chain from carriage to carriage: |S_i S_j| <= l_i + l_j + |B_i B_j|.
    """
    S, B = m.rails.point + m.rails.direction * q[..., None], m.joints.platform
    l = np.broadcast_to(m.legs.length, 6)
    i, j = np.triu_indices(6, 1)
    reach = l[i] + l[j] + np.linalg.norm(B[i] - B[j], axis=-1)
    apart = np.linalg.norm(S[:, i] - S[:, j], axis=-1)

    def why(row):
        k = int(np.flatnonzero(apart[row] > reach)[0])
        rule = f"are {apart[row, k]:.4g} m apart, farther than legs and platform reach ({reach[k]:.4g} m)"
        return rule, f"carriages {i[k] + 1} and {j[k] + 1}"

    return (apart <= reach).all(-1), why
