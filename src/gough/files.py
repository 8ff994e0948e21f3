"""Files: TOML with line numbers, reading with care, writing that is whole or not at all.

Everything read here may come from a stranger: sizes and depths are capped before anything is parsed, nothing is
executed, and what is wrong is said with file, line, rule and cure.  Everything written here is complete or not there:
a file is made beside its place, flushed to the disk and moved over the old one.
"""

from __future__ import annotations

import dataclasses
import os
import re
import shutil
import stat
import tomllib
import unicodedata
import uuid
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .errors import ExperimentError, InputError, StorageError, nearest
from .names import printable
from .toml_lines import key_lines, too_deep

LARGEST_TOML = 256 * 1024  # bytes; the largest sheet of the library has 8 kB
DEEPEST_TOML = 32
MOST_KEYS = 5000  # the largest sheet of the library has 90

# characters that reorder or hide text on the screen: what a reader sees would not be what is read
_HIDDEN = re.compile("[\u200b-\u200f\u202a-\u202e\u2060-\u2069\ufeff\u061c]")


# -- reading --------------------------------------------------------------------------------------------------------


def read_text(path: str | Path, largest: int, kind: type[InputError] = ExperimentError) -> str:
    """The UTF-8 text of a regular file of at most `largest` bytes.

    Raises
    ------
    InputError
        of the given kind: no such file, a folder, device or pipe, too large, not UTF-8.
    """
    path = Path(path)
    try:
        # a pipe would block and a device never end: ask what it is before opening, and again once open
        if not stat.S_ISREG(os.stat(path).st_mode):
            raise kind("must be a regular file", file=str(path), value=_what(os.stat(path).st_mode))
        with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise kind("must be a regular file", file=str(path), value=_what(os.fstat(file.fileno()).st_mode))
            data = file.read(largest + 1)
            size = max(len(data), os.fstat(file.fileno()).st_size)
    except FileNotFoundError:
        raise kind("no such file", file=str(path), cure=_neighbour(path)) from None
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        if isinstance(error, InputError):
            raise
        raise kind(
            "cannot be read", file=printable(str(path)), value=getattr(error, "strerror", None) or str(error)
        ) from None
    if size > largest:
        raise kind(
            f"a file of this kind has at most {largest // 1024} kB", file=str(path), value=f"{size / 1024:.0f} kB"
        )
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise kind(
            "is not UTF-8 text",
            file=str(path),
            line=line,
            value=f"byte 0x{data[error.start]:02x}",
            cure="save it as UTF-8",
        ) from None


@dataclasses.dataclass(frozen=True)
class Document:
    """A TOML file that was read: its data, and the line of every key."""

    path: Path
    text: str
    data: dict[str, Any]
    lines: dict[str, int]

    def line(self, key: str) -> int | None:
        """Line, from 1, of a dotted key ("controller.0.kind"); None if the file has no such key."""
        return self.lines.get(key)

    def locate(self, error: InputError, prefix: str = "") -> InputError:
        """The same error with file, line and full key on every problem that has no file yet.

        `prefix` is the table that the keys of the error are relative to.  A key that is missing is placed at the
        nearest table above it that is there.
        """
        placed = []
        for problem in error.problems:
            if problem.file is None:
                key = ".".join(part for part in (prefix, problem.key) if part)
                problem = dataclasses.replace(
                    problem, file=str(self.path), line=problem.line or self._nearest_line(key), key=key or None
                )
            placed.append(problem)
        return type(error)(problems=placed)

    def _nearest_line(self, key: str) -> int | None:
        while key:
            if key in self.lines:
                return self.lines[key]
            key = key.rpartition(".")[0]
        return None


def read_toml(path: str | Path, kind: type[InputError] = ExperimentError) -> Document:
    """Read a TOML file of at most 256 kB and 32 levels.

    Raises
    ------
    InputError
        of the given kind, with file and line: unreadable, too large or deep, malformed, a key given twice.
    """
    return parse_toml(read_text(path, LARGEST_TOML, kind), path, kind)


def parse_toml(text: str, path: str | Path, kind: type[InputError] = ExperimentError) -> Document:
    """`read_toml` of a text that is at hand already; `path` is only named in errors."""
    hidden = _HIDDEN.search(text)
    if hidden:
        name = unicodedata.name(hidden[0], "unnamed")
        raise kind(
            f"a character that hides or reorders text, at column {_column(text, hidden.start())}",
            file=str(path),
            line=_line(text, hidden.start()),
            value=f"U+{ord(hidden[0]):04X} {name}",
            cure="delete it",
        )
    place = too_deep(text, DEEPEST_TOML)
    if place is not None:
        raise kind(
            f"nested deeper than {DEEPEST_TOML} levels at column {_column(text, place)}",
            file=str(path),
            line=_line(text, place),
        )
    try:
        data = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise _malformed(error, text, path, kind) from None
    lines = key_lines(text)
    document = Document(Path(path), text, data, lines)
    keys = _check_values(document, data, (), kind)
    if keys > MOST_KEYS:
        raise kind(f"a file of this kind has at most {MOST_KEYS} keys", file=str(path), value=str(keys))
    return document


def _check_values(document: Document, value: Any, path: tuple[str, ...], kind: type[InputError]) -> int:
    """Refuse what is too deep or too large; the number of keys."""
    keys = 0
    if len(path) > DEEPEST_TOML:
        raise document.locate(kind(f"nested deeper than {DEEPEST_TOML} levels", key=".".join(path)))
    if isinstance(value, dict):
        for key, inner in value.items():
            keys += 1 + _check_values(document, inner, path + (key,), kind)
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            keys += _check_values(document, inner, path + (str(i),), kind)
    elif isinstance(value, int) and not -(2**63) <= value < 2**63:
        raise document.locate(kind("a whole number of TOML has 64 bits", key=".".join(path), value="more"))
    return keys


def _malformed(error: Exception, text: str, path: str | Path, kind: type[InputError]) -> InputError:
    if "integer string conversion" in str(error):
        return kind("a whole number of TOML has 64 bits", file=str(path), value="thousands of digits")
    match = re.fullmatch(r"(.*) \(at line (\d+), column (\d+)\)", str(error), re.DOTALL)
    if match:
        rule, line, column = match[1], int(match[2]), int(match[3])
    else:
        rule = str(error).removesuffix(" (at end of document)")
        end = text.rstrip()
        line, column = _line(end, len(end)), _column(end, len(end))
    rule = f"not valid TOML at column {column}: {rule[:1].lower()}{rule[1:]}"
    return kind(rule, file=str(path), line=line, cure=_cure(rule, text.split("\n")[:line]))


def _cure(rule: str, lines: list[str]) -> str | None:
    """What to write instead of the last of these lines."""
    written = lines[-1].strip() if lines else ""
    if re.search("cannot (overwrite|declare|mutate)|duplicate", rule):
        name = written.partition("=")[0].strip()
        for i in range(len(lines) - 2, -1, -1):
            if lines[i].partition("=")[0].strip() == name:
                return f"{name} stands in line {i + 1} already: keep one of the two"
        return "each key and table is given once: keep one of the two"
    quantity = re.match(r"[^=]+=\s*([-+]?[.\d][-+.\w]* ?[A-Za-z%][\w /^*%-]*)(?:#.*)?$", written)
    if quantity and re.search("expected newline|invalid value", rule):
        return f'a quantity is a text in quotes: write "{quantity[1].strip()}"'
    word = re.match(r"[^=]+=\s*([A-Za-z][\w.-]*)\s*(?:#.*)?$", written)
    if word and "invalid value" in rule:
        return f'a text stands in quotes: write "{word[1]}"'
    if "illegal character '\\n'" in rule:
        return "a text ends in the line where it begins: close its quote"
    if "expected '='" in rule:
        return "write key = value"
    return "close it with ]" if "unclosed array" in rule else None


def _line(text: str, offset: int) -> int:
    return text.count("\n", 0, offset) + 1


def _column(text: str, offset: int) -> int:
    return offset - text.rfind("\n", 0, offset)


def _what(mode: int) -> str:
    kinds = ((stat.S_ISDIR, "a folder"), (stat.S_ISFIFO, "a pipe"), (stat.S_ISSOCK, "a socket"))
    return next((name for test, name in kinds if test(mode)), "a device")


def _neighbour(path: Path) -> str | None:
    """The cure for a file that is not there: one beside it with nearly the same name."""
    try:
        stems = {entry.stem: entry for entry in path.parent.iterdir() if entry.suffix == path.suffix}
    except OSError:
        return None
    found = nearest(path.stem, stems)
    return f"did you mean {stems[found]}?" if found else None


# -- writing --------------------------------------------------------------------------------------------------------


def write_atomic(path: str | Path, content: bytes | str | Callable[[Path], Any]) -> Path:
    """Write a file so that at any time either the old or the whole new one is there.

    `content` is the bytes, the text (UTF-8), or a function that writes the file whose path it is given; that path has
    the suffix of `path`.

    Raises
    ------
    StorageError
        the disk is full, the folder is not there or not writable.  The old file is intact, nothing is left behind.
    """
    path = Path(path)
    temporary = path.with_name(f".{uuid.uuid4().hex[:12]}.partial-{path.name}")
    try:
        try:
            if callable(content):
                content(temporary)
            else:
                temporary.write_bytes(content.encode() if isinstance(content, str) else content)
            sync(temporary)
            os.replace(temporary, path)
            sync(path.parent)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise storage_error(error, path) from error
    return path


def sync(path: Path) -> None:
    """Have the disk hold a file or a folder's entries before going on."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def storage_error(error: OSError, path: str | Path) -> StorageError:
    """What went wrong while writing `path`, with the space that is left there."""
    return StorageError(
        "cannot be written",
        file=printable(str(path)),
        value=error.strerror or str(error),
        cure=free_space(Path(path).absolute().parent),
    )


def free_space(folder: Path) -> str | None:
    """ "12.3 GB free on /data", of the nearest folder above that exists."""
    for place in (folder, *folder.parents):
        try:
            free = shutil.disk_usage(place).free
        except OSError:
            continue
        return f"{free / 1e9:.1f} GB free in {place}" if free >= 1e9 else f"{free / 1e6:.1f} MB free in {place}"
    return None
