"""The page of a sweep: its table, figures, worst runs and inputs in one HTML file that loads and runs nothing."""

from __future__ import annotations

import base64
import html
from collections.abc import Mapping, Sequence
from pathlib import Path

from .. import __version__
from ..files import write_atomic
from . import figures, limits, summary
from .run import Swept
from .table import Lines

DPI = 150
_CSS = Path(__file__).parents[1] / "report" / "page.css"
_OWN = (
    "figure { margin: 1.4rem 0; } figure img { max-width: 100%; height: auto; } pre.command { margin: .3rem 0 1rem; }"
)
# nothing is fetched and nothing runs, even if an escape were forgotten
_POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'"


def write_page(swept: Swept, lines: Lines, folder: Path, shown: Path, files: Mapping[str, str]) -> Path:
    """Write spread.png, effects.png and report.html into `folder`, which people know as `shown`; the page's path.

    Raises
    ------
    StorageError
        a file could not be written.
    """
    pictures = []
    drawn = {"spread": figures.spread(swept, lines).figure, "effects": figures.effects(swept, lines)}
    captions = {
        "spread": "The share of all runs that stay at or below a value; runs that failed stay below none.",
        "effects": "Every run over the value of each factor, and medians; the other factors as they came.",
    }
    for name, figure in drawn.items():
        if figure is not None:
            path = write_atomic(folder / f"{name}.png", lambda file, f=figure: f.savefig(file, dpi=DPI, format="png"))
            pictures.append(_picture(path, captions[name]))
    return write_atomic(folder / "report.html", _page(swept, lines, shown, files, pictures))


def _page(swept: Swept, lines: Lines, shown: Path, files: Mapping[str, str], pictures: Sequence[str]) -> str:
    cases = summary.cases_of(swept, lines)
    title = html.escape(f"Sweep of {swept.experiment.name}")
    kicker = f"{swept.experiment.machine.name} · {' and '.join(swept.experiment.labels)}"
    heads, rows = summary.case_rows(swept, lines, cases)
    left = f" The {len(rows)} best of {len(cases)} cases." if len(rows) < len(cases) else ""
    effect = summary.effect_rows(swept, lines, summary.effects_of(swept, lines))
    worst = "\n".join(_run(run) for run in summary.worst_runs(swept, lines, shown))
    texts = (*swept.progress.warned, *limits.unstable(swept, lines))
    warned = "".join(f"<li>{html.escape(text)}</li>" for text in texts)
    warned = f'<div class="warned" role="note"><strong>Warned</strong><ul>{warned}</ul></div>' if warned else ""
    inputs = "\n".join(
        f"<details><summary>{html.escape(name)}</summary><pre>{html.escape(text)}</pre></details>"
        for name, text in files.items()
    )
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
<p class="kicker">{html.escape(kicker)}</p>
<h1>{title}</h1>
{warned}
<p class="verdict">{html.escape(summary.verdict(swept, lines, cases))}</p>
</header>
<h2>Cases</h2>
<p class="note">{html.escape(swept.design.metric)} over all draws.{left}</p>
{_table(heads, rows)}
<h2>Spread and effects</h2>
{"".join(pictures)}
{_table(*effect) if effect[1] else ""}
<h2>Worst runs</h2>
<p class="note">Each command does the run again, with a full log and a report of its own.</p>
{worst}
<h2>Inputs</h2>
{inputs}
<footer><p>Made by gough {html.escape(__version__)}: gough sweep. The page holds all it shows and loads nothing.</p>
</footer>
</main>
</body>
</html>
"""


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    top = "".join(f"<th>{html.escape(head)}</th>" for head in heads)
    body = "\n".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f'<div class="scroll"><table><thead><tr>{top}</tr></thead>\n<tbody>\n{body}\n</tbody></table></div>'


def _run(run: summary.Shown) -> str:
    told = ", ".join(f"{key} = {value}" for key, value in run.settings.items())
    return (
        f"<h3>{html.escape(run.what)}</h3>\n<p class='note'>{html.escape(told)}</p>\n"
        f"<pre class='command'>{html.escape(run.command)}</pre>"
    )


def _picture(path: Path, caption: str) -> str:
    data = base64.b64encode(path.read_bytes()).decode()
    text = html.escape(caption)
    return f'<figure><img src="data:image/png;base64,{data}" alt="{text}"><figcaption>{text}</figcaption></figure>\n'
