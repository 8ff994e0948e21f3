"""What a corner costs whatever the law, from the machine's equations alone; docs/theory/corner.md.

    e = |dv|^2 cos(phi / 2) / (8 a)     the velocity turned by dv within |dv| / a s, centred on the corner          (2)
    e >= (v sin phi)^2 / (2 a)          neither preview nor lag: before the corner the tool is on the path          (3)

v the feed, phi <= 90 deg the turn of the path, a the acceleration that the motors give.
"""

from __future__ import annotations

import numpy as np

from .corner import FEED, POINTS


def directions() -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors along the two lines.  (3,) each."""
    legs = np.diff(POINTS, axis=0)
    legs = legs / np.linalg.norm(legs, axis=1)[:, None]
    return legs[0], legs[1]


def turn() -> float:
    """phi, the angle between the two lines, rad."""
    first, second = directions()
    return float(np.arctan2(np.linalg.norm(np.cross(first, second)), first @ second))


def jump() -> float:
    """|dv|, m/s."""
    return 2 * FEED * np.sin(turn() / 2)


def previewed(acceleration: float) -> float:
    """Eq. (2): contour error, m, of the shortest previewed turn of the velocity at `acceleration` m/s2."""
    return jump() ** 2 * np.cos(turn() / 2) / (8 * acceleration)


def unseen(acceleration: float) -> float:
    """Eq. (3): the least contour error, m, without preview and without lag."""
    return (FEED * np.sin(turn())) ** 2 / (2 * acceleration)


def straight(true, torque: float) -> float:
    """The acceleration, m/s2, that motors of `torque` N m give the tool along dv at the corner, the tool not turning.

    Friction takes its Coulomb level in every strut, against the motion.
    """
    first, second = directions()
    weight, per = _forces(true, (second - first) / np.linalg.norm(second - first))
    left = _force(true, torque) - _friction(true) - np.sign(per) * weight
    return float((left / np.abs(per)).min())


def greatest(true, torque: float) -> float:
    """The greatest deceleration, m/s2, across the second line that motors of `torque` N m give, the tool free to turn.

    u = J^-T (M a + h) is one to one, so a = M^-1 (J' u - h) is greatest in a corner of the box |u| <= F; friction adds
    its Coulomb level in every strut.
    """
    first, second = directions()
    across = -(first - second * (first @ second))
    c = np.append(across / np.linalg.norm(across), np.zeros(3))
    x = _pose(true)
    M, J = true.mass_matrix(x), true.jacobian(x)
    w = J @ np.linalg.solve(M, c)
    weight = true.inverse_dynamics(x, np.zeros(6), np.zeros(6))
    return float(np.abs(w) @ (_force(true, torque) + _friction(true)) - w @ weight)


def torque_for(true, acceleration_of, wanted: float) -> float:
    """The motor torque, N m, at which `straight` or `greatest` is `wanted` m/s2; both are linear in the torque."""
    low, high = 1e3, 2e3  # where they are the same line as at all torques that carry the machine
    a, b = acceleration_of(true, low), acceleration_of(true, high)
    return low + (wanted - a) * (high - low) / (b - a)


def _pose(true) -> np.ndarray:
    return np.append(true.home[:3] + POINTS[1], true.home[3:])


def _forces(true, direction) -> tuple[np.ndarray, np.ndarray]:
    """Joint forces at rest at the corner, and what 1 m/s2 along `direction` adds.  (n,) N, N s2/m."""
    x, still = _pose(true), np.zeros(6)
    weight = true.inverse_dynamics(x, still, still)
    return weight, true.inverse_dynamics(x, still, np.append(direction, still[:3])) - weight


def _force(true, torque: float) -> float:
    return torque * 2 * np.pi / true.drive.lead


def _friction(true) -> np.ndarray:
    """Coulomb level of every strut at rest at the corner.  (n,) N."""
    x, still = _pose(true), np.zeros(6)
    return true.friction.coulomb * true.reactions(x, still, still).normal
