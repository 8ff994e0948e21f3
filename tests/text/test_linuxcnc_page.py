"""docs/linuxcnc.md: its code prints what the page says; the parts it names are those that are exported."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from gough.export.linuxcnc import KINDS, core

PAGE = (Path(__file__).parents[2] / "docs" / "linuxcnc.md").read_text()


@pytest.mark.full
def test_the_python_of_the_page_prints_what_it_says():
    code, shown = re.search(r"```python\n(.*?)```\n```text\n(.*?)```", PAGE, re.S).groups()
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout == shown


def test_the_page_names_every_component_and_its_pins():
    for part in ("observer", "feedforward", "following"):
        assert f"`NAME_{part}`" in PAGE
    text = "".join(map(core.template, ("kins.c", "observer.comp", "feedforward.comp", "following.comp")))
    for pin in ("position-", "drive-", "wrench-", "force-", "tripped", "held", "gain", "kins.status", "kins.limit"):
        assert pin in PAGE and pin in text, pin
    assert len(KINDS) == 3 and all(word in PAGE for word in ("Hexapods", "hexaglides", "3-PRS"))
