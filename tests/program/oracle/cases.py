"""The tables of bad programs in tests/program/bad: program, what we say to it, and where LinuxCNC thinks otherwise.

--- title of the case
the program, to the next line of one of the other kinds
=> a line of our message, "part.ngc" as its file
~~ the row of docs/nc-differences.md that says why LinuxCNC accepts it
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

FOLDER = Path(__file__).parents[1] / "bad"
FILE = "part.ngc"


class Case(NamedTuple):
    """One bad program."""

    table: str
    title: str
    text: str
    message: str
    difference: str | None

    def __str__(self):
        return f"{self.table}: {self.title}"


def cases() -> list[Case]:
    """Every case of every table, in order."""
    out = []
    for table in sorted(FOLDER.glob("*.txt")):
        _, *parts = table.read_text().split("\n--- ")
        out += [_case(table.stem, part) for part in parts]
    return out


def _case(table, part):
    title, *lines = part.rstrip("\n").split("\n")
    program = [line for line in lines if line[:3] not in ("=> ", "~~ ")]
    while program and not program[-1]:
        program.pop()
    message = "\n".join(line[3:] for line in lines if line.startswith("=> "))
    difference = next((line[3:] for line in lines if line.startswith("~~ ")), None)
    return Case(table, title, "".join(f"{line}\n" for line in program), message, difference)


def rewritten(table: str, message) -> str:
    """The table with every message as `message(case)` has it.  To be read before it is believed."""
    head, *parts = (FOLDER / f"{table}.txt").read_text().split("\n--- ")
    out = [head.rstrip("\n")]
    for part in parts:
        case = _case(table, part)
        lines = [f"--- {case.title}", *case.text.rstrip("\n").split("\n")]
        lines += [f"=> {line}" for line in message(case).split("\n")]
        lines += [f"~~ {case.difference}"] if case.difference else []
        out.append("\n".join(lines))
    return "\n\n".join(out) + "\n"
