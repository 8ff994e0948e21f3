"""docs/programs.md says what the code does."""

import re
import tomllib

import numpy as np
import pytest

from gough.program import Circle, NCProgram, Program, program_from_table
from gough.program.junctions import CORNER
from gough.program.load import KINDS
from gough.program.ngc import codes, lexer, tip
from gough.program.ngc.arcs import MOST_TURNS
from gough.program.ngc.tools import tools_of

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


def test_every_kind_has_its_heading():
    page = PAGE.read_text()
    assert re.findall(r"^### (\w+)$", page, re.M) == list(KINDS)
    assert f"{np.degrees(CORNER):.2g} degrees" in page


def test_every_word_has_its_row_and_every_bound_its_number():
    page = (PAGE.parent / "nc-programs.md").read_text()
    table = page[page.index("| word |") : page.index("A line has")]
    rows = re.findall(r"^\| (.+?) \|", table, re.M)[1:]
    told = [word for row in rows for word in row.split() if re.fullmatch(r"[GM]\d+(\.\d)?", word)]
    known = [codes.name_of("G", code) for code in (*codes.G, codes.CANCEL)] + [f"M{code}" for code in codes.M]
    assert sorted(told) == sorted(known)  # each once
    assert set("XYZABCIJKRFSTHLPQN") <= {word for row in rows for word in row.split()}
    text = page.replace("\n", " ")
    for bound, what in ((lexer.LONGEST, "characters"), (MOST_TURNS, "turns"), (tip.MOST_MOVES, "moves")):
        assert f"{bound:,.0f} {what}".replace(",", " ").replace("1 000 turns", "1000 turns") in text


def test_the_program_and_the_tools_of_the_page_are_read():
    page = (PAGE.parent / "nc-programs.md").read_text()
    text = re.search(r"^    #<depth>.*?\n\n", page, re.M | re.S)[0]
    path = NCProgram(text=f"F100\n{text}\nM2\n").path()
    assert [round(1e3 * z, 9) for z in path.point(np.arange(len(path)), path.length)[::3, 2]] == [-1.5, -1.0, -0.5]
    (table,) = re.findall(r"```toml\n(\[program\].*?)```", page, re.S)
    entries = tomllib.loads(table)["tools"]
    assert [tool.offset[2] for tool in tools_of(entries, from_file=True)] == [80e-3, 52.5e-3]


def test_the_circle_of_the_page_is_read_and_has_the_speed_it_says(machine):
    page = PAGE.read_text()
    (text,) = re.findall(r"```toml\n(\[program\]\nkind.*?)```", page, re.S)
    circle = program_from_table(tomllib.loads(text)["program"])
    assert isinstance(circle, Circle)
    speed = circle.replace(feed=1.0).plan(machine).feed.speed[0]  # the fixture's acceleration is 2 m/s2
    assert speed == pytest.approx(np.sqrt(2 * 0.05), rel=1e-12)
    assert f"{speed:.3f} m/s" in page
