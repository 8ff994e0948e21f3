"""Jobs: the single runs of a sweep, each with an identity that is a hash of everything that makes its bits.

    experiment key   schema, versions and source of gough, versions of what it computes with, lanes, every part
    id of a run      experiment key, which controller, and the settings that its run hangs on

Two runs of one id are one run: it is done once, and found again by whoever asks for it.
"""

from __future__ import annotations

import functools
import hashlib
import json
from collections.abc import Sequence
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

from .. import __version__
from .design import Design
from .settings import Setter

SCHEMA = "gough-sweep-run-2"
PACKAGES = ("numpy", "casadi", "llvmlite")
ID_DIGITS = 32  # 128 bits
_NOT_COMPUTED = ("cli", "report", "study", "export", "monitor", "identify", "sweep", "tune", "plan", "view", "linuxcnc")
_FILES = ("machine.use", "program.file", "program.parameters", "program.subroutines")  # settings that name files


class Job(NamedTuple):
    """One run: its id, which controller of the experiment, and its settings."""

    id: str
    controller: int
    settings: dict[str, Any]


class Row(NamedTuple):
    """A line of the summary: which draw and point of the grid, and the run that answers for it."""

    draw: int
    point: int
    job: Job


def experiment_key(setter: Setter, lanes: int) -> str:
    """What all runs of a sweep have in common, as a hash."""
    experiment = setter.experiment
    run = experiment.run.replace(log_every=1, signals=None)  # what a log keeps changes no bit of a run
    of = {"machine": experiment.machine, "sheet": setter.sheet, "program": experiment.program, "run": run}
    of |= {"plant": experiment.plant, "observer": experiment.observer}
    told = {
        "schema": SCHEMA,
        "gough": [__version__, source_hash()],
        "versions": {name: metadata.version(name) for name in PACKAGES},
        "lanes": lanes,
        "parts": {name: None if part is None else part.digest() for name, part in of.items()},
    }
    return _hash(told)


@functools.cache
def source_hash() -> str:
    """SHA-256 of those modules of gough that a run's numbers may hang on."""
    found, root = hashlib.sha256(), Path(__file__).parents[1]
    for path in sorted(root.rglob("*.py")):
        if path.relative_to(root).parts[0] not in _NOT_COMPUTED:
            found.update(str(path.relative_to(root)).encode() + b"\0" + path.read_bytes())
    return found.hexdigest()


def rows_of(design: Design, setter: Setter, key: str) -> list[Row]:
    """Every line of a sweep: draws, points of the grid, controllers."""
    laws = [(one.kind, one.law.digest()) for one in setter.experiment.controllers]
    digests: dict[Any, str] = {}
    rows = []
    for drawn in design:
        for i, law in enumerate(laws):
            settings = setter.of_controller(drawn.settings, i)
            told = [key, law, sorted((_without_number(name), value) for name, value in settings.items())]
            files = {name: value for name, value in settings.items() if name in _FILES}
            if files:
                known = repr(sorted(files.items()))
                if known not in digests:
                    made = setter(files)
                    digests[known] = made.machine.digest() + made.program.digest()
                told.append(digests[known])
            rows.append(Row(drawn.draw, drawn.point, Job(_hash(told)[:ID_DIGITS], i, settings)))
    return rows


def _without_number(name: str) -> str:
    """A setting of the run's own controller, whichever of the file's it is."""
    table, _, rest = name.partition(".")
    return f"controller.{rest.partition('.')[2]}" if table == "controller" else name


def batches_of(jobs: Sequence[Job], workers: int) -> list[list[Job]]:
    """The jobs in batches for the workers: neighbours that a kernel may run side by side stand together."""

    def alike(job: Job) -> tuple:
        apart = [item for item in job.settings.items() if not item[0].startswith(("plant.", "controller.", "run.seed"))]
        return job.controller, repr(sorted(apart))

    groups: dict[tuple, list[Job]] = {}
    for job in jobs:
        groups.setdefault(alike(job), []).append(job)
    ordered = [job for key in sorted(groups) for job in groups[key]]
    share = -(-len(ordered) // (8 * workers))  # eight batches a worker: the last ones end at about the same time
    size = min(max(SLAB * -(-share // SLAB), SLAB), MOST)
    return [ordered[at : at + size] for at in range(0, len(ordered), size)]


SLAB, MOST = 8, 256  # jobs of a batch: a multiple of the first, at most the second


def _hash(told: Any) -> str:
    return hashlib.sha256(json.dumps(told, sort_keys=True, default=repr).encode()).hexdigest()
