"""CSV and its kin: what is not a row of numbers is said with its line, and never read as something else."""

from __future__ import annotations

import json
import re
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from ...machine.record import Text
from ...quantities import brief
from .table import Block, Source, marked

LONGEST_LINE = 1 << 20  # bytes
_PIECE = 1 << 22  # bytes read at a time
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_COMMA = re.compile(r"[+-]?\d+,\d+([eE][+-]?\d+)?")


class TextRows(Source):
    """A text file of rows.  With `wait` it follows a file that is still being written."""

    row_word = "line"

    def __init__(self, path: Path, text: Text, wait: Patience | None = None):
        super().__init__(path)
        self.text, self.wait = text, wait
        self.skip = tuple(text.skip)
        lines, names = self._lines(), []
        left = text.header
        self.start = 0
        for number, line in lines:
            if self._skipped(line):
                continue
            cells = self._cells(line)
            if left == 0 or left == 1:
                names, self.start = cells, number if left else number - 1
                break
            left -= 1
        if not names:
            raise self.error("has no rows", cure="a log has a line of names and rows of numbers")
        self.count = len(names)
        self.names = (
            [cell.strip().strip('"') for cell in names] if text.header else list(map(str, range(1, len(names) + 1)))
        )

    def blocks(self, names: Sequence[str]) -> Iterator[Block]:
        places = self.places(names)
        numbers, lines = [], []
        for number, line in self._lines():
            if number is None:  # nothing more for now: hand on what there is
                if lines:
                    yield self._block(numbers, lines, places)
                    numbers, lines = [], []
                continue
            if number <= self.start or self._skipped(line):
                continue
            numbers.append(number)
            lines.append(line)
            if len(lines) == 1 << 15:
                yield self._block(numbers, lines, places)
                numbers, lines = [], []
        if lines:
            yield self._block(numbers, lines, places)

    def _others(self, name: str) -> str:
        """As above; and where all names stand in one cell, that the delimiter is another."""
        marks = [mark for mark in ";\t|," if len(self.names) == 1 and mark in self.names[0]]
        return f"write delimiter = {json.dumps(marks[0])} in [text]" if marks else super()._others(name)

    # -- lines ----------------------------------------------------------------------------------------------------

    def _lines(self) -> Iterator[tuple[int | None, str]]:
        """(number, text) of every line that is whole; (None, "") where a file that is followed has no more for now."""
        number, rest = 0, b""
        with self.path.open("rb") as file:
            while True:
                piece = file.read(_PIECE)
                if not piece:
                    yield None, ""
                    if self.wait is None or not self.wait():
                        break
                    continue
                if self.wait is not None:
                    self.wait.seen()
                if b"\0" in piece:
                    line = number + 1 + (rest + piece)[: len(rest) + piece.index(b"\0")].count(b"\n")
                    raise self.error(
                        "has a NUL byte", line=line, cure="give a text file; UTF-16 must be saved as UTF-8"
                    )
                whole, mark, tail = (rest + piece).rpartition(b"\n")
                rest = tail if mark else rest + piece
                if len(rest) > LONGEST_LINE:
                    line = number + 1 + whole.count(b"\n") + bool(mark)
                    raise self.error("a line has at most 1 MB", line=line, cure="lines end with a line feed")
                if not mark:
                    continue
                for line in self._decoded(whole, number).split("\n"):
                    number += 1
                    yield number, line.removesuffix("\r")
        if rest.strip():
            self.told.append(f"line {number + 1} has no end: it may be cut off, and is left out")

    def _decoded(self, data: bytes, before: int) -> str:
        try:
            text = data.decode("utf-8-sig" if before == 0 else "utf-8")
        except UnicodeDecodeError as error:
            line = before + 1 + data.count(b"\n", 0, error.start)
            value = f"byte 0x{data[error.start]:02x}"
            raise self.error("is not UTF-8 text", line=line, value=value, cure="save it as UTF-8") from None
        return text

    def _skipped(self, line: str) -> bool:
        return not line.strip() or line.startswith(self.skip)

    def _cells(self, line: str) -> list[str]:
        return line.split() if self.text.delimiter == " " else line.split(self.text.delimiter)

    # -- rows -----------------------------------------------------------------------------------------------------

    def _block(self, numbers: list[int], lines: list[str], places: list[int]) -> Block:
        self._check_counts(numbers, lines)
        plain = [line.replace(",", ".") for line in lines] if self.text.decimal == "," else lines
        if self.text.decimal == "," and any("." in line for line in lines) or not all(map(str.isascii, lines)):
            values = None  # a point in a number with a comma is no number, nor is a digit of another script
        else:
            values = self._fast(plain, places)
        if values is not None:
            return Block(values, np.array(numbers), marked(values))
        values, bad = np.empty((len(lines), len(places))), []
        for row, line in enumerate(lines):
            cells = self._cells(line)
            for column, place in enumerate(places):
                values[row, column], wrong = self._number(cells[place])
                if wrong:
                    bad.append((row, column, wrong))
        return Block(values, np.array(numbers), bad)

    def _check_counts(self, numbers: list[int], lines: list[str]) -> None:
        if self.text.delimiter == " ":
            counts = [len(line.split()) for line in lines]
        else:
            counts = [line.count(self.text.delimiter) + 1 for line in lines]
        for number, count, line in zip(numbers, counts, lines, strict=True):
            if count == self.count:
                continue
            cure = None
            if self.text.delimiter == "," and count > self.count:
                cure = 'are these decimal commas? write delimiter = ";" and decimal = "," if they are'
            elif count == 1 and any(mark in line for mark in ";\t|,"):
                cure = "give the delimiter in [text]"
            raise self.error(
                "every row has as many cells as there are names", line=number, value=str(count), limit=str(self.count),
                cure=cure,
            )  # fmt: skip

    def _fast(self, lines: list[str], places: list[int]) -> np.ndarray | None:
        """All cells at once, where every one is a plain number."""
        delimiter = None if self.text.delimiter == " " else self.text.delimiter
        try:
            return np.loadtxt(lines, delimiter=delimiter, comments=None, usecols=places, ndmin=2)
        except ValueError:
            return None

    def _number(self, cell: str) -> tuple[float, str]:
        """A cell as a number; NaN and what is wrong."""
        text = cell.strip().strip('"').strip()
        if not text:
            return np.nan, "nothing"
        if self.text.decimal == ",":
            if "." in text:
                return np.nan, brief(text)
            text = text.replace(",", ".")
        if not _NUMBER.fullmatch(text):
            hint = ', a decimal comma: write decimal = "," in [text]' if _COMMA.fullmatch(text) else ""
            return np.nan, brief(cell.strip()) + hint
        value = float(text)
        return (value, "") if np.isfinite(value) else (np.nan, brief(cell.strip()))


class Patience:
    """Waits for more of a file that is still being written, until nothing has come for `seconds`."""

    def __init__(self, seconds: float, pause: float = 0.2, clock=time.monotonic, sleep=time.sleep):
        self.seconds, self.pause, self.clock, self.sleep = seconds, pause, clock, sleep
        self.since: float | None = None

    def __call__(self) -> bool:
        """Wait a little; False when enough has been waited."""
        now = self.clock()
        self.since = now if self.since is None else self.since
        if now - self.since >= self.seconds:
            return False
        self.sleep(self.pause)
        return True

    def seen(self) -> None:
        """Something has come."""
        self.since = None
