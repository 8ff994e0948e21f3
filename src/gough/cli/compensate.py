"""gough compensate: an NC program again, its tool leaning against the force that a log of its run shows."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..cutting.compensation import command
from ..cutting.deflection import Leaning
from ..cutting.profile import profile_of, thinned
from ..cutting.rewrite import Changed, rewritten
from ..errors import ExperimentError, LogError
from ..files import write_atomic
from ..log import Log
from ..machine.sheet import load_machine
from ..observe.disturbance import DisturbanceObserver
from ..observe.recorded import Recorder
from ..program import load_program
from ..simulate.reach import check_motion
from ..units import to_si
from .end import Outcome

PERIOD = 1e-3  # s, at which the corrected path is looked at


class Asked(NamedTuple):
    """The options of the command, as texts with units."""

    height: str
    air: str | None
    least: str
    linear: str | None
    quadratic: str | None
    bandwidth: str
    fine: str


def compensate_file(
    part: Path, log_file: Path, machine_name: str | None, asked: Asked, out: Path | None, force: bool, quiet: bool,
    outcome: Outcome,
) -> None:  # fmt: skip
    """Write the corrected program, and say which lines changed.

    Raises
    ------
    InputError
        the log is not of this program, shows no force, or the program cannot be corrected; the file is there.
    RunError
        the corrected program leaves the machine's limits: line and amount.
    """
    out = out or part.with_name(f"{part.stem}-compensated{part.suffix}")
    if out.resolve() == part.resolve():
        raise ExperimentError(
            "would overwrite the original program", key="--out", value=str(out), cure="choose another name"
        )
    if out.exists() and not force:
        raise ExperimentError("there is a file already", file=str(out), cure="choose another name, or add --force")
    log = Log.load(log_file)
    if log.batch:
        raise LogError("holds several runs", file=str(log_file), cure="give the log of one")
    told = log.info.get("program") or {}
    machine = load_machine(machine_name or str(log.info.get("machine_name")))
    origin = told.get("origin")
    origin = origin["value"] if isinstance(origin, dict) else origin
    place = None if origin is None else np.array([to_si(x, u) if isinstance(x, str) else x for x, u in zip(
        origin, ["m"] * 3 + ["rad"] * 3, strict=True)], float)  # fmt: skip
    program = load_program(part, **({} if place is None else {"origin": place}))
    if told.get("text") not in (None, program.text):
        raise LogError(
            "is the log of another program", file=str(log_file), value=str(told.get("name"))[:60],
            cure=f"run {part.name} and give its log",
        )  # fmt: skip
    motion = program.plan(machine)
    height, law = to_si(asked.height, "m"), _law(asked)
    air = None if asked.air is None else _range(asked.air)
    try:
        found = profile_of(
            motion.path, log.t, log["s_r"], _forces(log, machine, asked), air=air, least=to_si(asked.least, "N")
        )
    except LogError as error:
        raise error.at(file=str(log_file)) from None
    tilt, _ = command(law, found.force, height)
    rows = thinned(found.s, tilt, to_si(asked.fine, "rad"))
    made = rewritten(program, found.s[rows], tilt[rows], height)
    check_motion(machine, made.program.plan(machine), PERIOD)
    write_atomic(out, made.program.text)
    outcome.data.update(
        file=str(out), log=str(log_file), machine=machine.name, air=found.air,
        lines=[{**change._asdict(), "force": float(_force_of(change, law))} for change in made.changes],
    )  # fmt: skip
    if not quiet:
        outcome.say(_table(made.changes, law), f"{out} is written: {_lines(len(made.changes))} of {part.name} changed")


def _lines(count: int) -> str:
    return "1 line" if count == 1 else f"{count} lines"


def _law(asked: Asked) -> Leaning:
    given = {}
    if asked.linear is not None:
        given["linear"] = to_si(asked.linear, "rad/N")
    if asked.quadratic is not None:
        given["quadratic"] = to_si(asked.quadratic, "rad/N2")
    return Leaning(**given)


def _range(text: str) -> tuple[float, float]:
    first, dots, last = text.partition("..")
    if not dots:
        first, last = "0 mm", text
    low, high = to_si(first.strip(), "m"), to_si(last.strip(), "m")
    if not 0 <= low < high:
        raise ExperimentError(
            "must go from a place to one behind it", key="--air", value=text, cure='write "5 mm..30 mm"'
        )
    return low, high


def _forces(log: Log, machine, asked: Asked) -> np.ndarray:
    """The force on the tool: the log's own estimate, or one made of its readings and forces.  (n, 3) N."""
    if "wrench_hat" in log:
        return log["wrench_hat"][:, :3]
    for name in ("q_m", "u", "x_r"):
        if name not in log:
            raise LogError(
                "has neither wrench_hat nor what it is made of", key=name, cure="log q_m and u, or an observer"
            )
    steps = np.diff(log.t)
    if np.ptp(steps) > 1e-6 * steps.mean():
        raise LogError("rows must come at one period", key="t")
    observer = DisturbanceObserver(bandwidth=to_si(asked.bandwidth, "Hz")).on(machine, float(steps.mean()))
    u = log["u"]
    before = np.concatenate([u[:1], u[:-1]])
    return Recorder(observer, log["x_r"][0]).rows(log["q_m"], before)["wrench_hat"][:, :3]


def _force_of(change: Changed, law: Leaning) -> float:
    """The normal force whose tilt is that of a line."""
    size = abs(change.tilt)
    if law.quadratic == 0:
        force = size / law.linear
    else:
        force = (-law.linear + np.sqrt(law.linear**2 + 4 * law.quadratic * size)) / (2 * law.quadratic)
    return float(np.copysign(force, change.tilt))


def _table(changes: list[Changed], law: Leaning) -> str:
    rows = [f"{'line':>6}  {'force':>8}  {'tilt':>10}  {'shift':>9}  moves  was"]
    for change in changes:
        rows.append(
            f"{change.line:>6}  {_force_of(change, law):>6.1f} N  {np.degrees(change.tilt):>6.3f} deg  "
            f"{1e6 * change.shift:>6.1f} um  {len(change.now):>5}  {change.was[:40]}"
        )
    return "\n".join(rows)
