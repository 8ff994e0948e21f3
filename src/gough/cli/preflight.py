"""gough preflight: what a program asks of a machine, before metal is cut."""

from __future__ import annotations

import csv
import io
import json
import sys
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import ExperimentError
from ..experiment import SUFFIXES, load_experiment, nc_file
from ..files import write_atomic
from ..machine import sheet
from ..plan.preflight import CARTESIAN, JOINTS, Preflight, preflight
from ..results import results_folder
from .end import Outcome, plain
from .progress import preparing


class Asked(NamedTuple):
    """The options of the command line, as they were written."""

    planner: str
    out: Path | None
    force: bool


def preflight_file(file: Path, machine: str | None, asked: Asked, quiet: bool, outcome: Outcome) -> None:
    """Judge the program of a file; the status is "failed" where the machine cannot follow it.

    Raises
    ------
    InputError
        with every mistake of what was given.
    """
    if asked.planner not in (CARTESIAN, JOINTS):
        raise ExperimentError(
            "no such planner", key="--planner", value=asked.planner[:40], cure=f"write {CARTESIAN} or {JOINTS}"
        )
    known, program, path = loaded(file, machine)
    with preparing(path.name, quiet):
        found = preflight(known, program, asked.planner)
    outcome.data.update(found.to_json())
    if asked.out is not None:
        with results_folder(asked.out, asked.force) as folder:
            write_atomic(folder / "preflight.json", json.dumps(plain(found.to_json()), indent=1) + "\n")
            write_atomic(folder / "lines.csv", table(found))
        outcome.data["folder"] = str(asked.out)
    if not quiet and not outcome.as_json:
        outcome.say(found)
    if not found.passed:
        outcome.data.update(status="failed", error=found.error().to_json())
        if quiet:
            print(f"{path.name}: {len(found.findings)} limits exceeded", file=sys.stderr)


def loaded(file: Path, machine: str | None) -> tuple[Any, Any, Path]:
    """Machine and program of an NC program, or of an experiment; and the file's path.

    Raises
    ------
    InputError
        with every mistake.
    """
    from ..program import load_program

    path = nc_file(file)
    if path.suffix.lower() == ".toml":
        experiment = load_experiment(path, machine)
        return experiment.machine, experiment.program, path
    if path.suffix.lower() not in SUFFIXES:
        raise ExperimentError(
            "is no program", file=str(path), cure=f"give an NC program ({', '.join(SUFFIXES)}) or an experiment (.toml)"
        )
    if machine is None:
        cure = f"give one of {', '.join(sheet.library())}, or a data sheet (.toml)"
        raise ExperimentError("is missing", key="--machine", cure=cure)
    return sheet.load_machine(machine), load_program(path), path


def table(found: Preflight) -> str:
    """Every line of the program with the limit that it comes nearest to, as CSV."""
    text = io.StringIO()
    out = csv.writer(text, lineterminator="\n")
    out.writerow(["line", "use", "joint", "limit", "t_s"])
    seen = found.found
    for line, use, column, t in zip(seen.lines, seen.use, seen.column, seen.time, strict=True):
        out.writerow([int(line), f"{use:.6g}", *found.demand.name(int(column)), f"{t:.6g}"])
    return text.getvalue()
