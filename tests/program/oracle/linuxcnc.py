"""Runs LinuxCNC on NC programs, in two ways, each in processes and a folder of their own.

Its Python module `gcode` gives full doubles and line numbers; the program `rs274 -g` prints four decimals, and
everything else that is asked of a machine.  Both read a tool table and share it by a file in $HOME.
"""

from __future__ import annotations

import functools
import json
import os
import re
import shutil
import subprocess
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .canon import INCH, Machine, Move, Refused

RS274 = shutil.which("rs274")
PYTHON = "/usr/bin/python3"  # Debian's: the one its module `gcode` is built for
_PLANE_NUMBERS = {1: "XY", 2: "YZ", 3: "XZ"}


@functools.cache
def missing() -> str | None:
    """Why there is nothing to compare with, or None."""
    if RS274 is None:
        return "LinuxCNC's interpreter rs274 is not installed"
    if not Path(PYTHON).exists():
        return f"{PYTHON}, for LinuxCNC's Python module gcode, is not there"
    done = subprocess.run([PYTHON, "-c", "import gcode"], capture_output=True, text=True)
    return None if done.returncode == 0 else "LinuxCNC's Python module gcode is not installed"


# -- the Python module ------------------------------------------------------------------------------------------------


def read_full(texts, folder: Path, tools=(), timeout: int = 10) -> list[list[Move] | Refused]:
    """Each program as read by the module `gcode`: full doubles, line numbers.

    `tools`: rows (number, x, y, z) in mm.  A crash or a hang ends that program only: it is Refused, with that text.
    """
    folder.mkdir(exist_ok=True, parents=True)
    (folder / "tools.json").write_text(json.dumps([list(row) for row in tools]))
    _tool_memory(folder, tools)
    files = []
    for number, text in enumerate(texts):
        files.append(folder / f"{number}.ngc")
        files[-1].write_bytes(text if isinstance(text, bytes) else text.encode())
    done = subprocess.run(
        [PYTHON, Path(__file__).parent / "gcode_module.py", folder, str(timeout)],
        input="".join(f"{file}\n" for file in files), stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        env=environment(folder), cwd=folder, check=True,
    )  # fmt: skip
    return [_moves_of(json.loads(line)) for line in done.stdout.splitlines()]


def _tool_memory(folder, tools):
    """`rs274` writes the tool table into the file the library shares it through."""
    (folder / "end.ngc").write_text("M2\n")
    run_rs274(folder / "end.ngc", folder, tools)


def environment(folder):
    return {**os.environ, "HOME": str(folder), "PYTHONPATH": "/usr/lib/python3/dist-packages", "LC_ALL": "C.UTF-8"}


def _moves_of(answer) -> list[Move] | Refused:
    machine = Machine()
    for name, line, n in answer["calls"]:
        _call(machine, name, line, n)
    return machine.moves if answer["error"] is None else Refused(answer["error"], answer["line"], machine.moves)


def _call(machine, name, line, n):
    scale = np.array([INCH] * 3 + [1.0] * 3)
    if name in ("straight_traverse", "straight_feed"):
        machine.straight("rapid" if name == "straight_traverse" else "feed", scale * n[:6], line=line)
    elif name == "arc_feed":
        first, second, first_center, second_center, turns, height, *abc = n[:9]
        lengths = (INCH * v for v in (first, second, first_center, second_center))
        machine.arc(*lengths, turns, INCH * height, abc, line=line)
    elif name == "dwell":
        machine.dwell(n[0], line=line)
    elif name == "set_feed_rate":
        machine.feed = machine.feed_word = INCH * n[0]
    elif name == "set_plane":
        machine.plane = _PLANE_NUMBERS.get(n[0], machine.plane)
    elif name == "tool_offset":
        machine.change_tool_offset(INCH * np.array(n[:3]))
    elif name == "set_g5x_offset":
        machine.g5x = scale * n[1:7]
    elif name == "set_g92_offset":
        machine.g92 = scale * n[:6]
    elif name == "set_xy_rotation":
        machine.turn(n[0])


# -- the program rs274 ------------------------------------------------------------------------------------------------


class Printed(NamedTuple):
    """One run of `rs274 -g`."""

    moves: list[Move]
    error: str | None  # what it wrote about the program, if it refused it
    half: float  # mm, half of the last decimal printed, in the coarser unit if both are used


def read_printed(text, folder: Path, tools=(), timeout: float = 20.0, more=()) -> Printed:
    """One program as read by `rs274 -g`.  TimeoutExpired if it hangs.  `more`: further options."""
    folder.mkdir(exist_ok=True, parents=True)
    file = folder / "part.ngc"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    done = run_rs274(file, folder, tools, timeout, more)
    return _printed(done)


def run_rs274(file, folder, tools, timeout=20.0, more=()):
    rows = [f"T{n} P{k} X{x / INCH:.15f} Y{y / INCH:.15f} Z{z / INCH:.15f}" for k, (n, x, y, z) in enumerate(tools, 1)]
    (folder / "tool.tbl").write_text("".join(f"{row}\n" for row in rows))  # its own tools are in inch
    (folder / "rs274.var").write_text("")  # offsets of the last run stay in it
    command = [RS274, "-t", folder / "tool.tbl", "-v", folder / "rs274.var", *more, "-g", file]
    return subprocess.run(
        command, cwd=folder, env=environment(folder), capture_output=True, timeout=timeout, stdin=subprocess.DEVNULL
    )


_STOPS = {
    "PROGRAM_STOP", "OPTIONAL_PROGRAM_STOP", "START_CHANGE", "START_SPINDLE_CLOCKWISE",
    "START_SPINDLE_COUNTERCLOCKWISE", "STOP_SPINDLE_TURNING", "FLOOD_ON", "FLOOD_OFF", "MIST_ON", "MIST_OFF",
}  # fmt: skip


def _printed(done) -> Printed:
    out, noise = done.stdout.decode("utf-8", "replace"), done.stderr.decode("utf-8", "replace")
    machine = _PrintedMachine()
    for name, inner in re.findall(r"^ +\d+ +N\S+ +([A-Z_0-9]+)\((.*)\)$", out, re.M):
        machine.call(name, inner)
    said = [line for line in noise.splitlines() if line.strip() and line.strip() != "executing"]
    error = None
    if done.returncode:
        error = "\n".join(said) or f"exit status {done.returncode}"
    return Printed(machine.moves, error, 0.5e-4 * machine.coarsest)


class _PrintedMachine(Machine):
    def __init__(self):
        # a move to the same place looks like one where the unit changed, by the rounding of four inches or so
        super().__init__(blind=8 * 0.5e-4 * INCH)
        self.unit = self.coarsest = 1.0
        self.speed, self.sense, self.ended = 0.0, 0, False

    def numbers(self, inner):
        return np.array([float(v) for v in re.split(r"[ ,]+", inner.strip())])

    def call(self, name, inner):
        if name == "PROGRAM_END" or self.ended:
            self.ended = True
            return
        if name == "USE_LENGTH_UNITS":
            self.unit = INCH if inner == "CANON_UNITS_INCHES" else 1.0
            self.coarsest = max(self.coarsest, self.unit)
        elif name == "SELECT_PLANE":
            self.plane = inner.removeprefix("CANON_PLANE_")
        elif name == "SET_MOTION_CONTROL_MODE":
            mode, _, tolerance = inner.partition(",")
            told = {"CANON_EXACT_STOP": -1.0, "CANON_EXACT_PATH": 0.0}
            self.tolerance = told[mode] if mode in told else self.unit * float(tolerance) or np.inf
        elif name in _STOPS:
            self.sense = {"START_SPINDLE_CLOCKWISE": 1, "START_SPINDLE_COUNTERCLOCKWISE": -1}.get(
                name, 0 if name == "STOP_SPINDLE_TURNING" else self.sense
            )
            self.spindle = self.sense * self.speed
            self.add("stop")
        elif name == "SET_SPINDLE_SPEED":
            self.speed = self.numbers(inner)[1]
            self.spindle = self.sense * self.speed
        elif name in self._with_numbers:
            self._with_numbers[name](self, self.numbers(inner))

    def set_feed(self, word):
        self.feed_word, self.feed = word, self.unit * word

    def _lengths(self, n):
        return np.array([*(self.unit * n[:3]), *n[3:6]])

    def _arc(self, n):
        self.arc(*(self.unit * n[:4]), n[4], self.unit * n[5], n[6:9])

    _with_numbers = {
        "STRAIGHT_TRAVERSE": lambda m, n: m.straight("rapid", m._lengths(n)),
        "STRAIGHT_FEED": lambda m, n: m.straight("feed", m._lengths(n)),
        "ARC_FEED": lambda m, n: m._arc(n),
        "DWELL": lambda m, n: m.dwell(n[0]),
        "SET_FEED_RATE": lambda m, n: m.set_feed(n[0]),
        "SET_G5X_OFFSET": lambda m, n: setattr(m, "g5x", m._lengths(n[1:])),
        "SET_G92_OFFSET": lambda m, n: setattr(m, "g92", m._lengths(n)),
        "SET_XY_ROTATION": lambda m, n: m.turn(n[0]),
        "USE_TOOL_LENGTH_OFFSET": lambda m, n: m.change_tool_offset(m.unit * n[:3]),
    }
