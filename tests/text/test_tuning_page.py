"""docs/tuning.md: its code runs and prints what the page says; the table it shows is one that is taken."""

from __future__ import annotations

import re
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest

from gough.experiment import load_experiment
from gough.tune.table import Table, task_of

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "tuning.md").read_text()


@pytest.mark.full
def test_the_python_of_the_page_prints_what_it_says():
    code, shown = re.search(r"```python\n(.*?)```\n```text\n(.*?)```", PAGE, re.S).groups()
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    numbers = [np.array(re.findall(r"-?\d+\.?\d*", text), float) for text in (shown, done.stdout)]
    np.testing.assert_allclose(numbers[1], numbers[0], rtol=1e-3)


def test_the_table_of_the_page_is_taken_and_names_every_key(tmp_path):
    block = textwrap.dedent(re.search(r"\n\n(    \[tune\]\n.*?)\n\n", PAGE, re.S)[1])
    example = (ROOT / "examples" / "12_tuned.toml").read_text()
    (tmp_path / "e.toml").write_text(example[: example.index("[tune]")] + block + "\n")
    task = task_of(load_experiment(tmp_path / "e.toml"))
    assert len(task.gains) == 2 and len(task.machines) == len(task.held_out) == 8 and task.table.force == 8000.0
    for key in Table.model_fields:
        assert re.search(rf"^{key} +=", block, re.M), key
