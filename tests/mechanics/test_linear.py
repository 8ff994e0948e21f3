"""The solvers written out in SX, against LAPACK."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from gough.mechanics.linear import clip, determinant_6, solve_spd, solve_square, solve_square_transposed


def function(f, *shapes):
    symbols = [ca.SX.sym(f"x{i}", *shape) for i, shape in enumerate(shapes)]
    compiled = ca.Function("f", symbols, [f(*symbols)])
    return lambda *values: np.array(compiled(*values))


def with_condition(rng, n, kappa):
    """A random matrix with singular values from 1 to 1 / kappa."""
    U, _, V = np.linalg.svd(rng.normal(size=(n, n)))
    return U @ np.diag(np.geomspace(1, 1 / kappa, n)) @ V


@pytest.mark.parametrize("n", [1, 2, 3, 6, 9])
@pytest.mark.parametrize("kappa", [1.0, 1e3, 1e6])
def test_solve_spd_is_backward_stable(n, kappa):
    """The residual is rounding whatever the condition, as for every Cholesky-like elimination (Higham, 10.1)."""
    rng = np.random.default_rng(n)
    solve = function(solve_spd, (n, n), (n, 2))
    for _ in range(20):
        A = with_condition(rng, n, kappa**0.5)
        M, b = A @ A.T, rng.normal(size=(n, 2))
        x = solve(M, b)
        assert np.abs(M @ x - b).max() <= 1e-14 * n * np.abs(M).max() * np.abs(x).max()


def test_solve_spd_reads_only_the_lower_triangle():
    rng = np.random.default_rng(0)
    A = rng.normal(size=(5, 5))
    M, b = A @ A.T + np.eye(5), rng.normal(size=(5, 1))
    spoiled = np.tril(M) + np.triu(np.full((5, 5), 7.0), 1)
    solve = function(solve_spd, (5, 5), (5, 1))
    assert np.array_equal(solve(spoiled, b), solve(M, b))


@pytest.mark.parametrize("kappa", [1.0, 30.0, 1e3])
def test_solve_square_loses_no_more_than_the_square_of_the_condition(kappa):
    rng = np.random.default_rng(1)
    forward, transposed = (function(f, (6, 6), (6, 1)) for f in (solve_square, solve_square_transposed))
    for _ in range(50):
        J, x = with_condition(rng, 6, kappa), rng.normal(size=(6, 1))
        for solve, A in ((forward, J), (transposed, J.T)):
            error = np.linalg.norm(solve(J, A @ x) - x) / np.linalg.norm(x)
            assert error <= 1e-15 * 20 * kappa**2


def test_a_singular_system_gives_no_finite_number_that_could_pass_for_an_answer():
    solve = function(solve_spd, (3, 3), (3, 1))
    assert not np.isfinite(solve(np.diag([1.0, 0.0, 1.0]), np.ones((3, 1)))).all()


def test_determinant_agrees_with_numpy_and_survives_zero_pivots():
    rng = np.random.default_rng(2)
    det = function(determinant_6, (6, 6))
    for _ in range(200):
        A = rng.normal(size=(6, 6))
        scale = np.prod(np.linalg.norm(A, axis=1))  # Hadamard's bound
        assert abs(det(A).item() - np.linalg.det(A)) <= 1e-14 * scale
    for order in ([1, 0, 2, 3, 4, 5], [1, 2, 3, 4, 5, 0], [5, 4, 3, 2, 1, 0], [3, 4, 5, 0, 1, 2]):
        P = np.eye(6)[order]  # zeros on the diagonal: elimination without pivoting divides by zero
        assert det(P).item() == round(np.linalg.det(P))
    assert det(np.ones((6, 6))).item() == 0


@pytest.mark.parametrize(
    ("x", "wanted"), [(-2.0, -1.0), (-1.0, -1.0), (0.3, 0.3), (3.0, 3.0), (np.inf, 3.0), (-np.inf, -1.0)]
)
def test_clip_holds_within_the_limits(x, wanted):
    assert function(lambda x: clip(x, -1.0, 3.0), (1, 1))(x).item() == wanted


def test_clip_lets_nan_through():
    """fmin and fmax would make a limit of it: a torque limit must not hide a NaN."""
    assert np.isnan(function(lambda x: clip(x, -1.0, 3.0), (1, 1))(np.nan)).item()
    both = function(lambda x, low: clip(x, low, -low), (3, 1), (3, 1))([0.0, np.nan, -9.0], [-1.0, -1.0, -1.0])
    assert both[0] == 0 and np.isnan(both[1]) and both[2] == -1
