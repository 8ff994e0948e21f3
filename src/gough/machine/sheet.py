"""Data sheets: a TOML file, schema "gough-machine-1", and the machine it describes.

    schema = "gough-machine-1"      name = "okuma-pm600"      kind = "hexapod"
    [platform] ...                  tables of the kind, quantities with units
    [source]                        "platform.mass" = "where the number is from"

A machine is named by a library name ("okuma-pm600") or a path (with a / or ending in .toml).
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module, resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import InputError, Problem, SheetError, did_you_mean
from ..files import Document, read_toml
from ..names import check_name
from .strut_limits import check_loads

if TYPE_CHECKING:
    from ..declare import Part
    from .base import Machine

SCHEMA = "gough-machine-1"
KINDS = {  # imported when asked for
    "hexapod": "gough.machine.hexapod:Hexapod",
    "hexaglide": "gough.machine.hexaglide:Hexaglide",
    "tripod": "gough.machine.tripod:Tripod",
    "hybrid": "gough.machine.hybrid:Hybrid",
    "axis": "gough.machine.axis:Axis",
}


def library() -> dict[str, Path]:
    """The data sheets that come with gough: name -> path."""
    folder = Path(str(resources.files("gough.machine") / "library"))
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


def load_machine(name_or_path: str | Path) -> Machine:
    """The machine of a library name, or of a data sheet at a path.

    Raises
    ------
    SheetError
        no such machine or file, or the sheet is wrong: every mistake with file, line, key and cure.
    """
    return machine_of(read_toml(find(name_or_path), SheetError))


def find(name_or_path: str | Path, folder: Path | None = None) -> Path:
    """Path of a machine's sheet; relative paths start at `folder`, else at the working directory.

    Raises
    ------
    SheetError
        no library machine has this name; the nearest is said.
    """
    text = str(name_or_path)
    if isinstance(name_or_path, Path) or "/" in text or text.endswith(".toml"):
        return (folder or Path()) / text
    known = library()
    if text not in known:
        beside = (folder or Path()) / f"{text}.toml"
        cure = f"write {beside.name} for the file" if beside.is_file() else did_you_mean(text, known)
        raise SheetError("no machine of the library has this name", value=ascii(text), cure=cure)
    return known[text]


def machine_of(document: Document) -> Machine:
    """The machine that a data sheet describes.

    Raises
    ------
    SheetError
        as `load_machine`.
    """
    data = dict(document.data)
    problems = schema_problems(data.pop("schema", None), SCHEMA)
    try:
        check_name(data.get("name"), kind=SheetError)
    except SheetError as error:
        problems += error.problems if "name" in data else [Problem("is missing", key="name", cure='write name = "..."')]
        data["name"] = "unnamed"
    kind = data.get("kind")
    if not isinstance(kind, str) or kind not in KINDS:
        cure = did_you_mean(kind, KINDS) if isinstance(kind, str) else f"write kind = {' or '.join(map(repr, KINDS))}"
        rule = "no such kind of machine" if "kind" in data else "is missing"
        problems.append(Problem(rule, key="kind", value=ascii(kind) if "kind" in data else None, cure=cure))
        raise document.locate(SheetError(problems=problems))
    try:
        machine = machine_class(kind).from_file(data)
        check_loads(machine)
    except InputError as error:
        problems += error.problems
    if not problems:  # a key mistyped in the sheet would make its right entry in [source] look wrong
        problems += source_problems(document)
    if problems:
        raise document.locate(SheetError(problems=problems))
    return machine


def machine_class(kind: str) -> type[Machine]:
    """The class of a kind of machine, imported now."""
    module, _, name = KINDS[kind].partition(":")
    return getattr(import_module(module), name)


def schema_problems(found: Any, expected: str) -> list[Problem]:
    """What is wrong with the `schema` of a file: missing, of another kind of file, or of another version of gough."""
    if found == expected:
        return []
    if found is None:
        return [Problem("is missing", key="schema", cure=f'write schema = "{expected}" as the first line')]
    stem = expected.rpartition("-")[0]
    if isinstance(found, str) and found.startswith(f"{stem}-"):
        from .. import __version__

        cure = f"gough {__version__} reads {expected}; use the gough that the file was written for"
        return [Problem("a version of this file that is not known", key="schema", value=ascii(found), cure=cure)]
    other = {"gough-machine": "a data sheet of a machine", "gough-experiment": "an experiment"}
    name = other.get(found.rpartition("-")[0]) if isinstance(found, str) else None
    if name:
        return [Problem(f"this is {name}, not {other[stem]}", key="schema", cure="gough check tells what a file is")]
    return [Problem("no such schema", key="schema", value=ascii(found)[:60], cure=f'write schema = "{expected}"')]


def source_problems(document: Document) -> list[Problem]:
    """Entries of [source] that name no key of the sheet, or are no text."""
    source = document.data.get("source")
    if not isinstance(source, Mapping):
        return []
    keys = [key for key in document.lines if not key.startswith("source")]
    found = []
    for key, text in source.items():
        if not isinstance(text, str):
            rule, cure = "a source is a text", f'write "{key}" = "..." with the key in quotes'
        elif key not in document.lines or key.startswith("source"):
            rule, cure = "the sheet has no such key", did_you_mean(key, keys) if len(found) < 20 else None
        else:
            continue
        found.append(Problem(rule, key=f"source.{key}", cure=cure))
    return found


_PLACES = {"pose", "tip"}  # keys of the table [home]: a pose, or the place of a tip


def source_of(key: str, sources: Mapping[str, str]) -> str | None:
    """What [source] says of a key, or of the nearest table above it."""
    while key:
        if key in sources:
            return sources[key]
        key = key.rpartition(".")[0]
    return None


# -- changing a machine by a table ----------------------------------------------------------------------------------


def overridden(machine: Machine, table: Mapping[str, Any]) -> Machine:
    """The machine with the keys of a table changed: quantities, "1.2 x", "none", dotted keys or tables of them.

    A table for something the machine has not (friction where there was none), or of another `kind`, is taken whole.

    Raises
    ------
    SheetError
        with a problem for every wrong key; `key` is set, file and line are not.
    """
    changes: dict[str, Any] = {}
    whole: dict[str, Any] = {}
    _sort(machine, table, "", changes, whole)
    problems: list[Problem] = []
    if whole:
        data = machine.to_file()
        for key, raw in whole.items():
            *above, last = key.split(".")
            inner = data
            for name in above:
                inner = inner[name]
            inner[last] = raw
        try:
            machine = type(machine).from_file(data)
        except InputError as error:
            problems += error.problems
    try:
        machine = machine.replace_from_file(changes)
    except InputError as error:
        problems += error.problems
    if problems:
        raise SheetError(problems=problems)
    return machine


def _sort(part: Part, table: Mapping[str, Any], above: str, changes: dict[str, Any], whole: dict[str, Any]) -> None:
    fields = type(part).model_fields
    for key, raw in table.items():
        path = f"{above}{key}"
        old = getattr(part, key, None) if key in fields else None
        is_table = isinstance(raw, Mapping) and key in fields and key not in part.specs()
        if is_table and _is_part(old) and raw.get("kind", getattr(old, "kind", None)) == getattr(old, "kind", None):
            _sort(old, raw, f"{path}.", changes, whole)
        elif is_table:
            whole[path] = raw
        elif isinstance(raw, Mapping) and len(raw) == 1 and set(raw) <= _PLACES:  # [home] pose, which is kept as home
            changes[path] = next(iter(raw.values()))
        else:
            changes[path.removesuffix(".pose").removesuffix(".tip")] = raw


def _is_part(value: Any) -> bool:
    from ..declare import Part

    return isinstance(value, Part)
