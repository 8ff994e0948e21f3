"""The tape: what is shared, what is rewritten, and that nothing else is."""

import casadi as ca
import numpy as np
import pytest

from gough.kernel import compile_rows
from gough.kernel.tape import trace

from .examples import random_function


def count(tape, op):
    return sum(node[0] == op for node in tape.nodes)


def test_equal_operations_get_one_number_also_with_the_arguments_turned():
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    tape = trace(ca.Function("f", [x, y], [ca.sin(x * y) + ca.cos(x + y), ca.sin(y * x) - ca.cos(y + x)]))
    assert [count(tape, op) for op in ("mul", "add", "sin", "cos", "sub")] == [1, 2, 1, 1, 1]


def test_a_difference_and_a_quotient_are_not_turned():
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    tape = trace(ca.Function("f", [x, y], [x - y, y - x, ca.atan2(x, y), ca.atan2(y, x)]))
    assert count(tape, "sub") == 2 and count(tape, "atan2") == 2


def test_a_divisor_used_twice_gets_one_reciprocal():
    x, d = ca.SX.sym("x", 3), ca.SX.sym("d")
    tape = trace(ca.Function("f", [x, d], [x / d]))
    assert (count(tape, "div"), count(tape, "inv"), count(tape, "mul")) == (0, 1, 3)


def test_a_divisor_used_once_stays_a_divisor():
    x, d = ca.SX.sym("x"), ca.SX.sym("d")
    tape = trace(ca.Function("f", [x, d], [x / d]))
    assert (count(tape, "div"), count(tape, "inv")) == (1, 0)


def test_a_reciprocal_that_casadi_hid_in_quotients_is_found_again():
    x, d = ca.SX.sym("x", 3), ca.SX.sym("d")
    reciprocal = 1 / d
    tape = trace(ca.Function("f", [x, d], [x * reciprocal, reciprocal]))
    assert (count(tape, "div"), count(tape, "inv")) == (0, 1)


def test_what_no_output_needs_is_left_out():
    x = ca.SX.sym("x", 3)
    tape = trace(ca.Function("f", [x], [x[0] * 0 + x[1], ca.if_else(True, x[1], ca.exp(x[2]))]))
    assert {node for node in tape.nodes if node[0] == "input"} == {("input", 0, 1)}


def test_structural_zeros_are_zeros_in_and_out():
    m = ca.SX.sym("m", ca.Sparsity.lower(3))
    out = ca.SX(3, 2)
    out[1, 1] = m[2, 0]
    function = ca.Function("f", [m], [out, ca.mtimes(m, m)])
    tape = trace(function)
    assert tape.inputs == (9,) and tape.outputs == (6, 9)
    M = np.arange(1.0, 10).reshape(3, 3)
    placed, square = tape.replay(M)
    assert np.array_equal(placed, [0, 0, 0, 0, M[2, 0], 0])
    L = np.tril(M)
    assert np.array_equal(square.reshape(3, 3, order="F"), L @ L)
    rows = compile_rows(function, native=False)(M.reshape(-1, order="F"))
    assert all(np.array_equal(a[0], b) for a, b in zip(rows, (placed, square), strict=True))


def test_the_digest_knows_the_content_and_not_the_name():
    x = ca.SX.sym("x")
    first, same, other = (trace(ca.Function(n, [x], [e])) for n, e in (("a", x * 2), ("b", x * 2), ("a", x * 3)))
    assert first.digest == same.digest != other.digest


@pytest.mark.parametrize("seed", range(4))
def test_the_replay_of_a_random_function_equals_one_lane_to_the_last_bit(seed):
    function = random_function(seed)
    x = np.random.default_rng(seed).normal(size=(20, 5))
    got = compile_rows(function, lanes=1, cache=False)(x)[0]
    tape = trace(function)
    assert np.array_equal(got, [tape.replay(row)[0] for row in x])


@pytest.mark.quick("0-*", "*-8")
@pytest.mark.parametrize("lanes", [1, 2, 4, 8])
@pytest.mark.parametrize("seed", range(4))
def test_a_random_function_agrees_with_the_interpreter(seed, lanes):
    function = random_function(seed)
    x = np.random.default_rng(seed).normal(size=(40, 5))
    got = compile_rows(function, lanes=lanes, cache=False)(x)[0]
    expected = np.array([np.array(function(row)).ravel() for row in x])
    # KERNEL.md: 1e-12 relative a call; the values are of size 1
    assert np.abs(got - expected).max() <= 1e-12 * np.abs(expected).max()
