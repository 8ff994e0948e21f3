"""One short run, saved, for everything that looks at it."""

from __future__ import annotations

import pytest

import gough as gk


@pytest.fixture(scope="session")
def run_log():
    machine = gk.load_machine("nist-octahedral")
    return gk.simulate(machine, gk.PID(bandwidth=12.0), gk.Circle(radius=0.05, feed=0.3))
