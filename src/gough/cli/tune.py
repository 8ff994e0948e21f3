"""gough tune: gains that make the contour error small on drawn machines, in a file that runs."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable
from pathlib import Path

from ..experiment import load_experiment
from ..files import write_atomic
from ..results import results_folder
from .end import Outcome, plain
from .progress import preparing

FIGURE = "progress.svg"
RESULT = "tuning.json"
EVERY = 5.0  # s between two lines where stderr is no terminal


def tune_file(
    file: Path,
    machine: str | None,
    kinds: Iterable[str],
    budget: int | None,
    seed: int | None,
    out: Path | None,
    force: bool,
    quiet: bool,
    outcome: Outcome,
) -> None:
    """Tune the controller of an experiment; write its gains as an experiment that runs, with all that was tried."""
    import json

    from ..tune.figure import progress_figure
    from ..tune.tuning import tune

    with preparing(file.name, quiet):
        experiment = load_experiment(file, machine, kinds)
    target = out or Path("results") / f"{experiment.name}-tuned"
    with results_folder(target, force) as folder, _Line(quiet) as line:
        tuned = tune(experiment, budget, seed, line)
        for name, text in tuned.files().items():
            (folder / name).parent.mkdir(exist_ok=True)
            write_atomic(folder / name, text)
        told = tuned.to_json() | {"history": [score.to_json() for score in tuned.history]}
        write_atomic(folder / RESULT, json.dumps(plain({"schema": "gough-tuning-1", **told}), indent=1) + "\n")
        progress_figure(tuned).figure.savefig(folder / FIGURE)
    outcome.data.update(tuned.to_json(), file=str(target / "experiment.toml"), figure=str(target / FIGURE))
    if not quiet:
        outcome.say(str(tuned))
    if not outcome.as_json:
        outcome.say(f"gains: {target / 'experiment.toml'}")


class _Line:
    """One line on stderr: candidates tried, the best so far, the time to go; on a terminal it is written over."""

    def __init__(self, quiet: bool):
        self.quiet, self.terminal = quiet, sys.stderr.isatty()
        self.begun = self.last = time.monotonic()

    def __enter__(self) -> _Line:
        return self

    def __exit__(self, *_) -> None:
        if not self.quiet and self.terminal:
            print(file=sys.stderr, flush=True)

    def __call__(self, tried: int, budget: int, best: float | None) -> None:
        from .. import units

        now = time.monotonic()
        if self.quiet or (not self.terminal and now - self.last < EVERY and tried < budget):
            return
        self.last = now
        left = (now - self.begun) / tried * (budget - tried)
        told = "none holds the limits yet" if best is None else f"best {units.show(best, 'm')}"
        text = f"tuning: {tried} of {budget} candidates, {told}, {left:.0f} s to go at most"
        print(f"\r{text:78}" if self.terminal else text, end="" if self.terminal else "\n", file=sys.stderr, flush=True)
