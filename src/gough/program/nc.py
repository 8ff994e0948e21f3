"""NCProgram: an NC program with all that says what it does, so that the same object is the same motion everywhere."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Mapping
from pathlib import Path as FilePath
from typing import Any, ClassVar

from pydantic import Field, field_validator, model_validator

from ..errors import InputError, ProgramError
from .base import Program
from .blocks import Blocks
from .ngc.parameters import LAST, Parameters
from .ngc.read import read_program
from .ngc.search import Called
from .ngc.tools import Tools, tools_of
from .path import Path
from .progress import tell

_NOTHING = "G0 X1\nM2\n"  # the shortest program: to check the options before the text


class NCProgram(Program):
    """An NC program in the dialect of LinuxCNC, see the package ngc.  `name` is where its errors point to."""

    input_error: ClassVar[type[InputError]] = ProgramError

    text: str = Field(description="the NC program", repr=False)
    name: str = "program"
    subroutines: dict[str, str] = Field(default={}, description="texts of called files by name", repr=False)
    tools: Tools | None = Field(None, description="lengths of the tools by number; else all are the data sheet's")
    parameters: dict[int, float] = Field(default={}, description="numbered parameters at the start, lengths in mm")
    block_delete: bool = Field(True, description='leave out the lines that begin with "/"')
    steps: int = Field(1_000_000, description="lines that loops and calls may run", ge=1, le=100_000_000)

    def to_file(self) -> dict[str, Any]:
        out = super().to_file()
        out |= {"parameters": {str(number): value for number, value in self.parameters.items()}}
        return out | ({} if self.tools is None else {"tools": self.tools.to_file()})

    @field_validator("tools", mode="before")
    @classmethod
    def _tools(cls, raw: Any) -> Any:
        if not isinstance(raw, Mapping):
            return raw
        written = any(isinstance(value, str) for entry in raw.values() for value in getattr(entry, "values", list)())
        return tools_of(raw, from_file=written)

    @field_validator("parameters", mode="before")
    @classmethod
    def _numbers_of(cls, raw: Any) -> Any:
        if not isinstance(raw, Mapping):
            return raw
        numbers = {int(key) if isinstance(key, str) and key.isdecimal() else key: value for key, value in raw.items()}
        for number in numbers:
            if type(number) is int and not 1 <= number <= LAST:
                raise InputError(f"parameters go from 1 to {LAST}", value=str(number))
        return numbers

    def __repr__(self) -> str:
        return f"NCProgram({self.name!r}, {len(self.text.splitlines())} lines)"

    __str__ = __repr__

    @model_validator(mode="after")
    def _check_text(self):
        self.path()
        return self

    def path(self) -> Path:
        return _path(self)

    def _read(self, text: str, folder: Mapping[str, str]) -> Blocks:
        """The blocks of `text` with the options of this program; `folder`: the files it may call, by name."""
        parameters = Parameters()
        for number, value in self.parameters.items():
            parameters.keep(number, value)
        try:
            return read_program(
                text, self.name, tools=self.tools, parameters=parameters, folders=[folder], steps=self.steps,
                block_delete=self.block_delete, tell=lambda done, lines: tell("reading", done / max(lines, 1)),
            )  # fmt: skip
        except ProgramError as error:
            raise error.at(file=self.name) from None


def nc_program(make, text: str, name: str, folders: Iterable[FilePath], **options: Any) -> NCProgram:
    """An NC program whose called files are looked for in `folders` and kept with it.

    `make` is NCProgram or NCProgram.from_file, as the options are written.

    Raises
    ------
    ProgramError
        with file and line; InputError for a wrong option.
    """
    called = Called(tuple(folders))
    if "call" in text.lower():  # only a program that calls has to be read twice
        options_only: NCProgram = make({**options, "text": _NOTHING, "name": name})
        options_only._read(text, called)
    return make({**options, "text": text, "name": name, "subroutines": dict(called.texts)})


@functools.lru_cache(maxsize=2)
def _path(program: NCProgram) -> Path:
    try:
        return Path(program._read(program.text, program.subroutines))
    except ProgramError as error:  # of the path; those of the text have their file
        raise error.at(file=program.name) from None
