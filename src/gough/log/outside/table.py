"""What every reader of a foreign log gives: names, and tables of numbers, a block of rows at a time.

source.names                          columns that there are
for block in source.blocks(names):    rows in order; the memory is that of one block
    block.values   (n, k)             NaN where a cell is empty or no finite number
    block.bad      [(row, column, what stands there)]
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...errors import LogError, nearest
from ...quantities import brief

_SHOWN, _LONGEST = 12, 160  # names, characters of a text out of a file in a message
ROWS = 1 << 16  # of a block; 7 MB for 13 columns


class Block(NamedTuple):
    """Rows of a log, in order."""

    values: np.ndarray  # (n, k)
    lines: np.ndarray  # (n,) line of the file, or number of the row from 1
    bad: list[tuple[int, int, str]]  # (row of the block, column of `values`, what stands there)


class Source(ABC):
    """A file with columns."""

    row_word = "row"  # what a number of Block.lines counts

    def __init__(self, path: Path):
        self.path = path
        self.told: list[str] = []  # what was found beside the rows

    names: list[str]

    @abstractmethod
    def blocks(self, names: Sequence[str]) -> Iterator[Block]:
        """The rows of these columns.  LogError where a row cannot be read as a row."""

    def places(self, names: Sequence[str]) -> list[int]:
        """Where these columns stand.

        Raises
        ------
        LogError
            there is no such column, or two of the name.
        """
        found = []
        for name in names:
            count = self.names.count(name)
            if count > 1:
                raise self.error("two columns have this name", value=brief(name), cure="give each a name of its own")
            if count == 0:
                raise self.error("the file has no such column", value=brief(name), cure=self._others(name))
            found.append(self.names.index(name))
        return found

    def _others(self, name: str) -> str:
        """What to do about a column that is not there."""
        near = nearest(name, self.names)
        more = f", and {len(self.names) - _SHOWN} more" if len(self.names) > _SHOWN else ""
        return f"did you mean {near}?" if near else f"there is {', '.join(self.names[:_SHOWN]) or 'none'}{more}"

    def error(self, rule: str, **parts) -> LogError:
        """An error of this file; what was read of it stands there printable, and not longer than a line."""
        shown = {key: printable(text) if isinstance(text, str) else text for key, text in parts.items()}
        return LogError(rule, file=str(self.path), **shown)


def printable(text: str) -> str:
    """A text out of a file for a message: escapes for what no terminal shows, and an end where it is long."""
    shown = "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
    return shown if len(shown) <= _LONGEST else f"{shown[: _LONGEST - 3]}..."


def marked(values: np.ndarray, told: str = "no number") -> list[tuple[int, int, str]]:
    """`bad` of a block whose cells are numbers already: those that are not finite, which become NaN."""
    wrong = ~np.isfinite(values)
    if not wrong.any():
        return []
    out = []
    for row, column in np.argwhere(wrong):
        cell = values[row, column]
        out.append((int(row), int(column), told if np.isnan(cell) else f"{cell}"))
    values[wrong] = np.nan
    return out
