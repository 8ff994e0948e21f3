"""Parameters: ranges, who may set what, what belongs to a subroutine, and files of LinuxCNC."""

import math

import pytest

from gough.errors import ProgramError
from gough.program.ngc.parameters import LAST, READ_ONLY, SYSTEM_NAMES, Parameters


def error(function, *args):
    with pytest.raises(ProgramError) as caught:
        function(*args)
    return str(caught.value)


def test_numbered_parameters_are_zero_until_they_are_set():
    p = Parameters()
    assert {p.get(n) for n in range(1, LAST + 1)} == {0.0, 1.0}
    assert [n for n in range(1, LAST + 1) if p.get(n)] == [5220]  # the coordinate system in force: G54
    p.set(31, 4.5)
    assert p.get(31) == 4.5


def test_the_number_of_a_parameter_may_be_off_by_less_than_a_ten_thousandth():
    p = Parameters()
    p.set(7.00009, 2.0)
    assert p.get(7) == p.get(6.99991) == 2.0
    assert error(p.get, 7.00011) == "the number of a parameter is whole, got #[7.00011]; use FIX[...] or ROUND[...]"


@pytest.mark.parametrize("number", [0, -1, 5602, 1e300, -1e300])
def test_parameters_out_of_range_are_refused(number):
    p = Parameters()
    told = f"parameters go from #1 to #5601, got #{number:.6g}; use e.g. #100"
    assert error(p.get, number) == error(p.set, number, 1.0) == told
    assert not p.exists(number)


@pytest.mark.parametrize("number", [math.nan, math.inf])
def test_a_number_that_is_not_finite_names_no_parameter(number):
    p = Parameters()
    for function in (p.get, p.exists):
        assert error(function, number).startswith("the number of a parameter is whole")


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_no_parameter_takes_a_value_that_is_not_finite(value):
    p = Parameters()
    assert error(p.set, 1, value) == f"a parameter is a finite number, got #1 = {value}"
    assert error(p.set_named, "a", value) == f"a parameter is a finite number, got #<a> = {value}"


def test_programs_set_neither_the_tool_in_force_nor_the_position_and_the_machine_does():
    p = Parameters()
    assert sorted(READ_ONLY) == [*range(5400, 5414), *range(5420, 5429)]  # those that rs274 calls read-only
    for number in READ_ONLY:
        told = f"a parameter that programs only read, got #{number}; use another, e.g. #100"
        assert error(p.set, number, 1.0) == told
    p.keep(5403, 12.5)
    assert p.get(5403) == 12.5


def test_numbers_of_the_machine_are_asked_for_when_they_are_read():
    p, at = Parameters(), [1.0]
    p.system_numbers[5421] = lambda: at[0]
    assert p.get(5421) == 1.0
    at[0] = 2.0
    assert p.get(5421) == 2.0


def test_named_parameters_are_local_and_those_with_an_underscore_are_not():
    p = Parameters()
    p.set_named("a", 1.0)
    p.set_named("_g", 2.0)
    p.enter([])
    assert p.get_named("_g") == 2.0
    assert not p.exists_named("a")
    told = (
        "a named parameter that was never set, got #<a>; set it in the subroutine, or use #<_a>, which holds everywhere"
    )
    assert error(p.get_named, "a") == told
    p.set_named("a", 5.0)
    p.set_named("_g", 6.0)
    p.leave(None)
    assert (p.get_named("a"), p.get_named("_g")) == (1.0, 6.0)


def test_what_is_not_set_cannot_be_read():
    told = "a named parameter that was never set, got #<depth>; write #<depth>=... before it"
    assert error(Parameters().get_named, "depth") == told


@pytest.mark.parametrize("name", sorted(SYSTEM_NAMES))
def test_names_of_the_machine_are_not_set_by_programs(name):
    told = f"a parameter that programs only read, got #<{name}>; use another name, e.g. #<my{name}>"
    assert error(Parameters().set_named, name, 1.0) == told


def test_names_of_the_machine_are_asked_for_when_they_are_read():
    p, at = Parameters(), [1.0]
    told = "a parameter of the machine that is not supported, got #<_x>; remove it, or write the number"
    assert error(p.get_named, "_x") == told
    assert not p.exists_named("_x")
    p.system["_x"] = lambda: at[0]
    at[0] = 3.0
    assert p.get_named("_x") == 3.0
    assert p.exists_named("_x")


@pytest.mark.parametrize("name", ["_ini[axis_x]max_velocity", "_hal[motion.enable]"])
def test_nothing_is_read_from_ini_files_or_hal(name):
    told = f"values of the INI file and of HAL are not supported, got #<{name}>; write the number"
    assert error(Parameters().get_named, name) == told


def test_a_call_sees_its_arguments_and_zeros_and_its_caller_gets_its_own_back():
    p = Parameters()
    for n in range(1, 40):
        p.set(n, float(n))
    p.enter([10.0, 20.0])
    assert [p.get(n) for n in range(1, 31)] == [10.0, 20.0] + [0.0] * 28
    assert p.get(31) == 31.0  # those above 30 are everybody's
    p.set(3, 7.0)
    p.set(31, 8.0)
    p.enter([1.0] * 30)
    assert p.get(30) == 1.0
    p.leave(None)
    assert [p.get(n) for n in (1, 2, 3, 4)] == [10.0, 20.0, 7.0, 0.0]
    p.leave(None)
    assert [p.get(n) for n in range(1, 31)] == [float(n) for n in range(1, 31)]
    assert p.get(31) == 8.0


def test_what_a_call_returned_is_known_until_the_next_returns():
    p = Parameters()
    seen = []
    for returned in (None, 5.0, 0.0, None):
        p.enter([])
        level = p.get_named("_call_level")
        p.leave(returned)
        seen.append((level, p.get_named("_value"), p.get_named("_value_returned")))
    assert seen == [(1.0, 0.0, 0.0), (1.0, 5.0, 1.0), (1.0, 0.0, 1.0), (1.0, 0.0, 0.0)]
    assert p.get_named("_call_level") == 0.0


def test_the_depth_of_calls_is_told_at_each_call_and_each_return():
    p, seen = Parameters(), []
    p.level = seen.append
    p.enter([])
    p.enter([])
    p.leave(None)
    p.leave(None)
    assert seen == [1, 2, 1, 0]


def test_a_parameter_file_is_taken_up_without_what_is_the_machines():
    p = Parameters()
    p.read("5161\t0.000000\n5221 12.5\n5222 -3\n\n5420 99\n", "machine.var")
    assert [p.get(n) for n in (5161, 5221, 5222, 5420)] == [0.0, 12.5, -3.0, 0.0]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("5221 1\n5221 2", "v:2: a parameter twice, got 5221; remove one"),
        ("5221", "v:1: a line of a parameter file is a number and its value, got '5221'; write e.g. 5221 12.5"),
        ("a b", "v:1: a line of a parameter file is a number and its value, got 'a b'; write e.g. 5221 12.5"),
        ("1 2 3", "v:1: a line of a parameter file is a number and its value, got '1 2 3'; write e.g. 5221 12.5"),
        ("1.5 2", "v:1: a line of a parameter file is a number and its value, got '1.5 2'; write e.g. 5221 12.5"),
        ("0 1", "v:1: parameters go from 1 to 5601, got '0'"),
        ("5602 1", "v:1: parameters go from 1 to 5601, got '5602'"),
        ("1 nan", "v:1: a parameter is a finite number, got 'nan'"),
        ("1 -inf", "v:1: a parameter is a finite number, got '-inf'"),
        ("\n" * 10_000 + "1 1", "v:10001: a parameter file has at most 10000 lines"),
        ("9" * 5000 + " 1", "v:1: a line of a parameter file is a number and its value, got "
         f"'{'9' * 30}'; write e.g. 5221 12.5"),
    ],
    ids=lambda text: repr(text[:12]),
)  # fmt: skip
def test_a_wrong_parameter_file_is_told_with_its_line(text, told):
    assert error(Parameters().read, text, "v") == told
