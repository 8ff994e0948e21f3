"""Programs from files: an NC program, or the [program] table of an experiment."""

from __future__ import annotations

import functools
import os
import stat
from collections.abc import Mapping
from pathlib import Path as FilePath
from typing import Any, ClassVar

from pydantic import Field, model_validator

from ..complaints import beside
from ..errors import ExperimentError, InputError, Problem, ProgramError, did_you_mean
from .base import Program
from .gcode import read_gcode
from .path import Path
from .piece import CircleDiamondSquare
from .standard import Circle, Ellipse, Line, Polyline

KINDS: dict[str, type[Program]] = {
    "circle": Circle,
    "ellipse": Ellipse,
    "line": Line,
    "polyline": Polyline,
    "circle_diamond_square": CircleDiamondSquare,
}
LARGEST_FILE = 64 * 1024 * 1024  # bytes


class NCProgram(Program):
    """An NC program, see gcode.py.  `name` is where its errors point to."""

    input_error: ClassVar[type[InputError]] = ProgramError

    text: str = Field(description="the NC program", repr=False)
    name: str = "program"

    @model_validator(mode="after")
    def _check_text(self):
        _path(self.text, self.name)
        return self

    def path(self) -> Path:
        return _path(self.text, self.name)


@functools.lru_cache(maxsize=4)
def _path(text: str, name: str) -> Path:
    try:
        return Path(read_gcode(text, name))
    except ProgramError as error:
        raise error.at(file=name) from None


def load_program(path: str | os.PathLike, **options: Any) -> NCProgram:
    """The NC program in the file `path`; `options` are those of Program (acceleration, corner, settle, origin, ...).

    Raises
    ------
    ProgramError
        the file cannot be read, or is no NC program of the subset (with the line).
    """
    return NCProgram(text=read_text(path), name=FilePath(path).name, **options)


def program_from_table(table: Mapping[str, Any], folder: str | os.PathLike = ".") -> Program:
    """The program of an experiment's [program] table: `file`, relative to `folder`, or `kind`, and options.

    Raises
    ------
    InputError
        with the key of every mistake.
    """
    options = dict(table)
    if "file" in options and "kind" in options:
        raise ExperimentError("a program has a file or a kind, not both", key="kind")
    if "file" in options:
        name = options.pop("file")
        if not isinstance(name, str):
            raise ExperimentError("must be the name of a file", key="file", value=repr(name)[:40])
        try:
            text = read_text(FilePath(folder) / name)
        except ProgramError as error:
            raise ExperimentError(error.problems[0].rule, key="file", value=name) from None
        wrong = [key for key in ("text", "name") if key in options]
        if wrong:
            raise ExperimentError("no such key", key=wrong[0])
        return NCProgram.from_file({**options, "text": text, "name": FilePath(name).name})
    if "kind" not in options:
        raise ExperimentError("is missing", key="kind", cure='write file = "part.ngc" or kind = "circle"')
    kind = options.pop("kind")
    if not isinstance(kind, str) or kind not in KINDS:
        wrong = Problem("no such program", key="kind", value=repr(kind)[:40], cure=did_you_mean(str(kind), KINDS))
        others = beside(kind, KINDS, lambda near: KINDS[near].from_file(options))
        raise ExperimentError(problems=[wrong, *others])
    return KINDS[kind].from_file(options)


def read_text(path: str | os.PathLike) -> str:
    """The text of a regular file of at most 64 MB, UTF-8.

    Raises
    ------
    ProgramError
        with the file's name.
    """
    path = FilePath(path)
    try:
        info = os.stat(path)
        if not stat.S_ISREG(info.st_mode):
            raise ProgramError("not a file", file=str(path))
        with open(path, "rb") as file:
            data = file.read(LARGEST_FILE + 1)
    except OSError as error:
        raise ProgramError(f"cannot be read: {error.strerror}", file=str(path)) from None
    if len(data) > LARGEST_FILE:
        raise ProgramError("an NC program has at most 64 MB", file=str(path))
    if b"\0" in data:
        line = data[: data.index(b"\0")].count(b"\n") + 1
        raise ProgramError("a NUL byte: this is no text", file=str(path), line=line)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        cure = "save it as ASCII or UTF-8"
        raise ProgramError("the text is not UTF-8", file=str(path), line=line, cure=cure) from None
