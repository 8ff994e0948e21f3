"""Pictures, tables and the page of one or several logs.

report(logs, folder) writes the page and the figures, report_table(logs) gives the rows of the table, save_all(logs,
folder) the figures alone.  matplotlib is imported when a figure is drawn.
"""

from __future__ import annotations

from typing import Any

__all__ = ["report", "report_table", "save_all"]

_HOMES = {"report": "page", "report_table": "table", "save_all": "figures"}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    import importlib

    return getattr(importlib.import_module(f".{_HOMES[name]}", __name__), name)
