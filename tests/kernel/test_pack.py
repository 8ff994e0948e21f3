"""Named tuples and their flat vectors."""

from typing import NamedTuple

import casadi as ca
import numpy as np
import pytest

from gough.errors import InputError
from gough.kernel import pack


class Filter(NamedTuple):
    x: object
    R: object


class State(NamedTuple):
    integral: object
    filter: Filter
    gain: object


class Nothing(NamedTuple):
    pass


def example():
    return State(np.array([1.0, 2.0, 3.0]), Filter(4.0, np.array([[5.0, 7.0], [6.0, 8.0]])), 9.0)


def test_a_tree_becomes_its_numbers_in_order_matrices_by_columns():
    assert np.array_equal(pack.flatten(example()), np.arange(1.0, 10.0))


def test_the_vector_becomes_the_tree_again():
    tree = pack.unflatten(example(), pack.flatten(example()))
    assert type(tree) is State and type(tree.filter) is Filter
    assert tree.gain == 9.0 and isinstance(tree.gain, float) and np.array_equal(tree.filter.R, example().filter.R)
    assert np.array_equal(tree.integral, example().integral)


def test_entries_and_fields_have_names():
    assert pack.names(example()) == (
        "integral[0]",
        "integral[1]",
        "integral[2]",
        "filter.x",
        "filter.R[0,0]",
        "filter.R[1,0]",
        "filter.R[0,1]",
        "filter.R[1,1]",
        "gain",
    )
    assert pack.fields(example()) == {
        "integral": slice(0, 3),
        "filter.x": slice(3, 4),
        "filter.R": slice(4, 8),
        "gain": slice(8, 9),
    }
    assert pack.size(example()) == 9


def test_symbols_and_numbers_agree_on_the_order():
    tree = pack.symbols(example(), "controller.")
    assert tree.filter.x.name() == "controller.filter.x"
    vector = pack.flatten(tree)
    f = ca.Function("f", [vector], [tree.filter.R, tree.gain])
    R, gain = f(np.arange(1.0, 10.0))
    assert np.array_equal(np.array(R), example().filter.R) and gain == 9.0
    back = pack.unflatten(example(), vector)
    assert back.filter.R.shape == (2, 2) and ca.is_equal(ca.vec(back.filter.R), vector[4:8], 2)


def test_symbols_beside_numbers_and_structural_zeros_are_packed_densely():
    tree = Filter(ca.SX.sym("x"), ca.SX.eye(2))
    vector = pack.flatten(tree)
    assert vector.shape == (5, 1) and vector.is_dense()
    assert pack.flatten(Filter(ca.SX.sym("x"), np.eye(3))).shape == (10, 1)


def test_a_state_without_fields_is_an_empty_vector():
    assert (
        pack.flatten(Nothing()).shape == (0,)
        and pack.names(Nothing()) == ()
        and pack.unflatten(Nothing(), []) == Nothing()
    )


def test_a_wrong_length_and_a_wrong_kind_are_errors():
    with pytest.raises(InputError, match="State has 9 entries, got 8"):
        pack.unflatten(example(), np.zeros(8))
    with pytest.raises(InputError, match="must be a NamedTuple, got dict"):
        pack.flatten({"x": 1.0})
    with pytest.raises(InputError, match="a field must be a number, an array or SX, got str"):
        pack.flatten(Filter("x", 1.0))


def test_symbols_in_lists_are_refused_not_made_nan():
    class Hidden(NamedTuple):
        a: object
        b: object

    y = ca.SX.sym("y")
    for leaf in ([y, 2.0], np.array([y, 2.0], object), [[y], [1.0]]):
        with pytest.raises(InputError, match="use ca.vertcat"):
            pack.flatten(Hidden(leaf, 1.0))
