"""Experiments for sweeps: short circles, in which everything happens that a sweep has to bear."""

from __future__ import annotations

import pytest

FILE = """\
schema = "gough-experiment-1"
[machine]
use = "nist-octahedral"
[plant]
"friction.coulomb" = "0.9 x"
[program]
kind = "circle"
radius = "20 mm"
feed = "6 m/min"
turns = 0.2
settle = "0.01 s"
[[controller]]
kind = "pid"
bandwidth = "10 Hz"
[[controller]]
kind = "computed_torque"
bandwidth = "10 Hz"
[sweep]
vary = {{ {vary} }}
{more}
"""


@pytest.fixture
def written(tmp_path):
    """An experiment file with this `vary`."""

    def write(vary: str, more: str = "", name: str = "part.toml", **changes: str):
        text = FILE.format(vary=vary, more=more)
        for old, new in changes.values():
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / name
        path.write_text(text)
        return path

    return write


@pytest.fixture
def experiment(written):
    """The experiment of such a file."""
    from gough.experiment import load_experiment

    return lambda *given, **changes: load_experiment(written(*given, **changes))


def runs_of(folder):
    """id -> bytes of every run's file of a store."""
    return {path.stem: path.read_bytes() for path in (folder / "runs").glob("*/*.json")}
