"""gough compensate: an NC program again, its tool leaning against the force that a log of its run shows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..cutting.compensation import command
from ..cutting.deflection import Leaning
from ..cutting.giving import Giving
from ..cutting.profile import Profile, profile_of, thinned
from ..cutting.rewrite import Changed, rewritten
from ..errors import ExperimentError, LogError, UnitError
from ..files import write_atomic
from ..log import Log
from ..log.outside import load_map
from ..log.outside.whole import load as load_record
from ..machine.sheet import load_machine
from ..monitor.along import felt
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
    flexible: bool


def compensate_file(
    part: Path, log_file: Path, machine_name: str | None, map_file: Path | None, asked: Asked, out: Path | None,
    force: bool, quiet: bool, outcome: Outcome,
) -> None:  # fmt: skip
    """Write the corrected program, and say which lines changed.

    Raises
    ------
    InputError
        the log is not of this program, shows no force, or the program cannot be corrected; the file is there; the
        machine has nothing that gives way.
    RunError
        the corrected program leaves the machine's limits: line and amount.
    """
    out = out or part.with_name(f"{part.stem}-compensated{part.suffix}")
    for what, file in (("original program", part), ("log", log_file), ("map", map_file)):
        if file is not None and _same(out, file):
            raise ExperimentError(
                f"would overwrite the {what}", key="--out", value=str(out), cure="choose another name"
            )
    if out.exists() and not force:
        raise ExperimentError("there is a file already", file=str(out), cure="choose another name, or add --force")
    height, least = _above("--height", asked.height, "m"), _above("--least", asked.least, "N")
    bandwidth, fine = _above("--bandwidth", asked.bandwidth, "Hz"), _above("--fine", asked.fine, "rad")
    law, air = _law(asked), None if asked.air is None else _range(asked.air)
    log, machine = _read(log_file, machine_name, map_file)
    program = _program(part, log, log_file)
    flexible = None
    if asked.flexible:
        try:
            flexible = machine.flexible()
        except ExperimentError as error:
            raise ExperimentError(problems=[replace(one, key="--flexible") for one in error.problems]) from None
    motion = program.plan(machine)
    try:
        rows = felt(log, machine, motion.path, bandwidth)
        found = profile_of(motion.path, *rows, air=air, least=least)
    except LogError as error:
        raise error.at(file=str(log_file)) from None
    tilt, shift = command(law, found.force, height)
    told = {}
    if flexible is not None:
        moved, turned = _given(flexible, motion.path, found, height)
        tilt, shift = tilt - turned, shift + moved
        told = {"gives": float(np.abs(moved).max()), "turns": float(np.abs(turned).max())}
    kept = np.union1d(thinned(found.s, tilt, fine), thinned(found.s, shift, fine * height))
    made = rewritten(program, found.s[kept], tilt[kept], height, shift[kept])
    check_motion(machine, made.program.plan(machine), PERIOD)
    write_atomic(out, made.program.text)
    outcome.data.update(
        file=str(out), log=str(log_file), machine=machine.name, air=found.air, **told,
        lines=[{**change._asdict(), "force": _force_of(change, found)} for change in made.changes],
    )  # fmt: skip
    if not quiet:
        more = [] if flexible is None else [
            f"of it {machine.name} gives way by {1e6 * told['gives']:.1f} um at the tip and "
            f"{np.degrees(told['turns']):.4f} deg at most"
        ]  # fmt: skip
        outcome.say(
            _table(made.changes, found), *more,
            f"{out} is written: {_lines(len(made.changes))} of {part.name} changed",
        )  # fmt: skip


def _read(log_file: Path, machine_name: str | None, map_file: Path | None):
    """The log, gough's own or recorded, and the machine."""
    machine = None if machine_name is None else load_machine(machine_name)
    if map_file is None and log_file.suffix.lower() == ".nc" and getattr(machine, "record", None) is None:
        log = Log.load(log_file)
        if log.batch:
            raise LogError("holds several runs", file=str(log_file), cure="give the log of one")
        return log, machine or load_machine(str(log.info.get("machine_name")))
    if machine is None:
        raise ExperimentError(
            "is missing: a recorded log does not say which", key="--machine", cure="gough machines lists the library"
        )
    return load_record(log_file, machine, None if map_file is None else load_map(map_file)), machine


def _program(part: Path, log: Log, log_file: Path):
    """The program, its zero where the log has it.  LogError where the log is of another one."""
    told = log.info.get("program") or {}
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
    return program


def _given(flexible, path, found: Profile, height: float) -> tuple[np.ndarray, np.ndarray]:
    """delta_m and psi of cutting/giving.py along a profile, 0 where nothing is cut.  (n,) m, (n,) rad."""
    on = np.flatnonzero(found.force)
    moved, turned = np.zeros(len(found.s)), np.zeros(len(found.s))
    last = max(found.s[on[-1]], found.s[on[0]] + 1e-6)
    forces = np.concatenate([found.vector, np.zeros((len(found.s), 1))], 1)[on]
    moved[on], turned[on] = Giving(flexible, path, found.s[on[0]], last).under(found.s[on], forces, height)
    return moved, turned


def _lines(count: int) -> str:
    return "1 line" if count == 1 else f"{count} lines"


def _law(asked: Asked) -> Leaning:
    given = {}
    for name, text, unit in (("linear", asked.linear, "rad/N"), ("quadratic", asked.quadratic, "rad/N2")):
        if text is not None:
            given[name] = _number(f"--{name}", text, unit)
            if given[name] < 0:
                raise ExperimentError(f"must be at least 0 {unit}", key=f"--{name}", value=text)
    return Leaning(**given)


def _number(option: str, text: str, unit: str) -> float:
    """SI value of an option; its name is in the error."""
    try:
        return to_si(text, unit)
    except UnitError as error:
        raise error.at(key=option) from None


def _above(option: str, text: str, unit: str) -> float:
    """SI value of an option that must be above 0."""
    value = _number(option, text, unit)
    if not value > 0:
        raise ExperimentError(f"must be above 0 {unit}", key=option, value=text)
    return value


def _same(one: Path, other: Path) -> bool:
    """Whether two names are of one file, by another spelling or a link."""
    return one.resolve() == other.resolve() or (one.exists() and other.exists() and one.samefile(other))


def _range(text: str) -> tuple[float, float]:
    first, dots, last = text.partition("..")
    if not dots:
        first, last = "0 mm", text
    low, high = (_number("--air", one.strip(), "m") for one in (first, last))
    if not 0 <= low < high:
        raise ExperimentError(
            "must go from a place to one behind it", key="--air", value=text, cure='write "5 mm..30 mm"'
        )
    return low, high


def _force_of(change: Changed, found: Profile) -> float:
    """The greatest normal force along a line that was, N."""
    on = found.force[(found.s >= change.first) & (found.s <= change.last)]
    return float(on[np.argmax(np.abs(on))]) if len(on) else 0.0


def _table(changes: list[Changed], found: Profile) -> str:
    rows = [f"{'line':>6}  {'force':>8}  {'tilt':>10}  {'shift':>9}  moves  was"]
    for change in changes:
        rows.append(
            f"{change.line:>6}  {_force_of(change, found):>6.1f} N  {np.degrees(change.tilt):>6.3f} deg  "
            f"{1e6 * change.shift:>6.1f} um  {len(change.now):>5}  {change.was[:40]}"
        )
    return "\n".join(rows)
