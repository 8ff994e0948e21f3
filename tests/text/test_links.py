"""What the texts point at is there: pages, headings, files of the repository, tests by name."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DOCS = sorted(p for p in (ROOT / "docs").rglob("*.md") if "_build" not in p.parts)
PAGES = [*DOCS, *(ROOT / name for name in ("README.md", "MAP.md", "CHANGELOG.md"))]
EVERY = pytest.mark.parametrize("path", PAGES, ids=lambda p: str(p.relative_to(ROOT)))
PLACE = re.compile(r"(?<![\w/.:-])((?:tests|bench|examples|docs|tools|src)/[\w./*{},-]*\w)(?:::(\w+))?")
BLOCK = re.compile(r"^```.*?^```$", re.S | re.M)


def slug(heading: str) -> str:
    """The anchor of a heading, as GitHub and MyST make it."""
    return re.sub(r"[^\w\- ]", "", heading.strip().lower().replace("`", "")).replace(" ", "-")


@cache
def anchors(path: Path) -> set[str]:
    text = BLOCK.sub("", path.read_text("utf-8"))
    return {slug(heading) for heading in re.findall(r"^#+ (.*)$", text, re.M)} | set(
        re.findall(r"^\((.+)\)=$", text, re.M)
    )


@cache
def names_of_tests() -> set[str]:
    return {name for file in (ROOT / "tests").rglob("*.py") for name in re.findall(r"def (test_\w+)", file.read_text())}


@EVERY
def test_every_link_leads_to_a_page_and_a_heading_of_it(path):
    text = re.sub(r"`[^`\n]*`", "", BLOCK.sub("", path.read_text("utf-8")))
    for target, heading in re.findall(r"\]\((?!https?:|mailto:)([^)#\s]*)#?([^)\s]*)\)", text):
        found = path.parent / target if target else path
        assert found.exists(), target
        assert not heading or heading in anchors(found), f"{target}#{heading}"


@EVERY
def test_every_file_and_test_that_a_text_names_is_there(path):
    for place, test in PLACE.findall(path.read_text("utf-8")):
        found = list(ROOT.glob(place)) if not re.search(r"[{}]", place) else [ROOT]
        assert found, place
        assert not test or re.search(rf"def {test}\b", found[0].read_text()), f"{place}::{test}"
    for name in re.findall(r"`(test_[a-z0-9_]{8,})`", path.read_text("utf-8")):
        assert name in names_of_tests() or list((ROOT / "tests").rglob(f"{name}.py")), name


def test_every_promise_names_a_test_that_holds_it():
    page = (ROOT / "docs" / "promises.md").read_text("utf-8")
    rows = re.findall(r"^\| (.*) \| (.*) \|$", page, re.M)[1:]
    assert len(rows) > 12
    for promise, held in rows:
        assert PLACE.findall(held), promise
    assert "not a safety function" in page
