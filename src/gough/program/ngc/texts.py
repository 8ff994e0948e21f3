"""A text that runs: the main program or a file of subroutines, between its percent signs."""

from __future__ import annotations

from ...errors import ProgramError
from .expressions import show
from .lexer import Line, read_line
from .structure import structure_of
from .words import Words


class Text:
    """Lines and their structure.  Indices of lines count from 0.

    first, end  the lines that run are lines[first:end]
    percent     the first line is "%"
    closed      there is the second "%", which ends the program
    kept        what was read of the lines that run again
    """

    def __init__(self, text: str, file: str | None, block_delete: bool):
        self.lines = text.split("\n")
        self.file, self.block_delete = file, block_delete
        begin = next((index for index, line in enumerate(self.lines) if line.strip()), 0)
        self.percent = _is_percent(self.lines[begin])
        self.first = begin + 1 if self.percent else 0
        self.end, self.closed = len(self.lines), False
        if self.percent:
            found = next((n for n in range(self.first, self.end) if _is_percent(self.lines[n])), None)
            if found is not None:
                self.end, self.closed = found, True
        self.kept: dict[int, Words | Line] = {}
        try:
            self.structure = structure_of(self.lines, self.first, self.end, block_delete)
        except ProgramError as error:
            raise error.at(file=file) from None

    def no_end(self) -> ProgramError:
        """The error of a program that ran to its last line."""
        last = next((n for n in range(len(self.lines), 0, -1) if self.lines[n - 1].strip()), 1)
        cure = 'write "%" or M2 as its last line' if self.percent else "write M2 or M30 as its last line"
        return ProgramError("the program has no end", line=last, cure=cure)

    def check_behind(self, index: int) -> None:
        """The end of the program is lines[index]: a block that can never run is a mistake.

        Raises
        ------
        ProgramError
            with the line; not where the end stands in a condition, a loop or a subroutine.
        """
        jumps = self.structure.jumps
        if any(at < index < jump.end for at, jump in jumps.items()):
            return
        index += 1
        while index < self.end:
            jump = jumps.get(index)
            if jump is not None and jump.keyword == "SUB":
                index = jump.end
            elif self._says_something(index):
                rule, value = "a block behind the end of the program", show(self.lines[index])
                raise ProgramError(rule, line=index + 1, value=value, cure="remove it")
            index += 1

    def _says_something(self, index: int) -> bool:
        line = self.lines[index]
        if not line.strip() or _is_percent(line):
            return False
        try:
            found = read_line(line, index + 1, self.block_delete)
        except ProgramError:
            return True
        return bool(found.words or found.settings or found.oword and found.oword.keyword)


def _is_percent(line: str) -> bool:
    return line.strip() == "%"
