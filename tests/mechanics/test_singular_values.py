"""Singular values and eigenvalues written out against LAPACK."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from gough.kernel.rows import compile_rows
from gough.mechanics.singular_values import extremes, singular_values


def found(matrices, function):
    A = ca.SX.sym("A", *matrices.shape[1:])
    rows = compile_rows(ca.Function("values", [A], [function(A)]))
    return rows(np.swapaxes(matrices, 1, 2).reshape(len(matrices), -1))[0]


def spread(rng, count, n, decades):
    """Random matrices whose singular values spread over `decades`."""
    U, V = (np.linalg.qr(rng.standard_normal((count, n, n)))[0] for _ in range(2))
    return U * 10 ** rng.uniform(-decades, 0, (count, 1, n)) @ V


@pytest.mark.parametrize("n", [2, 3, pytest.param(6, marks=pytest.mark.full)])
def test_singular_values_are_those_of_lapack_small_ones_too(n):
    A = spread(np.random.default_rng(n), 20_000, n, 6)
    wanted = np.linalg.svd(A, compute_uv=False)
    # LAPACK's own error is some eps times the largest value, 1e6 times the smallest: 1e-9 of it at most
    np.testing.assert_allclose(-np.sort(-found(A, singular_values), axis=-1), wanted, rtol=1e-9)


def test_equal_columns_and_zeros_have_their_values():
    A = np.stack([np.eye(3), np.zeros((3, 3)), np.ones((3, 3)), np.diag([2.0, 0.0, 1.0])])
    values = -np.sort(-found(A, singular_values), axis=-1)
    np.testing.assert_allclose(values, [[1, 1, 1], [0, 0, 0], [3, 0, 0], [2, 1, 0]], atol=1e-15)


def test_extremes_are_the_ends_of_the_spectrum():
    A = np.random.default_rng(1).standard_normal((20_000, 3, 3))
    A = A + np.swapaxes(A, 1, 2)
    A[0], A[1], A[2] = 0, np.eye(3), np.ones((3, 3))
    ends = found(A, lambda A: ca.vertcat(*extremes(A)))
    np.testing.assert_allclose(ends, np.linalg.eigvalsh(A)[:, [0, -1]], atol=1e-13)
