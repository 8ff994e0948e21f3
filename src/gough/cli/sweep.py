"""gough sweep: the runs that an experiment's [sweep] table asks for, side by side, kept run by run."""

from __future__ import annotations

import dataclasses
import json
import shutil
import sys
import tempfile
import time
import warnings
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import ExperimentError, LogError, RunError
from ..experiment import load_experiment
from ..files import write_atomic
from .end import Outcome, show_warning

LAST = "sweep.json"  # which experiment of the store a sweep of its folder means


class Asked(NamedTuple):
    """What the command's options say."""

    runs: int | None
    seed: int | None
    workers: int | None
    scheduler: str | None


def sweep_file(file: Path, asked: Asked, out: Path | None, quiet: bool, outcome: Outcome) -> None:
    """Do the runs of a sweep that are not in its folder yet, and write table, figures and page.

    Raises
    ------
    InputError
        the experiment or its [sweep] table is wrong.
    RunError
        workers die, the scheduler does not answer, the store cannot be written.
    """
    from ..sweep import limits, page, table
    from ..sweep.run import resolved_with, sweep

    warnings.showwarning = show_warning
    file, target, asked = _what(file, out, asked)
    for name, value in (("--runs", asked.runs), ("--workers", asked.workers)):
        if value is not None and value < 1:
            raise ExperimentError("must be at least 1", key=name, value=str(value))
    experiment = load_experiment(file)
    target = target or Path("results") / f"{experiment.name}-sweep"
    outcome.kept = f"what has ended is kept in {target}: the same command goes on"
    with Bar(quiet) as bar:
        swept = sweep(
            experiment, target, runs=asked.runs, seed=asked.seed, workers=asked.workers, scheduler=asked.scheduler,
            tell=bar.show,
        )  # fmt: skip
    lines, files = table.lines_of(swept), resolved_with(experiment, swept.design)
    try:
        table.write_index(swept, lines, target / "index.parquet")
    except LogError as error:
        if not quiet:
            print(f"no index.parquet: {error}", file=sys.stderr)
    last = {"experiment": swept.key, "runs": asked.runs, "seed": asked.seed}
    write_atomic(target / LAST, json.dumps(last, indent=1) + "\n")
    report = page.write_page(swept, lines, target, target, files)
    for text in (*swept.progress.warned, *limits.unstable(swept, lines)) if not quiet else ():
        print(f"warning: {text}", file=sys.stderr)
    _tell(swept, lines, target, report, quiet, outcome)


def _tell(swept: Any, lines: Any, target: Path, report: Path, quiet: bool, outcome: Outcome) -> None:
    from ..sweep import limits, summary

    cases, labels, grid = summary.cases_of(swept, lines), swept.experiment.labels, swept.design.grid()
    worst = summary.worst_runs(swept, lines, target)
    outcome.data.update(
        experiment=swept.experiment.name, folder=str(target), runs=len(lines.ids),
        new=swept.progress.total - swept.progress.found, failed=int((lines.status != "done").sum()),
        metric=swept.design.metric,
        cases=[
            {
                "controller": labels[case.controller], "settings": grid[case.point], "runs": case.runs,
                "failed": case.failed, "median": case.median, "p95": case.most, "worst": case.worst,
                "worst_run": case.worst_id, "saturated": case.saturated, "limits": case.limits,
            }
            for case in cases
        ],
        worst=[{"id": run.id, "what": run.what, "settings": run.settings, "command": run.command} for run in worst],
        report=str(report),
    )  # fmt: skip
    if not quiet:
        heads, rows = summary.case_rows(swept, lines, cases)
        outcome.say(_aligned([heads, *rows]), "", summary.verdict(swept, lines, cases))
        if worst:
            outcome.say(f"worst run: {worst[0].command}")
        for failure in limits.failures(lines)[:5]:
            outcome.say(limits.told_of(failure, lines))
    if not outcome.as_json:
        outcome.say(f"report: {report}")
    broken = [reason for reason, status in zip(lines.reason, lines.status, strict=True) if status == "broken"]
    if broken:
        cure = "the same command does them again"
        outcome.fail(RunError(f"{len(broken)} runs broke and were not kept", value=broken[0], cure=cure))
    elif not (lines.status == "done").any():
        outcome.fail(RunError("every run failed", value=lines.reason[0] if lines.reason else None))


def rerun(folder: Path, id: str, out: Path | None, force: bool, quiet: bool, outcome: Outcome) -> None:
    """Do one run of a sweep again, as `gough run` would, with a full log and a report.

    Raises
    ------
    LogError
        no such run.
    """
    from ..experiment.resolve import NAME, resolved
    from ..sweep.settings import Setter
    from ..sweep.store import Store, is_store
    from .run import run_file

    if not is_store(folder):
        raise ExperimentError("is no folder of a sweep", key="--rerun", value=str(folder))
    store = Store(folder)
    record = store.find(id)
    experiment = load_experiment(store.experiment_file(record["experiment"]))
    made = Setter(experiment)(record["settings"])
    document = dataclasses.replace(
        made.document, data={key: value for key, value in made.document.data.items() if key != "sweep"}
    )
    made = dataclasses.replace(made, controllers=(made.controllers[record["controller"]],), document=document)
    target = out or Path("results") / f"{folder.resolve().name}-{record['id'][:10]}"
    own = Path(tempfile.mkdtemp(prefix="gough-rerun-"))
    try:
        for name, text in resolved(made).items():
            (own / name).parent.mkdir(parents=True, exist_ok=True)
            (own / name).write_text(text)
        run_file(own / NAME, None, (), None, target, force, quiet, False, outcome)
    finally:
        shutil.rmtree(own, ignore_errors=True)
    outcome.data.update(run=record["id"], experiment=experiment.name)


def _what(file: Path, out: Path | None, asked: Asked) -> tuple[Path, Path | None, Asked]:
    """The experiment, its folder and options; a folder of a sweep stands for the sweep that filled it last."""
    from ..sweep.store import Store, is_store

    if not file.is_dir():
        return file, out, asked
    if not is_store(file):
        raise ExperimentError("is no folder of a sweep", file=str(file), cure="give an experiment (.toml)")
    if out is not None:
        raise ExperimentError("a folder of a sweep goes on in itself", key="--out", cure="leave it out")
    try:
        last = json.loads((file / LAST).read_text()[:10_000])
        found = Store(file).experiment_file(str(last["experiment"]))
    except (OSError, ValueError, LookupError, TypeError):
        raise ExperimentError(
            "no sweep has ended here yet", file=str(file), cure="give the experiment (.toml)"
        ) from None
    runs, seed = (last.get(name) if isinstance(last.get(name), int) else None for name in ("runs", "seed"))
    return found, file, asked._replace(runs=asked.runs or runs, seed=seed if asked.seed is None else asked.seed)


def _aligned(rows: list[list[str]]) -> str:
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    lines = [
        "  ".join([row[0].ljust(widths[0]), *(c.rjust(w) for c, w in zip(row[1:], widths[1:], strict=True))]).rstrip()
        for row in rows
    ]
    lines.insert(1, "-" * max(map(len, lines)))
    return "\n".join(lines)


class Bar:
    """Progress of a sweep on stderr: a bar with the time left and the best so far, or a line now and then."""

    _PAUSE = 10.0  # s between lines where there is no terminal

    def __init__(self, quiet: bool):
        self.quiet, self.bars, self.task = quiet, None, None
        self.begun = self.told = time.monotonic()

    def __enter__(self) -> Bar:
        if not self.quiet and sys.stderr.isatty():
            from rich.console import Console
            from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

            columns = [MofNCompleteColumn(), BarColumn(20), TextColumn("{task.fields[told]}", markup=False)]
            self.bars = Progress(*columns, console=Console(stderr=True))
            self.task = self.bars.add_task("runs", total=None, told="preparing")
            self.bars.start()
        return self

    def __exit__(self, *_error: Any) -> None:
        if self.bars:
            self.bars.stop()

    def show(self, progress: Any) -> None:
        """Take what a sweep tells."""
        first, last = progress.done == progress.found, progress.done == progress.total
        if first:
            self.begun = time.monotonic()
        told = ", ".join(part for part in (self._left(progress), _failed(progress), _best(progress)) if part)
        if self.bars:
            self.bars.update(self.task, completed=progress.done, total=progress.total, told=told)
            return
        if self.quiet or not (first or last or time.monotonic() - self.told > self._PAUSE):
            return
        self.told = time.monotonic()
        found = f"{progress.found} of them kept from before" if first and progress.found else ""
        text = ", ".join(part for part in (f"{progress.done} of {progress.total} runs", found, told) if part)
        print(text, file=sys.stderr, flush=True)

    def _left(self, progress: Any) -> str:
        """The time to go, by what this sweep itself has done."""
        done, left = progress.done - progress.found, progress.total - progress.done
        if not done or not left:
            return ""
        seconds = round((time.monotonic() - self.begun) / done * left)
        minutes, hours = seconds // 60, seconds // 3600
        text = f"{seconds} s" if seconds < 120 else f"{minutes} min" if minutes < 120 else f"{hours} h"
        return f"about {text} to go"


def _failed(progress: Any) -> str:
    return f"{progress.failed} failed" if progress.failed else ""


def _best(progress: Any) -> str:
    from ..measure.tree import told
    from ..units import show

    if progress.best is None:
        return ""
    value, id = progress.best
    return f"best {progress.metric} {show(value, told(progress.metric)[0])} ({id[:10]})"
