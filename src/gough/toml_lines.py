"""Where each key of a TOML text stands.

tomllib keeps no line numbers, so this scanner walks the text a second time and notes the line of every key path.  It is
not a parser: the text has already passed tomllib, values are skipped, not read.  Paths are dotted, entries of arrays
are numbered from 0, quotes around keys are dropped: "platform.mass", "controller.1.kind", "joints.base.value.0".
"""

from __future__ import annotations

import re
import tomllib
from bisect import bisect_right

_SPACE = re.compile(r"[ \t]*")
_BLANK = re.compile(r"(?:[ \t\r\n]+|#[^\n]*)*")
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_STRING = re.compile(
    r'"""(?:[^"\\]|\\.|"(?!""))*"{3,5}'  # up to two quotes may stand before the closing three
    r"|'''(?:[^']|'(?!''))*'{3,5}"
    r'|"(?:[^"\\\n]|\\.)*"'
    r"|'[^'\n]*'",
    re.DOTALL,
)
_PLAIN = re.compile(r"[^,\]}#\n]*")  # numbers, booleans, dates
_TOKEN = re.compile(f"{_STRING.pattern}|#[^\n]*|([][{{}}.=,\n\"'])", re.DOTALL)

Path = tuple[str, ...]


def too_deep(text: str, most: int) -> int | None:
    """The offset where brackets nest, or a dotted key grows, beyond `most` levels; None if nowhere.

    Works on any text, valid or not, in linear time: it guards the recursive parser of tomllib.
    """
    brackets = dots = 0
    for match in _TOKEN.finditer(text):
        token = match[1]
        if token is None:
            continue
        if token in "\"'":
            return None  # a string that never ends: tomllib will say so and go no deeper
        if token in "[{":
            brackets += 1
        elif token in "]}":
            brackets -= 1
        dots = dots + 1 if token == "." else 0
        if brackets + dots > most:
            return match.start()
    return None


def key_lines(text: str) -> dict[str, int]:
    """The line, from 1, of every key path of a valid TOML text."""
    return _Scanner(text).run()


class _Scanner:
    def __init__(self, text: str):
        self.text = text
        self.at = 0
        self.starts = [0] + [match.end() for match in re.finditer("\n", text)]
        self.lines: dict[str, int] = {}
        self.count: dict[Path, int] = {}  # entries of each array of tables

    def run(self) -> dict[str, int]:
        table: Path = ()
        while self._skip(_BLANK) < len(self.text):
            if self.text.startswith("[[", self.at):
                table = self._header(2)
            elif self.text[self.at] == "[":
                table = self._header(1)
            else:
                self._pair(table)
        return self.lines

    def _header(self, brackets: int) -> Path:
        line = self._line()
        self.at += brackets
        name, self.at = self._key(), self.at + brackets
        path: Path = ()
        for i, part in enumerate(name):
            path += (part,)
            self._note(path, line)
            last = i == len(name) - 1
            if last and brackets == 2:
                self.count[path] = self.count.get(path, -1) + 1
            if path in self.count:  # a header through an array of tables means its newest entry
                path += (str(self.count[path]),)
                self._note(path, line)
        if brackets == 1:
            self.lines[".".join(path)] = line  # its own header places a table better than that of a child above it
        return path

    def _pair(self, table: Path) -> None:
        line = self._line()
        path = table
        for part in self._key():
            path += (part,)
            self._note(path, line)
        self.at += 1  # "="
        self._skip(_SPACE)
        self._value(path)

    def _value(self, path: Path) -> None:
        first = self.text[self.at : self.at + 1]
        if first == "[":
            self.at += 1
            entry = 0
            while self.text[self._skip(_BLANK)] != "]":
                self._note(path + (str(entry),), self._line())
                self._value(path + (str(entry),))
                if self.text[self._skip(_BLANK)] == ",":
                    self.at += 1
                entry += 1
            self.at += 1
        elif first == "{":
            self.at += 1
            while self.text[self._skip(_BLANK)] != "}":
                self._pair(path)
                if self.text[self._skip(_BLANK)] == ",":
                    self.at += 1
            self.at += 1
        else:
            match = _STRING.match(self.text, self.at) or _PLAIN.match(self.text, self.at)
            self.at = match.end()

    def _key(self) -> Path:
        parts = []
        while True:
            self._skip(_SPACE)
            match = _BARE_KEY.match(self.text, self.at) or _STRING.match(self.text, self.at)
            parts.append(_unquote(match[0]))
            self.at = match.end()
            self._skip(_SPACE)
            if self.text[self.at] != ".":
                return tuple(parts)
            self.at += 1

    def _skip(self, pattern: re.Pattern) -> int:
        self.at = pattern.match(self.text, self.at).end()
        return self.at

    def _line(self) -> int:
        return bisect_right(self.starts, self.at)

    def _note(self, path: Path, line: int) -> None:
        self.lines.setdefault(".".join(path), line)


def _unquote(key: str) -> str:
    if key[0] not in "\"'":
        return key
    return key[1:-1] if "\\" not in key or key[0] == "'" else tomllib.loads(f"k = {key}")["k"]
