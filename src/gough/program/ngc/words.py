"""Words: what a block says, evaluated; the form in which the language hands blocks to the machine side."""

from __future__ import annotations

import functools
import re
from collections.abc import Iterable
from typing import NamedTuple

from ...errors import ProgramError
from .functions import whole

LONGEST = 252  # characters of a line, a carriage return counted: LinuxCNC refuses 253
MOST_M = 4  # M codes in a block, as in LinuxCNC

# a word can be read in one way only, else a wrong line would be tried in exponentially many; E may be an exponent
_PLAIN = re.compile(r"(?:N[0-9]+)?((?:[A-DF-MP-Z][+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+))*)")
_WORD = re.compile(r"([A-Z])([^A-Z]+)")
_WHOLE = frozenset("HLT")  # letters besides M whose number LinuxCNC wants whole


class Words(NamedTuple):
    """The words of one block.

    g       G codes times ten, in the order written: G61.1 is 611
    m       M codes
    values  the other letters' numbers, as written, in the program's unit
    texts   how a word was written: {"X": "X[#1*2]", "G1": "G01"}
    line    number of the line in the main text, from 1
    """

    g: tuple[int, ...]
    m: tuple[int, ...]
    values: dict[str, float]
    texts: dict[str, str]
    line: int


def plain(line: str, number: int) -> Words | None:
    """The words of a line of nothing but letters and numbers, quickly; None: it is no such line, or it is wrong."""
    if not line.isascii() or len(line) > LONGEST:
        return None
    found = _PLAIN.fullmatch(line.removesuffix("\r").replace(" ", "").replace("\t", "").upper())
    if found is None:
        return None
    g, m, values, texts = [], [], {}, {}
    for letter, digits in _WORD.findall(found[1]):
        if letter == "G":
            code, name = _g_code(digits)
            g.append(code)
            texts[name] = "G" + digits
        elif letter == "M":
            code = _m_code(digits)
            if code is None:
                return None
            m.append(code)
            texts[f"M{code}"] = "M" + digits
        else:
            if letter in values or letter in _WHOLE:
                return None
            values[letter] = float(digits)
            texts[letter] = letter + digits
    if len(m) > MOST_M or -1 in g:
        return None
    return Words(tuple(g), tuple(m), values, texts, number)


def sorted_words(found: Iterable[tuple[str, float, str]], number: int) -> Words:
    """Words from (letter, value, text) each.

    Raises
    ------
    ProgramError
        a code that is none, a letter twice, too many M codes; without file and line.
    """
    g, m, values, texts = [], [], {}, {}
    for letter, value, text in found:
        if letter == "G":
            code = whole10(value)
            if code is None:
                raise ProgramError(
                    "no such G code", value=text, cure="a G code has one decimal at most, e.g. G1, G61.1"
                )
            g.append(code)
            texts[_g_name(code)] = text
        elif letter == "M":
            code = whole(value)
            if code is None:
                raise ProgramError("an M code is a whole number", value=text, cure="write e.g. M3")
            m.append(code)
            texts[f"M{code}"] = text
        elif letter in values:
            raise ProgramError(f"{letter} twice in a block", value=f"{texts[letter]} {text}", cure="write it once")
        else:
            if letter in _WHOLE:
                value = _whole_value(letter, value, text)
            values[letter], texts[letter] = value, text
    if len(m) > MOST_M:
        written = " ".join(texts[f"M{code}"] for code in m[: MOST_M + 1]) + " ..." * (len(m) > MOST_M + 1)
        raise ProgramError(f"more than {MOST_M} M codes in a block", value=written, cure="write them in two blocks")
    return Words(tuple(g), tuple(m), values, texts, number)


def whole10(value: float) -> int | None:
    """A G code times ten, or None: codes have one decimal."""
    nearest = round(10 * value)
    return nearest if abs(10 * value - nearest) < 1e-3 else None


def _whole_value(letter, value, text):
    nearest = whole(value)
    if nearest is None:
        raise ProgramError(f"{letter} is a whole number", value=text, cure=f"write e.g. {letter}2")
    return float(nearest)


def _g_name(code: int) -> str:
    return f"G{code // 10}" if code % 10 == 0 else f"G{code / 10:.1f}"


@functools.lru_cache(maxsize=512)  # programs write few codes, in few ways
def _g_code(digits: str) -> tuple[int, str]:
    code = whole10(float(digits))
    return (-1, "") if code is None else (code, _g_name(code))


@functools.lru_cache(maxsize=512)
def _m_code(digits: str) -> int | None:
    return whole(float(digits))
