"""record(part, machine): an NC program run by LinuxCNC itself, and every command of it at full precision.

a private folder: exported machine, compiled modules, program, clock
LinuxCNC in namespaces of its own (sandbox.py): on, homed, program, idle (session.py), samplers (channels.py)
Recording: the rows of the program, in m and rad
"""

from __future__ import annotations

import json
import re
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import ExperimentError, Problem, ProgramError, RunError
from ..export.linuxcnc import PERIOD, files_of
from ..export.linuxcnc.core import identifier
from ..program.nc import NCProgram
from . import sandbox
from .channels import channels_of, hal_of, rows_of, types_of

SPEED, SECONDS = 10, 600.0  # times real time; s of real time for one program
_LINE = re.compile(r"(?:[Nn]ear line|on line|at line|line) (\d+)")
_ROTARY = np.pi / 180


@dataclass(frozen=True, eq=False)
class Recording:
    """What LinuxCNC commanded, one row each servo period from the release of the program to its end, SI.

    axis   (N, d) the planner's pose, in the program's frame: m, rad      joint  (N, n) commands of the joints, m
    rows   everything recorded, from LinuxCNC's start on, in LinuxCNC's units; `first` is the row where `axis` begins
    """

    period: float
    axis: np.ndarray
    joint: np.ndarray
    joint_rate: np.ndarray
    joint_acceleration: np.ndarray
    line: np.ndarray
    rows: dict[str, np.ndarray]
    first: int
    said: tuple[str, ...]
    version: str = sandbox.VERSION

    @property
    def duration(self) -> float:
        """s of motion."""
        return (len(self.axis) - 1) * self.period


def record(
    program: NCProgram,
    machine,
    *,
    name: str | None = None,
    period: float = PERIOD,
    speed: int = SPEED,
    timeout: float = SECONDS,
    keep: Path | None = None,
    **options,
) -> Recording:
    """Run an NC program in LinuxCNC on `machine` and record it.

    speed      how many times faster than real time LinuxCNC's clock runs, 1 ... 50
    timeout    s of real time after which it is ended
    keep       a folder for the exported files, the configuration and LinuxCNC's log
    options    those of `gough.export.linuxcnc.files_of`

    Raises
    ------
    ExperimentError
        LinuxCNC is not here, or of another version; the machine cannot be exported.
    ProgramError
        LinuxCNC refused the program: what it said, with the line.
    RunError
        the modules do not compile, LinuxCNC does not start or end, or its recorder lost rows.
    """
    sandbox.check()
    if not 1 <= speed <= 50:
        raise ExperimentError("LinuxCNC's clock runs 1 to 50 times as fast", key="--speed", value=str(speed))
    if not 1 <= timeout <= 86400:
        raise ExperimentError("must be between 1 s and a day", key="--timeout", value=f"{timeout:g} s")
    _check_options(program)
    word = identifier(machine, name)
    files = files_of(machine, word, period=period, **options)
    channels = channels_of(machine, word)
    folder = Path(tempfile.mkdtemp(prefix="gough-linuxcnc-"))
    try:
        for file, text in files.items():
            (folder / file).write_text(text)
        sandbox.compile_modules(folder)
        sandbox.compile_clock(folder)
        part = _part(folder, program)
        (folder / "record.hal").write_text(hal_of(channels))
        (folder / f"{word}.ini").write_text(_headless(files[f"{word}.ini"], word))
        (folder / "display.sh").write_text(
            f"#!/bin/sh\nexec /usr/bin/python3 /mnt/session.py {part} {','.join(map(types_of, channels))} {timeout:g}"
            f" {int(program.block_delete)}\n"
        )
        (folder / "display.sh").chmod(0o755)
        (folder / f"{word}.tbl").write_text("".join(f"T{k} P{k} D0 Z0\n" for k in range(1, 100)))
        sandbox.prepare(folder)
        sandbox.run_inside(folder, f"{word}.ini", speed, timeout + 30)
        said = _outcome(folder, program)
        rows = _rows(folder, channels)
    finally:
        if keep is not None:
            _keep(folder, keep, files)
        shutil.rmtree(folder, ignore_errors=True)
    return _recording(rows, period, len(machine.task), said)


def _check_options(program: NCProgram) -> None:
    """Refuse options that LinuxCNC would not know of: it would run another path than the one that is measured."""
    problems = [
        Problem("LinuxCNC is run without this option of a program", key=f"program.{key}", cure=cure)
        for key, given, cure in (
            ("origin", program.origin is not None, "move home in the data sheet"),
            ("tools", program.tools is not None, "leave the tools out: all have the length of the data sheet's"),
            ("parameters", bool(program.parameters), "set them in the program"),
        )
        if given
    ]
    if problems:
        raise ExperimentError(problems=problems)


def _part(folder: Path, program: NCProgram) -> str:
    """The program and what it calls, in the run's folder; its path as LinuxCNC sees it."""
    place = folder / "nc"
    place.mkdir()
    (place / "part.ngc").write_text(program.text)
    for called, text in program.subroutines.items():
        (place / Path(called).name).with_suffix(".ngc").write_text(text)
    return "/mnt/nc/part.ngc"


def _headless(ini: str, word: str) -> str:
    """The configuration with our session in place of a screen, and the samplers."""
    ini = re.sub(r"(?m)^DISPLAY = .*$", "DISPLAY = ./display.sh", ini)
    ini = ini.replace(f"HALFILE = {word}.hal", f"HALFILE = {word}.hal\nHALFILE = record.hal")
    return ini.replace("[RS274NGC]", "[RS274NGC]\nSUBROUTINE_PATH = /mnt/nc")


def _outcome(folder: Path, program: NCProgram) -> tuple[str, ...]:
    """What LinuxCNC said along the way; its refusal as an error."""
    result = folder / "result.json"
    if not result.exists():
        raise RunError("LinuxCNC did not start", value=sandbox.tail(folder / "linuxcnc.log"))
    found = json.loads(result.read_text())
    if found["status"] == "done":
        return tuple(message["text"] for message in found["said"])
    problems = []
    for message in found["said"]:
        if not message["error"]:
            continue
        text = " ".join(message["text"].replace("/mnt/nc/part.ngc", program.name).split())
        if text == "timeout":
            raise RunError("LinuxCNC did not end the program in time", cure="give a longer --timeout")
        line = _LINE.search(text)
        number = int(line[1]) if line else message["line"] or None
        cure = "gough check says which limit" if "kinematicsInverse" in text else None
        problems.append(Problem(f"LinuxCNC refuses it: {text}", file=program.name, line=number, cure=cure))
    if not problems:
        raise RunError("LinuxCNC ended without a word", value=sandbox.tail(folder / "linuxcnc.log"))
    # what follows from another refusal says nothing
    said = [problem for problem in problems if "invalid params" not in problem.rule]
    raise ProgramError(problems=said or problems)


def _rows(folder: Path, channels) -> dict[str, np.ndarray]:
    raw = []
    for k, channel in enumerate(channels):
        file = folder / f"channel-{k}.bin"
        data = np.fromfile(file) if file.exists() else np.zeros(0)
        lost = json.loads((folder / f"channel-{k}.json").read_text())["overruns"] if file.exists() else 0
        rows = data.reshape(-1, 1 + len(channel))
        if len(rows) < 2 or lost or (np.diff(rows[:, 0]) != 1).any():
            raise RunError(
                "LinuxCNC's samples were not read fast enough", value=f"{lost} lost", cure="give a smaller --speed"
            )
        raw.append(rows)
    return rows_of(channels, raw)


def _recording(rows: dict[str, np.ndarray], period: float, d: int, said) -> Recording:
    """The rows of the program: from the last at rest behind the release on; SI.

    Whether the release is seen in the servo period that sampled it, or in the next, is chance: what stands before the
    first move is left out, a dwell too.
    """
    held = np.flatnonzero(rows["inhibit"] != 0)
    first = int(held[-1]) + 1 if len(held) else 0
    if first >= len(rows["inhibit"]) - 2:
        raise RunError("LinuxCNC did not run the program: nothing was released")
    begun = np.flatnonzero((np.diff(rows["axis"][max(first - 1, 0) :], axis=0) != 0).any(1))
    first = max(first - 1, 0) + int(begun[0]) if len(begun) else first
    # up to where the joints stand for good: how long LinuxCNC idles behind that is chance
    moving = np.flatnonzero((rows["joint"] != rows["joint"][-1]).any(1))
    stop = max(int(moving[-1]) + 2 if len(moving) else 0, first + 4)
    scale = np.array([1e-3] * 3 + [_ROTARY] * 3)[:d]
    part = slice(first, stop)
    return Recording(
        period, rows["axis"][part] * scale, rows["joint"][part] * 1e-3, rows["joint_rate"][part] * 1e-3,
        rows["joint_acceleration"][part] * 1e-3, rows["line"][part].astype(int), rows, first, said,
    )  # fmt: skip


def _keep(folder: Path, target: Path, files: dict[str, str]) -> None:
    """Copies of what was exported, run and said."""
    target.mkdir(parents=True, exist_ok=True)
    more = ("record.hal", "display.sh", "linuxcnc.log", "result.json")
    for name in [*files, *more]:
        if (folder / name).exists():
            shutil.copyfile(folder / name, target / name)
