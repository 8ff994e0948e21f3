"""Rotations, quaternions, twists and axis angles: the only place where conventions are written.

Pose for people     x y z a b c, metres and radians,     R_WT = Rz(c) Ry(b) Rx(a)                                  (1)
Quaternion          w x y z, unit, R(q) u = q u q*                                                                 (2)
Twist               V_WT = [v; w] in W, v the velocity of the origin of T, q' = (0, w) q / 2                        (3)
abc rates           w = E(b, c) [a' b' c'],  E = [Rz(c) Ry(b) ex, Rz(c) ey, ez]                                     (4)
Rotation vector     exp(r) = rotation by |r| about r / |r|;  log is its inverse, |log| <= pi                        (5)

Functions of this page take CasADi SX columns (names without suffix) or NumPy arrays (..., k) (suffix `_np`).
docs/theory/frames.md derives (4).
"""

from __future__ import annotations

import casadi as ca
import numpy as np

# -- symbolic: columns in, columns and matrices out ---------------------------------------------------------------


def skew(u):
    """(3, 3) with skew(u) w = u x w."""
    return ca.vertcat(ca.horzcat(0, -u[2], u[1]), ca.horzcat(u[2], 0, -u[0]), ca.horzcat(-u[1], u[0], 0))


def rotation_of_abc(abc):
    """R = Rz(c) Ry(b) Rx(a), eq. (1).  (3, 3)."""
    ca_, sa, cb, sb, cc, sc = (f(abc[i]) for i in range(3) for f in (ca.cos, ca.sin))
    return ca.vertcat(
        ca.horzcat(cc * cb, cc * sb * sa - sc * ca_, cc * sb * ca_ + sc * sa),
        ca.horzcat(sc * cb, sc * sb * sa + cc * ca_, sc * sb * ca_ - cc * sa),
        ca.horzcat(-sb, cb * sa, cb * ca_),
    )


def rotation_of_quaternion(quat):
    """R(q) of a unit quaternion, eq. (2).  (3, 3)."""
    w, x, y, z = (quat[i] for i in range(4))
    return ca.vertcat(
        ca.horzcat(1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        ca.horzcat(2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        ca.horzcat(2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )


def quaternion_product(p, q):
    """p q, the rotation q first, then p.  (4,)."""
    return ca.vertcat(
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    )


def quaternion_rate(quat, w):
    """q' = (0, w) q / 2 for an angular velocity w in W, eq. (3).  (4,)."""
    return quaternion_product(ca.vertcat(0, w / 2), quat)


def quaternion_of_rotation_vector(r):
    """exp of a rotation vector as a quaternion, eq. (5).  (4,).  Accurate at r = 0, and so is its derivative."""
    half2 = ca.dot(r, r) / 4
    small = half2 < 1e-8  # the series are exact to rounding there: next terms half^4 / 24 < 5e-18
    half = ca.sqrt(ca.if_else(small, 1, half2))  # 1: the branch not taken must not make a NaN of a derivative
    sinc = ca.if_else(small, 1 - half2 / 6, ca.sin(half) / half)
    return ca.vertcat(ca.if_else(small, 1 - half2 / 2, ca.cos(half)), sinc * r / 2)


def rotation_vector_of_quaternion(quat):
    """log of a unit quaternion, eq. (5).  (3,), |.| <= pi.  Accurate at the identity."""
    flip = ca.if_else(quat[0] < 0, -1, 1)  # q and -q are one rotation
    w, u = flip * quat[0], flip * quat[1:]
    sine2 = ca.dot(u, u)
    sine = ca.sqrt(sine2)
    small = sine2 < 1e-8
    # 2 atan2(s, w) / s -> 2 / w (1 - (s / w)^2 / 3) for small s
    return u * ca.if_else(small, 2 / w * (1 - sine2 / (3 * w * w)), 2 * ca.atan2(sine, w) / ca.if_else(small, 1, sine))


def quaternion_of_rotation(R):
    """Unit quaternion w x y z of a rotation (3, 3), w >= 0.  (4,).  Stable for every angle, as is its derivative."""
    trace = R[0, 0] + R[1, 1] + R[2, 2]
    found, best = None, None
    for i in range(4):  # four times the i-th column of q q', and its entry on the diagonal
        if i == 0:
            size = 1 + trace
            column = ca.vertcat(size, R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1])
        else:
            a = i - 1
            b, c = (a + 1) % 3, (a + 2) % 3
            size = 1 + 2 * R[a, a] - trace
            rest = {a: size, b: R[a, b] + R[b, a], c: R[a, c] + R[c, a]}
            column = ca.vertcat(R[c, b] - R[b, c], *[rest[k] for k in range(3)])
        if found is None:
            found, best = column, size
        else:
            better = size > best
            found, best = ca.if_else(better, column, found), ca.if_else(better, size, best)
    quat = found / ca.norm_2(found)
    return ca.if_else(quat[0] < 0, -quat, quat)


def quaternion_of_abc(abc):
    """Quaternion of Rz(c) Ry(b) Rx(a), eq. (1).  (4,)."""

    def about(i, angle):
        return ca.vertcat(ca.cos(angle / 2), *[ca.sin(angle / 2) if j == i else 0 for j in range(3)])

    return quaternion_product(about(2, abc[2]), quaternion_product(about(1, abc[1]), about(0, abc[0])))


def abc_of_rotation(R):
    """a b c of a rotation (3, 3), b in [-pi/2, pi/2], c = 0 where b = +-pi/2.  (3,) rad."""
    level = ca.sqrt(R[0, 0] * R[0, 0] + R[1, 0] * R[1, 0])
    steep = level <= 1e-12
    return ca.vertcat(
        ca.if_else(steep, ca.atan2(-R[1, 2], R[1, 1]), ca.atan2(R[2, 1], R[2, 2])),
        ca.atan2(-R[2, 0], level),
        ca.if_else(steep, 0, ca.atan2(R[1, 0], R[0, 0])),
    )


def conjugate(quat):
    """The inverse rotation.  (4,)."""
    return ca.vertcat(quat[0], -quat[1], -quat[2], -quat[3])


# -- NumPy: leading axes are rows -----------------------------------------------------------------------------------


def rotation_of_abc_np(abc):
    """R = Rz(c) Ry(b) Rx(a), eq. (1).  (..., 3) rad -> (..., 3, 3)."""
    abc = np.asarray(abc, float)
    (ca_, cb, cc), (sa, sb, sc) = np.moveaxis(np.cos(abc), -1, 0), np.moveaxis(np.sin(abc), -1, 0)
    rows = [
        [cc * cb, cc * sb * sa - sc * ca_, cc * sb * ca_ + sc * sa],
        [sc * cb, sc * sb * sa + cc * ca_, sc * sb * ca_ - cc * sa],
        [-sb, cb * sa, cb * ca_],
    ]
    return np.stack([np.stack(row, -1) for row in rows], -2)


def abc_of_rotation_np(R):
    """a b c of a rotation, b in [-pi/2, pi/2], c = 0 where b = +-pi/2.  (..., 3, 3) -> (..., 3) rad."""
    R = np.asarray(R, float)
    b = np.arctan2(-R[..., 2, 0], np.hypot(R[..., 0, 0], R[..., 1, 0]))
    level = np.hypot(R[..., 0, 0], R[..., 1, 0]) > 1e-12
    a = np.where(level, np.arctan2(R[..., 2, 1], R[..., 2, 2]), np.arctan2(-R[..., 1, 2], R[..., 1, 1]))
    c = np.where(level, np.arctan2(R[..., 1, 0], R[..., 0, 0]), 0.0)
    return np.stack([a, b, c], -1)


def abc_rate_matrix_np(abc):
    """E of eq. (4): w = E [a' b' c'].  (..., 3) -> (..., 3, 3)."""
    abc = np.asarray(abc, float)
    cb, sb, cc, sc = np.cos(abc[..., 1]), np.sin(abc[..., 1]), np.cos(abc[..., 2]), np.sin(abc[..., 2])
    one, zero = np.ones_like(cb), np.zeros_like(cb)
    columns = [np.stack(col, -1) for col in ((cc * cb, sc * cb, -sb), (-sc, cc, zero), (zero, zero, one))]
    return np.stack(columns, -1)


def abc_rate_matrix_dot_np(abc, abc_rate):
    """dE/dt of eq. (4), so that w' = E abc'' + E' abc'.  (..., 3), (..., 3) -> (..., 3, 3)."""
    abc, rate = np.broadcast_arrays(np.asarray(abc, float), np.asarray(abc_rate, float))
    cb, sb, cc, sc = np.cos(abc[..., 1]), np.sin(abc[..., 1]), np.cos(abc[..., 2]), np.sin(abc[..., 2])
    bd, cd = rate[..., 1], rate[..., 2]
    zero = np.zeros_like(cb)
    first = np.stack([-sc * cd * cb - cc * sb * bd, cc * cd * cb - sc * sb * bd, -cb * bd], -1)
    second = np.stack([-cc * cd, -sc * cd, zero], -1)
    return np.stack([first, second, np.zeros_like(first)], -1)


def quaternion_of_rotation_np(R):
    """Unit quaternion w x y z of rotations, w >= 0.  (..., 3, 3) -> (..., 4).  Stable for every angle."""
    R = np.asarray(R, float)
    diagonal = np.einsum("...ii->...i", R)
    trace = diagonal.sum(-1)
    # four times the outer product q q'; its column with the largest diagonal entry is the best conditioned
    outer = np.empty(R.shape[:-2] + (4, 4))
    outer[..., 0, 0] = 1 + trace
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        outer[..., i + 1, i + 1] = 1 + 2 * diagonal[..., i] - trace
        outer[..., 0, i + 1] = outer[..., i + 1, 0] = R[..., k, j] - R[..., j, k]
        outer[..., j + 1, k + 1] = outer[..., k + 1, j + 1] = R[..., j, k] + R[..., k, j]
    best = np.argmax(np.einsum("...ii->...i", outer), -1)
    column = np.take_along_axis(outer, best[..., None, None], -1)[..., 0]
    quat = column / np.linalg.norm(column, axis=-1, keepdims=True)
    return np.where(quat[..., :1] < 0, -quat, quat)


def rotation_of_quaternion_np(quat):
    """R(q) of unit quaternions, eq. (2).  (..., 4) -> (..., 3, 3)."""
    w, x, y, z = np.moveaxis(np.asarray(quat, float), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, -1) for row in rows], -2)


def rotation_of_vector_np(r):
    """exp of rotation vectors, eq. (5).  (..., 3) -> (..., 3, 3)."""
    r = np.asarray(r, float)
    angle = np.linalg.norm(r, axis=-1)[..., None, None]
    K = np.zeros(r.shape[:-1] + (3, 3))
    K[..., 2, 1], K[..., 0, 2], K[..., 1, 0] = r[..., 0], r[..., 1], r[..., 2]
    K -= np.swapaxes(K, -1, -2)
    return np.eye(3) + np.sinc(angle / np.pi) * K + 0.5 * np.sinc(angle / (2 * np.pi)) ** 2 * (K @ K)


def rotation_vector_np(R):
    """log of rotations, eq. (5).  (..., 3, 3) -> (..., 3), |.| <= pi."""
    quat = quaternion_of_rotation_np(R)
    sine = np.linalg.norm(quat[..., 1:], axis=-1, keepdims=True)
    safe = np.where(sine > 0, sine, 1.0)
    return np.where(sine > 1e-9, 2 * np.arctan2(sine, quat[..., :1]) / safe, 2.0) * quat[..., 1:]


def quaternion_of_abc_np(abc):
    """Unit quaternion of x-y-z angles, eq. (1).  (..., 3) rad -> (..., 4), w >= 0."""
    return quaternion_of_rotation_np(rotation_of_abc_np(abc))
