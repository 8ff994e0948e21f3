"""docs/sweeps.md: its table is the example's, and it names every distribution and key."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

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
