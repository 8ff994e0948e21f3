"""A cache of its own for every test: nobody's real cache is touched."""

import pytest


@pytest.fixture(autouse=True)
def cache_folder(tmp_path, monkeypatch):
    folder = tmp_path / "cache"
    monkeypatch.setenv("GOUGH_CACHE", str(folder))
    return folder / "kernel"
