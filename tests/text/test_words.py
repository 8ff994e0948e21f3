"""The field's words are written in one way in pages, docstrings, messages and examples: that of docs/words.md."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
WORDS = ROOT / "docs" / "words.md"
CODE = re.compile(r"^```.*?^```$|`[^`\n]*`|\]\([^)]*\)", re.S | re.M)
ROW = re.compile(r"^\| ([^|]+) \| ([^|]+) \| ([^|]*)\|$", re.M)
PAGES = [p for p in (ROOT / "docs").rglob("*.md") if "_build" not in p.parts and p != WORDS]
PAGES += [ROOT / "README.md", ROOT / "CHANGELOG.md", *(ROOT / "examples").glob("*.*")]
SPELLINGS = ("color", "behavior", "neighbor", "meters", "millimeter", "micrometer", "artifact", "analyze", "modelling")


def never() -> dict[str, str]:
    """What is never written: the word to write instead."""
    found = {}
    for word, _, bad in ROW.findall(WORDS.read_text("utf-8")):
        if word != "word" and not word.startswith("---"):
            found |= {one.strip(): word for one in bad.split(",") if one.strip()}
    return found


@cache
def texts() -> dict[str, str]:
    """Place: prose of pages without their code, and every text in the source that is a sentence."""
    found = {str(p.relative_to(ROOT)): CODE.sub("", p.read_text("utf-8")) for p in PAGES if p.suffix == ".md"}
    found |= {str(p.relative_to(ROOT)): p.read_text("utf-8") for p in PAGES if p.suffix != ".md"}
    for path in (ROOT / "src" / "gough").rglob("*.py"):
        tree = ast.parse(path.read_text("utf-8"))
        said = [n.value for n in ast.walk(tree) if isinstance(n, ast.Constant) and isinstance(n.value, str)]
        found[str(path.relative_to(ROOT))] = "\n".join(CODE.sub("", one) for one in said if " " in one)
    return found


def places(pattern: str) -> list[str]:
    return [
        f"{place}: ...{text[max(0, m.start() - 30) : m.end() + 20]!r}"
        for place, text in texts().items()
        for m in re.finditer(pattern, text, re.I)
    ]


def test_the_page_of_words_has_the_words_of_the_field_with_a_meaning():
    rows = {word: meaning for word, meaning, _ in ROW.findall(WORDS.read_text("utf-8"))}
    assert {"contour error", "feed, F", "strut", "tool tip", "lag", "reversal", "wrench"} <= rows.keys()
    assert len(never()) > 20


@pytest.mark.parametrize("bad", sorted(never()))
def test_a_word_of_the_field_is_written_in_one_way(bad):
    assert not places(rf"(?<![\w-]){re.escape(bad)}s?(?![\w-])"), f"write {never()[bad]}"


@pytest.mark.parametrize("bad", SPELLINGS)
def test_prose_is_spelled_as_british_prose_is(bad):
    found = places(rf"\b{bad}(?!\w*[:(=-])")  # CSS and calls have names of their own
    assert not found, found
