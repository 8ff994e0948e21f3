"""Tapes printed as C: every operation, numbers put in, results in place of inputs."""

from __future__ import annotations

import dataclasses
import math

import casadi as ca
import numpy as np
import pytest
from compiled import build, needs_gcc, pointer

from gough.errors import ExperimentError, InputError
from gough.export.c import printer
from gough.export.c.fold import baked
from gough.export.c.functions import print_functions
from gough.export.c.names import distinct, identifier, suggested
from gough.kernel import ops
from gough.kernel.tape import trace

ODD = [0.0, -0.0, 1.0, -1.0, 0.5, -0.75, 2.5, -3.5, 1e-310, 1e308, -1e308, math.pi, math.inf, -math.inf, math.nan]


@pytest.mark.parametrize("value", [*ODD, 0.1, 1 / 3, 5e-324, 123456.0, 1e22, -(2.0**-1074)])
def test_a_number_in_c_reads_back_as_itself(value):
    text = printer.number(value).strip("()")
    known = {"NAN": math.nan, "INFINITY": math.inf, "-INFINITY": -math.inf}
    back = known[text] if text in known else float.fromhex(text) if "x" in text else float(text)
    assert np.array_equal(back, value, equal_nan=True)
    assert math.copysign(1, back) == math.copysign(1, value) or math.isnan(value)


def every_operation():
    """A function with every operation of the kernel on x and y: the values that went in, one output each."""
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    names = list(dict.fromkeys([*ops.UNARY.values(), *ops.BINARY.values()]))
    base = trace(ca.Function("base", [x, y], [x + y]))
    nodes = [("input", 0, 0), ("input", 1, 0)]
    nodes += [(name, 0, 1 if name in set(ops.BINARY.values()) else 0) for name in names]
    results = (tuple(range(2, len(nodes))),)
    return names, dataclasses.replace(base, nodes=tuple(nodes), results=results, outputs=(len(names),))


@needs_gcc
def test_every_operation_in_c_is_that_of_one_lane_to_the_last_bit(tmp_path):
    names, tape = every_operation()
    c = "#include <math.h>\n" + printer.function(tape, "all_of", ["x", "y"], ["out"], static=False)
    h = f"void all_of(const double x[1], const double y[1], double out[{len(names)}]);\n"
    library = build(tmp_path, {"all.c": h + c})
    for a in ODD:
        for b in ODD:
            out = np.empty(len(names))
            library.all_of(pointer(np.array([a])), pointer(np.array([b])), pointer(out))
            expected = tape.replay([a], [b])[0]
            same = (out == expected) & (np.signbit(out) == np.signbit(expected)) | np.isnan(out) & np.isnan(expected)
            assert same.all(), (a, b, [n for n, ok in zip(names, same, strict=True) if not ok])


def test_numbers_put_in_change_no_bit_and_leave_no_work_that_could_be_done_before():
    theta, x = ca.SX.sym("theta", 3), ca.SX.sym("x", 2)
    f = ca.Function("f", [theta, x], [ca.sin(theta[0]) * x + ca.if_else(theta[1] > 0, theta[2], x[0]), theta])
    tape, rng = trace(f), np.random.default_rng(0)
    for _ in range(5):
        numbers, at = rng.normal(size=3), rng.normal(size=2)
        done = baked(tape, {0: numbers})
        for a, b in zip(done.replay(np.zeros(0), at), tape.replay(numbers, at), strict=True):
            assert np.array_equal(a, b)
        assert done.inputs == (0, 2)
        assert not {"sin", "lt"} & {op for op, _, _ in done.nodes}


@needs_gcc
def test_an_output_may_be_the_array_of_an_input(tmp_path):
    x, y = ca.SX.sym("x", 3), ca.SX.sym("y", 1)
    f = ca.Function("turn", [x, y], [ca.vertcat(x[2], x[0], x[1] + y), 2 * y], ["x", "y"], ["after", "twice"])
    c, h = print_functions("some", [f])
    library = build(tmp_path, {"some.c": c, "some.h": h})
    values, other = np.array([1.0, 2.0, 3.0]), np.array([10.0])
    library.some_turn(pointer(values), pointer(other), pointer(values), pointer(other))
    assert values.tolist() == [3.0, 1.0, 12.0]
    assert other.tolist() == [20.0]


def test_inputs_that_are_constants_are_no_parameters():
    x, k = ca.SX.sym("x"), ca.SX.sym("k")
    f = ca.Function("scaled", [k, x], [k * x], ["k", "x"], ["y"])
    _, h = print_functions("some", [f], {"k": np.array([2.0])})
    assert "void some_scaled(const double x[1], double y[1]);" in h


def many(count):
    x = ca.SX.sym("x", count)
    parts = [ca.sin(x[i]) for i in range(count)]  # all needed at once: each twice, in turn and in the other
    return trace(
        ca.Function("many", [x], [ca.sum1(ca.vertcat(*parts)), ca.vertcat(*reversed(parts))], ["x"], ["s", "v"])
    )


def test_more_values_than_a_frame_holds_are_refused_or_go_into_the_callers_memory():
    tape = many(400)
    with pytest.raises(InputError, match="many_of needs too many values at once for a frame of 2560 B"):
        printer.function(tape, "many_of", ["x"], ["s", "v"])
    text = printer.function(tape, "many_of", ["x"], ["s", "v"], work=True)
    assert f"work[{printer.spilled(tape) - 1}]" in text
    assert f"work[{printer.spilled(tape)}]" not in text
    assert f"r{printer.LOCAL}" not in text


@needs_gcc
def test_values_in_the_callers_memory_are_the_same_values(tmp_path):
    tape = many(400)
    text = printer.function(tape, "many_of", ["x"], ["s", "v"], static=False, work=True)
    prototype = "void many_of(const double x[400], double s[1], double v[400], double work[]);\n"
    library = build(tmp_path, {"many.c": "#include <math.h>\n" + prototype + text})
    x, s, v, work = np.linspace(0, 1, 400), np.empty(1), np.empty(400), np.empty(printer.spilled(tape))
    library.many_of(*(pointer(one) for one in (x, s, v, work)))
    for found, expected in zip((s, v), tape.replay(x), strict=True):
        assert np.array_equal(found, expected)


@pytest.mark.parametrize(
    ("name", "rule", "cure"),
    [
        ("okuma-pm600", "a name in C has letters, digits and _ only, and begins with a letter", "okuma_pm600"),
        ("3prs", "a name in C has letters, digits and _ only, and begins with a letter", "m_3prs"),
        ("while", "the name is a word of the language C, or of its library", "while_1"),
        ("x" * 32, "a name in C has at most 31 letters here", "x" * 31),
        ("Größe", "a name in C has letters, digits and _ only, and begins with a letter", "gr_e"),
        ("", "a name in C has letters, digits and _ only, and begins with a letter", "m"),
        ('a"; system("x', "a name in C has letters, digits and _ only, and begins with a letter", "a_system_x"),
    ],
)
def test_a_name_that_c_does_not_take_is_refused_with_one_that_it_does(name, rule, cure):
    with pytest.raises(ExperimentError) as caught:
        identifier(name)
    problem = caught.value.problems[0]
    assert (problem.rule, problem.cure) == (rule, f"write --name {cure}")
    assert identifier(suggested(name)) == cure


def test_labels_that_would_be_one_name_get_numbers():
    assert distinct(["law a", "law-a", "law.a", "7"]) == ["law_a", "law_a_2", "law_a_3", "x7"]
