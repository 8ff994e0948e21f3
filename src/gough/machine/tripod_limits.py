"""Limits of a 3-PRS at its coordinates: ends of the rails, angles of the links, cones of the joints, singular poses."""

from __future__ import annotations

import casadi as ca
import numpy as np

from ..errors import InputError, Problem
from .limits import COINCIDENT
from .platform import SINGULAR
from .tripod_parts import SIDES, stands

PHI_B = "near a singularity: the links do not hold the platform, condition number of phi_b"


def margins_of(m, p, z):
    """`Machine.margins` of a tripod `m`."""
    limits = p.limits
    values = [z[:3] - limits.travel[0], limits.travel[1] - z[:3], z[3:] - limits.angle[0], limits.angle[1] - z[3:]]
    if limits.cone is not None:
        home = m.coordinates_of(p, p.home)
        in_T = [_links_in_T(m, p, y) for y in (z, home)]
        values.append(ca.sum1(in_T[0] * in_T[1]).T - ca.cos(limits.cone))
    values += [inverse_condition(m.closed(p, z).phi_b, p.link.length) - 1 / limits.condition]
    values += [m.determinant_of(p, z) - limits.determinant]
    return names_of(limits), ca.vertcat(*values)


def names_of(limits) -> tuple[str, ...]:
    """What each margin says when it is negative."""
    names = [f"slider {i}: beyond the {end} of its rail" for end in ("start", "end") for i in (1, 2, 3)]
    names += [f"link {i}: angle beyond the {end}" for end in ("least", "greatest") for i in (1, 2, 3)]
    if limits.cone is not None:
        names += [f"link {i}: platform joint beyond its cone" for i in (1, 2, 3)]
    return (*names, PHI_B, SINGULAR)


def _links_in_T(m, p, z):
    R = m.tool_motion_of(p, z, ca.SX(6, 1)).rotation
    return R.T @ m.links(p, z)


def inverse_condition(A, length):
    """1 / (L |A^-1|), Frobenius's norm, of phi_b (3, 3) m: |det A| / (L |adj A|), 0 where A is singular.

    The condition number is taken against L, what a link's turning does at best: links square to their rails make all
    of phi_b vanish, which |A| |A^-1| would not tell.
    """
    rows = [A[i, :].T for i in range(3)]
    adj = ca.horzcat(*[ca.cross(rows[(i + 1) % 3], rows[(i + 2) % 3]) for i in range(3)])
    return ca.fabs(ca.dot(rows[0], adj[:, 0])) / (length * ca.norm_fro(adj))


def told(m, index: int, margin: float) -> tuple[str, str, str]:
    """Rule, value and limit in words of the margin `index` that is `margin` < 0."""
    limits, name = m.limits, names_of(m.limits)[index]
    if name == SINGULAR:
        return name, f"{limits.determinant + margin:.3g} of it", f"{limits.determinant:g}"
    if name == PHI_B:
        left = margin + 1 / limits.condition
        return name, f"{1 / left:.3g}" if left > 0 else "infinite", f"{limits.condition:g}"
    if index < 6:
        bound = limits.travel[index // 3]
        return name, f"{bound - margin if index // 3 else bound + margin:.8g} m", f"{bound:g} m"
    if index < 12:
        bound = limits.angle[index // 3 - 2]
        angle = bound - margin if index // 3 == 3 else bound + margin
        return name, f"{np.degrees(angle):.4g} deg", f"{np.degrees(bound):g} deg"
    cosine = np.cos(limits.cone) + margin
    return name, f"{np.degrees(np.arccos(np.clip(cosine, -1, 1))):.4g} deg", f"{np.degrees(limits.cone):g} deg"


def check_home(m) -> None:
    """Refuse a tripod whose joints are no triangle, or that cannot stand at home within its limits.

    Raises
    ------
    InputError
        a problem for each.
    """
    wrong, t = [], m.joints.platform
    sides = np.linalg.norm(t - np.roll(t, -1, axis=0), axis=1)
    area = np.linalg.norm(np.cross(t[1] - t[0], t[2] - t[0])) / 2
    if sides.min() < COINCIDENT or area < 1e-6 * sides.max() ** 2:
        raise InputError("the platform's joints are no triangle", key="joints.platform", value=f"area {area:.3g} m2")
    for key, span in (("joints.platform", sides.max()), ("rails.point", np.ptp(m.rails.point, axis=0).max())):
        if span > 50:
            wrong.append(Problem("spans a strange distance", key=key, value=f"{span:g} m", cure="did you mean mm?"))
    if np.linalg.norm(m.platform.center - t.mean(0)) > 5 * sides.max():
        value = f"{np.linalg.norm(m.platform.center - t.mean(0)):g} m from its joints"
        wrong.append(Problem(
            "the centre of mass lies far outside the machine", key="platform.center", value=value,
            limit=f"{5 * sides.max():.3g} m", cure="did you mean mm?",
        ))  # fmt: skip
    if np.linalg.norm(m.gravity) > 30:
        value = f"{np.linalg.norm(m.gravity):g} m/s2"
        wrong.append(Problem("gravity is no planet's", key="gravity", value=value, limit="30 m/s2"))
    if wrong:
        raise InputError(problems=wrong)
    found = m.unreachable(m.home)
    if found is not None:
        raise InputError(problems=[_at_home(problem) for problem in found[1].problems])
    _, values = margins_at_home(m)
    for index in np.flatnonzero(~(values >= 0)):
        rule, value, limit = told(m, int(index), float(values[index]))
        wrong.append(
            Problem(f"at home, {rule}", key="home", value=value, limit=limit, cure="change home or the limits")
        )
    if wrong:
        raise InputError(problems=wrong)


def margins_at_home(m) -> tuple[tuple[str, ...], np.ndarray]:
    """Names and values of `margins_of` at home, in NumPy: a machine is made without building an expression."""
    R, _, along = (part[0] for part in stands(m, m.home))
    limits, d, c, L = m.limits, m.rails.direction, m.rails.across, m.link.length
    theta = np.arccos(along / L)
    S = ((m.home + m.joints.platform @ R.T - m.rails.point) * d).sum(1) - L * np.sin(theta)
    turned = L * (np.cos(theta)[:, None] * d - np.sin(theta)[:, None] * c)
    T, phi_b = m.joints.platform @ R.T, np.zeros((3, 3))
    for k, (i, j) in enumerate(SIDES):
        side = (T[i] - T[j]) / np.linalg.norm(T[i] - T[j])
        phi_b[k, i], phi_b[k, j] = side @ turned[i], -side @ turned[j]
    held = 1 / (L * np.linalg.norm(np.linalg.inv(phi_b))) if np.linalg.det(phi_b) else 0.0
    cones = np.zeros(0) if limits.cone is None else np.full(3, 1 - np.cos(limits.cone))
    values = [S - limits.travel[0], limits.travel[1] - S, theta - limits.angle[0], limits.angle[1] - theta, cones,
              [held - 1 / limits.condition], [1 - limits.determinant]]  # fmt: skip
    return names_of(limits), np.concatenate(values)


def _at_home(problem: Problem) -> Problem:
    return Problem(
        f"at home, {problem.rule}", key="home", value=problem.value, limit=problem.limit,
        cure="change home, the rails, the joints or link.length",
    )  # fmt: skip
