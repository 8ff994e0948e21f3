"""docs/flexible.md: its code runs and prints what the page says; the joints it names are those there are."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from gough.machine.sheet import KINDS, machine_class

PAGE = (Path(__file__).parents[2] / "docs" / "flexible.md").read_text()


@pytest.mark.full
def test_the_python_of_the_page_prints_what_it_says():
    code, shown = re.search(r"```python\n(.*?)```\n```text\n(.*?)```", PAGE, re.S).groups()
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    numbers = [np.array(re.findall(r"-?\d+\.?\d*", text), float) for text in (shown, done.stdout)]
    np.testing.assert_allclose(numbers[1], numbers[0], rtol=1e-5)


def test_the_page_names_every_joint_that_may_give_way():
    for kind in KINDS:
        for place in machine_class(kind).elastic_places:
            assert f"{place}s" in PAGE, (kind, place)
