"""Sphinx: pictures that are made and not kept in git: those of the examples, and the figures of the five studies.

    :::{example} examples/05_what_a_corner_costs.py       the picture of an example, drawn now if it is not fresh
    :::{study} chen2008                                   every figure of `gough reproduce`, and its rows

GOUGH_DOCS=quick draws nothing: what is there is shown, for the rest a line says how it is made.  A study is a minute
or two of computing, so it is never done here: `make figures` does all five, `make docs` those that are missing.
"""

from __future__ import annotations

import html
import json
import os
import sys
from collections.abc import Sequence
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.errors import ExtensionError
from sphinx.util.docutils import SphinxDirective

ROOT = Path(__file__).resolve().parents[2]
PAPERS = ROOT / "results" / "papers"
HEADS = ("claim", "published", "ours", "band", "verdict")
sys.path.insert(0, str(ROOT / "tools"))

import gallery  # noqa: E402

from gough.study.source import source_hash  # noqa: E402


class Pictures(SphinxDirective):
    """What both have: a picture from outside of docs, and a line for what is not there."""

    required_arguments = 1

    def picture(self, path: Path, told: str, caption: str = "") -> nodes.Node:
        here = Path(self.env.doc2path(self.env.docname)).parent
        self.env.note_dependency(str(path))
        figure = nodes.figure("", nodes.image(uri=os.path.relpath(path, here), alt=told), classes=["drawn"])
        if caption:
            figure += nodes.caption("", caption)
        return figure

    def missing(self, command: str) -> nodes.Node:
        text = nodes.paragraph("", "Not drawn in this copy: ")
        text += nodes.literal("", command)
        return nodes.note("", text)


class Example(Pictures):
    """The picture of an example."""

    option_spec = {"command": directives.unchanged_required, "picture": directives.unchanged_required}

    def run(self) -> list[nodes.Node]:
        one = gallery.example(self.arguments[0], self.options)
        self.env.note_dependency(str(one.file))
        if os.environ.get("GOUGH_DOCS") != "quick" and not gallery.fresh(one):
            try:
                gallery.draw(one)
            except gallery.ExampleError as error:
                raise ExtensionError(str(error)) from None
        if not one.drawn.is_file():
            return [self.missing(f"python tools/gallery.py {one.file.name[:2]}")]
        command = " ".join([*one.command, str(one.file.relative_to(ROOT))])
        shown = nodes.literal_block(command, command, language="console")
        return [shown, self.picture(one.drawn, f"What {one.file.name} draws"), *folded(one.file)]


def folded(file: Path) -> list[nodes.Node]:
    """The text of a file, behind a line to open it."""
    text = file.read_text("utf-8")
    code = nodes.literal_block(text, text, language=file.suffix[1:].replace("py", "python"))
    name = html.escape(f"{file.parent.name}/{file.name}")
    opened = nodes.raw("", f"<details><summary>{name}</summary>", format="html")
    return [opened, code, nodes.raw("", "</details>", format="html")]


class Study(Pictures):
    """Figures and rows of a study, as `gough reproduce` left them."""

    def run(self) -> list[nodes.Node]:
        paper = self.arguments[0]
        folder = PAPERS / paper
        self.env.note_dependency(str(folder / "study.json"))
        if not (folder / "study.json").is_file():
            return [self.missing(f"gough reproduce {paper} --out results/papers/{paper}")]
        made = json.loads((folder / "study.json").read_text("utf-8"))
        day = datetime.fromtimestamp((folder / "study.json").stat().st_mtime, UTC).date()
        out = [nodes.paragraph("", self._state(made, day))]
        out += [self.picture(folder / one["file"], one["caption"], one["caption"]) for one in made["figures"]]
        out += [nodes.paragraph("", f"All {len(made['rows'])} rows, as the command printed them:"), table(made["rows"])]
        return out

    def _state(self, made: dict[str, Any], day: date) -> str:
        same = made["source"] == source_hash()
        with_ = "with the source that this page is of" if same else "with an earlier state of the source than this page"
        return f"Made on {day} by gough {made['gough']}, {with_}."


def table(rows: list[list[str]]) -> nodes.Node:
    """The rows of a study."""
    group = nodes.tgroup(cols=len(HEADS))
    group += [nodes.colspec(colwidth=width) for width in (6, 2, 2, 2, 2)]
    group += nodes.thead("", row(HEADS))
    group += nodes.tbody("", *map(row, map(cells, rows)))
    return nodes.table("", group, classes=["rows"])


def cells(one: Sequence[str]) -> list[str]:
    """Those of a row that are shown; what was calibrated is no evidence, and the verdict says so."""
    *shown, verdict, remark = one
    return [*shown, f"{verdict}, calibrated" if remark.startswith("calibrated") else verdict]


def row(cells: Sequence[str]) -> nodes.Node:
    return nodes.row("", *(nodes.entry("", nodes.paragraph("", cell)) for cell in cells))


def setup(app) -> dict:
    app.add_directive("example", Example)
    app.add_directive("study", Study)
    return {"version": "1", "parallel_read_safe": False}
