"""The slow path: what takes it, and that it says so once."""

import sys
import warnings

import casadi as ca
import numpy as np
import pytest

from gough.errors import InputError
from gough.kernel import KernelWarning, compile, compile_rows

from .examples import pendulum, reference

VALUES = {"p": [10.0, 1.0]}, {"x": [0.1, 0.0]}


def law(x, r, p, w):
    return p[0] * (r - x[0]) - p[1] * x[1] + 0.1 * w[2]


def test_a_law_in_plain_python_runs_and_says_once_that_it_is_slow():
    with pytest.warns(KernelWarning, match="task law is plain Python: .* 20 to 60 times slower") as record:
        kernel = compile(pendulum(control=law))
        rows = kernel.start(*VALUES).advance(100, reference(100))
    assert len(record) == 1 and not kernel.native
    expected = compile(pendulum()).start(*VALUES).advance(100, reference(100))
    np.testing.assert_allclose(rows, expected, rtol=0, atol=1e-12)


def test_without_llvmlite_the_interpreter_runs_and_says_once_why(monkeypatch):
    monkeypatch.setitem(sys.modules, "llvmlite.binding", None)
    with pytest.warns(KernelWarning, match="llvmlite cannot be loaded") as record:
        kernel = compile(pendulum())
        kernel.start(*VALUES).advance(10, reference(10))
    assert len(record) == 1 and not kernel.native
    x = ca.SX.sym("x")
    with pytest.warns(KernelWarning, match="llvmlite cannot be loaded .*: f is interpreted"):
        f = compile_rows(ca.Function("f", [x], [x * 2]))
    assert f([[3.0]])[0] == 6.0


def test_machine_code_demanded_where_none_can_be_made_is_an_error():
    with pytest.raises(InputError, match="no machine code can be made, got task law is plain Python"):
        compile(pendulum(control=law), native=True)


def test_the_interpreter_asked_for_warns_of_nothing():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert not compile(pendulum(), native=False).native


def test_plain_python_must_return_what_the_task_writes():
    for wrong, message in (
        (lambda *a: np.zeros(2), "task law: must return 1 numbers for u, got 2"),
        (lambda *a: (np.zeros(1), np.zeros(1)), "task law: must return 1 arrays, got 2"),
    ):
        simulation = compile(pendulum(control=wrong), native=False).start(*VALUES)
        with pytest.raises(InputError, match=message):
            simulation.advance(1, reference(1))


def test_plain_python_cannot_reach_into_the_simulation():
    def vandal(x, r, p, w):
        x[:] = p[:] = 1e9
        return [0.0]

    simulation = compile(pendulum(control=vandal), native=False).start(*VALUES)
    honest = compile(pendulum(control=lambda *a: [0.0]), native=False).start(*VALUES)
    assert np.array_equal(simulation.advance(20, reference(20)), honest.advance(20, reference(20)))


def test_an_error_in_plain_python_comes_out():
    def broken(x, r, p, w):
        raise ZeroDivisionError("of the law")

    with pytest.raises(ZeroDivisionError, match="of the law"):
        compile(pendulum(control=broken), native=False).start(*VALUES).advance(1, reference(1))
