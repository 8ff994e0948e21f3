"""Machines and programs of these tests; the runs of LinuxCNC are made once each."""

from __future__ import annotations

import fcntl
import functools
import tempfile
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from gough.linuxcnc import record, sandbox
from gough.machine.sheet import load_machine
from gough.program.nc import NCProgram

needs_linuxcnc = pytest.mark.skipif(sandbox.missing() is not None, reason=f"LinuxCNC: {sandbox.missing()}")

INCH = 0.0254
# LinuxCNC's default hexapod: genhexkins' pins base.N and platform.N as they are when it is loaded, inch
BASE = [[-22.95, 13.25], [22.95, 13.25], [22.95, 13.25], [0, -26.5], [0, -26.5], [-22.95, 13.25]]
PLATFORM = [[-1, 11.5], [1, 11.5], [10.459, -4.884], [9.459, -6.616], [-9.459, -6.616], [-10.459, -4.884]]

PARTS = {
    "corners": "G21 G90 G64 P0.05\nG1 F3000 X20\nG1 Y20\nG2 X0 Y0 I-10 J-10\nG1 Z-5\nM2\n",
    "tilted": "G21 G90 G61\nG1 F1200 X15 A6 B-4\nG64 P0.1\nG3 X0 Y15 I-15 A-3\nG93\nG1 F30 Z8 C12\nG94\n"
    "G0 X0 Y0 Z0 A0 B0 C0\nM2\n",
    "turned": "G21 G90\nG1 F1200 C70\nG1 X40 Y40\nM2\n",
    "line": "G21 G90\nG1 F3000 X30 Y-10 Z5\nG4 P0.1\nG1 X0 Y0 Z0\nM2\n",
}


@functools.cache
def default_hexapod():
    """LinuxCNC's default hexapod, with the masses of a library machine; limits wide enough for C = 70 deg."""
    points = {name: np.c_[np.array(xy) * INCH, np.zeros(6)] for name, xy in (("base", BASE), ("platform", PLATFORM))}
    return load_machine("nist-octahedral").replace(**{
        "name": "default-hexapod", "joints.base": points["base"], "joints.platform": points["platform"],
        "tool": None, "joints.base_axis": None, "joints.friction": None, "platform.center": [0.0, 0.0, 0.0],
        "home": [0.0, 0.0, 20 * INCH, 0.0, 0.0, 0.0], "friction": None, "limits.length": [0.5, 1.2],
        "limits.cone": None, "limits.workspace.radius": 0.2, "limits.workspace.height": 0.2,
        "limits.workspace.tilt": 0.4, "limits.workspace.c": 1.5, "source": {},
    })  # fmt: skip


@functools.cache
def machine_of(name: str):
    """A library machine; LinuxCNC's default hexapod; or a library machine whose home is tilted, turned and aside."""
    if name == "turned-home":
        home = [0.02, -0.01, 0.015, 0.03, -0.05, 0.2]
        return load_machine("nist-octahedral").replace(home=home)
    return default_hexapod() if name == "default-hexapod" else load_machine(name)


def program_of(part: str) -> NCProgram:
    return NCProgram(text=PARTS[part], name=f"{part}.ngc")


@contextmanager
def turn(alone: bool = False):
    """A lock that runs of LinuxCNC share, over all processes of the tests; `alone` has it for itself."""
    with open(Path(tempfile.gettempdir(), "gough-linuxcnc-tests.lock"), "w") as file:
        fcntl.flock(file, fcntl.LOCK_EX if alone else fcntl.LOCK_SH)
        yield


@functools.cache
def run(machine: str, part: str, speed: int = 10):
    """The recording of a part of PARTS on a machine."""
    with turn():
        return _recorded(machine, part, speed)


def _recorded(machine: str, part: str, speed: int):
    return record(program_of(part), machine_of(machine), speed=speed, timeout=120)
