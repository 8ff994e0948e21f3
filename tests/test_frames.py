"""Rotations, quaternions and rotation vectors: each the inverse or the derivative of another, in SX and in NumPy."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from numpy.testing import assert_allclose

from gough import frames

RNG = np.random.default_rng(0)
ABC = np.concatenate([RNG.uniform(-np.pi, np.pi, (200, 3)) * [1, 0.5, 1], np.zeros((1, 3))])


def symbolic(f, size):
    s = ca.SX.sym("s", size)
    compiled = ca.Function("f", [s], [f(s)])
    return lambda value: np.array(compiled(value)).squeeze()


def hamilton(p, q):
    """p q by scalar and vector parts."""
    return np.r_[p[0] * q[0] - p[1:] @ q[1:], p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])]


def expm(K):
    """Matrix exponential by squaring its Taylor series: the oracle of the rotation vector."""
    A, out, term = K / 1024, np.eye(3), np.eye(3)
    for n in range(1, 12):
        term = term @ A / n
        out = out + term
    for _ in range(10):
        out = out @ out
    return out


@pytest.mark.parametrize(
    ("sym", "num", "size"),
    [
        (frames.rotation_of_abc, frames.rotation_of_abc_np, 3),
        (frames.rotation_of_quaternion, frames.rotation_of_quaternion_np, 4),
    ],
)
def test_symbolic_and_numpy_forms_are_one_function(sym, num, size):
    f = symbolic(sym, size)
    for value in np.random.default_rng(1).normal(size=(50, size)):
        assert_allclose(f(value), num(value), atol=1e-14)


def test_rotations_are_orthogonal_with_determinant_one():
    R = frames.rotation_of_abc_np(ABC)
    assert_allclose(R @ np.swapaxes(R, -1, -2), np.broadcast_to(np.eye(3), R.shape), atol=1e-15)
    assert_allclose(np.linalg.det(R), 1, rtol=1e-14)


def test_angles_come_back_from_the_rotation():
    assert_allclose(
        frames.abc_of_rotation_np(frames.rotation_of_abc_np(ABC)), ABC, atol=1e-13 / np.cos(ABC[:, 1]).min()
    )


def test_angles_of_a_rotation_are_those_of_the_numpy_form_also_at_gimbal_lock():
    f = symbolic(lambda flat: frames.abc_of_rotation(ca.reshape(flat, 3, 3).T), 9)
    locked = np.array([[0.7, b, -1.9] for b in (np.pi / 2, -np.pi / 2)])
    for R in frames.rotation_of_abc_np(np.concatenate([ABC, locked])):
        assert_allclose(f(R.ravel()), frames.abc_of_rotation_np(R), rtol=0, atol=1e-14)


@pytest.mark.parametrize("b", [np.pi / 2, -np.pi / 2, np.pi / 2 - 1e-9, -np.pi / 2 + 1e-9])
def test_at_gimbal_lock_the_angles_still_make_the_same_rotation(b):
    for a, c in np.random.default_rng(2).uniform(-3, 3, (20, 2)):
        R = frames.rotation_of_abc_np([a, b, c])
        again = frames.abc_of_rotation_np(R)
        assert np.isfinite(again).all()
        assert_allclose(frames.rotation_of_abc_np(again), R, atol=1e-7)  # a and c differ by rounding / cos b
        if abs(b) == np.pi / 2:
            assert again[2] == 0, "c is zero by rule"


def test_quaternion_of_a_rotation_is_its_inverse_for_every_angle():
    """Including half turns, where the usual formula by the trace divides by zero."""
    quat = np.random.default_rng(3).normal(size=(500, 4))
    quat[:3] = np.eye(4)[1:]  # half turns about x, y, z
    quat[3] = [1e-9, 1, 1, 0]
    quat /= np.linalg.norm(quat, axis=1)[:, None]
    quat[quat[:, 0] < 0] *= -1
    found = frames.quaternion_of_rotation_np(frames.rotation_of_quaternion_np(quat))
    same = np.minimum(np.abs(found - quat).max(1), np.abs(found + quat).max(1))
    assert same.max() < 1e-14 and (found[:, 0] >= 0).all()


def test_the_symbolic_quaternion_of_a_rotation_is_its_inverse_for_every_angle_and_so_is_its_derivative():
    """Turns of every size about every axis, and half turns, where w = 0 and each part in its turn is the largest."""
    quat = np.random.default_rng(5).normal(size=(60, 4)) * np.repeat([[1, 1, 1, 1], [1e-9, 1, 1, 1]], 30, axis=0)
    quat = np.concatenate([quat, np.eye(4), -np.eye(4), np.eye(4) + [1e-3, 0, 0, 0]])
    quat /= np.linalg.norm(quat, axis=1, keepdims=True)
    assert set(np.abs(quat).argmax(1)) == {0, 1, 2, 3}  # all four ways through it
    q = ca.SX.sym("q", 4)
    found = frames.quaternion_of_rotation(frames.rotation_of_quaternion(q))
    back = ca.Function("back", [q], [found, ca.jacobian(found, q)])
    for one in quat:
        there, slope = (np.array(out).squeeze() for out in back(one))
        sign = 1.0 if there @ one > 0 else -1.0  # q and -q are one rotation
        assert there[0] >= 0
        assert_allclose(sign * there, one, atol=1e-15 * 4)  # rounding of a dozen sums of numbers up to 4
        across = np.eye(4) - np.outer(one, one)  # what keeps q a unit quaternion
        assert_allclose(sign * slope @ across, across, atol=1e-14)


def test_quaternion_of_angles_agrees_with_the_rotation_of_angles():
    f = symbolic(frames.quaternion_of_abc, 3)
    for abc in ABC[:50]:
        assert_allclose(frames.rotation_of_quaternion_np(f(abc)), frames.rotation_of_abc_np(abc), atol=1e-15)


def test_product_of_quaternions_is_product_of_rotations():
    p, q = np.random.default_rng(4).normal(size=(2, 4))
    p, q = p / np.linalg.norm(p), q / np.linalg.norm(q)
    pq = np.array(frames.quaternion_product(ca.DM(p), ca.DM(q))).ravel()
    assert_allclose(pq, hamilton(p, q), atol=1e-16)
    R = frames.rotation_of_quaternion_np
    assert_allclose(R(pq), R(p) @ R(q), atol=1e-15)
    assert_allclose(R(np.array(frames.conjugate(ca.DM(p))).ravel()), R(p).T, atol=1e-16)


def test_quaternion_rate_turns_the_rotation_at_w():
    """R' = skew(w) R along q' = (0, w) q / 2."""
    q, w = ca.SX.sym("q", 4), ca.SX.sym("w", 3)
    R = frames.rotation_of_quaternion(q)
    Rd = ca.reshape(ca.jtimes(ca.vec(R), q, frames.quaternion_rate(q, w)), 3, 3)
    f = ca.Function("f", [q, w], [Rd - frames.skew(w) @ R])
    for value in np.random.default_rng(5).normal(size=(20, 4)):
        assert_allclose(np.array(f(value / np.linalg.norm(value), [0.3, -1.2, 2.0])), 0, atol=1e-14)


def test_spin_is_E_times_the_angle_rates():
    """R' R' from the derivative of the rotation, and E' from the derivative of E."""
    abc, rate = ca.SX.sym("abc", 3), ca.SX.sym("rate", 3)
    R = frames.rotation_of_abc(abc)
    Rd = ca.reshape(ca.jtimes(ca.vec(R), abc, rate), 3, 3)
    S = Rd @ R.T
    f = ca.Function("f", [abc, rate], [ca.vertcat(S[2, 1], S[0, 2], S[1, 0])])
    h = 1e-6
    for angles, rates in zip(ABC[:50], np.random.default_rng(6).normal(size=(50, 3)), strict=True):
        E = frames.abc_rate_matrix_np(angles)
        assert_allclose(E @ rates, np.array(f(angles, rates)).ravel(), atol=1e-14)
        difference = (frames.abc_rate_matrix_np(angles + h * rates) - frames.abc_rate_matrix_np(angles - h * rates)) / (
            2 * h
        )
        assert_allclose(
            frames.abc_rate_matrix_dot_np(angles, rates), difference, atol=1e-8
        )  # h^2 |rate|^3 and 1e-16 / h


@pytest.mark.parametrize("angle", [0.0, 1e-300, 1e-12, 1e-9, 1e-4, 1.9e-4, 2.1e-4, 1e-3, 1.0, 3.0, np.pi - 1e-9])
def test_rotation_vectors_are_the_exponential_and_its_inverse(angle):
    exp, log = symbolic(frames.quaternion_of_rotation_vector, 3), symbolic(frames.rotation_vector_of_quaternion, 4)
    for d in np.random.default_rng(7).normal(size=(10, 3)):
        r = angle * d / np.linalg.norm(d)
        K = np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])
        R, quat = frames.rotation_of_vector_np(r), exp(r)
        assert_allclose(R, expm(K), atol=2e-13)  # ten squarings lose three digits
        assert_allclose(frames.rotation_of_quaternion_np(quat), R, atol=1e-15)
        for back in (log(quat), log(-quat), frames.rotation_vector_np(R)):
            # near a half turn the vector is a square root of what the matrix knows
            assert_allclose(back, r, rtol=1e-12, atol=1e-15 if angle < 3.1 else 1e-7)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1.9e-4, 2.1e-4, 0.5])
def test_derivatives_of_exp_and_log_are_finite_and_right_even_at_zero(angle):
    """Observers and gradients differentiate through them: d exp = r / 2 and d log = 2 at the identity."""
    r, q = ca.SX.sym("r", 3), ca.SX.sym("q", 4)
    exp, log = frames.quaternion_of_rotation_vector(r), frames.rotation_vector_of_quaternion(q)
    dexp = ca.Function("f", [r], [ca.jacobian(exp, r)])
    chain = ca.Function("f", [r], [ca.jacobian(ca.substitute(log, q, exp), r)])
    value = angle * np.array([0.6, -0.64, 0.48])
    assert_allclose(np.array(chain(value)), np.eye(3), atol=1e-12)
    if angle == 0:
        assert_allclose(np.array(dexp(value)), np.vstack([np.zeros(3), np.eye(3) / 2]), atol=1e-16)


def test_nan_is_not_turned_into_an_angle():
    for f in (frames.rotation_of_abc_np, frames.rotation_of_vector_np, frames.abc_rate_matrix_np):
        assert np.isnan(f(np.array([0.1, np.nan, 0.2]))).any()
    assert np.isnan(symbolic(frames.rotation_vector_of_quaternion, 4)([np.nan, 0, 0, 0])).any()


def test_leading_axes_are_rows():
    abc = ABC[:24].reshape(2, 3, 4, 3)
    R = frames.rotation_of_abc_np(abc)
    assert R.shape == (2, 3, 4, 3, 3) and np.array_equal(R[1, 2, 3], frames.rotation_of_abc_np(abc[1, 2, 3]))
    assert frames.quaternion_of_rotation_np(R).shape == (2, 3, 4, 4)
    assert frames.rotation_vector_np(R).shape == abc.shape
