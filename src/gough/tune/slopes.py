"""The slope of the mean rms contour error by the coordinates of the search, from sensitivities of every run."""

from __future__ import annotations

import numpy as np

from .gains import settings
from .table import Task


def slopes(task: Task, u: np.ndarray) -> np.ndarray:
    """d mean rms / du at the point u (gains,), m.

    Raises
    ------
    ExperimentError
        the run is not smooth (simulate.sensitivity), by name.
    """
    from ..simulate.sensitivity import contour_gradient

    names, found = tuple(".".join(gain.names) for gain in task.gains), []
    for machine in task.machines:
        one = task.setter({**machine, **settings(task.gains, u)})
        law, run = one.controllers[0].law, one.run
        slope = contour_gradient(
            one.machine, law, one.program, one.plant, names, run.period, run.substeps, run.seed
        ).by_gain
        own = task.experiment.controllers[0].law
        found.append([s * gain.slope(gain.of(law), gain.of(own)) for s, gain in zip(slope, task.gains, strict=True)])
    return np.mean(found, axis=0)
