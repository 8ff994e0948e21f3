"""tune(): an experiment with a [tune] table in, better gains out, and what they are worth on other machines."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..errors import RunError
from ..experiment import Experiment
from .gains import settings as settings_at
from .judge import BEYOND, Judge, Score
from .result import Tuned
from .search import Spent, descent, methods
from .slopes import slopes
from .table import Task, task_of

Progress = Callable[[int, int, float | None], None]  # candidates tried, the budget, the best goal so far


def tune(
    experiment: Experiment, budget: int | None = None, seed: int | None = None, progress: Progress | None = None
) -> Tuned:
    """The gains that make the goal of the [tune] table of an experiment least within its limits.

    The first candidate is the experiment as it stands.  `budget` and `seed` take the place of what the table says;
    `progress(tried, budget, best)` is called behind every generation.

    Raises
    ------
    ExperimentError
        with every mistake of the tables [tune] and [sweep]; no candidate is one that the program and the machine take.
    RunError
        no candidate tried holds the limits; the one that comes closest is told.
    """
    task = task_of(experiment, budget, seed)
    gains, table, judge = task.gains, task.table, Judge(task, task.machines)
    history: list[Score] = []
    best: list[Score] = []

    def take(scores: list[Score]) -> None:
        history.extend(scores)
        best[:] = [min([*best, *scores], key=lambda score: score.cost)]
        if progress is not None:
            progress(len(history), table.budget, best[0].goal if best[0].status == "held" else None)

    def judged(points: np.ndarray) -> np.ndarray:
        room = table.budget - len(history)
        if room < 1:
            raise Spent
        scores = judge([settings_at(gains, u) for u in points[:room]])
        take(scores)
        if len(scores) < len(points):
            raise Spent
        return np.array([score.cost for score in scores])

    before: dict[str, Any] = {}  # no setting at all: the experiment as it stands
    take(judge([before]))
    if history[0].status == "refused":  # what does not run at all is a mistake of the file, and said as one
        _refuse(task)
    start = np.array([_place(task, gain) for gain in gains])
    method = table.method or ("cma" if len(gains) > 1 else "evolution")
    scale = history[0].goal or 1.0
    if method == "gradient":
        descent(judged, lambda u: slopes(task, u), start, scale, BEYOND)
    else:
        methods()[method](judged, start, scale, table.seed)
    if best[0].status != "held":
        raise RunError(
            f"none of {len(history)} candidates holds the limits of [tune]", where="tune",
            value=f"the closest: {_text(best[0].settings)}: {best[0].reason}",
            cure="wider limits or ends, more budget, or a slower program",
        )  # fmt: skip
    aside = Judge(task, task.held_out)([before, best[0].settings]) if task.held_out else []
    return Tuned(task, method, history, best[0], aside)


def _refuse(task: Task) -> None:
    """Raise what the experiment as it stands is refused for."""
    from ..simulate.run import simulate

    one = task.setter(task.machines[0])
    one.controllers[0].law.on(one.machine, one.run.period)
    options = {name: getattr(one.run, name) for name in type(one.run).model_fields}
    simulate(one.machine, one.controllers[0].law, one.program, one.plant, observer=one.observer, **options)


def _place(task: Task, gain) -> float:
    """Where the search begins: at the experiment's own number, or in the middle where it has none between the ends."""
    own = gain.of(task.experiment.controllers[0].law)
    if gain.unit == "x":
        own = None if own is None else "1 x"
    found = None if own is None or np.ndim(own) else gain.place(own)
    return 0.5 if found is None else found


def _text(settings: dict[str, Any]) -> str:
    return ", ".join(f"{key} = {value}" for key, value in settings.items()) or "as it stands"
