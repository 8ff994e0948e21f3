"""gough reproduce: published experiments done again, and their numbers held against the paper's."""

from __future__ import annotations

import csv
import io
import json
import sys
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from .. import __version__
from ..errors import RunError
from ..files import write_atomic
from ..results import results_folder
from ..study import PAPERS, built, find
from ..study.claims import NOT_MET, Claim
from ..study.page import write_page
from ..study.source import source_hash
from ..study.study import Beyond, Experiment, Figure, Study, Told
from ..study.text import claims_table, notes, plain_table, summary
from .end import Outcome, plain
from .progress import Shown
from .together import together

ALL = "all"
WIDE = 160  # columns of a table that goes into a file or a pipe
DPI = 150


def reproduce_papers(paper: str, campaign: bool, out: Path | None, force: bool, quiet: bool, outcome: Outcome) -> None:
    """Do the study of a paper, or all that are built, with its long campaigns if `campaign`.

    Each has a folder of its own: claims.json, report.html, the figures as PNG, what goes beyond the paper as CSV, and
    study.json, from which the documentation shows rows and figures.

    Raises
    ------
    ExperimentError
        no such paper, or none that is built.
    RunError
        a run of an experiment ended early.
    StorageError
        a file could not be written.
    """
    studies = [find(name) for name in built()] if paper == ALL else [find(paper)]
    # an experiment that drives a motor into its limit means to; what it came to is in the table
    warnings.showwarning = lambda *_: None
    outcome.rows = []
    for study in studies:
        target = (out / study.paper if paper == ALL else out) if out else Path("results") / study.paper
        asked = [beyond for beyond in study.beyond if campaign or not beyond.campaign]
        with results_folder(target, force) as folder:
            groups = _experiments(study.paper, [study.experiments, *(one.experiments for one in asked)], quiet)
            claims = study.claims(groups[0])
            rows = [plain(claim.row(study.paper)) for claim in claims]
            write_atomic(folder / "claims.json", json.dumps(rows, indent=1, allow_nan=False) + "\n")
            told = [_beyond(one, results, folder) for one, results in zip(asked, groups[1:], strict=True)]
            figures = study.figures(groups[0], folder)
            page = write_page(study, claims, figures, told, folder)
            note = made(claims, [*figures, *(one.figure for one in told)])
            write_atomic(folder / "study.json", json.dumps(note, indent=1) + "\n")
        outcome.rows += rows
        if any(claim.verdict == NOT_MET for claim in claims):
            outcome.data["status"] = "failed"
        if not quiet:
            _print(study, claims, told)
        if not outcome.as_json:
            outcome.say(summary(claims), f"report: {target / page.name}")
    missing = [name for name in PAPERS if name not in built()]
    if paper == ALL and missing:
        print(f"not built yet: {', '.join(missing)}", file=sys.stderr)


def _experiments(paper: str, groups: Sequence[Sequence[Experiment]], quiet: bool) -> list[list[Any]]:
    """The results of the experiments of every group; all run side by side."""
    every = [experiment for group in groups for experiment in group]
    with Shown([experiment.label for experiment in every], quiet) as shown:

        def job(i: int) -> Callable[[], Any]:
            def work() -> Any:
                try:
                    result = every[i].work(lambda done, total: shown.tick(i, done, total))
                except RunError as error:
                    shown.end(i, "failed")
                    raise error.at(where=f"{paper}, {every[i].label}") from None
                shown.end(i, "done")
                return result

            return work

        results = iter(together([job(i) for i in range(len(every))], shown.stop))
    return [[next(results) for _ in group] for group in groups]


def made(claims: Sequence[Claim], figures: Sequence[Figure]) -> dict[str, Any]:
    """Rows as they are printed, figures with their captions, and of which source they are."""
    kinds = ("published", "measured", "band")
    return {
        "schema": "gough-study-1",
        "gough": __version__,
        "source": source_hash(),
        "rows": [[one.claim, *map(one.text, kinds), one.verdict, one.remark] for one in claims],
        "figures": [{"file": figure.file, "caption": figure.caption} for figure in figures],
    }


def _beyond(beyond: Beyond, results: Sequence[Any], folder: Path) -> Told:
    """Write table and picture; what there is to say of them."""
    rows = beyond.table(results)
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([beyond.heads, *rows])
    write_atomic(folder / f"{beyond.name}.csv", text.getvalue())
    picture = beyond.picture(results).figure
    name = f"{beyond.name}.png"
    write_atomic(folder / name, lambda file: picture.savefig(file, dpi=DPI, format="png"))
    return Told(beyond, rows, beyond.text(results), Figure(name, beyond.title))


def _print(study: Study, claims: Sequence[Claim], told: Sequence[Told]) -> None:
    from rich.console import Console

    console = Console(width=None if sys.stdout.isatty() else WIDE)
    console.print(claims_table(f"{study.title} ({study.cited})", claims))
    for line in notes(claims):
        console.print(line, markup=False, highlight=False, soft_wrap=True)
    for one in told:
        console.print()
        console.print(plain_table(one.beyond.title, one.beyond.heads, one.rows))
        console.print(one.text, markup=False, highlight=False, soft_wrap=True)
    console.print()
