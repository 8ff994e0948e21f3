"""The O lines of a text, matched: where each condition, loop and subroutine goes on.  Found before anything runs.

Labels belong to the subroutine they stand in, or to the main program, and each is one construct's.  Constructs lie
inside one another or apart.
"""

from __future__ import annotations

import itertools
import re
from typing import NamedTuple

from ...errors import ProgramError
from .expressions import Program, show
from .lexer import OWord, read_line

DEEPEST = 100  # conditions and loops inside one another

_O_LINE = re.compile(r"(/?)[ \t]*(?:N[ \t0-9]*)?O", re.I)
_BEGINS = {"IF": "endif", "WHILE": "endwhile", "REPEAT": "endrepeat", "DO": "while", "SUB": "endsub"}
_ENDS = {"ENDIF": "IF", "ENDWHILE": "WHILE", "ENDREPEAT": "REPEAT", "ENDSUB": "SUB"}


class Jump(NamedTuple):
    """An O line in its place: the word, and the index of the line to go on at when it jumps.

    IF, ELSEIF     target: the next ELSEIF, ELSE or ENDIF      end: the ENDIF
    ELSE           end: the ENDIF
    WHILE, REPEAT  end: the ENDWHILE, ENDREPEAT                UNTIL (the WHILE of a DO) target: the DO
    ENDWHILE, ENDREPEAT    target: the WHILE, REPEAT
    BREAK          target: the last line of the loop           CONTINUE target: the line with the loop's condition
    SUB            end: the ENDSUB                             RETURN, ENDSUB target: the SUB
    """

    keyword: str
    word: OWord
    target: int = -1
    end: int = -1


class Structure(NamedTuple):
    """Indices of lines count from 0.

    jumps     of the O lines
    subs      index of SUB, by label
    loops     the first and the last line of each
    repeated  1 for lines of loops and subroutines, a byte for each line
    """

    jumps: dict[int, Jump]
    subs: dict[str, int]
    loops: list[tuple[int, int]]
    repeated: bytearray

    def loop_around(self, index: int) -> int | None:
        """Index of the first line of the innermost loop that a line stands in."""
        around = [first for first, last in self.loops if first <= index <= last]
        return max(around, default=None)


class _Open(NamedTuple):
    keyword: str
    label: str
    index: int
    branches: list[int]  # IF: its IF, ELSEIF and ELSE lines
    exits: list[int]  # loops: their BREAK and CONTINUE lines


def structure_of(lines: list[str], first: int, end: int, block_delete: bool) -> Structure:
    """The structure of lines[first:end].

    Raises
    ------
    ProgramError
        with the line.
    """
    return _Builder(lines, first, end, block_delete).build()


class _Builder:
    def __init__(self, lines, first, end, block_delete):
        self.lines, self.first, self.end, self.block_delete = lines, first, end, block_delete
        self.jumps: dict[int, Jump] = {}
        self.subs: dict[str, int] = {}
        self.loops: list[tuple[int, int]] = []
        self.edges = [0] * (len(lines) + 1)  # +1 where a repeated stretch begins, -1 behind its end
        self.open: list[_Open] = []
        self.labels: dict[str, int] = {}  # of this subroutine, or of the main program
        self.outer: dict[str, int] = {}

    def build(self) -> Structure:
        for index in range(self.first, self.end):
            found = _O_LINE.match(self.lines[index].lstrip(" \t"))
            if found is None or found[1] and self.block_delete:
                continue
            try:
                word = read_line(self.lines[index], index + 1, self.block_delete).oword
                if word is not None and word.keyword:
                    self._take(index, word)
            except ProgramError as error:
                raise error.at(line=index + 1) from None
        if self.open:
            self._not_ended(self.open[-1])
        repeated = bytearray(depth > 0 for depth in itertools.accumulate(self.edges))
        return Structure(self.jumps, self.subs, self.loops, repeated)

    def _take(self, index: int, word: OWord):
        keyword, label = word.keyword, word.label
        if keyword == "CALL":
            self.jumps[index] = Jump(keyword, word)
            return
        if isinstance(label, Program):
            cure = "write a number or a name; only call computes its label"
            raise ProgramError(f"{keyword.lower()} with a computed label", value=show(word.text), cure=cure)
        if keyword == "RETURN":
            self._return(index, word)
        elif keyword in ("BREAK", "CONTINUE"):
            self._leave(index, word)
        elif keyword in ("ELSEIF", "ELSE"):
            self._branch(index, word)
        elif keyword in _ENDS or keyword == "WHILE" and self._innermost_is("DO", label):
            self._close(index, word)
        else:
            self._begin(index, word)

    def _innermost_is(self, keyword, label):
        return bool(self.open) and (self.open[-1].keyword, self.open[-1].label) == (keyword, label)

    # -- beginnings -----------------------------------------------------------------------------------------------

    def _begin(self, index, word):
        keyword, label = word.keyword, word.label
        if keyword == "SUB":
            around = next((o for o in self.open if o.keyword == "SUB"), None)
            if around:
                rule = "a subroutine inside another"
                raise ProgramError(
                    rule, value=show(word.text), cure=f"write endsub for {name_of(around.label)} before it"
                )
            if label in self.subs:
                rule = f"a second subroutine {name_of(label)}, the first is in line {self.subs[label] + 1}"
                raise ProgramError(rule, value=show(word.text), cure="give it another label")
            self.subs[label] = index
            self.outer, self.labels = self.labels, {}
        else:
            if label in self.labels:
                rule = f"the label {name_of(label)} is already that of line {self.labels[label] + 1}"
                raise ProgramError(rule, value=show(word.text), cure="give it another label")
            self.labels[label] = index
        if len(self.open) >= DEEPEST:
            rule = f"more than {DEEPEST} conditions and loops inside one another"
            raise ProgramError(rule, value=show(word.text), cure="use subroutines")
        self.open.append(_Open(keyword, label, index, [index], []))
        self.jumps[index] = Jump(keyword, word)

    # -- ends -----------------------------------------------------------------------------------------------------

    def _close(self, index, word):
        keyword, label = word.keyword, word.label
        begins = _ENDS.get(keyword, "DO")
        if not self._innermost_is(begins, label):
            self._unmatched(word, begins)
        opened = self.open.pop()
        jump = self.jumps[opened.index]
        if keyword == "ENDIF":
            self._end_if(index, word, opened)
            return
        if keyword == "WHILE":
            self.jumps[index] = Jump("UNTIL", word, target=opened.index)
        else:
            self.jumps[index] = Jump(keyword, word, target=opened.index)
        self.jumps[opened.index] = jump._replace(end=index)
        self.edges[opened.index] += 1
        self.edges[index + 1] -= 1
        if keyword == "ENDSUB":
            self.labels = self.outer
            return
        self.loops.append((opened.index, index))
        for at in opened.exits:
            leave = self.jumps[at]
            again = index if begins == "DO" else opened.index
            self.jumps[at] = leave._replace(target=index + 1 if leave.keyword == "BREAK" else again)

    def _end_if(self, index, word, opened):
        self.jumps[index] = Jump("ENDIF", word)
        for at, target in itertools.pairwise([*opened.branches, index]):
            self.jumps[at] = self.jumps[at]._replace(target=target, end=index)

    def _unmatched(self, word, begins):
        label, keyword = word.label, word.keyword.lower()
        if any((o.keyword, o.label) == (begins, label) for o in self.open):
            inner = self.open[-1]
            rule = f"{keyword} before the {_BEGINS[inner.keyword]} of {name_of(inner.label)} in line {inner.index + 1}"
            raise ProgramError(rule, value=show(word.text), cure="end what begins last first")
        of = next((o for o in reversed(self.open) if o.keyword == begins), None)
        cure = (
            f"did you mean {name_of(of.label)}?"
            if of
            else f"write {name_of(label)} {begins.lower()} before it, or remove it"
        )
        raise ProgramError(f"{keyword} without its {begins.lower()}", value=show(word.text), cure=cure)

    def _not_ended(self, opened):
        needs = _BEGINS[opened.keyword]
        cure = f"write {name_of(opened.label)} {needs}{' [...]' if needs == 'while' else ''}"
        rule = f"{opened.keyword.lower()} without its {needs}"
        raise ProgramError(rule, value=show(self.jumps[opened.index].word.text), cure=cure, line=opened.index + 1)

    # -- in between -----------------------------------------------------------------------------------------------

    def _branch(self, index, word):
        if not self._innermost_is("IF", word.label):
            self._unmatched(word, "IF")
        branches = self.open[-1].branches
        if self.jumps[branches[-1]].keyword == "ELSE":
            raise ProgramError(f"{word.keyword.lower()} behind else", value=show(word.text), cure="write else last")
        branches.append(index)
        self.jumps[index] = Jump(word.keyword, word)

    def _return(self, index, word):
        around = next((o for o in self.open if o.keyword == "SUB"), None)
        if around is None:
            raise ProgramError("return outside a subroutine", value=show(word.text), cure="write M2 to end the program")
        if around.label != word.label:
            cure = f"write {name_of(around.label)} return"
            raise ProgramError("return with the label of another subroutine", value=show(word.text), cure=cure)
        self.jumps[index] = Jump("RETURN", word, target=around.index)

    def _leave(self, index, word):
        opened = next((o for o in reversed(self.open) if o.label == word.label and o.keyword != "SUB"), None)
        if opened is None or opened.keyword not in ("WHILE", "DO"):
            inner = next((o for o in reversed(self.open) if o.keyword in ("WHILE", "DO")), None)
            cure = f"did you mean {name_of(inner.label)}?" if inner else "write it inside while or do"
            rule = f"{word.keyword.lower()} is not inside a while or do loop of its label"
            raise ProgramError(rule, value=show(word.text), cure=cure)
        opened.exits.append(index)
        self.jumps[index] = Jump(word.keyword, word)


def name_of(label: str) -> str:
    """How a label is written: O100, O<name>."""
    return f"O{label}" if label.isdigit() else f"O<{label}>"
