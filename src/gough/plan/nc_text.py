"""Lines of NC programs as they are written: their code without comments, their F, and what else they say."""

from __future__ import annotations

import math
import re
from typing import NamedTuple

from ..errors import ProgramError
from ..program.ngc.lexer import RawWord, read_line

_NUMBER = re.compile(r"^\s*/?\s*(N\s*\d[\d\s]*)", re.I)
_MOTIONS = {0.0, 1.0, 2.0, 3.0}
_PLAIN = set("GXYZABCIJKRPF")
_F = re.compile(r"F", re.I)
_VALUE = re.compile(r"\s*[+-]?(?:[\d.][\d.\s]*|#\s*(?:\d+|<[^>]*>))")
_RAPID = re.compile(r"G\s*0*0(?![\d.])\s*", re.I)


class Written(NamedTuple):
    """A line of a program.  `words` of it; whether it only moves, so that it may become several lines."""

    text: str
    number: str  # "N20 ", or nothing
    words: tuple[RawWord, ...]
    motion: int | None  # the G0 to G3 that it says itself
    has_feed: bool
    only_moves: bool

    def of(self, letters: str) -> list[str]:
        """Its words of these letters, as written."""
        return [word.text for word in self.words if word.letter in letters]


def written(text: str, number: int, block_delete: bool = True) -> Written:
    """A line of an NC program that has run.

    Raises
    ------
    ProgramError
        the line is a call, a condition or a loop.
    """
    read = read_line(text, number, block_delete)
    if read.oword is not None:
        raise ProgramError(
            "the feed of moves in a called file cannot be changed", line=number, value=text.strip()[:40],
            cure="copy the subroutine into the program",
        )  # fmt: skip
    codes = [word.value for word in read.words if word.letter == "G"]
    motions = [int(code) for code in codes if code in _MOTIONS]
    only = not text.lstrip().startswith("/") and not read.settings and read.comment is None and read.stop is None
    only = only and all(word.letter in _PLAIN for word in read.words) and all(code in _MOTIONS for code in codes)
    label = _NUMBER.match(text)
    return Written(
        text, f"{''.join(label[1].split())} " if label else "", read.words, motions[0] if motions else None,
        any(word.letter == "F" for word in read.words), only,
    )  # fmt: skip


def with_feed(text: str, feed: str) -> str:
    """The line with `feed` ("F1200") for its F, or behind its words where it has none.

    Raises
    ------
    ProgramError
        an F whose value is a formula.
    """
    code, rest = _parted(text)
    for found in _F.finditer(code):
        at = found.start()
        if code[:at].count("[") > code[:at].count("]") or code[:at].count("<") > code[:at].count(">"):
            continue  # of a function or a name
        value = _VALUE.match(code, at + 1)
        end = value.end() if value else _closed(code, at + 1)
        if end is None:
            raise ProgramError("an F that cannot be replaced", value=text.strip()[:40], cure="write a number")
        tail = code[end:]
        space = " " if tail and not tail[0].isspace() else ""
        blank = code[at:end][len(code[at:end].rstrip()) :]  # spaces behind the number stay
        return f"{code[:at]}{feed}{blank or space}{tail}{rest}"
    bare = code.rstrip()
    return f"{bare} {feed}{code[len(bare) :]}{rest}" if bare else f"{feed} {rest}"


def with_motion(text: str, code: int) -> str:
    """The line with G`code` for its G0, or before its words where it says no motion."""
    head, rest = _parted(text)
    if _RAPID.search(head):
        return _RAPID.sub(f"G{code} ", head, count=1) + rest
    label = _NUMBER.match(head)
    at = label.end() if label else 0
    return f"{head[:at]}{'' if not at or head[at - 1].isspace() else ' '}G{code} {head[at:].lstrip()}{rest}"


def _parted(text: str) -> tuple[str, str]:
    """The code up to the first comment, and the rest."""
    found = [at for at in (text.find("("), text.find(";")) if at >= 0]
    at = min(found) if found else len(text)
    return text[:at], text[at:]


def _closed(code: str, at: int) -> int | None:
    """Behind the bracket that opens at `at`, spaces skipped; None where none does."""
    while at < len(code) and code[at].isspace():
        at += 1
    if at >= len(code) or code[at] != "[":
        return None
    depth = 0
    for end in range(at, len(code)):
        depth += (code[end] == "[") - (code[end] == "]")
        if depth == 0:
            return end + 1
    return None


def number_text(value: float, decimals: int) -> str:
    """A number without needless zeros."""
    text = f"{value:.{decimals}f}".rstrip("0").rstrip(".") if decimals else f"{value:.0f}"
    return "0" if text in ("-0", "") else text


def feed_text(value: float, digits: int = 5) -> str:
    """F and a number: never above `value`, and short; as it is where it is short already."""
    decimals = max(digits - 1 - math.floor(math.log10(value)), 0)
    near = round(value, decimals)
    if abs(near - value) > 1e-9 * value:
        near = math.floor(value * 10**decimals) / 10**decimals
    return f"F{number_text(near, decimals)}"
