"""NC programs to blocks: the whole way, and what is wrong with a program.

The first mistake ends the execution: what follows depends on it.  The lines of the main text behind it are still read,
one by one, and codes and words that could never be right are told too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from ...errors import Problem, ProgramError
from ..blocks import Blocks, Rest
from . import block
from .flow import run
from .interpreter import Interpreter
from .lexer import read_line
from .parameters import Parameters
from .tools import Tools, tools_of
from .words import sorted_words

MOST_PROBLEMS = 50
_MOST_COUNTED = 10_000  # wrong lines; a file with more is no NC program and is not read on
_ENDS = (2, 30)


def read_program(
    text: str,
    file: str | None = None,
    *,
    tools: Tools | Mapping | None = None,
    parameters: Parameters | None = None,
    folders: Sequence[Path] = (),
    steps: int = 1_000_000,
    block_delete: bool = True,
    tell: Callable[[int, int], None] | None = None,
) -> Blocks:
    """The blocks of an NC program, in the frame of its zero, SI.

    tools         a tool table, or {number: {"length": m, "x": m, "y": m, "diameter": m}}; None: every tool is the data
                  sheet's, and G43 offsets nothing
    parameters    the numbered parameters to begin with, those of LinuxCNC's .var file; they are changed
    folders       where subroutines in files of their own are looked for
    steps         lines that may run more than once over the length of the text
    block_delete  leave out the lines that begin with "/"
    tell          called with (lines done, lines of the text) now and then

    Raises
    ------
    ProgramError
        with file and line of the first fifty problems, and how many lines more are wrong.
    """
    if tools is not None and not isinstance(tools, Tools):
        tools = tools_of(tools)
    parameters = parameters or Parameters()
    blocks = Blocks()
    found = _Found(file)
    try:
        machine = Interpreter(parameters, blocks, tools)
        run(
            text, machine.execute, parameters, file=file, folders=folders, steps=steps, block_delete=block_delete,
            tell=tell,
        )  # fmt: skip
        if not any(_moves(one) for one in blocks):
            raise ProgramError(
                "the program moves nothing", line=_last_line(text), cure="write a G0 or G1 with an axis word"
            )
    except ProgramError as error:
        found.add(error, None)
        line = error.problems[0].line
        if line is not None and error.problems[0].file in (None, file):
            _read_on(text, line, block_delete, found)
    found.tell()
    return blocks


def _moves(one) -> bool:
    return type(one.segment) is not Rest or one.dwell > 0 or one.abc0 != one.abc1


def _last_line(text: str) -> int:
    lines = text.split("\n")
    return max((n for n, line in enumerate(lines, 1) if line.strip()), default=1)


def _read_on(text, line, block_delete, found):
    """What is wrong in the lines behind `line`, whatever the program does."""
    for number, written in enumerate(text.split("\n")[line:], line + 1):
        if written.strip() == "%":
            return
        try:
            read = read_line(written, number, block_delete)
            words = sorted_words(((w.letter, w.value, w.text) for w in read.words if _is_code(w)), number)
            block.sort(words)
        except ProgramError as error:
            found.add(error, number)
            if found.more >= _MOST_COUNTED:
                return
            continue
        if any(code in _ENDS for code in words.m):
            return


def _is_code(word) -> bool:
    """A word whose number is written out: what an expression gives is not known here."""
    return isinstance(word.value, float)


class _Found:
    """The problems of a program: the first ones whole, of the rest the number of lines."""

    def __init__(self, file: str | None):
        self.file = file
        self.problems: list[Problem] = []
        self.more, self.since = 0, None

    def add(self, error: ProgramError, line: int | None):
        room = MOST_PROBLEMS - len(self.problems)
        problems = error.at(file=self.file, line=line).problems
        self.problems += problems[:room]
        if len(problems) > room:
            self.more += 1
            self.since = self.since or line or problems[0].line

    def tell(self):
        if self.more:
            count = "1 line more is" if self.more == 1 else f"{self.more} lines more are"
            if self.more >= _MOST_COUNTED:
                count, cure = f"{count} wrong, and there may be more", "check that this is an NC program"
            else:
                count, cure = f"{count} wrong", None
            self.problems.append(Problem(f"from here on {count}", file=self.file, line=self.since, cure=cure))
        if self.problems:
            raise ProgramError(problems=self.problems)
