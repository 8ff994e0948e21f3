"""One axis on a short line: a tuning of it takes a second."""

from __future__ import annotations

import pytest

TEXT = """schema = "gough-experiment-1"
[machine]
use = "emps"
[program]
kind = "line"
to = ["4 mm", "0 mm", "0 mm"]
feed = "50 mm/s"
settle = "50 ms"
[[controller]]
kind = "pid"
bandwidth = "8 Hz"
"""
SWEEP = """[sweep]
vary = { "plant.friction.coulomb" = "uniform(0.5, 1.5) x" }
seed = 3
"""
TUNE = """[tune]
vary = { "controller.bandwidth" = ["4 Hz", "40 Hz"] }
budget = 12
"""


@pytest.fixture
def written(tmp_path):
    """Writes an experiment and loads it."""
    from gough.experiment import load_experiment

    def write(tune: str = TUNE, sweep: str = SWEEP, text: str = TEXT):
        path = tmp_path / "axis.toml"
        path.write_text(text + sweep + tune)
        return load_experiment(path)

    return write
