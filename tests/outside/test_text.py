"""RELIABILITY L1, L6: text that is not a table of numbers is read right or refused, never misread."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from gough.errors import LogError
from outside.conftest import MAP, NAMES, csv_text


def same(found, truth, skip=1):
    """Readings, and forces of the sample before, are those of the truth."""
    assert_allclose(found.q, truth.q, rtol=0, atol=1e-15)
    assert_array_equal(found.u[skip:], truth.u[: len(truth.u) - skip])


def semicolon(extra=""):
    return MAP + f'[text]\ndelimiter = ";"\n{extra}'


READ = {  # what is read right: (map, bytes of the table)
    "plain": (MAP, lambda t: csv_text(t)),
    "crlf": (MAP, lambda t: csv_text(t, end="\r\n")),
    "byte order mark": (MAP, lambda t: "\ufeff" + csv_text(t)),
    "spaces around cells": (MAP, lambda t: csv_text(t).replace(",", " , ")),
    "quoted cells": (MAP, lambda t: '"' + csv_text(t).replace(",", '","').replace("\n", '"\n"')[:-1]),
    "comments and empty lines": (MAP, lambda t: "# made by a drive\n\n" + csv_text(t).replace("\n", "\n#\n\n", 20)),
    "semicolons": (semicolon(), lambda t: csv_text(t, delimiter=";")),
    "semicolons and decimal commas": (semicolon('decimal = ","\n'), lambda t: csv_text(t, delimiter=";", decimal=",")),
    "tabs": (MAP + '[text]\ndelimiter = "\\t"\n', lambda t: csv_text(t, delimiter="\t")),
    "bars": (MAP + '[text]\ndelimiter = "|"\n', lambda t: csv_text(t, delimiter="|")),
    "blanks": (MAP + '[text]\ndelimiter = " "\n', lambda t: csv_text(t, delimiter="   ")),
    "exponents": (MAP, lambda t: "\n".join([",".join(NAMES), *(",".join(f"{v:.17E}" for v in r) for r in t)]) + "\n"),
    "plus signs": (MAP, lambda t: "\n".join([",".join(NAMES), *(",".join(f"{v:+.17g}" for v in r) for r in t)]) + "\n"),
    "three lines of header": (MAP + "[text]\nheader = 3\n", lambda t: "drive 7\n2024\n" + csv_text(t)),
    "columns in another order": (MAP, lambda t: csv_text(t[:, ::-1], NAMES[::-1])),
    "columns that nobody asks for": (MAP, lambda t: csv_text(np.c_[t, t], [*NAMES, *(f"x{n}" for n in NAMES)])),
}  # fmt: skip


@pytest.mark.parametrize("name", READ)
def test_a_table_in_this_dress_gives_the_numbers(record, truth, name):
    map_text, dress = READ[name]
    _, found, _ = record(dress(truth.table), map_text)
    same(found, truth)


def test_columns_without_names_go_by_their_numbers(record, truth):
    numbered = MAP
    for i, name in reversed(list(enumerate(NAMES, 1))):
        numbered = numbered.replace(f'"{name}"', f'"{i}"')
    _, found, _ = record(csv_text(truth.table).split("\n", 1)[1], numbered + "[text]\nheader = 0\n")
    same(found, truth)


def cell(text, row=5, column=3, delimiter=","):
    """The table with one cell replaced; row counts from 0 below the names."""

    def change(table):
        lines = csv_text(table, delimiter=delimiter).split("\n")
        cells = lines[row + 1].split(delimiter)
        cells[column] = text
        lines[row + 1] = delimiter.join(cells)
        return "\n".join(lines)

    return change


REFUSED = {  # what is refused: (map, bytes, message)
    "nan": (MAP, cell("nan"), "log.csv:7: q3: a number should be here, got no number; allow short gaps"),
    "infinity": (MAP, cell("-inf"), "log.csv:7: q3: a number should be here, got -inf"),
    "beyond any number": (MAP, cell("1e400"), "log.csv:7: q3: a number should be here, got inf"),
    "nothing": (MAP, cell(""), "log.csv:7: q3: a number should be here, got nothing"),
    "a word": (MAP, cell("overrun"), "log.csv:7: q3: a number should be here, got 'overrun'"),
    "a number and a unit": (MAP, cell("12 mm"), "log.csv:7: q3: a number should be here, got '12 mm'"),
    "hexadecimal": (MAP, cell("0x1F"), "log.csv:7: q3: a number should be here, got '0x1F'"),
    "an underscore": (MAP, cell("1_000"), "log.csv:7: q3: a number should be here, got '1_000'"),
    "two points": (MAP, cell("1.234.5"), "log.csv:7: q3: a number should be here, got '1.234.5'"),
    "arabic digits": (MAP, cell("\u0661\u0662"), "log.csv:7: q3: a number should be here"),
    "a decimal comma among points": (
        semicolon(), cell("12,5", delimiter=";"),
        "log.csv:7: q3: a number should be here, got '12,5', a decimal comma: write decimal = \",\" in [text]",
    ),
    "decimal commas nobody told of": (
        MAP, lambda t: csv_text(t, decimal=",").replace(",".join(NAMES), ";".join(NAMES)),
        "log.csv: the file has no such column, got 'q1'",
    ),
    "decimal commas between commas": (
        MAP, lambda t: csv_text(t[:, :]).replace(".", ","),
        "log.csv:2: every row has as many cells as there are names, got 26 (limit 13); are these decimal commas?",
    ),
    "points in a table of decimal commas": (
        semicolon('decimal = ","\n'), cell("1.234,5", delimiter=";"),
        "log.csv:2: t: a row needs its time, got '0.0'",
    ),
    "a row too short": (
        MAP, lambda t: csv_text(t).replace("\n", "\n1,2,3\n", 1),
        "log.csv:2: every row has as many cells as there are names, got 3 (limit 13)",
    ),
    "a row too long": (
        semicolon(), lambda t: csv_text(t, delimiter=";").replace("\n", ";1\n", 3).replace(";1\n", "\n", 1),
        "log.csv:2: every row has as many cells as there are names, got 14 (limit 13)",
    ),
    "another delimiter": (
        MAP, lambda t: csv_text(t, delimiter=";"), "log.csv: the file has no such column, got 'q1'",
    ),
    "a NUL": (MAP, lambda t: csv_text(t).replace("\n", "\n\0", 3), "log.csv:2: has a NUL byte; give a text file"),
    "utf-16": (MAP, lambda t: csv_text(t).encode("utf-16"), "log.csv:1: has a NUL byte"),
    "latin-1": (
        MAP, lambda t: csv_text(t).replace("t,", "t\xb5,", 1).encode("latin-1"), "log.csv:1: is not UTF-8 text",
    ),
    "a line of 2 MB": (
        MAP, lambda t: csv_text(t) + "1" * (2 << 20) + "\n", "every row has as many cells as there are names, got 1",
    ),
    "a line without an end": (MAP, lambda t: csv_text(t) + "1" * (6 << 20), "a line has at most 1 MB"),
    "nothing at all": (MAP, lambda t: "", "log.csv: is empty"),
    "names alone": (MAP, lambda t: ",".join(NAMES) + "\n", "log.csv: has no rows"),
    "comments alone": (MAP, lambda t: "# nothing\n", "log.csv: has no rows"),
    "two columns of one name": (
        MAP, lambda t: csv_text(np.column_stack([t, t[:, 1]]), [*NAMES, "q1"]), "two columns have this name, got 'q1'",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_table_of_numbers_is_refused_with_its_place(record, truth, name):
    map_text, dress, message = REFUSED[name]
    with pytest.raises(LogError) as caught:
        record(dress(truth.table), map_text)
    assert message in str(caught.value)


DRESSES = [
    (delimiter, decimal, end, mark)
    for delimiter in (",", ";", "\t", "|", " ")
    for decimal in (".", ",")
    for end, mark in (("\n", ""), ("\r\n", "\ufeff"))
    if (delimiter, decimal) != (",", ",")
]


@pytest.mark.parametrize("told", DRESSES[::2], ids=repr)
def test_a_table_in_another_dress_than_the_map_says_is_right_or_refused(record, truth, told):
    """RELIABILITY C2, L6: no pair of a file's dress and a map's gives numbers that are not in the file."""
    delimiter, decimal, _, _ = told
    text = f'[text]\ndelimiter = "{delimiter}"\ndecimal = "{decimal}"\n'.replace("\t", "\\t")
    short = type(truth)(*(column[:8] for column in truth))
    right = 0
    for delimiter, decimal, end, mark in DRESSES:
        dressed = mark + csv_text(short.table, delimiter=delimiter, decimal=decimal, end=end)
        try:
            _, found, _ = record(dressed, MAP + text)
        except LogError:
            assert (delimiter, decimal) != told[:2], "the right map reads it"
            continue
        same(found, short)
        right += 1
    assert right >= 2


def test_a_last_line_without_an_end_is_left_out_and_told(record, truth):
    """A number cut off in its digits is a number still: 1.2 of 1.25."""
    found, rows, _ = record(csv_text(truth.table)[:-3])
    assert len(rows.t) == len(truth.t) - 1
    assert [str(f) for f in found.findings.kept] == ["line 401 has no end: it may be cut off, and is left out"]


def test_every_cut_of_a_file_is_read_to_its_last_whole_line_or_refused(record, truth):
    """RELIABILITY C2: no silent misreading of a truncated file."""
    text = csv_text(truth.table[:6])
    for length in range(1, len(text), 37):
        try:
            _, rows, _ = record(text[:length])
        except LogError:
            continue
        whole = text[:length].count("\n") - 1
        assert len(rows.t) == whole
        assert_allclose(rows.q, truth.q[:whole], rtol=0, atol=1e-15)
