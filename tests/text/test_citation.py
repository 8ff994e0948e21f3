"""CITATION.cff says of the package what the package says of itself."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_the_citation_has_what_its_format_asks_for_and_agrees_with_the_package():
    text = (ROOT / "CITATION.cff").read_text("utf-8")
    entries = dict(re.findall(r"^([a-z-]+): *(.*)$", text, re.M))
    assert {"cff-version", "message", "title", "authors", "version", "license"} <= entries.keys()
    package = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    assert entries["version"] == package["version"] and entries["license"] == package["license"]
    head = re.search(r"^## (\S+), (.*)$", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.M)
    assert head[1] == package["version"]
    assert ("date-released" in entries) == (head[2] != "unreleased"), "a date when it is released, and not before"
