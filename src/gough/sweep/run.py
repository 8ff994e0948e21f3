"""sweep(): the runs that an experiment's [sweep] table asks for, each kept in a store as soon as it has ended.

Runs that the store has already are not done again, so a sweep that was ended goes on where it stopped, and one with
more draws adds those alone.  The store is the same, bit for bit, whatever the number of workers, the batches, and the
times it was ended.
"""

from __future__ import annotations

import contextlib
import dataclasses
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..experiment import Experiment
from ..experiment.resolve import resolved
from ..files import Document
from ..kernel.lanes import native_width
from .design import Design, design_of
from .jobs import Job, Row, batches_of, experiment_key, rows_of
from .pool import Pool
from .settings import Setter
from .store import Store
from .work import Done, Task, task_of

Tell = Callable[["Progress"], None]


@dataclass
class Progress:
    """How far a sweep is, for whoever shows it."""

    metric: str  # of which the least is the best
    total: int  # runs, those of the store included
    found: int  # of them in the store when it began
    done: int = 0  # of them now
    failed: int = 0
    best: tuple[float, str] | None = None  # least value of the metric, and the run's id
    warned: list[str] = field(default_factory=list)

    def take(self, record: dict[str, Any]) -> None:
        self.done += 1
        self.failed += record["status"] != "done"
        value = record["metrics"].get(self.metric)
        if (
            record["status"] == "done"
            and value is not None
            and (self.best is None or (value, record["id"]) < self.best)
        ):
            self.best = value, record["id"]


@dataclass(frozen=True)
class Swept:
    """A sweep that has come to its end: its lines, and the record of each run by id."""

    experiment: Experiment
    design: Design
    rows: list[Row]
    records: dict[str, dict[str, Any]]
    progress: Progress
    key: str  # of its experiment in the store


def sweep(
    experiment: Experiment,
    folder: str | Path,
    *,
    runs: int | None = None,
    seed: int | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    lanes: int | None = None,
    tell: Tell | None = None,
) -> Swept:
    """Do the runs of the [sweep] table of `experiment` that the store in `folder` has not, in `workers` processes.

    `runs` and `seed` take the place of what the table says; `workers` is by default one for each core; with
    `scheduler`, the address of a dask.distributed scheduler, its workers are used instead.  `tell` is called whenever
    a batch has been kept.

    Raises
    ------
    ExperimentError
        the [sweep] table is wrong, or the folder is no store.
    StorageError
        the store cannot be written; what has been kept is sound.
    RunError
        workers die, or the scheduler does not answer.
    """
    setter = Setter(experiment)
    design = design_of(experiment, runs, seed, setter)
    width = lanes or native_width()
    key = experiment_key(setter, width)
    rows = rows_of(design, setter, key)
    jobs = {row.job.id: row.job for row in rows}
    with Store(folder) as store:
        store.keep_experiment(key, resolved_with(experiment, design))
        records = {id: record for id in jobs if (record := store.get(id)) is not None}
        progress = Progress(design.metric, len(jobs), len(records))
        for record in records.values():
            progress.take(record)
        if tell is not None:
            tell(progress)
        todo = [job for id, job in jobs.items() if id not in records]

        def missing(batch: list[Job]) -> list[Job]:
            """Those of a batch that no other sweep on this store has done meanwhile."""
            for job in batch:
                if (record := store.get(job.id)) is not None:
                    records[job.id] = record
                    progress.take(record)
            return [job for job in batch if job.id not in records]

        work = _each(todo, setter, width, workers, scheduler, store.shared, missing)
        with contextlib.closing(work):  # whatever happens here, no worker is left
            for done in work:
                kept = [{**record, "experiment": key} for record in done.records]
                store.put(kept)
                for record in kept:
                    records[record["id"]] = record
                    progress.take(record)
                for id, reason in done.broken.items():
                    records[id] = {"id": id, "status": "broken", "reason": reason, "metrics": {}, "experiment": key}
                    progress.done, progress.failed = progress.done + 1, progress.failed + 1
                progress.warned += [text for text in done.warned if text not in progress.warned]
                if tell is not None and progress.done < progress.total:
                    tell(progress)
    if tell is not None:
        tell(progress)
    return Swept(experiment, design, rows, records, progress, key)


def _each(
    todo: list[Job], setter: Setter, lanes: int, workers: int | None, scheduler: str | None, shared: bool,
    missing: Callable[[list[Job]], list[Job]],
) -> Iterator[Done]:  # fmt: skip
    """What comes of the jobs, batch by batch."""
    if not todo:
        return

    def tasks(count: int) -> tuple[int, Iterator[Task]]:
        batches = batches_of(todo, count)
        ordered = reversed(batches) if shared else batches  # two sweeps of one store meet in the middle
        found = (missing(batch) for batch in ordered)
        return len(batches), (task_of(setter, lanes, batch) for batch in found if batch)

    if scheduler is not None:
        from .cluster import Cluster

        with Cluster(scheduler) as cluster:
            for _, done in cluster.each(tasks(cluster.workers)[1]):
                yield done
    else:
        count = workers or len(os.sched_getaffinity(0))
        with Pool(count) as pool:
            most, coming = tasks(count)
            for _, done in pool.each(coming, most):
                yield done


def resolved_with(experiment: Experiment, design: Design) -> dict[str, str]:
    """The files that repeat a sweep: as those of its experiment, its [sweep] table with nothing left open."""
    old = experiment.document
    document = Document(old.path, old.text, {**old.data, "sweep": design.to_file()}, old.lines)
    return resolved(dataclasses.replace(experiment, document=document))
