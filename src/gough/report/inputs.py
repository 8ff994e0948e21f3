"""What made a result, for the page: files, machine sheet, controller, program with line numbers, versions, hashes."""

from __future__ import annotations

import json
from collections.abc import Mapping
from html import escape
from typing import Any

import tomli_w

from ..log import Log
from .sections import Section
from .table import heads

# characters of one text on the page; the log holds the whole, and a page must stay quick to open
LONGEST = 400_000

_PARTS = (
    ("machine", "Machine sheet"),
    ("controller", "Controller"),
    ("plant", "Plant: what differs from the machine and nobody told the controller"),
    ("program", "Program"),
    ("run", "Run"),
)


def section(logs: list[Log], files: Mapping[str, str]) -> Section:
    """Every input and version, collapsed; what is the same for all logs stands once."""
    names = heads(logs)
    parts = [_details(name, _pre(text)) for name, text in files.items()]
    for key, heading in _PARTS:
        for whose, value in _grouped(logs, names, key):
            if key == "program":
                parts += _program(value, whose)
            elif value not in (None, {}, [], ""):
                parts.append(_details(heading, _pre(_toml(value)), whose))
    for whose, value in _grouped(logs, names, "versions"):
        facts = value if isinstance(value, dict) else {}
        gough = next((log.info.get("version") for log in logs if log.info.get("version")), None)
        processor = next((log.info.get("processor") for log in logs if log.info.get("processor")), None)
        facts = {"gough": gough} | facts | ({"processor": processor} if processor else {})
        parts.append(_details("Versions", _facts({k: v for k, v in facts.items() if v is not None}), whose))
    for whose, value in _grouped(logs, names, "hashes"):
        if isinstance(value, dict) and value:
            parts.append(_details("Hashes (SHA-256)", _facts(value), whose))
    note = '<p class="note">Everything that went in. The same inputs, seed and versions give the same numbers.</p>'
    return Section("inputs", "What made this", note + "\n".join(parts))


def _grouped(logs: list[Log], names: list[str], key: str) -> list[tuple[str, Any]]:
    """(names of the logs, value) for each different value of info[key]; no names if it is one and the same for all."""
    groups: dict[str, tuple[list[str], Any]] = {}
    for log, name in zip(logs, names, strict=True):
        value = log.info.get(key)
        groups.setdefault(json.dumps(value, sort_keys=True), ([], value))[0].append(name)
    if len(groups) == 1:
        return [("", next(iter(groups.values()))[1])]
    return [(", ".join(whose), value) for whose, value in groups.values()]


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
