"""Where the columns of a record stand: a map file, or what gough's own logs are known to have."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from ...errors import InputError, LogError, Problem
from ...files import Document, read_toml
from ...machine.record import SCHEMA, RecordMap
from .table import Source


def load_map(path: str | Path) -> RecordMap:
    """The map that a TOML file of schema "gough-log-map-1" tells.

    Raises
    ------
    LogError
        every mistake with file, line, key and cure.
    """
    return map_of(read_toml(path, LogError))


def map_of(document: Document) -> RecordMap:
    """The map of a document that was read.

    Raises
    ------
    LogError
        as `load_map`.
    """
    data: dict[str, Any] = dict(document.data)
    found = data.pop("schema", None)
    problems = []
    if found != SCHEMA:
        rule = "is missing" if found is None else "no such schema"
        value = None if found is None else ascii(found)[:60]
        problems.append(Problem(rule, key="schema", value=value, cure=f'write schema = "{SCHEMA}" as the first line'))
    try:
        made = RecordMap.from_file(data)
    except InputError as error:
        problems += error.problems
    if problems:
        raise document.locate(LogError(problems=problems))
    return made


_OWN = re.compile(r"(q_m|u)\.(\d+)(?: \[(\S+)\])?")


def own_map(source: Source, joints: int) -> RecordMap | None:
    """The map of a log of gough's by its names; None for a file without them.  The period is that of its first rows."""
    names = {}
    for name in source.names:
        match = _OWN.fullmatch(name)
        if match:
            names[match[1], int(match[2])] = name
    time = next((name for name in ("t", "t [s]") if name in source.names), None)
    wanted = [(kind, i + 1) for kind in ("q_m", "u") for i in range(joints)]
    if time is None or any(key not in names for key in wanted):
        return None
    block = next(source.blocks([time]), None)
    if block is None or len(block.values) < 2 or not block.values[1, 0] > block.values[0, 0]:
        raise source.error("a log needs two rows of rising times")
    return RecordMap.from_file(
        {
            "time": {"column": time, "unit": "s", "period": f"{float(block.values[1, 0] - block.values[0, 0])!r} s"},
            "joints": {"columns": [names["q_m", i + 1] for i in range(joints)], "unit": "m"},
            "forces": {"columns": [names["u", i + 1] for i in range(joints)], "unit": "N"},
            "text": {"header": 1, "skip": ["#"]},
        }
    )
