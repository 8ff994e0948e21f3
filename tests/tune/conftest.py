"""Three sliders on a small circle: a tuning of it takes a second or two."""

from __future__ import annotations

import pytest

TEXT = """schema = "gough-experiment-1"
[machine]
use = "ccu-3prs"
[program]
kind = "circle"
radius = "4 mm"
feed = "100 mm/s"
settle = "30 ms"
[[controller]]
kind = "pid"
bandwidth = "8 Hz"
"""
SWEEP = """[sweep]
vary = { "plant.payload" = "uniform(1, 4) kg" }
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
        path = tmp_path / "tripod.toml"
        path.write_text(text + sweep + tune)
        return load_experiment(path)

    return write
