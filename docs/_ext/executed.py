"""Sphinx: every page is carried out before it is built (tools/pages.py); one whose code fails does not build.

GOUGH_DOCS=quick leaves that out, where the tests have done it already.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from sphinx.errors import ExtensionError

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

import pages  # noqa: E402


def carry_out(app, docname: str, source: list[str]) -> None:
    """Carry out a page that is about to be read."""
    if os.environ.get("GOUGH_DOCS") == "quick" or not pages.runs(source[0]):
        return
    done = pages.run_page(Path(app.env.doc2path(docname)))
    if done.returncode:
        raise ExtensionError(f"{docname}: {done.stderr}")


def setup(app) -> dict:
    app.connect("source-read", carry_out)
    return {"version": "1", "parallel_read_safe": True}
