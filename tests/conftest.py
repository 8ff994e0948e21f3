"""The command line in this process: `gough("check", "f.toml")` gives status, stdout and stderr."""

from __future__ import annotations

import fnmatch
import json
import os
import signal
import textwrap
import warnings
from pathlib import Path
from typing import NamedTuple

# workers side by side: threads of theirs would stand in each other's way, a hundred times slower
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest  # noqa: E402


@pytest.hookimpl(tryfirst=True)  # before pytest's own leaves out what is marked
def pytest_collection_modifyitems(config, items):
    """`@pytest.mark.quick("a-*", "b")`: `make check` runs the cases with such an id; the others of this test are full.

    A test of which no case is left is an error, unless single cases were asked for: a new name hides no claim.
    """
    left = {}
    for item in items:
        mark, case = item.get_closest_marker("quick"), getattr(item, "callspec", None)
        if mark is None or case is None:
            continue
        chosen = any(fnmatch.fnmatchcase(case.id, pattern) for pattern in mark.args)
        name = item.nodeid.partition("[")[0]
        left[name] = left.get(name, False) or chosen
        if not chosen:
            item.add_marker(pytest.mark.full)
    none = [name for name, some in left.items() if not some]
    if none and not any("::" in argument for argument in config.args):
        raise pytest.UsageError(f"mark quick names no case of {', '.join(none)}")


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
    before = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGINT)}

    def call(*arguments) -> Ended:
        capsys.readouterr()
        with pytest.raises(SystemExit) as caught:
            main([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        assert "Traceback" not in err or "--debug" in arguments
        return Ended(caught.value.code or 0, out, err)

    yield call
    for number, handler in before.items():
        signal.signal(number, handler)


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
