"""docs/maps.md: its code runs and prints what the page says; its table names what there is."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from gough.plan.quantities import QUANTITIES, TOLD

PAGE = (Path(__file__).parents[2] / "docs" / "maps.md").read_text()


@pytest.mark.full
@pytest.mark.parametrize("which", [0, 1])
def test_the_python_of_the_page_prints_what_it_says(which):
    code, shown = re.findall(r"```python\n(.*?)```\n```text\n(.*?)```", PAGE, re.S)[which]
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    words, numbers = zip(*(_parts(text) for text in (shown, done.stdout)), strict=True)
    np.testing.assert_allclose(numbers[1], numbers[0], rtol=1e-4)
    # mirrored struts end together: which of them is named is a matter of rounding
    assert words[0] == words[1]


def _parts(text):
    text = re.sub(r"(strut|slider|link) \d", r"\1", text)
    return re.sub(r"-?\d+\.?\d*", "#", text).split(), np.array(re.findall(r"-?\d+\.?\d*", text), float)


CHATTER = {"depth", "depth_here", "chatter_frequency"}  # of Python alone


def test_the_table_of_the_page_names_every_map_and_every_variable():
    rows = dict(re.findall(r"^\| `(\w+)` \| (.*?) \|", PAGE, re.M))
    assert list(rows) == list(QUANTITIES)
    named = {name for cell in rows.values() for name in re.findall(r"`(\w+)`", cell)}
    assert named == set(TOLD) - {"inside", "declared"} - CHATTER
    assert {name for name in CHATTER if f"`{name}`" in PAGE} == CHATTER < set(TOLD)
