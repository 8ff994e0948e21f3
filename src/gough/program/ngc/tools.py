"""Tools: how far each one carries the tip away from the T of the data sheet, and which is in the table.

An experiment's [tools] has a table for each number:      [tools]
                                                          1 = { length = "80 mm" }
                                                          5 = { length = "52.5 mm", x = "0.1 mm", diameter = "6 mm" }
LinuxCNC's tool table has a line for each tool:           T5 P5 X0.1 Z52.5 D6 ;end mill
in mm.  `length` (Z) runs from the data sheet's T along the tool towards the work: the tip is at -length on T's third
axis.  P (the pocket), I, J and Q do nothing here.  Turned tools (A B C) and U V W are refused.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from ...declare import Part, quantity
from ...errors import ExperimentError, InputError, Problem, ProgramError

MOST_TOOLS = 10_000
_LARGEST = 1e4  # mm
_LARGEST_NUMBER = 1_000_000


class Tool(NamedTuple):
    """A tool: its number, where T stands from its tip along the axes of T, (3,) m, and its diameter, m."""

    number: int
    offset: tuple[float, float, float]
    diameter: float = 0.0


class _Entry(Part):
    """A tool as an experiment writes it."""

    length: float = quantity("m", "from T to the tip, towards the work", default=0.0, at_least=-10, at_most=10)
    x: float = quantity("m", "T from the tip, along the first axis of T", default=0.0, at_least=-10, at_most=10)
    y: float = quantity("m", "T from the tip, along the second axis of T", default=0.0, at_least=-10, at_most=10)
    diameter: float = quantity("m", "diameter", default=0.0, at_least=0, at_most=10)


class Tools:
    """A table of tools by number."""

    def __init__(self, tools: Mapping[int, Tool] | None = None):
        self._tools = dict(sorted((tools or {}).items()))

    def __repr__(self) -> str:
        return f"Tools({list(self)})"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Tools) and self._tools == other._tools

    def __hash__(self) -> int:
        return hash(tuple(self))

    def to_file(self) -> dict[str, dict[str, str]]:
        """The table [tools] that `tools_of(..., from_file=True)` reads back to an equal one."""
        return {
            str(number): {"length": f"{z!r} m", "x": f"{x!r} m", "y": f"{y!r} m", "diameter": f"{diameter!r} m"}
            for number, (x, y, z), diameter in self
        }

    def __len__(self) -> int:
        return len(self._tools)

    def __iter__(self) -> Iterator[Tool]:
        return iter(self._tools.values())

    def __contains__(self, number: object) -> bool:
        return number in self._tools

    def __getitem__(self, number: int) -> Tool:
        """The tool; number 0, if the table has none, is no tool: its offset is zero.  KeyError: no such tool."""
        if number == 0 and 0 not in self._tools:
            return Tool(0, (0.0, 0.0, 0.0))
        return self._tools[number]

    def there_is(self) -> str:
        """The cure for a number that is not in the table: the first ones that are."""
        names = [f"T{number}" for number in self._tools]
        if not names:
            return "the table is empty"
        more = f" and {len(names) - 12} more" if len(names) > 12 else ""
        return f"there is {', '.join(names[:12])}{more}"


def tools_of(table: Mapping[Any, Any], from_file: bool = False) -> Tools:
    """The tools of an experiment's [tools]: number to {length, x, y, diameter}, in m; with `from_file` with units.

    Raises
    ------
    ExperimentError
        with the key of every mistake, "5.length".
    """
    found: dict[int, Tool] = {}
    problems: list[Problem] = []
    for key, entry in table.items():
        number = _number(key)
        try:
            if number is None:
                raise ExperimentError("a tool's number is a whole number above 0", value=repr(key)[:40])
            if not isinstance(entry, Mapping):
                raise ExperimentError("must be a table", value=repr(entry)[:40], cure='write { length = "80 mm" }')
            e = _Entry.from_file(entry) if from_file else _Entry(**entry)
        except (InputError, TypeError) as error:
            if isinstance(error, TypeError):  # a key that is no text
                error = ExperimentError("must be a table of named numbers", value=repr(entry)[:40])
            name = str(key)[:40]
            problems += [_under(name, p) for p in error.problems]
            continue
        found[number] = Tool(number, (e.x, e.y, e.length), e.diameter)
    if problems:
        raise ExperimentError(problems=problems)
    return Tools(found)


def tool_number(value: float, text: str, tools: Tools | None) -> int:
    """The number of a T, H or Q word, written as `text`, of a tool that is in the table, if there is one.

    Raises
    ------
    ProgramError
        it is no tool's number.
    """
    if value < 0 or value % 1:
        raise ProgramError("the number of a tool is whole, and not below 0", value=text, cure="write e.g. T5")
    number = int(value)
    if tools is not None and number and number not in tools:
        raise ProgramError("no such tool in the tool table", value=text, cure=tools.there_is())
    return number


def _number(key):
    if isinstance(key, str) and re.fullmatch(r"[0-9]{1,7}", key):
        key = int(key)
    whole = isinstance(key, int) and not isinstance(key, bool)
    return key if whole and 0 < key <= _LARGEST_NUMBER else None


def _under(name, problem):
    parts = {**vars(problem), "key": f"{name}.{problem.key}" if problem.key else name}
    return Problem(**parts)


_WORD = re.compile(r"\s*([A-Za-z])\s*([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+))(?![0-9.eE])")
_LENGTHS, _NOTHING, _REFUSED = "XYZD", "PIJQ", "ABCUVW"


def read_tool_table(text: str, file: str | None = None) -> Tools:
    """The tools of LinuxCNC's tool.tbl, lengths in mm.

    Raises
    ------
    ProgramError
        with the line.
    """
    found: dict[int, Tool] = {}
    for line, row in enumerate(text.split("\n"), 1):
        try:
            tool = _row(row.partition(";")[0].strip())
            if tool is None:
                continue
            if tool.number in found:
                raise ProgramError("a tool twice in the table", value=f"T{tool.number}", cure="remove one line")
            if len(found) >= MOST_TOOLS:
                raise ProgramError(f"a tool table has at most {MOST_TOOLS} tools", cure="remove some")
        except ProgramError as error:
            raise error.at(file=file, line=line) from None
        found[tool.number] = tool
    return Tools(found)


def _row(row: str) -> Tool | None:
    if not row:
        return None
    if len(row) > 255:
        raise ProgramError("a line has at most 255 characters", value=str(len(row)), cure="shorten it")
    values: dict[str, float] = {}
    at = 0
    while row[at:].strip():
        word = _WORD.match(row, at)
        if not word:
            raise ProgramError(
                "not a word of a tool table", value=repr(row[at:].strip()[:30]), cure="write e.g. T1 P1 Z80"
            )
        letter, value, at = word[1].upper(), float(word[2]), word.end()
        shown = word[0].strip()
        if letter in values:
            raise ProgramError(f"{letter} twice in a line", value=shown, cure="write it once")
        if letter not in "T" + _LENGTHS + _NOTHING + _REFUSED:
            raise ProgramError("no word of a tool table", value=shown, cure="remove it")
        if letter in _REFUSED and value:
            raise ProgramError("a tool has an offset in X, Y and Z only", value=shown, cure="remove it")
        if letter in _LENGTHS and not abs(value) <= _LARGEST:
            raise ProgramError(f"{letter} is beyond {_LARGEST:.0f} mm", value=shown, cure="lengths are in mm")
        values[letter] = value
    number = values.get("T")
    if number is None:
        raise ProgramError("a tool without a number", value=repr(row[:30]), cure="write T and its number")
    if not (number.is_integer() and 0 <= number <= _LARGEST_NUMBER):
        raise ProgramError("a tool's number is a whole number", value=f"T{number:g}", cure="write e.g. T5")
    x, y, z, d = (values.get(letter, 0.0) * 1e-3 for letter in _LENGTHS)
    return Tool(int(number), (x, y, z), abs(d))
