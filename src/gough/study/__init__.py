"""Published experiments done again: one folder and one claims table a paper.

    from gough.study import find

    study = find("garagic2004")
    results = [experiment.work(None) for experiment in study.experiments]
    rows = study.claims(results)

A study is `experiments` that do not know each other, `claims` that hold their results against the paper, and `figures`.
`gough reproduce` runs the experiments side by side, prints the rows and writes the page.
"""

from __future__ import annotations

from importlib import import_module

from ..errors import ExperimentError, did_you_mean
from .study import Study

# every paper of the toolbox: its name -> the package that has its STUDY, or None where it is not built yet
PAPERS: dict[str, str | None] = {
    "garagic2004": "garagic2004",
    "honegger1998": "honegger1998",
    "chen2008": "chen2008",
    "bouzgarrou2001": "bouzgarrou2001",
    "okuda2006": "okuda2006",
}


def built() -> list[str]:
    """The papers whose study is built, in the order of PAPERS."""
    return [name for name, package in PAPERS.items() if package]


def find(name: str) -> Study:
    """The study of a paper.

    Raises
    ------
    ExperimentError
        there is no paper of this name, or its study is not built yet.
    """
    if name not in PAPERS:
        raise ExperimentError("no such paper", key="PAPER", value=ascii(name)[:60], cure=did_you_mean(name, PAPERS))
    package = PAPERS[name]
    if package is None:
        cure = f"there is {', '.join(built())}"
        raise ExperimentError("the study of this paper is not built yet", key="PAPER", value=name, cure=cure)
    return import_module(f".{package}", __name__).STUDY
