"""What `gough reproduce` promises, with a study of no work."""

from __future__ import annotations

import json

import pytest

import gough.cli.reproduce as command
from gough.errors import DivergedError
from gough.report import style
from gough.study import PAPERS
from gough.study.claims import Claim
from gough.study.study import Beyond, Experiment, Figure, Study


@pytest.fixture
def fake(monkeypatch):
    """Puts a study in the place of garagic2004: one experiment that gives `measured`, or does what `work` does."""

    def put(measured=1.0, work=None):
        def done(tick):
            tick(0.5, 1.0)
            return measured

        def figures(results, folder):
            style.new_axes((1.0, 1.0)).figure.savefig(folder / "one.png")
            return [Figure("one.png", "A <picture>.")]

        def beyond(name, campaign):
            return Beyond(
                name, f"Beyond: {name}", [Experiment(name, lambda tick: 3)], ("law", "what", "error"),
                lambda results: [["CDAC", "a, b", f"{results[0]} um"]], lambda results: style.new_axes((1.0, 1.0)),
                lambda results: f"{name} says <{results[0]}>", campaign,
            )  # fmt: skip

        study = Study(
            "garagic2004", "A & B", "C, 2004", "About.", [Experiment("first", work or done)],
            lambda results: [Claim("one <is> one", results[0], "1", (1, 1), published=1.0, note="[note]")], figures,
            (beyond("fair", False), beyond("many", True)),
        )  # fmt: skip
        monkeypatch.setattr(command, "find", lambda name: study)

    return put


def test_a_claim_that_is_met_ends_with_0_and_leaves_table_figures_and_page(gough, fake, tmp_path):
    fake()
    ended = gough("reproduce", "garagic2004")
    assert ended.status == 0
    *table, found, report = ended.out.splitlines()
    assert found == "1 claims: 1 met" and report == "report: results/garagic2004/report.html"
    text = "\n".join(table)
    assert "one <is> one" in text and "1: [note]" in text and "fair says <3>" in text and "many" not in text
    folder = tmp_path / "results/garagic2004"
    made = {path.name for path in folder.iterdir()}
    assert made == {".gough", "claims.json", "study.json", "report.html", "one.png", "fair.csv", "fair.png"}
    note = json.loads((folder / "study.json").read_text())
    assert note["rows"] == [["one <is> one", "1", "1", "1", "met", "[note]"]]
    assert note["figures"] == [
        {"file": "one.png", "caption": "A <picture>."}, {"file": "fair.png", "caption": "Beyond: fair"},
    ]  # fmt: skip
    assert (folder / "fair.csv").read_text() == 'law,what,error\nCDAC,"a, b",3 um\n'
    page = (folder / "report.html").read_text()
    assert "one &lt;is&gt; one" in page and "A &lt;picture&gt;." in page and "fair says &lt;3&gt;" in page
    assert "A &amp; B" in page and page.count("data:image/png;base64,") == 2
    assert "http" not in page.replace("http-equiv", ""), "the page fetches nothing"


def test_json_is_a_list_of_rows_and_nothing_else_is_on_stdout(gough, fake):
    fake()
    ended = gough("reproduce", "garagic2004", "--json", "--out", "here")
    assert ended.status == 0
    assert ended.json == [
        {
            "paper": "garagic2004", "claim": "one <is> one", "published": 1.0, "measured": 1.0, "unit": "1",
            "band": [1, 1], "verdict": "met", "note": "[note]",
        }
    ]  # fmt: skip


def test_the_file_of_claims_is_what_json_prints(gough, fake, tmp_path):
    fake()
    rows = gough("reproduce", "garagic2004", "--json").json
    assert json.loads((tmp_path / "results/garagic2004/claims.json").read_text()) == rows


@pytest.mark.parametrize("measured", [2.0, float("nan")])
def test_a_claim_that_is_not_met_ends_with_1_and_leaves_its_page(gough, fake, tmp_path, measured):
    fake(measured)
    ended = gough("reproduce", "garagic2004", "--json")
    assert ended.status == 1
    assert ended.json[0]["verdict"] == "not met"
    assert (tmp_path / "results/garagic2004/report.html").exists()


def test_campaigns_run_only_when_asked_for(gough, fake, tmp_path):
    fake()
    assert gough("reproduce", "garagic2004", "--campaign", "--quiet").status == 0
    assert (tmp_path / "results/garagic2004/many.csv").exists()


def test_a_run_that_fails_says_which_and_leaves_nothing(gough, fake, tmp_path):
    def work(tick):
        raise DivergedError("v is no longer finite", time=0.2)

    fake(work=work)
    ended = gough("reproduce", "garagic2004", "--json")
    assert ended.status == 1
    assert ended.err.splitlines()[-1] == "garagic2004, first: v is no longer finite at t = 0.2 s"
    assert ended.json["error"]["code"] == "DivergedError"
    assert not (tmp_path / "results/garagic2004").exists()


def test_an_interruption_ends_with_130_and_leaves_nothing(gough, fake, tmp_path):
    def work(tick):
        raise KeyboardInterrupt

    fake(work=work)
    ended = gough("reproduce", "garagic2004")
    assert ended.status == 130 and ended.err.endswith("gough: interrupted; nothing was written\n")
    assert list((tmp_path / "results").iterdir()) == []


def test_all_is_every_study_that_is_built_each_in_a_folder_and_the_rest_is_named(gough, fake, monkeypatch, tmp_path):
    fake()
    monkeypatch.setattr(command, "built", lambda: ["garagic2004"])
    monkeypatch.setattr(command, "PAPERS", {"garagic2004": "garagic2004", "okuda2006": None})
    ended = gough("reproduce", "all", "--json", "--out", "papers")
    assert ended.status == 0 and len(ended.json) == 1
    assert ended.err.endswith("not built yet: okuda2006\n")
    assert (tmp_path / "papers/garagic2004/report.html").exists()


def test_an_unknown_paper_is_refused_with_the_nearest(gough):
    ended = gough("reproduce", "garagic2005")
    assert ended == (2, "", "PAPER: no such paper, got 'garagic2005'; did you mean garagic2004?\n")


def test_a_paper_whose_study_is_not_built_is_refused_by_name(gough, monkeypatch):
    monkeypatch.setitem(PAPERS, "okuda2006", None)
    ended = gough("reproduce", "okuda2006")
    assert ended.status == 2
    assert ended.err == (
        "PAPER: the study of this paper is not built yet, got okuda2006; "
        "there is garagic2004, honegger1998, chen2008, bouzgarrou2001\n"
    )
