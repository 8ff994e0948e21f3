"""What the tests of the exports share."""

from __future__ import annotations

import shutil

import pytest
from compiled import GENHEX, InC

import gough as gk


@pytest.fixture(scope="session")
def genhex(tmp_path_factory):
    """LinuxCNC's default hexapod in C."""
    if shutil.which("gcc") is None:
        pytest.skip("gcc is not installed")
    return InC(tmp_path_factory.mktemp("genhex"), gk.load_machine(GENHEX), options=("-O0",))
