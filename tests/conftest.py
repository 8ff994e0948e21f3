"""The command line in this process: `gough("check", "f.toml")` gives status, stdout and stderr."""

from __future__ import annotations

import json
import signal
import textwrap
import warnings
from pathlib import Path
from typing import NamedTuple

import pytest

SHEET = """\
schema = "gough-machine-1"
name = "mine"
kind = "hexapod"

[platform]
mass = "120 kg"
center = { unit = "m", value = [0, 0, 0.3] }
inertia = { unit = "kg m2", value = [[5, 0, 0], [0, 5, 0], [0, 0, 6]] }

[joints]
base = { unit = "m", value = [
    [-0.1455, 0.6847, 1.0], [0.1455, 0.6847, 1.0], [-0.5202, -0.4684, 1.0],
    [-0.6657, -0.2163, 1.0], [0.6657, -0.2163, 1.0], [0.5202, -0.4684, 1.0],
] }
platform = { unit = "m", value = [
    [-0.1262, 0.1802, 0.25], [0.1262, 0.1802, 0.25], [-0.0930, -0.1994, 0.25],
    [-0.2192, 0.0192, 0.25], [0.2192, 0.0192, 0.25], [0.0930, -0.1994, 0.25],
] }

[drive]
lead = "20 mm"

[limits]
length = ["0.70 m", "1.15 m"]

[home]
pose = ["0 mm", "0 mm", "0 mm", "0 deg", "0 deg", "0 deg"]
"""

EXPERIMENT = """\
schema = "gough-experiment-1"

[machine]
use = "nist-octahedral"

[program]
kind = "circle"
radius = "20 mm"
feed = "6 m/min"

[[controller]]
kind = "pid"
bandwidth = "10 Hz"

[[controller]]
kind = "computed_torque"
bandwidth = "10 Hz"

[run]
period = "1 ms"
"""


class Ended(NamedTuple):
    """How a command ended."""

    status: int
    out: str
    err: str

    @property
    def json(self) -> dict:
        assert self.out.count("\n") == 1, "one object, one line"
        return json.loads(self.out)


@pytest.fixture
def gough(tmp_path, monkeypatch, capsys):
    """Runs the command line in an empty folder."""
    from gough.cli import main

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(warnings, "showwarning", warnings.showwarning)  # put back what a command sets
    before = signal.getsignal(signal.SIGTERM)

    def call(*arguments) -> Ended:
        capsys.readouterr()
        with pytest.raises(SystemExit) as caught:
            main([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        assert "Traceback" not in err or "--debug" in arguments
        return Ended(caught.value.code or 0, out, err)

    yield call
    signal.signal(signal.SIGTERM, before)


@pytest.fixture
def write(tmp_path):
    """Writes a file: `write("f.toml", text)`, or with changes `write("f.toml", SHEET, {"old": "new"})`."""

    def file(name: str, text: str, changes: dict[str, str] | None = None) -> Path:
        for old, new in (changes or {}).items():
            assert old in text, f"{old!r} is not in the text to change"
            text = text.replace(old, new)
        path = tmp_path / name
        path.write_text(textwrap.dedent(text))
        return path

    return file
