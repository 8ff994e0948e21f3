"""What a reader can copy runs, and prints what the page says."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from test_gallery import asserts_01

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text()
CLI = [sys.executable, "-m", "gough"]


def text_of(block: str) -> list[str]:
    """The words, without what differs from machine to machine: wall times and folders."""
    lines = [line for line in block.strip("\n").splitlines() if not line.startswith(("wall time", "report:"))]
    return " ".join(lines).split()


def assert_same(shown: str, found: str):
    """Words alike, numbers to 2 %: another processor rounds otherwise, and friction's peaks show it in a digit."""
    shown, found = text_of(shown), text_of(found)
    assert len(shown) == len(found), (shown, found)
    for a, b in zip(shown, found, strict=True):
        try:
            assert float(b) == pytest.approx(float(a), rel=0.02), (a, b)
        except ValueError:
            assert a == b


@pytest.mark.full
def test_the_demo_prints_what_the_readme_says(tmp_path):
    shown = re.search(r"<!-- run: gough (.*?) -->\n```text\n(.*?)```", README, re.S)
    done = subprocess.run([*CLI, *shown[1].split(), "-o", tmp_path / "out"], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert_same(shown[2], done.stdout)
    assert (tmp_path / "out" / "report.html").stat().st_size > 1e6
    assert len(list((tmp_path / "out").glob("*.nc"))) == 2 and len(list((tmp_path / "out").glob("*.png"))) >= 5
    asserts_01(tmp_path / "out")
    # and the folder repeats the run
    again = subprocess.run(
        [*CLI, "run", tmp_path / "out" / "experiment.toml", "-o", tmp_path / "again"], capture_output=True, text=True
    )
    assert text_of(again.stdout) == text_of(done.stdout), again.stderr


@pytest.mark.full
def test_the_python_of_the_readme_prints_what_it_says():
    code, shown = re.search(r"```python\n(.*?)```\n```text\n(.*?)```", README, re.S).groups()
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert_same(shown, done.stdout)


@pytest.mark.full
@pytest.mark.parametrize("path", sorted((ROOT / "examples").glob("*.toml")), ids=lambda p: p.stem)
def test_the_example_experiment_is_found_right(path):
    done = subprocess.run([*CLI, "check", path], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
