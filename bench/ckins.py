"""Kinematics in C beside LinuxCNC's: `python -m bench.ckins`, where the package linuxcnc-uspace and gcc are.

The packaged genhexkins.so is loaded as it is; halstub.c is the HAL it asks for.  Both are called in loops of C, on the
same poses of LinuxCNC's default hexapod, in turns, in one process; medians of the turns are told, since others use the
processor too.  Ours is compiled with -O2.
"""

from __future__ import annotations

import ctypes
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import gough as gk
from gough.export.c.machine_text import machine_text

MODULE = Path("/usr/lib/linuxcnc/modules/genhexkins.so")
SHEET = Path(__file__).parents[1] / "tests" / "export" / "genhex.toml"
INCH = 0.0254
POSES, TURNS = 2000, 41
AIMS = {"inverse": 0.6, "forward at C = 0": 1 / 3, "forward at C = 45 deg": 1 / 20}  # of genhexkins' time; issue 12


class Both:
    """Both kinematics of the default hexapod, ready to be timed."""

    def __init__(self, folder: Path):
        self.machine = gk.load_machine(SHEET)
        for name, text in zip(("ours.c", "ours.h"), machine_text("ours", self.machine), strict=True):
            (folder / name).write_text(text)
        self.stub = _library(folder, "halstub", [Path(__file__).with_name("halstub.c")], ctypes.RTLD_GLOBAL)
        self.ours = _library(folder, "ours", [folder / "ours.c"])
        self.theirs = ctypes.CDLL(str(MODULE))
        self.theirs.rtapi_app_main()
        for name in ("genhex_inverse", "genhex_forward", "our_inverse", "our_forward"):
            getattr(self.stub, f"time_{name}").restype = ctypes.c_double
        self._time("genhex_forward", self.theirs.kinematicsForward, np.ones((1, 6)), np.zeros((1, 9)))  # fails once

    def pin(self, name: str) -> float:
        """The value of a pin of genhexkins."""
        self.stub.pin_value.restype = ctypes.POINTER(ctypes.c_double)
        return self.stub.pin_value(f"genhexkins.{name}".encode())[0]

    def joints(self) -> tuple[np.ndarray, np.ndarray]:
        """Base and platform joints of genhexkins, (6, 3) m each."""
        base, platform = (
            np.array([[self.pin(f"{what}.{i}.{axis}") for axis in "xyz"] for i in range(6)]) * INCH
            for what in ("base", "platform")
        )
        return base, platform

    def path(self, c: float) -> np.ndarray:
        """Poses 1 ms apart at 100 mm/s and 10 deg/s about the angle c, (POSES, 6)."""
        t = np.arange(POSES) * 1e-3
        x = np.tile(self.machine.home, (POSES, 1))
        x[:, 0], x[:, 1] = 0.05 * np.cos(2 * t), 0.05 * np.sin(2 * t)
        x[:, 3], x[:, 4] = 0.05 * np.sin(3 * t), 0.05 * np.cos(3 * t)
        x[:, 5] = c
        return x

    def inverse(self, x: np.ndarray) -> tuple[float, float]:
        """ns a call, theirs and ours, once."""
        theirs, ours = np.zeros((len(x), 6)), np.zeros((len(x), 6))
        times = (
            self._time("genhex_inverse", self.theirs.kinematicsInverse, _emc(x), theirs),
            self._time("our_inverse", self.ours.ours_inverse, np.ascontiguousarray(x), ours),
        )
        assert np.abs(theirs * INCH - ours).max() < 1e-12  # lengths of 30 in and 17 digits
        return times

    def forward(self, x: np.ndarray) -> tuple[float, float]:
        """ns a call, theirs and ours, once; the last good pose is that of a sample before."""
        q = self.machine.inverse_kinematics(x)[1:]
        theirs, ours = _emc(x[:-1]), x[:-1].copy()
        times = (
            self._time("genhex_forward", self.theirs.kinematicsForward, np.ascontiguousarray(q / INCH), theirs),
            self._time("our_forward", self.ours.ours_forward, np.ascontiguousarray(q), ours),
        )
        assert np.abs(ours - x[1:]).max() < 1e-12
        return times

    def _time(self, name, function, inputs, outputs) -> float:
        failures = ctypes.c_int(0)
        timer = getattr(self.stub, f"time_{name}")
        address = ctypes.cast(function, ctypes.c_void_p)
        found = timer(address, _pointer(inputs), _pointer(outputs), len(inputs), ctypes.byref(failures))
        self.failures = failures.value
        return found


def _emc(x: np.ndarray) -> np.ndarray:
    """Poses as LinuxCNC has them, inches and degrees, with u v w.  (N, 9)."""
    return np.concatenate([x[:, :3] / INCH, np.degrees(x[:, 3:]), np.zeros((len(x), 3))], 1)


def _pointer(array: np.ndarray):
    return array.ctypes.data_as(ctypes.c_void_p)


def _library(folder: Path, name: str, sources, mode=ctypes.RTLD_LOCAL) -> ctypes.CDLL:
    out = folder / f"lib{name}.so"
    command = ["gcc", "-O2", "-shared", "-fPIC", "-ffp-contract=off", *map(str, sources), "-o", str(out), "-lm"]
    subprocess.run(command, check=True, timeout=120)
    return ctypes.CDLL(str(out), mode=mode)


def measured(turns: int = TURNS) -> dict[str, tuple[float, float]]:
    """What is timed -> medians in ns a call, genhexkins and ours."""
    with tempfile.TemporaryDirectory() as folder:
        both = Both(Path(folder))
        jobs = {
            "inverse": lambda: both.inverse(both.path(0.3)),
            "forward at C = 0": lambda: both.forward(both.path(0.0)),
            "forward at C = 45 deg": lambda: both.forward(both.path(np.pi / 4)),
        }
        return {name: tuple(np.median([job() for _ in range(turns)], axis=0)) for name, job in jobs.items()}


def main() -> int:
    """Print the table; 1 where an aim is missed, 0 where there is nothing to compare with."""
    if not MODULE.exists():
        print(f"{MODULE} is not there: install linuxcnc-uspace")
        return 0
    print(f"{'':24} {'genhexkins':>12} {'gough':>9}  ratio   aim")
    late = 0
    for name, (theirs, ours) in measured().items():
        late += ours > AIMS[name] * theirs
        print(f"{name:24} {theirs:9.0f} ns {ours:6.0f} ns  {ours / theirs:5.3f}  {AIMS[name]:5.3f}")
    return int(late > 0)


if __name__ == "__main__":
    sys.exit(main())
