"""Lines of an NC program to words.

    line = ["%"] | (N integer)? (word | comment)*          word    = letter number
    number = digits, at most one point, a sign in front     comment = "(" text ")" | ";" text to the end of the line

Blanks may stand anywhere but inside a number.  Case does not count.  Numbers have no exponent.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from ..errors import ProgramError

LONGEST = 255  # characters of a line; LinuxCNC's buffer holds 256
LARGEST = 1e6  # of any number but N: a kilometre in mm is no machine tool's business

_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)")
# comments that LinuxCNC acts on; (MSG, ...) is only shown
_ACTIVE = re.compile(r"\s*(LOG|LOGOPEN|LOGAPPEND|LOGCLOSE|PROBEOPEN|PROBECLOSE|DEBUG|PRINT|PY|ABORT)\s*[,)]", re.I)

_PROGRAM_NUMBER = re.compile(r"\s*O\s*[0-9]+\s*(?:\([^()]*\)\s*)*(?:;.*)?", re.I)


class Word(NamedTuple):
    """A letter, its number, and how it was written."""

    letter: str
    value: float
    text: str


def words(line: str) -> list[Word]:
    """The words of one line, comments left out.

    Raises
    ------
    ProgramError
        without file and line: the line is not of the grammar above.
    """
    if len(line) > LONGEST:
        raise ProgramError(f"a line has at most {LONGEST} characters", value=str(len(line)), cure="split the line")
    control = next((c for c in line if ord(c) < 32 and c != "\t" or ord(c) == 127), None)
    if control is not None:
        raise ProgramError("a control character in the line", value=f"\\x{ord(control):02x}", cure="remove it")
    out, at = [], 0
    while at < len(line):
        c = line[at]
        if c in " \t":
            at += 1
        elif c == "(":
            at = _comment(line, at)
        elif c == ";":
            break
        elif c.isascii() and c.isalpha():
            word, at = _word(line, at)
            out.append(word)
        else:
            raise _stray(line, at, out)
    return out


def _comment(line, at):
    end = line.find(")", at)
    if end < 0:
        raise ProgramError("a comment is not closed", value=_show(line[at:]), cure='write ")" at its end')
    if "(" in line[at + 1 : end]:
        raise ProgramError("a comment inside a comment", value=_show(line[at : end + 1]), cure='remove the second "("')
    active = _ACTIVE.match(line[at + 1 : end + 1])
    if active:
        raise ProgramError(
            "a comment that asks for an action is not in the subset", value=_show(line[at : end + 1]), cure="remove it"
        )
    return end + 1


def _word(line, at):
    letter, start = line[at].upper(), at
    at += 1
    while at < len(line) and line[at] in " \t":
        at += 1
    found = _NUMBER.match(line, at)
    if letter == "O":
        raise _o_word(line, start)
    if not found:
        following = line[at : at + 1]
        if following in ("O", "o"):
            raise _letter_o(line, start)
        if following in ("#", "["):
            raise ProgramError(
                "parameters and expressions are not in the subset", value=_show(line[start:]), cure="write the number"
            )
        raise ProgramError(f"{letter} has no number", value=_show(line[start:]), cure=f"write e.g. {letter}10")
    end = found.end()
    after = line[end : end + 2].upper()
    if re.match(r"E[0-9+-]", after):
        raise ProgramError("a number has no exponent", value=_show(line[start:]), cure="write all its digits")
    if after[:1] == ".":
        raise ProgramError("a number has one point at most", value=_show(line[start:]), cure="remove one")
    if after[:1] == ",":
        raise ProgramError("a number has a point, not a comma", value=_show(line[start:]), cure="write a point")
    if after[:1] == "O":
        raise _letter_o(line, start)
    value = float(found[0])
    if letter != "N" and not abs(value) <= LARGEST:
        cure = "F is mm/min: write at most" if letter == "F" else "write at most"
        raise ProgramError(f"{letter} is beyond {LARGEST:.0f}", value=_show(found[0]), cure=f"{cure} {LARGEST:.0f}")
    return Word(letter, value, f"{letter}{found[0]}"), end


def _o_word(line, at):
    if _PROGRAM_NUMBER.fullmatch(line):
        number = _show(line[at:].partition("(")[0].partition(";")[0])
        cure = "remove it: programs have no number"
        return ProgramError("a program number is not in the subset", value=number, cure=cure)
    rule = "O words (subroutines, conditions, loops) are not in the subset"
    return ProgramError(rule, value=_show(line[at:]), cure="write out the blocks that it runs")


def _letter_o(line, start):
    return ProgramError("a letter O in a number", value=_show(line[start:]), cure="did you mean zero?")


def _stray(line, at, before):
    c, rest = line[at], _show(line[at:])
    if not c.isascii():
        return ProgramError("a character that is not ASCII, outside a comment", value=_show(c))
    if c == "/" and not before:
        return ProgramError("block delete is not in the subset", value=rest, cure='remove the "/", or the line')
    if c == "%":
        return ProgramError('"%" stands alone on its line', value=rest)
    if c in "#[":
        return ProgramError("parameters and expressions are not in the subset", value=rest, cure="write the number")
    if c.isdigit() or c in "+-.":
        return ProgramError("a number without a letter", value=rest)
    if c == ")":
        return ProgramError('")" without "("', value=rest)
    return ProgramError("not a word", value=rest)


def _show(text):
    text = text.strip()
    return repr(text if len(text) <= 30 else text[:27] + "...")
