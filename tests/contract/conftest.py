"""The machines that keep the contract.  A new machine joins by one line in MACHINES."""

from __future__ import annotations

import pytest

import gough as gk

MACHINES = [
    "nist-octahedral",
    "okuma-pm600",
    "eth-hexaglide",
    "ccu-3prs",
    "ifma-hsm",
]


@pytest.fixture(params=MACHINES, scope="module")
def machine(request):
    return gk.load_machine(request.param)
