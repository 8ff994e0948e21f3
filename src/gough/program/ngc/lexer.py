"""A line of an NC program to words, parameter settings or an O word; values are compiled, not evaluated.

    line    = "/"? ("N" digits)? ((word | setting | comment)* | oword comment*)
    word    = letter value
    setting = "#" value "=" value  |  "#<" name ">=" value
    oword   = "O" (value | "<" name ">") keyword ("[" expression "]")*
    comment = "(" text ")"  |  ";" text to the end of the line

Outside comments neither blanks nor case count, blanks inside numbers and names not either: "X 1 2" is X12.  Numbers
have no exponent.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from ...errors import ProgramError, did_you_mean
from .comments import asked, without_comments
from .compiler import NO_NUMBER, compile_value, read_name
from .expressions import Program, show
from .functions import whole
from .parameters import ARGUMENTS
from .words import LONGEST

KEYWORDS = (
    *("SUB", "ENDSUB", "CALL", "RETURN", "IF", "ELSEIF", "ELSE", "ENDIF"),
    *("WHILE", "ENDWHILE", "DO", "REPEAT", "ENDREPEAT", "BREAK", "CONTINUE"),
)
_KEYWORD = re.compile("(?:" + "|".join(sorted(KEYWORDS, key=len, reverse=True)) + ")")
_ONE = {"IF", "ELSEIF", "WHILE", "REPEAT"}  # need one expression
_OPTIONAL = {"ENDSUB", "RETURN"}  # may have one
_DIGITS = re.compile(r"[0-9]*")
_OTHER_FLOW = re.compile(r"IF\[|WHILE\[|GOTO|DO[0-9]|END[0-9]|ELSE|ENDIF|ENDWHILE")  # of other controls
_BLANKS = str.maketrans("", "", " \t\r")


class RawWord(NamedTuple):
    """A letter, its value or what gives it, and how the word was written."""

    letter: str
    value: float | Program
    text: str


class Setting(NamedTuple):
    """#target = value; the target is a name, a number, or what gives the number."""

    target: str | float | Program
    value: float | Program
    text: str


class OWord(NamedTuple):
    """An O line; the label is a text, or what gives a number; "" as keyword: a program number, which does nothing."""

    keyword: str
    label: str | Program
    values: tuple[float | Program, ...]
    text: str


class Line(NamedTuple):
    """One line.  `comment`: the text of a (MSG, ...); `stop`: of an (ABORT, ...)."""

    number: int
    words: tuple[RawWord, ...] = ()
    settings: tuple[Setting, ...] = ()
    oword: OWord | None = None
    deleted: bool = False
    comment: str | None = None
    stop: str | None = None


def read_line(text: str, number: int = 1, block_delete: bool = True) -> Line:
    """One line, without its line feed.  With `block_delete` nothing is read behind a "/" at its start.

    Raises
    ------
    ProgramError
        without file and line: the line is not of the grammar above.
    """
    if len(text) > LONGEST or not text.isascii() and len(text.encode(errors="replace")) > LONGEST:
        raise ProgramError(f"a line has at most {LONGEST} characters", value=str(len(text)), cure="split the line")
    if "\0" in text:
        raise ProgramError("a control character in the line", value="\\x00", cure="remove it")
    code, last = without_comments(text.removesuffix("\r"))
    if code.startswith("/") and block_delete:
        return Line(number, deleted=True)
    _check_characters(code)
    code = code.translate(_BLANKS).upper()
    at = _line_number(code, text, 1 if code.startswith("/") else 0)
    if code.startswith("O", at):
        return Line(number, oword=_o_word(code, at), **asked(last))
    if _OTHER_FLOW.match(code, at):
        cure = "write e.g. o1 if [#1 gt 2], o1 else, o1 endif; o1 while [#1 lt 9], o1 endwhile"
        raise ProgramError("a condition or loop without an O word", value=show(code[at:]), cure=cure)
    words, settings = [], []
    while at < len(code):
        c = code[at]
        if c == "(":
            at += 2
        elif c == "#":
            setting, at = _setting(code, at)
            settings.append(setting)
        elif "A" <= c <= "Z" and c not in "NO":
            value, end = _value(code, at, text)
            words.append(RawWord(c, value, code[at:end]))
            at = end
        else:
            raise _stray(code, at, text)
    return Line(number, tuple(words), tuple(settings), **asked(last))


def _check_characters(code: str) -> None:
    for c in code:
        if not c.isascii():
            raise ProgramError("a character that is not ASCII, outside a comment", value=show(c))
        if ord(c) < 32 and c != "\t" or ord(c) == 127:
            raise ProgramError("a control character in the line", value=f"\\x{ord(c):02x}", cure="remove it")


def _line_number(code: str, text: str, at: int) -> int:
    if not code.startswith("N", at):
        return at
    end = _DIGITS.match(code, at + 1).end()
    if end == at + 1 or code[end : end + 1] == ".":
        raise ProgramError("a line number is a whole number", value=show(code[at:]), cure="write e.g. N10")
    return end


def _value(code: str, at: int, text: str):
    """The value behind a letter."""
    try:
        value, end = compile_value(code, at + 1)
    except ProgramError as error:
        if error.problems[0].rule == NO_NUMBER:
            raise _no_number(code, at) from None
        raise
    after = code[end : end + 2]
    if type(value) is float and after:
        if after[0] == "E" and re.search(r"[0-9.]E[0-9+-]", text.upper()):
            raise ProgramError("a number has no exponent", value=show(code[at:]), cure="write all its digits")
        if after[0] == ",":
            raise ProgramError("a number has a point, not a comma", value=show(code[at:]), cure="write a point")
        if after[0] == "O" and re.search(r"[0-9.]O", text.upper()):
            raise _letter_o(code, at)
    if after[:1] in ("+", "-", "*") or after[:1] == "/":
        raise ProgramError("an expression stands in brackets", value=show(code[at:]), cure="write e.g. X[1+2]")
    return value, end


def _no_number(code, at):
    letter = code[at]
    if code.startswith("O", at + 1):
        return _letter_o(code, at)
    return ProgramError(f"{letter} has no number", value=show(code[at:]), cure=f"write e.g. {letter}10")


def _letter_o(code, at):
    return ProgramError("a letter O in a number", value=show(code[at:]), cure="did you mean zero?")


def _setting(code: str, at: int) -> tuple[Setting, int]:
    start = at
    if code.startswith("<", at + 1):
        target, at = read_name(code, at + 1)
    else:
        target, at = compile_value(code, at + 1)
    if code[at : at + 1] != "=":
        cure = "write e.g. #1=2, or a letter in front: X#1"
        raise ProgramError("a parameter without a letter, and without a value", value=show(code[start:]), cure=cure)
    try:
        value, at = compile_value(code, at + 1)
    except ProgramError as error:
        if error.problems[0].rule == NO_NUMBER:
            cure = "write e.g. #1=2 or #1=[#2+1]"
            raise ProgramError('a number is missing behind "="', value=show(code[start:]), cure=cure) from None
        raise
    if code[at : at + 1] in ("+", "-", "*", "/"):
        raise ProgramError("an expression stands in brackets", value=show(code[start:]), cure="write e.g. #1=[#2+1]")
    return Setting(target, value, code[start:at]), at


def _o_word(code: str, at: int) -> OWord:
    start = at
    if code.startswith("<", at + 1):
        label, at = read_name(code, at + 1)
    else:
        try:
            label, at = compile_value(code, at + 1)
        except ProgramError as error:
            if error.problems[0].rule == NO_NUMBER:
                cure = "write e.g. O100 or O<name>"
                raise ProgramError("an O word without a label", value=show(code[start:]), cure=cure) from None
            raise
        if type(label) is float:
            label = label_of(label)
    keyword = _KEYWORD.match(code, at)
    if keyword is None:
        rest = code[at:].replace("()", "")
        if not rest:
            return OWord("", label, (), code[start:at])
        word = re.match(r"[A-Z]*", rest)[0]
        cure = did_you_mean(word.lower(), [name.lower() for name in KEYWORDS])
        raise ProgramError("no such O word", value=show(code[start:]), cure=cure)
    name, at = keyword[0], keyword.end()
    values = []
    while at < len(code):
        if code[at] == "(" and (name == "CALL" or not code.startswith("()[", at)):
            at += 2
            continue
        if code[at] != "[":
            break
        value, at = compile_value(code, at)
        values.append(value)
    written = show(code[start:])
    if name in _ONE and not values:
        lacks, example = ("a count", "10") if name == "REPEAT" else ("a condition", "#1 lt 10")
        cure = f"write e.g. {name.lower()} [{example}]"
        raise ProgramError(f"{name.lower()} without {lacks} in brackets", value=written, cure=cure)
    most = ARGUMENTS if name == "CALL" else 1 if name in _ONE | _OPTIONAL else 0
    if len(values) > most or at < len(code):
        if name == "CALL" and len(values) > most:
            raise ProgramError(f"a call has at most {most} arguments", value=str(len(values)), cure="use #<_names>")
        raise ProgramError(f"something behind {name.lower()}", value=written, cure="write it on a line of its own")
    return OWord(name, label, tuple(values), code[start:])


def label_of(number: float) -> str:
    """The label that a number stands for.

    Raises
    ------
    ProgramError
        it is not a whole number from 0 on.
    """
    n = whole(number)
    if n is None or n < 0:
        raise ProgramError(
            "the number of an O word is whole", value=f"O{number:.6g}", cure="write e.g. O100 or O<name>"
        )
    return str(n)


def _stray(code: str, at: int, text: str) -> ProgramError:
    c, rest = code[at], show(code[at:])
    if c == "N":
        return ProgramError("N is not the first word of its line", value=rest, cure="remove it")
    if c == "O":
        return ProgramError("an O word is not the first of its line", value=rest, cure="write it on a line of its own")
    if c == "/":
        return ProgramError('"/" stands only at the start of a line', value=rest, cure="remove it")
    if code == "%":
        return ProgramError('"%" ends a program only if its first line is "%"', cure="write M2")
    if c == "%":
        return ProgramError('"%" stands alone on its line', value=rest)
    if c == "[":
        return ProgramError("an expression without a letter", value=rest, cure="write e.g. X[1+2]")
    if c.isdigit() or c in "+-.":
        return ProgramError("a number without a letter", value=rest)
    if c == ")":
        return ProgramError('")" without "("', value=rest)
    return ProgramError("not a word", value=rest)
