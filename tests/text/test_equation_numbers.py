"""Equations of the theory pages and the code that cites them: every number on either side is found on the other."""

from __future__ import annotations

import ast
import io
import re
import tokenize
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SRC = ROOT / "src" / "gough"
FILES = sorted(SRC.rglob("*.py"))
THEORY = sorted((ROOT / "docs" / "theory").glob("*.md"))
NAMED = re.compile(r"docs/theory/(\w+)\.md")
NUMBER = r"\(([1-9]\d?)\)"
ITEM = rf"{NUMBER}\s*(?:(?:,|and|or|to|-)\s*)*"
CITED = re.compile(rf"\b(?:eqs?\.?|equations?)\s+((?:{ITEM})+)")


def displayed(text: str) -> set[str]:
    """Numbers at the ends of lines: those of equations that are written out."""
    return set(re.findall(rf"(?<!\w){NUMBER}\s*$", text, re.M))


def cited(text: str) -> set[str]:
    """Numbers after `eq.`, ranges filled."""
    found = set()
    for one in CITED.finditer(text):
        found |= set(re.findall(NUMBER, one[1]))
        for a, b in re.findall(rf"{NUMBER}\s*(?:to|-)\s*{NUMBER}", one[1]):
            found |= {str(k) for k in range(int(a), int(b) + 1)}
    return found


def of_page(text: str, page: str) -> set[str]:
    """Numbers said to be of a theory page: `eq. (3) of docs/theory/x.md`, `docs/theory/x.md, eqs. (1), (2)`."""
    name = rf"docs/theory/{page}\.md"
    numbers = rf"eqs?\.\s+(?:{ITEM})+"
    said = re.finditer(rf"{numbers}of\s+{name}|{name},\s+{numbers}", text)
    return set().union(*(cited(one[0]) for one in said))


@cache
def told() -> dict[str, set[str]]:
    """Theory page: the numbers that files which name it write out or cite, in what they say and not in what they do.

    Where such a file cites a paper's equations too, `eq. (3) of the paper` counts as well: they cannot be told apart.
    """
    out = {}
    for path in [*FILES, *(ROOT / "tests").rglob("*.py")]:
        text = path.read_text("utf-8")
        for page in set(NAMED.findall(text)):
            tokens = tokenize.generate_tokens(io.StringIO(text).readline)
            said = "\n".join(t.string for t in tokens if t.type in (tokenize.COMMENT, tokenize.STRING))
            out.setdefault(page, set()).update(displayed(said) | cited(said))
    return out


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(SRC)))
def test_equations_that_a_module_cites_stand_in_its_theory_page(path):
    text = path.read_text("utf-8")
    written = displayed(ast.get_docstring(ast.parse(text)) or "")
    for page in set(NAMED.findall(text)):
        numbers = written | of_page(text, page)
        theory = (ROOT / "docs" / "theory" / f"{page}.md").read_text("utf-8")
        assert numbers, f"{path.name} names {page} and numbers no equation"
        assert not [n for n in numbers if f"({n})" not in theory], f"{page} lacks equations of {path.name}"


@pytest.mark.parametrize("path", THEORY, ids=lambda p: p.stem)
def test_every_equation_of_a_theory_page_is_cited_by_code_that_names_the_page(path):
    numbers = displayed(path.read_text("utf-8"))
    assert numbers, "a theory page has numbered equations"
    assert not numbers - told().get(path.stem, set()), f"nobody who names docs/theory/{path.name} cites them"


def test_citations_are_read_as_they_are_written():
    assert cited("by eqs. (3) to (5), and equation (8)") == {"3", "4", "5", "8"}
    assert cited("see eq. (2) and (7), not (9)") == {"2", "7"}
    assert cited("Fig. (3); f(4)") == set()
    assert of_page("eqs. (4)\nto (6) of docs/theory/x.md; docs/theory/x.md, eq. (9)", "x") == {"4", "5", "6", "9"}
    assert displayed("    a = g(0)\n    b = c      (12)\n  d (3) e") == {"12"}
