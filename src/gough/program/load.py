"""Programs from files: an NC program, or the [program] table of an experiment.

An NC program is named by a library name ("cone-frustum") or a path (with a / or a . in it), as machines are.
"""

from __future__ import annotations

import os
import stat
from collections.abc import Mapping
from importlib import resources
from pathlib import Path as FilePath
from typing import Any

from ..complaints import beside
from ..errors import ExperimentError, Problem, ProgramError, did_you_mean
from .base import Program
from .nc import NCProgram, nc_program
from .ngc.parameters import Parameters
from .ngc.tools import Tools, read_tool_table, tools_of
from .standard import (
    Circle,
    CircleDiamondSquare,
    CircularTest,
    ConeFrustum,
    Ellipse,
    Fourier,
    Line,
    Polyline,
    SPiece,
    Spline,
    SquareCorners,
    Zigzag,
)

KINDS: dict[str, type[Program]] = {
    "circle": Circle,
    "ellipse": Ellipse,
    "line": Line,
    "polyline": Polyline,
    "spline": Spline,
    "fourier": Fourier,
    "circle_diamond_square": CircleDiamondSquare,
    "circular_test": CircularTest,
    "square_corners": SquareCorners,
    "zigzag": Zigzag,
    "cone_frustum": ConeFrustum,
    "s_piece": SPiece,
}
LARGEST_FILE = 64 * 1024 * 1024  # bytes


def pieces() -> dict[str, FilePath]:
    """The NC programs that come with gough, test pieces of machine tools: name -> path."""
    folder = FilePath(str(resources.files("gough.program") / "pieces"))
    return {path.stem: path for path in sorted(folder.glob("*.ngc"), key=lambda path: path.stem)}


def find_program(name_or_path: str | os.PathLike, folder: str | os.PathLike = ".") -> FilePath:
    """Path of an NC program; relative paths start at `folder`.

    Raises
    ------
    ProgramError
        no program of the library has this name; the nearest is said.
    """
    text = str(name_or_path)
    if not isinstance(name_or_path, str) or "/" in text or "." in text or os.sep in text:
        return FilePath(folder) / text
    known = pieces()
    if text not in known:
        beside = FilePath(folder) / text
        cure = f"write ./{text} for the file" if _is_file(beside) else did_you_mean(text[:60], known)
        raise ProgramError("no program of the library has this name", value=ascii(text)[:60], cure=cure)
    return known[text]


def _is_file(path: FilePath) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # a name too long, or with a NUL
        return False


def load_program(
    name_or_path: str | os.PathLike,
    *,
    tools: Tools | Mapping | str | os.PathLike | None = None,
    parameters: Mapping[int, float] | str | os.PathLike | None = None,
    subroutines: str | os.PathLike | None = None,
    **options: Any,
) -> NCProgram:
    """The NC program of a library name ("cone-frustum"), or in a file at a path ("part.ngc", "./part", a Path).

    tools        a tool table of LinuxCNC, or {number: {"length": m, ...}}; else every tool is the data sheet's
    parameters   a parameter file of LinuxCNC (.var), or {number: value}, lengths in mm
    subroutines  the folder of the files that the program calls; else its own folder
    options      those of Program and NCProgram (acceleration, corner, settle, origin, block_delete, ...)

    Raises
    ------
    ProgramError
        no such program, a file cannot be read, or is no NC program that this reader knows (with the line).
    """
    path = find_program(name_or_path)
    return nc_program(
        lambda data: NCProgram(**data),
        read_text(path),
        path.name,
        [FilePath(subroutines) if subroutines is not None else path.parent],
        tools=load_tools(tools),
        parameters=load_parameters(parameters),
        **options,
    )


def load_tools(tools: Tools | Mapping | str | os.PathLike | None) -> Tools | None:
    """A tool table: of LinuxCNC's tool.tbl (mm), of {number: {"length": m, ...}}, or as it is.

    Raises
    ------
    InputError
        with file and line, or the key.
    """
    if tools is None or isinstance(tools, Tools):
        return tools
    if isinstance(tools, Mapping):
        return tools_of(tools)
    return read_tool_table(read_text(tools), str(tools))


def load_parameters(parameters: Mapping[int, float] | str | os.PathLike | None) -> dict[int, float]:
    """Numbered parameters: of LinuxCNC's .var file, or {number: value}; none: {}.

    Raises
    ------
    ProgramError
        with file and line, or the number.
    """
    if parameters is None or isinstance(parameters, Mapping):
        return dict(parameters or {})
    return Parameters.of(read_text(parameters), str(parameters))


def program_from_table(
    table: Mapping[str, Any], folder: str | os.PathLike = ".", tools: Tools | None = None
) -> Program:
    """The program of an experiment's [program] table: `file`, a library name or a path from `folder` on, or `kind`.

    Beside `file` may stand `parameters`, a parameter file of LinuxCNC, and `subroutines`, the folder of called files.

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
            path = find_program(name, folder)
            text = read_text(path)
        except ProgramError as error:
            problem = error.problems[0]
            raise ExperimentError(problem.rule, key="file", value=name, cure=problem.cure) from None
        wrong = [key for key in ("text", "name", "tools") if key in options]
        if wrong:
            cure = "write a table [tools]" if wrong[0] == "tools" else None
            raise ExperimentError("no such key", key=wrong[0], cure=cure)
        for key, kind in (("parameters", "file"), ("subroutines", "folder")):
            if not isinstance(options.get(key, ""), str):
                raise ExperimentError(f"must be the name of a {kind}", key=key, value=repr(options[key])[:40])
        more = options.pop("parameters", None)
        subs = options.pop("subroutines", None)
        return nc_program(
            NCProgram.from_file,
            text,
            path.name,
            [path.parent if subs is None else FilePath(folder) / subs],
            tools=tools,
            parameters={} if more is None else load_parameters(FilePath(folder) / more),
            **options,
        )
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
    except ProgramError:
        raise
    except ValueError:  # a NUL
        raise ProgramError("cannot be read: no such name", file=ascii(str(path))) from None
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
