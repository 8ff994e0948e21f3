"""Tool tables: of an experiment, and LinuxCNC's."""

import pytest

from gough.errors import ExperimentError, ProgramError
from gough.program.ngc.tools import Tool, Tools, read_tool_table, tool_number, tools_of


def test_a_table_of_numbers_in_metres_and_one_with_units_are_one():
    numbers = tools_of({5: {"length": 0.0525, "x": 0.0001, "diameter": 0.006}, 1: {}})
    written = tools_of({"5": {"length": "52.5 mm", "x": "0.1 mm", "diameter": "6 mm"}, "1": {}}, from_file=True)
    assert list(numbers) == list(written) == [
        Tool(1, (0, 0, 0)), Tool(5, (pytest.approx(0.0001), 0, pytest.approx(0.0525)), pytest.approx(0.006))
    ]  # fmt: skip


@pytest.mark.parametrize(
    "table, told",
    [
        ({"5": {"lenght": "50 mm"}}, ["5.lenght: no such key; did you mean length?"]),
        ({"5": {"length": 50}}, ['5.length: has no unit, got 50; write e.g. "50 mm"']),
        ({"5": {"length": "50 deg"}}, None),
        ({"5": {"diameter": "-1 mm"}}, None),
        ({"5": 3}, ['5: must be a table, got 3; write { length = "80 mm" }']),
        ({"five": {}}, ["five: a tool's number is a whole number above 0, got 'five'"]),
        ({"0": {}}, ["0: a tool's number is a whole number above 0, got '0'"]),
        ({"-1": {}, "1.5": {}}, ["-1: a tool's number is a whole number above 0, got '-1'",
                                 "1.5: a tool's number is a whole number above 0, got '1.5'"]),
        ({True: {}}, ["True: a tool's number is a whole number above 0, got True"]),
        ({1: {2: 3}}, ["1: must be a table of named numbers, got {2: 3}"]),
    ],
)  # fmt: skip
def test_every_mistake_of_a_table_is_told_with_its_key(table, told):
    with pytest.raises(ExperimentError) as caught:
        tools_of(table, from_file=True)
    if told is None:
        assert [p.key.split(".")[0] for p in caught.value.problems] == ["5"]
    else:
        assert str(caught.value).split("\n") == told


@pytest.mark.parametrize("value", [float("nan"), float("inf"), 11.0])
def test_a_length_that_no_tool_has_is_refused(value):
    with pytest.raises(ExperimentError) as caught:
        tools_of({1: {"length": value}})
    assert caught.value.problems[0].key == "1.length"


def test_linuxcnc_s_table_is_read_in_mm():
    text = "T1 P1 X+0.1 Y-.2 Z80. D6 ;end mill\n\n; nothing\nt2 p2 z-5 a0 u0 i10 j20 q3\nT007P3Z1\r\n"
    assert list(read_tool_table(text)) == [
        Tool(1, (pytest.approx(0.0001), pytest.approx(-0.0002), pytest.approx(0.08)), pytest.approx(0.006)),
        Tool(2, (0, 0, pytest.approx(-0.005)), 0),
        Tool(7, (0, 0, pytest.approx(0.001)), 0),
    ]


@pytest.mark.parametrize(
    "row, message",
    [
        ("P1 Z5", "a tool without a number, got 'P1 Z5'; write T and its number"),
        ("T1.5 Z5", "a tool's number is a whole number, got T1.5; write e.g. T5"),
        ("T-1 Z5", "a tool's number is a whole number, got T-1; write e.g. T5"),
        ("T2 Z5 Z6", "Z twice in a line, got Z6; write it once"),
        ("T2 K5", "no word of a tool table, got K5; remove it"),
        ("T2 A5", "a tool has an offset in X, Y and Z only, got A5; remove it"),
        ("T2 W1", "a tool has an offset in X, Y and Z only, got W1; remove it"),
        ("T2 Z10001", "Z is beyond 10000 mm, got Z10001; lengths are in mm"),
        ("T2 Z1e3", "not a word of a tool table, got 'Z1e3'; write e.g. T1 P1 Z80"),
        ("T2 Z1.2.3", "not a word of a tool table, got 'Z1.2.3'; write e.g. T1 P1 Z80"),
        ("T2 Znan", "not a word of a tool table, got 'Znan'; write e.g. T1 P1 Z80"),
        ("T2 Z\u0661", "not a word of a tool table, got 'Z\u0661'; write e.g. T1 P1 Z80"),
        ("T2 Z#1", "not a word of a tool table, got 'Z#1'; write e.g. T1 P1 Z80"),
        ("T1 Z5", "a tool twice in the table, got T1; remove one line"),
        ("T2 " + "Z" * 300, "a line has at most 255 characters, got 303; shorten it"),
    ],
)
def test_a_wrong_row_is_refused_with_its_line(row, message):
    with pytest.raises(ProgramError) as caught:
        read_tool_table(f"T1 Z1\n{row}\n", "tool.tbl")
    assert str(caught.value) == f"tool.tbl:2: {message}"


def test_a_table_has_a_largest_size():
    with pytest.raises(ProgramError, match="10001: a tool table has at most 10000 tools"):
        read_tool_table("".join(f"T{n}\n" for n in range(1, 20_000)), "tool.tbl")


def test_tool_zero_is_no_tool_and_in_every_table():
    assert Tools()[0] == Tool(0, (0, 0, 0))
    assert tool_number(0.0, "T0", Tools()) == 0


def test_the_error_for_a_missing_tool_names_those_there_are():
    many = Tools({n: Tool(n, (0, 0, 0)) for n in range(1, 21)})
    for tools, cure in [
        (Tools(), "the table is empty"),
        (many, "there is T1, T2, T3, T4, T5, T6, T7, T8, T9, T10, T11, T12 and 8 more"),
    ]:
        with pytest.raises(ProgramError) as caught:
            tool_number(99.0, "T99", tools)
        assert str(caught.value) == f"no such tool in the tool table, got T99; {cure}"
