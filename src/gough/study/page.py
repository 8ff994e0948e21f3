"""The page of a study: its claims and figures in one HTML file that loads nothing and runs nothing."""

from __future__ import annotations

import base64
import html
from collections.abc import Sequence
from pathlib import Path

from .. import __version__
from ..files import write_atomic
from .claims import BY_DESIGN, MET, NOT_MET, Claim
from .study import Figure, Study, Told
from .text import HEADS, summary

_CSS = Path(__file__).parents[1] / "report" / "page.css"
_OWN = """
table { font-size: .92rem; } td { vertical-align: top; }
td.claim, th.claim { white-space: normal; text-align: left; min-width: 22rem; }
thead th { overflow-wrap: normal; }
table.beyond { font-size: .84rem; } .beyond td, .beyond th { padding: .38rem .5rem; }
.beyond td:nth-child(2), .beyond th:nth-child(2) { text-align: left; }
td.claim small { display: block; color: var(--soft); font-size: .85em; }
td.verdict-met { color: #1a7f37; } td.verdict-not { color: var(--red); font-weight: 650; }
td.verdict-design { color: #9a6700; font-weight: 600; }
figure { margin: 1.4rem 0; } figure img { max-width: 100%; height: auto; }
"""
_CLASS = {MET: "verdict-met", NOT_MET: "verdict-not", BY_DESIGN: "verdict-design"}
# nothing is fetched and nothing runs, even if an escape were forgotten
_POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'"


def write_page(
    study: Study, claims: Sequence[Claim], figures: Sequence[Figure], beyond: Sequence[Told], folder: Path
) -> Path:
    """Write report.html into `folder`, where the figures are; the path of the page.

    Raises
    ------
    StorageError
        the file could not be written.
    """
    return write_atomic(folder / "report.html", page(study, claims, figures, beyond, folder))


def page(study: Study, claims: Sequence[Claim], figures: Sequence[Figure], beyond: Sequence[Told], folder: Path) -> str:
    """The text of the page; the pictures are read from `folder`."""
    title = html.escape(f"{study.paper}: {study.title}")
    heads = "<th></th>" + "".join(f"<th{' class=claim' if head == 'claim' else ''}>{head}</th>" for head in HEADS)
    rows = "\n".join(_row(number, claim) for number, claim in enumerate(claims, 1))
    more = "\n".join(_beyond(told, folder) for told in beyond)
    pictures = "\n".join(_picture(figure, folder) for figure in figures)
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{_POLICY}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="generator" content="gough {html.escape(__version__)}">
<title>{title}</title>
<style>{_CSS.read_text("utf-8")}{_OWN}</style>
</head>
<body>
<main>
<header>
<p class="kicker">{html.escape(study.cited)}</p>
<h1>{html.escape(study.title)}</h1>
<p class="verdict">{html.escape(summary(claims))}.</p>
</header>
<p>{html.escape(study.about)}</p>
<h2>Claims</h2>
<div class="scroll"><table>
<thead><tr>{heads}</tr></thead>
<tbody>
{rows}
</tbody>
</table></div>
<h2>Figures</h2>
{pictures}
{more}
<footer><p>Made by gough {html.escape(__version__)}: gough reproduce {html.escape(study.paper)}. The page holds all it
shows and loads nothing.</p></footer>
</main>
</body>
</html>
"""


def _row(number: int, claim: Claim) -> str:
    numbers = "".join(f"<td>{html.escape(claim.text(what))}</td>" for what in ("published", "measured", "band"))
    verdict = f'<td class="{_CLASS[claim.verdict]}">{claim.verdict}</td>'
    note = f"<small>{html.escape(claim.remark)}</small>" if claim.remark else ""
    return f'<tr><td>{number}</td><td class="claim">{html.escape(claim.claim)}{note}</td>{numbers}{verdict}</tr>'


def _beyond(told: Told, folder: Path) -> str:
    heads = "".join(f"<th>{html.escape(head)}</th>" for head in told.beyond.heads)
    rows = "\n".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in told.rows)
    table = f"<thead><tr>{heads}</tr></thead>\n<tbody>\n{rows}\n</tbody>"
    text = f"<h2>{html.escape(told.beyond.title)}</h2>\n<p>{html.escape(told.text)}</p>"
    scroll = f'<div class="scroll"><table class="beyond">\n{table}</table></div>'
    return f"{text}\n{scroll}\n{_picture(told.figure, folder)}"


def _picture(figure: Figure, folder: Path) -> str:
    data = base64.b64encode((folder / figure.file).read_bytes()).decode()
    caption = html.escape(figure.caption)
    image = f'<img src="data:image/png;base64,{data}" alt="{caption}">'
    return f"<figure>{image}<figcaption>{caption}</figcaption></figure>"
