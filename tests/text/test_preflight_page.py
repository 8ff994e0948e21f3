"""docs/preflight.md and its example: the code runs and prints what the page says."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "preflight.md").read_text()


@pytest.mark.full
def test_the_python_of_the_page_prints_what_it_says():
    code, shown = re.search(r"```python\n(.*?)```\n```text\n(.*?)```", PAGE, re.S).groups()
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == shown.split()


@pytest.mark.full
def test_the_example_runs_and_its_assertions_hold():
    example = ROOT / "examples" / "14_before_metal_is_cut.py"
    done = subprocess.run([sys.executable, example], capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 0, done.stderr


def test_every_option_that_the_page_writes_is_one_of_the_command():
    from typer.main import get_command

    from gough.cli.app import app

    known = {name for option in get_command(app).commands["preflight"].params for name in option.opts}
    assert set(re.findall(r"(?<![\w-])--[a-z][a-z-]*", PAGE)) <= known
