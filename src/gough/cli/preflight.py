"""gough preflight: what a program asks of a machine, before metal is cut."""

from __future__ import annotations

import contextlib
import csv
import io
import json
import sys
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import ExperimentError, WorkspaceError
from ..experiment import SUFFIXES, load_experiment, nc_file
from ..files import write_atomic
from ..machine import sheet
from ..plan import Preflight, fix_feed, place, preflight
from ..plan.loop import Loop, closed_loop
from ..plan.preflight import CARTESIAN, JOINTS
from ..program.nc import NCProgram
from ..results import results_folder
from .end import Outcome, plain
from .progress import preparing


class Asked(NamedTuple):
    """The options of the command line, as they were written."""

    planner: str = CARTESIAN
    fix: Path | None = None
    place: bool = False
    turn: bool = False
    out: Path | None = None
    force: bool = False
    seed: int = 0
    loop: bool = False


def preflight_file(file: Path, machine: str | None, asked: Asked, quiet: bool, outcome: Outcome) -> None:
    """Judge the program of a file; the status is "failed" where the machine cannot follow it.

    Raises
    ------
    InputError
        with every mistake of what was given.
    WorkspaceError
        no feed or no place helps.
    """
    if asked.planner not in (CARTESIAN, JOINTS):
        raise ExperimentError(
            "no such planner", key="--planner", value=asked.planner[:40], cure=f"write {CARTESIAN} or {JOINTS}"
        )
    if asked.turn and not asked.place:
        raise ExperimentError("is for --place", key="--turn", cure="add --place")
    if asked.planner == JOINTS and (asked.fix or asked.place):
        cure = "leave --planner out: with the joints' limits in the planner no F needs to change"
        raise ExperimentError("is for the cartesian planner", key="--fix-feed" if asked.fix else "--place", cure=cure)
    if asked.loop and (asked.fix or asked.place):
        cure = "write the program first, then give an experiment that runs it"
        raise ExperimentError("is for a program as it is", key="--loop", cure=cure)
    known, program, path, plant = loaded(file, machine)
    if asked.loop and path.suffix.lower() != ".toml":
        cure = "give an experiment (.toml) with [[controller]] and the period of [run]"
        raise ExperimentError("needs a law and its sample time", key="--loop", cure=cure)
    if asked.fix is not None:
        _check_target(asked.fix, path, program, asked.force)
    # a folder that cannot be is refused before anything is written
    with contextlib.nullcontext() if asked.out is None else results_folder(asked.out, asked.force) as folder:
        found = _found(known, program, plant, asked, path, quiet or outcome.as_json, outcome)
        outcome.data.update(found.to_json())
        loops = _driven(found, path, machine, quiet or outcome.as_json) if asked.loop else []
        if asked.loop:
            outcome.data["loops"] = [loop.to_json() for loop in loops]
            outcome.data["passed"] = found.passed and all(loop.passed for loop in loops)
        if folder is not None:
            told = found.to_json() | {key: outcome.data[key] for key in ("passed", "loops") if key in outcome.data}
            write_atomic(folder / "preflight.json", json.dumps(plain(told), indent=1) + "\n")
            write_atomic(folder / "lines.csv", table(found))
            from ..report.preflight import preflight_figure

            figure = preflight_figure(found)
            write_atomic(folder / "preflight.png", lambda path: figure.savefig(path, dpi=130, format="png"))
            outcome.data["folder"] = str(asked.out)
    if not quiet and not outcome.as_json:
        outcome.say(found, *loops)
    problems = [p for loop in loops for p in loop.problems(found.name)]
    if not found.passed or problems:
        problems = [finding.problem(found.name) for finding in found.findings] + problems
        outcome.data.update(status="failed", error=WorkspaceError(problems=problems).to_json())
        if quiet:
            count = found.exceeded + sum(len(loop.hits) for loop in loops)
            print(f"{path.name}: {count} limit{'s' * (count != 1)} exceeded", file=sys.stderr)


def _found(known, program, plant, asked: Asked, path: Path, quiet: bool, outcome: Outcome) -> Preflight:
    """The verdict on the program: as it is, or at the best place, or with feeds that the joints can follow."""
    if asked.place:
        program = _placed(known, program, plant, asked, path, quiet, outcome)
    if asked.fix is not None:
        return _fixed(known, program, plant, asked.fix, path, quiet, outcome)
    with preparing(path.name, quiet):
        return preflight(known, program, asked.planner, plant=plant)


def _driven(found: Preflight, path: Path, machine: str | None, quiet: bool) -> list[Loop]:
    """The program under each law of the experiment."""
    experiment = load_experiment(path, machine)
    with preparing(path.name, quiet):
        return closed_loop(experiment, found)


def _check_target(target: Path, path: Path, program: Any, force: bool) -> None:
    """Refuse to write over the original, or over another file without `force`."""
    if not isinstance(program, NCProgram):
        raise ExperimentError("only an NC program has feed words", key="--fix-feed", cure="give a .ngc file")
    same = target.resolve() == path.resolve() or (target.exists() and target.samefile(path))
    if path.suffix.lower() == ".toml":  # the program stands beside it
        original = path.parent / program.name
        same = same or (target.exists() and original.exists() and target.samefile(original))
    if same:
        raise ExperimentError(
            "would overwrite the original program", key="--fix-feed", value=str(target), cure="choose another name"
        )
    if target.exists() and not force:
        cure = "choose another name, or add --force"
        raise ExperimentError("there is a file already", key="--fix-feed", file=str(target), cure=cure)


def _fixed(known, program, plant, target: Path, path: Path, quiet: bool, outcome: Outcome) -> Preflight:
    """Write the program with feeds that the joints can follow; what it asks for then."""
    with preparing(path.name, quiet):
        fixed = fix_feed(known, program, plant=plant)
    write_atomic(target, fixed.program.text)
    times = fixed.before.duration, fixed.after.duration
    outcome.data["fixed"] = {
        "file": str(target), "before": times[0], "after": times[1],
        "lines": [change._asdict() for change in fixed.changes], "note": fixed.note,
    }  # fmt: skip
    if not quiet:
        count = len(fixed.changes)
        lines = "no line" if not count else "1 line" if count == 1 else f"{count} lines"
        outcome.say(
            f"{target} is written: {lines} of {path.name} changed; {times[0]:.2f} s before, {times[1]:.2f} s now",
            *([] if fixed.note is None else [f"note: {fixed.note}"]),
        )
    return fixed.after


def _placed(known, program, plant, asked: Asked, path: Path, quiet: bool, outcome: Outcome) -> Any:
    """The program at the place with the greatest least margin."""
    with preparing(path.name, quiet):
        found = place(known, program, asked.turn, asked.fix is not None, asked.seed, plant)
    words = found.words(known)
    outcome.data["place"] = {
        "origin": found.origin.tolist(), "margin": found.margin, "before": found.before, "joint": found.joint,
        "what": found.what, "line": found.line, "table": found.table, "words": words,
    }  # fmt: skip
    if not quiet:
        outcome.say(
            f"least margin {found.margin:.3f} (0 at a limit; {found.before:.3f} where it was), of {found.joint}: "
            f"{found.what}, line {found.line}",
            f"in the [program] table of an experiment:  {found.table}",
            *([] if words is None else [f"on a controller whose machine zero is home:  {words}"]),
            "",
        )
    return program.replace(origin=found.origin)


def loaded(file: Path, machine: str | None) -> tuple[Any, Any, Path, Any]:
    """Machine and program of an NC program, or of an experiment; the file's path; and the experiment's plant, or None.

    Raises
    ------
    InputError
        with every mistake.
    """
    from ..program import load_program

    path = nc_file(file)
    if path.suffix.lower() == ".toml":
        experiment = load_experiment(path, machine)
        return experiment.machine, experiment.program, path, experiment.plant
    if path.suffix.lower() not in SUFFIXES:
        raise ExperimentError(
            "is no program", file=str(path), cure=f"give an NC program ({', '.join(SUFFIXES)}) or an experiment (.toml)"
        )
    if machine is None:
        cure = f"give one of {', '.join(sheet.library())}, or a data sheet (.toml)"
        raise ExperimentError("is missing", key="--machine", cure=cure)
    return sheet.load_machine(machine), load_program(path), path, None


def table(found: Preflight) -> str:
    """Every line of the program with the limit that it comes nearest to, as CSV."""
    text = io.StringIO()
    out = csv.writer(text, lineterminator="\n")
    out.writerow(["line", "use", "joint", "limit", "t_s"])
    seen = found.found
    for line, use, column, t in zip(seen.lines, seen.use, seen.column, seen.time, strict=True):
        out.writerow([int(line), f"{use:.6g}", *found.demand.name(int(column)), f"{t:.6g}"])
    return text.getvalue()
