"""The machines under test, made once."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

from gough.machine.workspace import random_poses
from oracle.lagrange import oracle as make_oracle
from oracle.machines import MACHINES

_made = lru_cache(lambda name: MACHINES[name]())
_oracles = lru_cache(lambda name: make_oracle(_made(name)))


@pytest.fixture(params=MACHINES)
def machine(request):
    return _made(request.param)


@pytest.fixture
def oracle(machine):
    return _oracles(machine.name)


@pytest.fixture(params=["nist-octahedral", "okuma-pm600", "general"])
def slender_machine(request):
    """Machines whose strut parts are slender bodies."""
    return _made(request.param)


@pytest.fixture(params=["nist-octahedral", "okuma-pm600"])
def library_machine(request):
    return _made(request.param)


@pytest.fixture
def nist():
    return _made("nist-octahedral")


@pytest.fixture
def okuma():
    return _made("okuma-pm600")


@pytest.fixture
def states(machine):
    """x, V, V', wrench of 1000 random states: poses of the workspace, twists to 1 m/s and 1 rad/s and more."""
    rng = np.random.default_rng(20240611)
    x = random_poses(machine, 1000, rng)
    V = rng.normal(size=(1000, 6)) * [1, 1, 1, 1.5, 1.5, 1.5]
    Vd = rng.normal(size=(1000, 6)) * [10, 10, 10, 30, 30, 30]
    wrench = rng.normal(size=(1000, 6)) * [1000, 1000, 1000, 100, 100, 100]
    return x, V, Vd, wrench
