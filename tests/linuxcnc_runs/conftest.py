"""Tests that look for processes left behind run while no other test of this machine has LinuxCNC running."""

from __future__ import annotations

import pytest

from .machines import turn


@pytest.fixture(autouse=True)
def lock(request):
    """A lock shared by all tests here; a test marked `alone` has it for itself."""
    alone = request.node.get_closest_marker("alone") is not None
    if "made" in request.fixturenames:  # runs take it themselves
        yield
        return
    with turn(alone):
        yield
