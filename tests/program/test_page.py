"""docs/programs.md says what the code does."""

import re
import tomllib

import numpy as np
import pytest

from gough.program import Circle, Program, program_from_table
from gough.program.feed import CORNER
from gough.program.gcode import _GROUPS
from gough.program.lexer import LARGEST, LONGEST
from gough.program.load import KINDS

from .tables import PAGE, renewed, tables


def test_the_tables_of_the_page_are_those_of_the_declared_options():
    assert renewed(PAGE.read_text()) == PAGE.read_text(), "python -m tests.program.tables writes them anew"


def test_every_option_has_a_meaning_and_a_unit():
    told = tables()
    for name, kind in KINDS.items():
        for option in kind.model_fields:
            table = told["every" if option in Program.model_fields else name]
            (row,) = re.findall(rf"^\| `{option}` \| (.+?) \| (.+?) \| (.*?) ?\|$", table, re.M)
            assert row[0].strip()
            assert row[1] not in ("", "None")


def test_every_kind_has_its_heading_and_every_word_its_row():
    page = PAGE.read_text()
    assert re.findall(r"^### (\w+)$", page, re.M) == list(KINDS)
    subset = page[page.index("| word |") : page.index("## Options")]
    first = " ".join(re.findall(r"^\| (.+?) \|", subset, re.M)).split()
    assert {word for word in first if re.fullmatch(r"[GM]\d+", word)} == set(_GROUPS)
    assert set("XYZABCIJRFN") <= set(first)
    assert f"{LONGEST} characters" in page
    assert f"{LARGEST:,.0f}".replace(",", " ") in page
    assert f"{np.degrees(CORNER):.2g} degrees" in page


def test_the_circle_of_the_page_is_read_and_has_the_speed_it_says(machine):
    page = PAGE.read_text()
    (text,) = re.findall(r"```toml\n(\[program\]\nkind.*?)```", page, re.S)
    circle = program_from_table(tomllib.loads(text)["program"])
    assert isinstance(circle, Circle)
    speed = circle.replace(feed=1.0).plan(machine).feed.speed[0]  # the fixture's acceleration is 2 m/s2
    assert speed == pytest.approx(np.sqrt(2 * 0.05), rel=1e-12)
    assert f"{speed:.3f} m/s" in page
