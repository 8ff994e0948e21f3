"""Experiments for sweeps: short circles, in which everything happens that a sweep has to bear."""

from __future__ import annotations

import pytest
from sweep_files import FILE


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
