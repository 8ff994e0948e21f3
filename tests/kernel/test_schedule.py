"""Mistakes in a schedule are found when it is made, and the message says where and what."""

import casadi as ca
import pytest

from gough.errors import InputError
from gough.kernel import Schedule, Signal, Task, period_ticks

from .examples import pendulum


def double(size=1, name="double"):
    x = ca.SX.sym("x", size)
    return ca.Function(name, [x], [2 * x])


A, B = Signal("alpha", 1, "state"), Signal("beta", 1, "wire")


def test_a_period_that_is_no_multiple_of_the_base_tick_is_an_error():
    with pytest.raises(InputError, match="multiple of the base tick of 0.001 s, got 0.0015 s"):
        period_ticks(0.0015, 0.001)
    with pytest.raises(InputError):
        period_ticks(0.0005, 0.001)
    with pytest.raises(InputError):
        period_ticks(float("nan"), 0.001)


def test_periods_that_are_multiples_but_for_rounding_are_counted():
    assert [period_ticks(k * 0.3e-3, 0.3e-3) for k in (1, 3, 7, 1000)] == [1, 3, 7, 1000]
    assert period_ticks(900e-6, 300e-6) == 3


def test_an_unknown_signal_is_named_with_the_nearest_right_one():
    with pytest.raises(InputError, match="task t: reads the unknown signal 'alhpa'; did you mean alpha?"):
        Schedule([A, B], Task("t", double(), "alhpa", "beta"))
    with pytest.raises(InputError, match="log: names the unknown signal 'gamma'"):
        Schedule([A, B], Task("t", double(), "alpha", "beta"), log=("gamma",))


def test_a_signal_of_another_size_is_an_error_that_names_both():
    with pytest.raises(InputError, match="task t: reads alpha of size 1 at position 0 of double, got size 3"):
        Schedule([A, B], Task("t", double(3), "alpha", "beta"))
    with pytest.raises(InputError, match="double has 1 inputs, the task reads 2 signals"):
        Schedule([A, B], Task("t", double(), ("alpha", "alpha"), "beta"))


def test_names_must_differ():
    with pytest.raises(InputError, match="names of signals must differ, got alpha"):
        Schedule([A, A])
    with pytest.raises(InputError, match="names of tasks must differ, got t"):
        Schedule([A, B], [Task("t", double(), "alpha", "beta"), Task("t", double(), "alpha", "beta")])


def test_parameters_and_inputs_are_never_written():
    for kind in ("parameter", "input", "noise"):
        with pytest.raises(InputError, match=f"task t: writes p, a signal of kind {kind}"):
            Schedule([A, Signal("p", 1, kind)], Task("t", double(), "alpha", "p"))


def test_a_wire_read_before_it_is_written_is_an_error():
    write, read = Task("write", double(), "alpha", "beta"), Task("read", double(), "beta", "alpha")
    Schedule([A, B], [write, read])
    with pytest.raises(
        InputError, match="task read: reads the wire beta before a task has written it; .* make beta a state"
    ):
        Schedule([A, B], [read, write])
    with pytest.raises(InputError, match="log: reads the wire beta"):
        Schedule([A, B], substep=write, log=("beta",))


def test_a_free_symbol_and_an_unknown_operation_name_task_and_function():
    x, stranger = ca.SX.sym("x"), ca.SX.sym("stranger")
    with pytest.raises(InputError, match="task t: free depends on symbols that are no inputs, got stranger"):
        Schedule([A, B], Task("t", ca.Function("free", [x], [x + stranger], {"allow_free": True}), "alpha", "beta"))
    inner = ca.Function("inner", [x], [x], {"never_inline": True})
    with pytest.raises(InputError, match="task t: outer has an operation that no kernel computes, got OP_CALL"):
        Schedule([A, B], Task("t", ca.Function("outer", [x], [inner(x)]), "alpha", "beta"))


def test_limits_are_one_wire():
    with pytest.raises(InputError, match="the limits task writes one wire"):
        Schedule([A, B], limits=Task("limits", double(), "alpha", "alpha"))


def test_kinds_sizes_labels_and_ticks_are_checked():
    for wrong in (
        lambda: Signal("x", 1, "sate"),
        lambda: Signal("x", -1, "state"),
        lambda: Signal("x", 2, "state", ("one",)),
        lambda: Task("t", double(), "a", "b", every=0),
        lambda: Task("t", 3.0),
        lambda: Schedule([A], period=0.0),
        lambda: Schedule([A], substeps=0),
        lambda: Task("t", double(), "a", ("b", "b")),
    ):
        with pytest.raises(InputError):
            wrong()


def test_a_pendulum_is_a_schedule():
    schedule = pendulum()
    assert [t.name for t in schedule.all_tasks] == ["law", "step", "reach"]
    assert schedule.limit_signal == "limits"
