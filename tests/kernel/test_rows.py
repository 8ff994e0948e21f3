"""Rows: one function on many rows, shapes and bits."""

import casadi as ca
import numpy as np
import pytest

from gough.errors import InputError
from gough.kernel import compile_rows

from .examples import random_function


def mixed():
    """Inputs and outputs of awkward sizes, a matrix among them."""
    a, b, m = ca.SX.sym("a", 3), ca.SX.sym("b"), ca.SX.sym("m", 3, 4)
    return ca.Function(
        "mixed", [a, b, m], [ca.mtimes(m.T, a) * b, ca.vertcat(*[ca.sin(i * b) for i in range(17)]), ca.dot(a, a)]
    )


def arrays(n, seed=0):
    rng = np.random.default_rng(seed)
    return rng.normal(size=(n, 3)), rng.normal(size=(n, 1)), rng.normal(size=(n, 12))


@pytest.mark.parametrize("lanes", [1, 2, 4, 8, "auto"])
def test_rows_agree_with_numpy(lanes):
    a, b, m = arrays(101)
    product, sines, square = compile_rows(mixed(), lanes=lanes)(a, b, m)
    matrices = m.reshape(-1, 4, 3).transpose(0, 2, 1)  # by columns
    np.testing.assert_allclose(product, np.einsum("nij,ni->nj", matrices, a) * b, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(sines, np.sin(b * np.arange(17)), rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(square[:, 0], (a**2).sum(axis=1), rtol=1e-12)


@pytest.mark.parametrize("lanes", [1, 8])
def test_the_bits_of_a_row_depend_neither_on_how_many_there_are_nor_on_its_place(lanes):
    f = compile_rows(random_function(1), lanes=lanes)
    x = np.random.default_rng(2).normal(size=(67, 5))
    whole = f(x)[0]
    for n in (1, 2, 7, 8, 9, 16, 66):
        assert np.array_equal(f(x[:n])[0], whole[:n])
        assert np.array_equal(f(x[-n:])[0], whole[-n:])
    order = np.random.default_rng(3).permutation(67)
    assert np.array_equal(f(x[order])[0], whole[order])


def test_long_arrays_are_worked_off_in_pieces(monkeypatch):
    from gough.kernel import rows

    x = np.random.default_rng(2).normal(size=(1003, 5))
    f = compile_rows(random_function(1))
    whole = f(x)[0]
    monkeypatch.setattr(rows, "CHUNK", 10 * f.operations)
    assert np.array_equal(f(x)[0], whole)


def test_one_row_serves_all_rows():
    a, b, m = arrays(20)
    f = compile_rows(mixed())
    for together, repeated in zip(f(a, b, m[0]), f(a, b, np.tile(m[0], (20, 1))), strict=True):
        assert np.array_equal(together, repeated)
    alone = f(a[0], b[0], m[0])
    assert [y.shape for y in alone] == [(1, 4), (1, 17), (1, 1)]


def test_views_and_integers_are_taken_as_they_are():
    x = ca.SX.sym("x", 2)
    f = compile_rows(ca.Function("f", [x], [2 * x]))
    table = np.arange(24.0).reshape(6, 4)
    assert np.array_equal(f(table[::2, 1:3])[0], 2 * table[::2, 1:3])
    assert np.array_equal(f([[1, 2], [3, 4]])[0], [[2, 4], [6, 8]])


def test_no_rows_give_no_rows():
    assert [y.shape for y in compile_rows(mixed())(*arrays(0))] == [(0, 4), (0, 17), (0, 1)]


def test_a_row_of_nan_stays_alone():
    f = compile_rows(random_function(5))
    x = np.random.default_rng(2).normal(size=(30, 5))
    clean = f(x)[0]
    x[11] = np.nan
    spoiled = f(x)[0]
    rest = np.arange(30) != 11
    assert np.array_equal(spoiled[rest], clean[rest])


def test_nothing_is_written_outside_the_results():
    """Guards around the memory: rows of 17 are no multiple of 8 lanes."""
    f = compile_rows(mixed(), lanes=8)
    a, b, m = arrays(8)
    outputs = [np.full((10, size), 7.0) for size in f.outputs]
    f._engine.run([a, b, m], [y[1:9] for y in outputs], 8)
    assert all((y[[0, 9]] == 7.0).all() and not (y[1:9] == 7.0).any() for y in outputs)


def test_the_interpreter_gives_the_same():
    a, b, m = arrays(9)
    for native, interpreted in zip(
        compile_rows(mixed())(a, b, m), compile_rows(mixed(), native=False)(a, b, m), strict=True
    ):
        np.testing.assert_allclose(native, interpreted, rtol=1e-12, atol=1e-14)


def test_wrong_shapes_are_named():
    f = compile_rows(mixed())
    a, b, m = arrays(5)
    with pytest.raises(InputError, match="mixed takes 3 arrays, got 2"):
        f(a, b)
    with pytest.raises(InputError, match=r"mixed takes \(N, 12\) or \(12,\) as argument 2, got \(5, 3, 4\)"):
        f(a, b, m.reshape(5, 3, 4))
    with pytest.raises(InputError, match="equally many rows, got 5 in argument 0, 4 in argument 1"):
        f(a, b[:4], m)


def test_a_function_without_inputs_and_one_without_outputs_run():
    x = ca.SX.sym("x", 0)
    assert compile_rows(ca.Function("f", [], [ca.SX(3.0)]))()[0].tolist() == [[3.0]]
    assert [y.shape for y in compile_rows(ca.Function("f", [x], [x]))(np.empty((4, 0)))] == [(4, 0)]
