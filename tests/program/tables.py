"""The tables of docs/programs.md, from the declared options.  `python -m tests.program.tables` writes them anew."""

from __future__ import annotations

from pathlib import Path
from typing import get_args

import numpy as np
from pydantic_core import PydanticUndefined

from gough.program import Program
from gough.program.load import KINDS
from gough.units import show

PAGE = Path(__file__).parents[2] / "docs" / "programs.md"


def rows(kind: type[Program], names) -> list[str]:
    """A row for each option: name, unit or words, meaning, default."""
    out = ["| option | unit | meaning | default |", "|---|---|---|---|"]
    for name in names:
        field, spec = kind.model_fields[name], kind.specs().get(name)
        if spec:
            unit = spec.unit if spec.unit not in ("", "1") else "number"
        elif field.annotation is bool:
            unit = "true or false"
        else:
            words = [word for part in (field.annotation, *get_args(field.annotation)) for word in get_args(part)]
            unit = " or ".join(f'"{word}"' for word in words if isinstance(word, str))
        out.append(f"| `{name}` | {unit} | {field.description} | {default(field.default, spec)} |")
    return out


def default(value, spec) -> str:
    if value is PydanticUndefined:
        return "must be given"
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value}"'
    if np.ndim(value):
        return ", ".join(show(v, spec.unit) for v in value) if np.any(value) else " ".join("0" for _ in value)
    return show(value, spec.unit)


def tables() -> dict[str, str]:
    """Table by the name of its marker in the page: "every" for what all programs take, then the kinds."""
    common = list(Program.model_fields)
    out = {"every": "\n".join(rows(Program, common))}
    for name, kind in KINDS.items():
        own = [option for option in kind.model_fields if option not in common]
        out[name] = "\n".join(rows(kind, own))
    return out


def renewed(page: str) -> str:
    """The page with each table between its markers as it should be.

    Raises
    ------
    ValueError
        a marker is missing.
    """
    for name, table in tables().items():
        begin, end = f"<!-- table {name} -->\n\n", f"\n\n<!-- end {name} -->"
        at, to = page.index(begin) + len(begin), page.index(end)
        page = page[:at] + table + page[to:]
    return page


if __name__ == "__main__":
    PAGE.write_text(renewed(PAGE.read_text()))
