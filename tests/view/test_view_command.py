"""gough view: a page on disk beside the report, and errors a stranger can act on."""

from __future__ import annotations

import importlib.util
import re

import pytest
from typer.testing import CliRunner

import gough as gk
from gough.cli.app import app

pytest.importorskip("viser", reason="viser (extra viewer) is not installed")


@pytest.fixture()
def folder(tmp_path, run_log):
    run_log.save(tmp_path / "pid.nc")
    return tmp_path


def gough(*arguments):
    done = CliRunner().invoke(app, [str(a) for a in arguments], standalone_mode=False)
    return done.return_value, done.output


@pytest.mark.full
def test_a_page_is_written_whole_and_loads_nothing(folder):
    status, said = gough("view", folder, "--export", folder / "scene.html", "--magnify", 300)
    assert (status, said) == (0, f"scene: {folder / 'scene.html'}\n")
    page = (folder / "scene.html").read_text()
    assert "drawn 300 times as large" in page
    assert not re.findall(r"""(?:src|href)=["']https?://""", page)
    status, said = gough("view", folder, "--export", folder / "scene.html")
    assert status == 2 and "there is a file already" in said


@pytest.mark.full
def test_the_report_beside_it_links_the_page_once(folder, run_log):
    gk.report(run_log, folder)
    for _ in range(2):
        gough("view", folder / "pid.nc", "--export", folder / "scene.html", "--force")
    assert (folder / "report.html").read_text().count('href="scene.html"') == 1


def test_what_cannot_be_shown_is_said(folder, monkeypatch):
    (folder / "other.nc").write_bytes((folder / "pid.nc").read_bytes())
    status, said = gough("view", folder, "--export", folder / "scene.html")
    assert status == 2 and "a page holds one run" in said
    status, said = gough("view", folder / "pid.nc", "--export", folder / "s.html", "--magnify", 0.5)
    assert status == 2 and "must be from 1 to 1e9" in said
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    status, said = gough("view", folder / "pid.nc")
    assert status == 2 and "pip install 'gough[viewer]'" in said
