"""What a worker does with a batch of jobs: parts out of settings, runs side by side, a record a run.

Runs that differ in numbers only share a kernel's lanes; others run after them, in batches of their own.  A run that
cannot be made, or cannot stand at its start, is a record with its reason, and the others of its batch are run without
it.  No bit of a record depends on the batch it was in (simulate/batch.py).
"""

from __future__ import annotations

import hashlib
import math
import pickle
import warnings
from collections.abc import Sequence
from typing import Any, NamedTuple

from ..errors import GoughError
from ..experiment import Experiment
from .jobs import Job
from .settings import Setter

_LONGEST_REASON = 1000
_MOST_WARNINGS = 20
_SETTERS: dict[str, Setter] = {}  # of this process, by the hash of their bytes


class Task(NamedTuple):
    """A batch on its way to a worker."""

    setter: bytes
    lanes: int
    jobs: list[Job]


class Done(NamedTuple):
    """What came of it: records of runs that have ended, reasons of those that broke, and warnings."""

    records: list[dict[str, Any]]
    broken: dict[str, str]  # id -> reason; such a run is not kept, and done again by the next sweep
    warned: list[str]


def task_of(setter: Setter, lanes: int, jobs: Sequence[Job]) -> Task:
    return Task(pickle.dumps(setter), lanes, list(jobs))


def work(task: Task) -> Done:
    """Carry out a batch.  Raises nothing but KeyboardInterrupt."""
    setter, done = _setter(task.setter), Done([], {}, [])
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        groups: dict[Any, list[tuple[Job, Experiment]]] = {}
        for job in task.jobs:
            try:
                made = setter(job.settings)
                groups.setdefault(_alike(made, job.controller), []).append((job, made))
            except Exception as error:
                _failed(done, job, error)
        for group in groups.values():
            _side_by_side(group, task.lanes, done)
    done.warned.extend(_told(caught))
    return done


def _setter(data: bytes) -> Setter:
    key = hashlib.sha256(data).hexdigest()
    if key not in _SETTERS:
        _SETTERS.clear()  # of a sweep before: a cluster's worker may serve for days
        _SETTERS[key] = pickle.loads(data)
    return _SETTERS[key]


def _alike(made: Experiment, i: int) -> tuple:
    """Equal for runs that one batch takes: the same objects, the same structure, the same tick."""
    from ..declare import Shape

    plant, run = made.plant, made.run
    options = tuple((name, repr(getattr(run, name))) for name in type(run).model_fields if name != "seed")
    tick = None if plant is None else (Shape(plant), len(plant.faults), plant.cutting and plant.cutting.digest())
    law = made.controllers[i].law
    return i, id(made.machine), id(made.program), id(made.observer), options, tick, Shape(law)


def _side_by_side(group: list[tuple[Job, Experiment]], lanes: int, done: Done) -> None:
    """Run a group as one batch; if it is refused as a whole, its halves, down to the runs that are the reason."""
    try:
        done.records.extend(_simulated(group, lanes))
    except Exception as error:
        if len(group) == 1:
            _failed(done, group[0][0], error)
            return
        half = len(group) // 2
        _side_by_side(group[:half], lanes, done)
        _side_by_side(group[half:], lanes, done)


def _simulated(group: list[tuple[Job, Experiment]], lanes: int) -> list[dict[str, Any]]:
    from ..log.batch import metrics_of
    from ..measure.tree import leaves
    from ..simulate.run import simulate
    from .limits import recorded

    made = group[0][1]
    run = {name: getattr(made.run, name) for name in type(made.run).model_fields if name not in ("seed", "signals")}
    log = simulate(
        made.machine, [one.controllers[job.controller].law for job, one in group], made.program,
        [one.plant for _, one in group], seed=[one.run.seed for _, one in group], observer=made.observer, lanes=lanes,
        keep="metrics", **run,
    )  # fmt: skip
    told, out = log.info["runs"], []
    for j, (job, _) in enumerate(group):
        found = {name: _finite(value) for name, value in leaves(metrics_of(log.dataset, j))}
        record = _record(job, told[j]["status"], told[j]["reason"], found)
        out.append(record | {
            "simulated_time": told[j]["simulated_time"], "limit_hit": recorded(told[j]["limit_hit"]),
            "spectral_radius": _finite(told[j]["spectral_radius"]),
        })  # fmt: skip
    return out


def _record(job: Job, status: str, reason: str, metrics: dict[str, Any]) -> dict[str, Any]:
    return {
        "id": job.id, "controller": job.controller, "settings": job.settings, "status": status,
        "reason": reason[:_LONGEST_REASON], "metrics": metrics,
    }  # fmt: skip


def _failed(done: Done, job: Job, error: Exception) -> None:
    if isinstance(error, GoughError):
        done.records.append(_record(job, "failed", str(error), {}) | {"simulated_time": 0.0})
    else:  # a bug, or no memory: nothing that belongs to the run
        done.broken[job.id] = f"{type(error).__name__}: {error}"[:_LONGEST_REASON]


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _told(caught: list) -> list[str]:
    """Warnings that say something of the experiment: of drives at their limits and loops that grow the records do."""
    from ..simulate.notes import EffortWarning, StabilityWarning

    texts = [str(one.message) for one in caught if not issubclass(one.category, EffortWarning | StabilityWarning)]
    return list(dict.fromkeys(texts))[:_MOST_WARNINGS]
