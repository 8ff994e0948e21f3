"""Random damage to recorded logs: the numbers that were written, with what was found told, or a LogError; soon.

python -m tests.outside.fuzz COUNT SEED [ONLY]      status 0: nothing found; ONLY: this case alone, with its story

Every case: what `Record` gives is what the record says at that time, or is marked as not good; nothing is not finite;
no error but LogError, in one line that names the file.  One case in MONITORED goes through `gough identify` and
`gough monitor` too: status 0 or 2, no traceback, and no force where none acts.  Cases run in a child, so that neither a
crash of a library nor a hang goes unseen.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import re
import select
import signal
import sys
import tempfile
import time
import traceback
from pathlib import Path

import numpy as np

import gough as gk
from gough.errors import GoughError, LogError
from gough.log.outside import Record, load_map
from gough.log.outside.whole import load
from gough.machine.sheet import find

from .conftest import MAP, circle, csv_text
from .damage import PERIOD, Made, made, written

SECONDS = 10.0  # of a case; most take some milliseconds
MEGABYTES = 600
ROWS = 260
MONITORED = 8
FEW = 200  # cases: fewer are read only, without the commands, to be quick
LONGEST = 400  # characters of a message
ACCEPTED, REFUSED = "accepted", "refused"


class World:
    """What all cases share: the machine, and its record without a wound."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.machine = gk.load_machine("okuma-pm600").frictionless()
        self.sheet = folder / "machine.toml"
        self.truth = circle(self.machine, ROWS)
        self.table = self.truth.table
        self.limit = self.machine.limits.speed * PERIOD


def trouble(world: World, one: Made, monitored: bool) -> str:
    """What is wrong with how a record is read; ACCEPTED or REFUSED if nothing is."""
    path, told = written(world.folder, one)
    try:
        record = Record(path, world.machine, load_map(told))
        parts = list(record.parts())
    except LogError as error:
        return _told_badly(error) or REFUSED
    except BaseException as error:
        return f"{error!r}\n{traceback.format_exc()[-1500:]}"
    wrong = _misread(world, one, record, parts)
    if wrong:
        return wrong
    try:
        log = load(path, world.machine, load_map(told))
        if not (np.isfinite(log["q_m"]).all() and np.isfinite(log["u"]).all() and (np.diff(log.t) > 0).all()):
            return "a whole log with numbers that are not finite, or time that does not rise"
    except LogError as error:
        return _told_badly(error) or REFUSED
    except BaseException as error:
        return f"load: {error!r}\n{traceback.format_exc()[-1500:]}"
    if monitored:
        return _monitored(world, one, path, told) or ACCEPTED
    return ACCEPTED


def _told_badly(error: GoughError) -> str | None:
    """A problem names its file, in one line of a length that one can read."""
    for text in map(str, error.problems):
        if len(text) > LONGEST or not text.isprintable() or not ("log." in text or "map.toml" in text):
            return f"told badly: {text[:600]!r}"
    return None


def _misread(world: World, one: Made, record: Record, parts) -> str | None:
    """A good sample that is not what the record says; a number that is not finite; a jump nobody is told of."""
    t, q, u, good = (np.concatenate([getattr(part, k) for part in parts]) for k in ("t", "q", "u", "good"))
    if not np.isfinite(t).all() or not np.isfinite(q[good]).all() or not np.isfinite(u[good]).all():
        return "a good sample that is not finite"
    if len(t) > 100 * ROWS:
        return f"{len(t)} samples of {ROWS} rows"
    step = np.abs(np.diff(q, axis=0)).max(1)
    step[np.cumsum([len(part.t) for part in parts])[:-1] - 1] = 0  # what begins anew may begin anywhere
    if (step[good[1:] & good[:-1]] > 1.001 * world.limit).any() and not {"jump", "counter"} & set(
        record.findings.counts
    ):
        return "a reading that no joint can have, and nobody is told"
    if one.expected is None:
        return None
    rows = np.rint((t - one.expected[0, 0]) / PERIOD).astype(int)
    if rows.min() < 0 or rows.max() >= ROWS:
        return "samples at times that the record does not have"
    told, before = one.expected[rows], one.expected[np.maximum(rows - 1, 0)]
    off = np.abs(q * 1e3 - told[:, 1:7]) > 1e-9 * np.maximum(1, np.abs(told[:, 1:7])), u != before[:, 7:]
    for name, wrong in zip(("reading", "force"), off, strict=True):
        if wrong[good].any():
            row = np.flatnonzero(good & wrong.any(1))[0]
            return f"a {name} at t = {t[row]:.4f} s that the record does not have"
    return None


def _monitored(world: World, one: Made, path: Path, told: Path) -> str | None:
    """Both commands on the same files: how they end, and the force that the monitor sees."""
    files = [path, "-m", world.sheet, "--map", told, "--json"]
    status, out, err = _gough("identify", *files, "--cutoff", "100 Hz", "--free", "platform.m", "--friction", "none")
    if "Traceback" in err or status not in (0, 2) or str(world.sheet) in out:
        return f"gough identify: status {status}, {(out + err)[-1500:]}"
    status, out, err = _gough("monitor", *files, "-o", world.folder / "out", "--force")
    if "Traceback" in err or status not in (0, 2):
        return f"gough monitor: status {status}, {err[-1500:]}"
    if status == 2:
        return None
    data = json.loads(out)
    sums = data["components"]
    if not all(np.isfinite(list(part.values())).all() for part in sums.values()):
        return "gough monitor: numbers that are not finite"
    # readings and forces are exact here, so what is as large as the noise of the encoders' steps is no noise
    most = np.linalg.norm([sums[name]["noise"] for name in ("fx", "fy", "fz")])
    if one.forceless and data["peak"]["force"] > most:
        return f"gough monitor: {data['peak']['force']:.0f} N where none acts (limit {most:.0f} N)"
    return None


def _gough(*words) -> tuple[int, str, str]:
    """Status, stdout and stderr of a command in this process."""
    from gough.cli import main

    out, err = io.TextIOWrapper(io.BytesIO()), io.TextIOWrapper(io.BytesIO())
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            main([str(word) for word in words])
        status = 0
    except SystemExit as end:
        status = end.code or 0
    for stream in (out, err):
        stream.flush()
    return status, *(stream.buffer.getvalue().decode() for stream in (out, err))


def child(seed: int, cases: range, pipe: int, commands: bool) -> None:
    """Runs cases, with the `commands` or without; says each before it begins, and what came of it."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        world = World(folder)
        _sheet(world)
        if commands:  # what is compiled and imported once is no part of a case
            sound = Made("log.csv", csv_text(world.table).encode(), MAP, None, True, "")
            assert trouble(world, sound, True) == ACCEPTED
        for case in cases:
            os.write(pipe, f"{case} begins\n".encode())
            rng = np.random.default_rng([seed, case])
            one = made(rng, world.table)
            told = trouble(world, one, commands and case % MONITORED == 0)
            text = told if told in (ACCEPTED, REFUSED) else f"{told}  [{one.story}]"
            os.write(pipe, f"{case} {json.dumps(text)}\n".encode())
        os.write(pipe, f"memory {_memory():.0f}\n".encode())


def _sheet(world: World) -> None:
    """The machine of the library's sheet without its friction, as a sheet."""
    text = find("okuma-pm600").read_text()
    text = re.sub(r"\[friction\][^\[]*", "", text)
    world.sheet.write_text(re.sub(r'"friction\.[^\n]*\n', "", text))
    assert gk.load_machine(world.sheet).theta.tolist() == world.machine.theta.tolist()


def _memory() -> float:
    """The most memory this process has had, MB."""
    with open("/proc/self/status", encoding="ascii") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmHWM")) / 1024


def watched(seed: int, cases: range, commands: bool) -> tuple[dict[int, str], float]:
    """What came of cases, run in children: a child that crashes or hangs is ended, and the next goes on behind it."""
    found: dict[int, str] = {}
    memory, left = 0.0, cases
    while len(left):
        read, write = os.pipe()
        pid = os.fork()
        if pid == 0:
            os.close(read)
            status = 1
            try:
                child(seed, left, write, commands)
                status = 0
            except BaseException:
                traceback.print_exc()
            finally:
                os._exit(status)
        os.close(write)
        last, text, ended = None, "", None
        while True:
            if not select.select([read], [], [], SECONDS + (60 if last is None else 0))[0]:
                ended = f"longer than {SECONDS} s"
                os.kill(pid, signal.SIGKILL)
                break
            piece = os.read(read, 1 << 16).decode()
            if not piece:
                break
            *lines, text = (text + piece).split("\n")
            for line in lines:
                case, _, told = line.partition(" ")
                if case == "memory":
                    memory = max(memory, float(told))
                elif told == "begins":
                    last = int(case)
                else:
                    found[int(case)] = json.loads(told)
        os.close(read)
        _, status = os.waitpid(pid, 0)
        if last is None:
            raise RuntimeError("no case began")
        if last not in found:
            found[last] = ended or f"the process ended with {os.waitstatus_to_exitcode(status)}"
        elif status and not ended:
            raise RuntimeError(f"the child ended with {status} behind case {last}")
        left = left[left.index(last) + 1 :]
    return found, memory


def main(count: int, seed: int, only: int | None = None) -> int:
    """Runs the cases; prints what was found, and how to repeat it."""
    began = time.perf_counter()
    found, memory = watched(seed, range(count) if only is None else range(only, only + 1), count >= FEW)
    bad = {case: text for case, text in found.items() if text not in (ACCEPTED, REFUSED)}
    for case, text in bad.items():
        print(f"case {case}: {text}\n    repeat: python -m tests.outside.fuzz {count} {seed} {case}")
    accepted = sum(text == ACCEPTED for text in found.values())
    troubles = len(bad)
    if count >= FEW and only is None and not 0.1 < accepted / count < 0.7:
        troubles += 1
        print("the damage is too great, or too small, to find anything")
    if memory > MEGABYTES:
        troubles += 1
        print(f"{memory:.0f} MB of memory, at most {MEGABYTES}")
    seconds = time.perf_counter() - began
    print(f"{count} logs, {accepted} accepted, {troubles} troubles, {memory:.0f} MB, {seconds:.1f} s")
    return min(troubles, 1)


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
