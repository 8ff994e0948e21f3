"""What is wrong with a file, as `gough check` says it."""

from __future__ import annotations

import pytest


@pytest.fixture
def complaints(gough, write):
    """The error lines that `gough check` prints of a text, without the file's name; the status must be 2."""

    def check(text: str, changes: dict[str, str] | None = None, name: str = "f.toml") -> list[str]:
        write(name, text, changes)
        ended = gough("check", name)
        assert ended.status == 2, ended
        assert ended.out == ""
        lines = ended.err.splitlines()
        assert all(line.startswith(f"{name}:") for line in lines), lines
        return [line.removeprefix(f"{name}:") for line in lines]

    return check
