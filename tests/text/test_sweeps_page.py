"""docs/sweeps.md: its table is one, its code prints what the page says, and it names every distribution and option."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

from gough.experiment import load_experiment
from gough.sweep.design import Table, design_of
from gough.sweep.distributions import KINDS

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "sweeps.md").read_text()


def test_the_table_of_the_page_is_that_of_the_example():
    (text,) = re.findall(r"```toml\n(.*?)```", PAGE, re.S)
    example = load_experiment(ROOT / "examples" / "11_drawn_machines.toml")
    assert tomllib.loads(text)["sweep"] | {"seed": 0} == example.document.data["sweep"] | {"seed": 0}
    assert len(design_of(example)) * len(example.controllers) == 600


def test_the_page_names_every_distribution_and_every_key():
    assert not [kind for kind in KINDS if f"`{kind}(" not in PAGE]
    assert not [key for key in Table.model_fields if not re.search(rf"^{key}\b", PAGE, re.M)]


@pytest.mark.full
def test_the_python_of_the_page_prints_what_it_says(tmp_path):
    code, shown = re.search(r"```python\n(.*?)```\n```text\n(.*?)```", PAGE, re.S).groups()
    script = tmp_path / "page.py"  # a file: worker processes import what started them
    script.write_text(code)
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    assert re.sub(r"[\d.]+ um", "", done.stdout) == re.sub(r"[\d.]+ um", "", shown)
    numbers = [np.array(re.findall(r"([\d.]+) um", text), float) for text in (shown, done.stdout)]
    np.testing.assert_allclose(numbers[1], numbers[0], rtol=0.02)  # as in the README: processors round otherwise


def test_the_sweep_of_the_template_is_right_once_it_is_switched_on(tmp_path):
    from gough.cli.new import EXPERIMENT

    text = re.sub(
        r"^# (?=\[sweep|runs +=|method +=|metric +=|\"plant\.payload\"|\"plant\.fri.*static\"|\"controller)",
        "",
        EXPERIMENT,
        flags=re.M,
    )
    path = tmp_path / "part.toml"
    path.write_text(text)
    design = design_of(load_experiment(path))
    assert len(design.factors) == 3 and len(design) == 200
