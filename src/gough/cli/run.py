"""gough run, gough report: from checked input to a results folder with logs, plots and the page."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import ExperimentError, InputError, LogError, RunError
from ..experiment import Experiment, load_experiment
from ..experiment.resolve import resolved
from ..files import write_atomic
from ..names import slug
from ..results import made_by_gough, results_folder
from .check import own_sheet, warn_of
from .end import Outcome, show_warning
from .progress import Shown, preparing
from .together import together


def run_file(
    file: Path,
    machine: str | None,
    kinds: Iterable[str],
    seed: int | None,
    out: Path | None,
    force: bool,
    quiet: bool,
    strict: bool,
    outcome: Outcome,
) -> None:
    """Run an experiment or an NC program and write its results folder."""
    warnings.showwarning = show_warning
    with preparing(file.name, quiet):
        experiment = load_experiment(file, machine, kinds, seed)
        if own_sheet(experiment):
            warn_of(experiment.machine)
    run_experiment(experiment, out, force, quiet, strict, outcome)


def run_experiment(
    experiment: Experiment,
    out: Path | None,
    force: bool,
    quiet: bool,
    strict: bool,
    outcome: Outcome,
    prepare: Callable[[Experiment, Path], Experiment] | None = None,
    command: str = "gough run",
) -> None:
    """Run an experiment and write its results folder; `command` repeats it.

    `prepare` gives the experiment to run in place of this one, and may write into the folder.
    """
    target = out or Path("results") / experiment.name
    outcome.data.update(experiment=experiment.name, controllers=[], report=None)
    with results_folder(target, force) as folder:
        if prepare is not None:
            experiment = prepare(experiment, folder)
        files = resolved(experiment, command)
        for name, text in files.items():
            (folder / name).parent.mkdir(exist_ok=True)
            write_atomic(folder / name, text)
        ended = _simulate(experiment, quiet, strict)
        logs = [run.log for run in ended if run.log is not None]
        if not logs:
            raise RunError(problems=[problem for run in ended for problem in run.error.problems])
        for run in ended:
            if run.log is not None:
                run.log.save(folder / f"{run.label}.nc")
        page = _page(logs, folder, files)
    outcome.data["controllers"] = [
        _entry(run.label, run.log, target / f"{run.label}.nc") for run in ended if run.log is not None
    ]
    outcome.data["report"] = str(target / page)
    for run in ended:
        if run.error is not None:
            outcome.fail(run.error)
    if not quiet:
        outcome.say(_table(logs))
    if not outcome.as_json:
        outcome.say(f"report: {target / page}")


def report_logs(paths: Sequence[Path], out: Path | None, force: bool, quiet: bool, outcome: Outcome) -> None:
    """Write the report of logs that are there, a folder standing for all in it; by default into results/."""
    from ..log import Log

    # results/first is a folder of logs already, so its report is not called "first"
    name = "-".join(f"{path.resolve().name}-report" if path.is_dir() else path.stem for path in paths)
    target = out or Path("results") / slug(name)
    paths = [log for path in paths for log in _logs_in(path)]
    if made_by_gough(target) and any(target.resolve() == path.resolve().parent for path in paths):
        # a results folder is replaced whole: the logs would be gone
        cure = "choose another folder with --out"
        raise ExperimentError("the folder holds the logs themselves", key="--out", value=str(target), cure=cure)
    logs = [Log.load(path) for path in paths]
    with results_folder(target, force) as folder:
        page = _page(logs, folder)
    outcome.data.update(
        controllers=[_entry(_kind(log), log, path) for log, path in zip(logs, paths, strict=True)],
        report=str(target / page),
    )
    if not quiet:
        outcome.say(_table(logs))
    if not outcome.as_json:
        outcome.say(f"report: {target / page}")


def _logs_in(path: Path) -> list[Path]:
    """The path of a log, or of every log in a folder."""
    if not path.is_dir():
        return [path]
    found = sorted(path.glob("*.nc"))
    if not found:
        cure = "name a results folder, or logs: files that end in .nc"
        raise LogError("the folder holds no log", file=str(path), cure=cure)
    return found


class Ended(NamedTuple):
    """How one controller's run ended: a log, and the error of a run that failed."""

    label: str
    log: Any
    error: RunError | None


def _simulate(experiment: Experiment, quiet: bool, strict: bool) -> list[Ended]:
    """Run every controller; those that fail have what they logged and their error."""
    from ..simulate.run import simulate

    options = {name: getattr(experiment.run, name) for name in type(experiment.run).model_fields}
    options |= {"strict": strict, "on_fail": "raise", "observer": experiment.observer}
    options["compensation"] = experiment.compensation
    with Shown(experiment.labels, quiet) as shown:

        def job(i: int):
            label, law = experiment.labels[i], experiment.controllers[i].law

            def tick(done: float, total: float) -> None:
                shown.tick(i, done, total)

            def work() -> Ended:
                parts = experiment.machine, law, experiment.program, experiment.plant
                try:
                    log, error = simulate(*parts, progress=tick, **options), None
                except RunError as caught:
                    log, error = getattr(caught, "log", None), _of(caught, label)
                except InputError as caught:
                    raise experiment.locate(caught, i) from None
                shown.end(i, "done" if error is None else "failed")
                return Ended(label, log, error)

            return work

        return together([job(i) for i in range(len(experiment.controllers))], shown.stop)


def _of(error: RunError, label: str) -> RunError:
    """The same error, said of the controller `label`."""
    said = [replace(p, where=f"{label}, {p.where}" if p.where else label) for p in error.problems]
    return type(error)(problems=said)


def _page(logs: list, folder: Path, files: dict[str, str] | None = None) -> str:
    """Write figures and page; the name of the page."""
    from ..report import report

    return report(logs, folder, files).name


def _entry(kind: str, log: Any, path: Path) -> dict[str, Any]:
    metrics = log.metrics
    return {
        "kind": _kind(log) if _kind(log) != "log" else kind,
        "status": log.status,
        "contour_error": _three(metrics.get("contour_error")),
        "orientation_error": _three(metrics.get("orientation_error")),
        "log": str(path),
    }


def _kind(log: Any) -> str:
    return str(log.info.get("controller_kind") or "log")


def _three(errors: Any) -> dict[str, Any] | None:
    return {name: errors.get(name) for name in ("max", "rms", "mean")} if isinstance(errors, dict) else None


def _table(logs: list) -> str:
    """The table of a report as text: labels to the left, one column a log, the best of each line marked."""
    from ..report.table import heads, report_table

    rows = report_table(logs)
    cells = [["", *heads(logs)]]
    for row in rows:
        marked = [f"{text} *" if i in row.best else f"{text}  " for i, text in enumerate(row.values)]
        cells.append([row.label, *marked])
    widths = [max(len(line[i]) for line in cells) for i in range(len(cells[0]))]
    cells[0] = [f"{head}  " if i else head for i, head in enumerate(cells[0])]
    widths = [max(w, len(c)) for w, c in zip(widths, cells[0], strict=True)]
    lines = []
    for line in cells:
        text = [line[0].ljust(widths[0]), *(cell.rjust(w) for cell, w in zip(line[1:], widths[1:], strict=True))]
        lines.append("  ".join(text).rstrip())
    lines.insert(1, "-" * max(map(len, lines)))
    if any(row.best for row in rows):
        lines.append("* the best of each line")
    return "\n".join(lines)
