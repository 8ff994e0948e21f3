"""The order in which the lines of a program run: subroutines, conditions and loops, within a budget of steps."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from ...errors import ProgramError, nearest
from .expressions import evaluate, show
from .lexer import Line, Setting, label_of, read_line
from .parameters import Parameters
from .search import LARGEST_FILE, find_subroutine
from .structure import Jump, name_of
from .texts import Text
from .words import Words, plain, sorted_words

DEEPEST = 9  # calls inside one another; LinuxCNC refuses the tenth
MOST_FILES = 100  # of subroutines
_MOST_KEPT = 20_000  # lines of loops and subroutines that are kept as words
_TELL_EVERY = 1000  # lines

Execute = Callable[[Words], bool]


def run(
    text: str,
    execute: Execute,
    parameters: Parameters,
    *,
    file: str | None = None,
    folders: Sequence[Path] = (),
    steps: int = 1_000_000,
    block_delete: bool = True,
    tell: Callable[[int, int], None] | None = None,
) -> None:
    """Run a program: `execute` gets the words of every line that runs and says whether they end the program.

    steps         lines that may run more than once over the length of the text, and then the program is refused
    block_delete  lines that begin with "/" are left out
    tell          called with (lines done, lines of the text) every thousand lines

    Raises
    ------
    ProgramError
        with the line, and the file where it is not `text`'s.
    """
    _Run(text, execute, parameters, file, tuple(folders), steps, block_delete, tell).run()


class _Call(NamedTuple):
    """What a call interrupted."""

    text: Text
    index: int  # of the line with the call
    counts: dict[int, int]


class _Run:
    def __init__(self, text, execute, parameters, file, folders, steps, block_delete, tell):
        self.block_delete, self.folders = block_delete, folders
        self.main = self.text = Text(text, file, block_delete)
        self.execute, self.parameters, self.tell = execute, parameters, tell
        self.steps, self.left = steps, steps + len(self.main.lines)
        self.index = self.main.first
        self.counts: dict[int, int] = {}  # repetitions left, by index of REPEAT
        self.calls: list[_Call] = []
        self.files: list[str] = []
        self.room = LARGEST_FILE  # characters that files may still have
        self.known: dict[str, tuple[Text, int]] = {}  # subroutines that ran past or were called: text, index of SUB
        self.ahead: set[str] = set()  # those of the main text that were called before their line was reached
        self.kept = 0
        parameters.system["_line"] = lambda: self.index + 1.0

    def run(self):
        try:
            self._run()
        except ProgramError as error:
            raise error.at(line=self.index + 1, file=self.text.file) from None

    def _run(self):
        do = {
            "SUB": self._sub, "ENDSUB": self._return, "CALL": self._call, "RETURN": self._return, "IF": self._if,
            "ELSEIF": self._else, "ELSE": self._else, "ENDIF": self._next, "WHILE": self._while,
            "ENDWHILE": self._back, "DO": self._next, "UNTIL": self._until, "REPEAT": self._repeat,
            "ENDREPEAT": self._repeated, "BREAK": self._back, "CONTINUE": self._back,
        }  # fmt: skip
        countdown = _TELL_EVERY
        while True:
            text, index = self.text, self.index
            if index >= text.end:
                if text.closed:
                    return
                raise text.no_end()
            if self.left <= 0:
                raise self._endless()
            self.left -= 1
            jump = text.structure.jumps.get(index)
            if jump is not None:
                do[jump.keyword](jump)
            else:
                words = self._words(text, index)
                if words is not None and self.execute(words):
                    if not self.calls:
                        text.check_behind(index)
                    return
                self.index = index + 1
            countdown -= 1
            if countdown == 0:
                countdown = _TELL_EVERY
                if self.tell:
                    self.tell(self._main_index(), len(self.main.lines))

    # -- plain lines ----------------------------------------------------------------------------------------------

    def _words(self, text: Text, index: int) -> Words | None:
        """The words of a line, its parameters set; None if there are none."""
        kept = text.kept.get(index)
        if kept is None:
            kept = self._read(text.lines[index], index)
            if text.structure.repeated[index] and self.kept < _MOST_KEPT:
                text.kept[index] = kept
                self.kept += 1
        if type(kept) is Line:
            return self._evaluate(kept)
        if not kept.texts:
            return None
        return kept if text is self.main else kept._replace(line=self._told_index() + 1)

    def _read(self, written: str, index: int) -> Words | Line:
        words = plain(written, index + 1)
        if words is not None:
            return words
        line = read_line(written, index + 1, self.block_delete)
        constant = all(type(word.value) is float for word in line.words)
        if line.settings or line.stop is not None or not constant:
            return line
        return sorted_words(line.words, index + 1)

    def _evaluate(self, line: Line) -> Words | None:
        if line.stop is not None:
            raise ProgramError("the program stops itself here", value=show(f"(ABORT,{line.stop})"))
        found = [(letter, self._value(value), text) for letter, value, text in line.words]
        words = sorted_words(found, self._told_index() + 1)
        # all values of a line are those from before it, LinuxCNC's rule
        settings = [self._setting(setting) for setting in line.settings]
        for target, value in settings:
            if isinstance(target, str):
                self.parameters.set_named(target, value)
            else:
                self.parameters.set(target, value)
        return words if found else None

    def _setting(self, setting: Setting) -> tuple[str | float, float]:
        target = setting.target
        return target if isinstance(target, str) else self._value(target), self._value(setting.value)

    def _value(self, value) -> float:
        return value if type(value) is float else evaluate(value, self.parameters)

    def _main_index(self) -> int:
        """Index of the line of the main text that runs, or that made the first of the calls."""
        return self.calls[0].index if self.calls else self.index

    def _told_index(self) -> int:
        """Index of the line that is told: in a file of subroutines, that of the line in the main text which called."""
        called = (call.index for call in reversed(self.calls) if call.text is self.main)
        return self.index if self.text is self.main else next(called)

    # -- O lines --------------------------------------------------------------------------------------------------

    def _next(self, jump: Jump):
        self.index += 1

    def _back(self, jump: Jump):
        self.index = jump.target

    def _else(self, jump: Jump):
        self.index = jump.end

    def _if(self, jump: Jump):
        jumps = self.text.structure.jumps
        while jump.keyword in ("IF", "ELSEIF") and not self._value(jump.word.values[0]):
            self.index = jump.target
            jump = jumps[self.index]
        self.index += 1

    def _while(self, jump: Jump):
        self.index = self.index + 1 if self._value(jump.word.values[0]) else jump.end + 1

    def _until(self, jump: Jump):
        self.index = jump.target + 1 if self._value(jump.word.values[0]) else self.index + 1

    def _repeat(self, jump: Jump):
        count = round(self._value(jump.word.values[0]))
        self.counts[self.index] = count
        self.index = self.index + 1 if count > 0 else jump.end + 1

    def _repeated(self, jump: Jump):
        self.counts[jump.target] -= 1
        self.index = jump.target + 1 if self.counts[jump.target] > 0 else self.index + 1

    # -- subroutines ----------------------------------------------------------------------------------------------

    def _sub(self, jump: Jump):
        label = jump.word.label
        if label in self.ahead:
            cure = "write it before the first call, or behind M2"
            raise ProgramError("a subroutine that was called before its lines", value=show(jump.word.text), cure=cure)
        if label in self.known:
            cure = "write it outside the loop"
            raise ProgramError("a subroutine is defined a second time", value=show(jump.word.text), cure=cure)
        self.known[label] = (self.text, self.index)
        self.index = jump.end + 1

    def _call(self, jump: Jump):
        label = jump.word.label
        label = label if isinstance(label, str) else label_of(self._value(label))
        arguments = [self._value(value) for value in jump.word.values]
        if len(self.calls) >= DEEPEST:
            cure = "check the condition that ends the recursion"
            raise ProgramError(f"more than {DEEPEST} calls inside one another", value=show(jump.word.text), cure=cure)
        text, index = self._find(label)
        self.parameters.enter(arguments)
        self.calls.append(_Call(self.text, self.index, self.counts))
        self.text, self.index, self.counts = text, index + 1, {}

    def _return(self, jump: Jump):
        values = jump.word.values
        self.parameters.leave(self._value(values[0]) if values else None)
        self.text, index, self.counts = self.calls.pop()
        self.index = index + 1

    def _find(self, label: str) -> tuple[Text, int]:
        """The text and the index of SUB: one that ran past, else one further down, else that of a file."""
        found = self.known.get(label)
        if found is None:
            place = self.text.structure.subs.get(label)
            if place is not None and place < self.index:
                rule = "a subroutine whose lines were not reached before its call"
                raise ProgramError(rule, value=name_of(label), cure="write it outside conditions, or behind the call")
            if place is not None:
                found = self.text, place
                if self.text is self.main:
                    self.ahead.add(label)
            else:
                found = self._file(label)
            self.known[label] = found
        return found

    def _file(self, label: str) -> tuple[Text, int]:
        try:
            found = find_subroutine(label, self.folders)
        except ProgramError as error:
            wrong = error.problems[0]
            if wrong.line is None:  # the call is to be told, not a line of the file
                told = f"{label}.ngc {wrong.rule}" if wrong.file else wrong.rule
                raise ProgramError(told, value=wrong.value, cure=wrong.cure) from None
            raise
        if found is None:
            subs = self.text.structure.subs
            near = nearest(label, itertools.islice(subs, 1000))
            where = f", or as {label}.ngc in the program's folder" if self.folders else ""
            cure = f"did you mean {name_of(near)}?" if near else f"write it in this file{where}"
            raise ProgramError("no such subroutine", value=name_of(label), cure=cure)
        path, text = found
        if len(self.files) >= MOST_FILES:
            raise ProgramError(f"more than {MOST_FILES} files of subroutines", value=repr(path.name))
        self.room -= len(text)
        if self.room < 0:
            rule = f"files of subroutines have at most {LARGEST_FILE >> 20} MB together"
            raise ProgramError(rule, value=repr(path.name), cure="split the program")
        self.files.append(label)
        unit = Text(text, str(path), self.block_delete)
        if label not in unit.structure.subs:
            cure = f"write {name_of(label)} sub and {name_of(label)} endsub around its lines"
            raise ProgramError(
                "the file has no such subroutine", value=name_of(label), file=str(path), line=1, cure=cure
            )
        return unit, unit.structure.subs[label]

    # -- mistakes -------------------------------------------------------------------------------------------------

    def _endless(self) -> ProgramError:
        loop = self.text.structure.loop_around(self.index)
        line = (self.index if loop is None else loop) + 1
        value = f"{self.steps} lines run beyond the length of the text"
        return ProgramError("possible endless loop", line=line, value=value, cure="check the condition that ends it")
