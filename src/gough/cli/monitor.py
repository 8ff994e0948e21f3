"""gough monitor: the force on the tool out of a recorded log."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import NamedTuple

from ..errors import ExperimentError, InputError
from ..files import write_atomic
from ..log.outside import load_map
from ..log.outside.text_rows import Patience
from ..machine.sheet import load_machine
from ..monitor import monitor
from ..monitor.events import Event
from ..monitor.figure import save
from ..names import slug
from ..observe.disturbance import DisturbanceObserver
from ..results import results_folder
from ..units import show, to_si
from .end import Outcome, plain

_PAUSE = 1.0  # s between two lines of progress on a terminal


class Asked(NamedTuple):
    """The options of the command, as texts with units."""

    bandwidth: str
    form: str
    alarm: str | None
    collision: str | None
    breakage: str | None
    until: str | None  # with --follow


def monitor_file(
    log: Path, machine_name: str | None, map_file: Path | None, asked: Asked, out: Path | None, force: bool,
    quiet: bool, outcome: Outcome,
) -> None:  # fmt: skip
    """Monitor a log; write figure, rows and numbers into a results folder, and the table to stdout."""
    if machine_name is None:
        raise ExperimentError("is missing", key="--machine", cure="say which machine: gough machines lists the library")
    machine = load_machine(machine_name)
    mapping = None if map_file is None else load_map(map_file)
    if asked.form not in ("momentum", "static"):
        raise ExperimentError("there is momentum and static", key="--form", value=repr(asked.form))
    observer = DisturbanceObserver(bandwidth=_number("--bandwidth", asked.bandwidth, "Hz"), form=asked.form)
    levels = {
        name: None if getattr(asked, name) is None else _number(f"--{name}", getattr(asked, name), "N")
        for name in ("alarm", "collision", "breakage")
    }
    wait = None if asked.until is None else Patience(_number("--until", asked.until, "s"))
    shown = _Shown(quiet or outcome.as_json)
    target = out or Path("results") / slug(f"{log.stem}-force")
    with results_folder(target, force) as folder:
        try:
            watch = monitor(
                log, machine, mapping, observer, **levels, wait=wait,
                tell=shown.event if wait is not None else None, progress=shown.progress,
            )  # fmt: skip
        finally:
            shown.end()
        watch.to_log().save(folder / "force.nc")
        save(watch, folder / "force.png")
        write_atomic(folder / "monitor.json", json.dumps(plain(watch.to_json()), indent=1))
    outcome.data.update(log=str(log), **watch.to_json())
    outcome.data["files"] = [str(target / name) for name in ("force.nc", "force.png", "monitor.json")]
    if not quiet:
        outcome.say(repr(watch))
    if not outcome.as_json:
        outcome.say(f"figure: {target / 'force.png'}")


def _number(key: str, text: str, unit: str) -> float:
    """An option as a number above 0, SI."""
    try:
        value = to_si(text, unit)
    except InputError as error:
        raise error.at(key=key) from None
    if not value > 0:
        raise ExperimentError(f"must be above 0 {unit}", key=key, value=repr(text))
    return value


class _Shown:
    """What is seen while it runs: on a terminal how far it is; events of a file that is followed, as they come."""

    def __init__(self, quiet: bool):
        self.quiet, self.last, self.shown = quiet, time.monotonic(), False

    def progress(self, t: float) -> None:
        """Samples until t s have been seen."""
        now = time.monotonic()
        if self.quiet or not sys.stderr.isatty() or now - self.last < _PAUSE:
            return
        self.last, self.shown = now, True
        print(f"\r{t:12.3f} s of the log", end="", file=sys.stderr, flush=True)

    def event(self, event: Event) -> None:
        """An event was found."""
        if not self.quiet:
            self.end()
            print(f"{event.kind}  t = {event.start:.6g} s  {show(event.peak, 'N')}", flush=True)

    def end(self) -> None:
        """Leave the line of progress."""
        if self.shown:
            print(file=sys.stderr, flush=True)
            self.shown = False
