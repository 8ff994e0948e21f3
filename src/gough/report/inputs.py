"""What made a result, for the page: files, machine sheet, controller, program with line numbers, versions, hashes."""

from __future__ import annotations

import json
from collections.abc import Mapping
from html import escape
from typing import Any

import tomli_w

from ..log import Log
from .sections import Section
from .table import names as names_of

# characters of one text on the page; the log holds the whole, and a page must stay quick to open
LONGEST = 400_000

_PARTS = (
    ("machine", "Machine sheet"),
    ("controller", "Controller"),
    ("observer", "Observer"),
    ("plant", "Plant: what is true and the controller was not told"),
    ("program", "Program"),
    ("run", "Run"),
)


def section(logs: list[Log], files: Mapping[str, str]) -> Section:
    """Every input and version, collapsed; what is the same for all logs stands once."""
    names = names_of(logs)
    programs = {_program_text(log) for log in logs}
    # a program among the files stands once, as the program with its line numbers
    parts = [_details(name, _pre(text)) for name, text in files.items() if text not in programs]
    for key, heading in _PARTS:
        for whose, log, value in _grouped(logs, names, key):
            if key == "program":
                parts += _program(value, whose)
            elif key == "plant" and isinstance(value, dict) and value:
                difference = _difference(log.info.get("machine"), value)
                parts.append(_details(heading, difference + _pre(_toml(value)), whose))
            elif value not in (None, {}, [], ""):
                parts.append(_details(heading, _pre(_toml(value)), whose))
    for whose, _, value in _grouped(logs, names, "versions"):
        facts = value if isinstance(value, dict) else {}
        gough = next((log.info.get("version") for log in logs if log.info.get("version")), None)
        processor = next((log.info.get("processor") for log in logs if log.info.get("processor")), None)
        facts = {"gough": gough} | facts | ({"processor": processor} if processor else {})
        parts.append(_details("Versions", _facts({k: v for k, v in facts.items() if v is not None}), whose))
    for whose, _, value in _grouped(logs, names, "hashes"):
        if isinstance(value, dict) and value:
            parts.append(_details("Hashes (SHA-256)", _facts(value), whose))
    note = '<p class="note">Everything that went in. The same inputs, seed and versions give the same numbers.</p>'
    return Section("inputs", "What made this", note + "\n".join(parts))


def _grouped(logs: list[Log], names: list[str], key: str) -> list[tuple[str, Log, Any]]:
    """(names, first log, value) for each different value of info[key]; no names if it is one and the same for all.

    Plants are the same only if what was believed of them is too: they are shown by the difference.
    """
    groups: dict[str, tuple[list[str], Log, Any]] = {}
    for log, name in zip(logs, names, strict=True):
        value = log.info.get(key)
        same = json.dumps([value, log.info.get("machine") if key == "plant" else None], sort_keys=True)
        groups.setdefault(same, ([], log, value))[0].append(name)
    alone = len(groups) == 1
    return [("" if alone else ", ".join(whose), log, value) for whose, log, value in groups.values()]


def _program_text(log: Log) -> str | None:
    program = log.info.get("program")
    return program.get("text") if isinstance(program, dict) else None


def _difference(believed: Any, plant: Mapping[str, Any]) -> str:
    """A table of the numbers in which the true machine is not the believed one."""
    told, true = _flat(believed), _flat(plant.get("machine"))
    keys = [key for key in true | told if told.get(key) != true.get(key)]
    if not true or not keys:
        return ""
    head = "<tr><th>number</th><th>believed</th><th>true</th></tr>"
    cells = ([key, told.get(key, "none"), true.get(key, "none")] for key in keys)
    rows = "".join("<tr>" + "".join(f"<td>{escape(str(cell))}</td>" for cell in row) + "</tr>" for row in cells)
    return f'<table class="facts"><thead>{head}</thead><tbody>{rows}</tbody></table>'


def _flat(table: Any, prefix: str = "") -> dict[str, Any]:
    """Nested tables as one, by dotted keys; a quantity of unit and value stays one entry."""
    if not isinstance(table, Mapping):
        return {}
    out: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, Mapping) and set(value) != {"unit", "value"}:
            out |= _flat(value, f"{prefix}{key}.")
        else:
            out[f"{prefix}{key}"] = f"{value['value']} {value['unit']}" if isinstance(value, Mapping) else value
    return out


def _program(value: Any, whose: str) -> list[str]:
    value = dict(value) if isinstance(value, dict) else {}
    text = value.pop("text", None)
    out = []
    if isinstance(text, str) and text:
        name = str(value.get("name") or "program")
        out.append(_details(f"NC program {name}", _numbered(text), whose))
    if set(value) - {"name", "kind"} or (value and not text):
        out.append(_details("Program", _pre(_toml(value)), whose))
    return out


def _details(heading: str, body: str, whose: str = "") -> str:
    extra = f" <small>{escape(whose)}</small>" if whose else ""
    return f"<details><summary>{escape(heading)}{extra}</summary>{body}</details>"


def _pre(text: str) -> str:
    return f"<pre>{escape(_cut(text))}</pre>"


def _numbered(text: str) -> str:
    lines = _cut(text).splitlines()
    return '<pre class="numbered">' + "".join(f"<span>{escape(line)}</span>" for line in lines) + "</pre>"


def _cut(text: str) -> str:
    if len(text) <= LONGEST:
        return text
    return f"{text[:LONGEST]}\n... {len(text) - LONGEST} characters more, in the log: log.info"


def _facts(table: Mapping[str, Any]) -> str:
    rows = "".join(f"<tr><td>{escape(str(key))}</td><td>{escape(str(value))}</td></tr>" for key, value in table.items())
    return f'<table class="facts"><tbody>{rows}</tbody></table>'


def _toml(value: Any) -> str:
    """A table as TOML, as its file would say it; anything TOML cannot say as JSON."""
    if isinstance(value, dict):
        try:
            return tomli_w.dumps(_without_none(value))
        except (TypeError, ValueError):
            pass
    return json.dumps(value, indent=2, ensure_ascii=False)


def _without_none(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without_none(inner) for key, inner in value.items() if inner is not None}
    return value
