"""Tuned: what a tuning found.  It prints itself as a table, goes into JSON, and is a file that runs."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .. import units
from ..experiment import Experiment
from ..experiment.resolve import resolved
from .judge import Score
from .table import Task


class Tuned(NamedTuple):
    """The result of a tuning; `history[0]` is the experiment as it stood, `best` the candidate found."""

    task: Task
    method: str
    history: list[Score]
    best: Score
    aside: list[Score]  # before and tuned on the machines held out; empty without such machines

    @property
    def before(self) -> Score:
        return self.history[0]

    @property
    def experiment(self) -> Experiment:
        """The experiment with the gains found."""
        return self.task.setter(self.best.settings)

    def files(self) -> dict[str, str]:
        """File name -> text of all that `gough run experiment.toml` needs, with the gains found."""
        return resolved(self.experiment)

    def to_json(self) -> dict[str, Any]:
        table, task = self.task.table, self.task
        return {
            "experiment": task.experiment.name,
            "controller": task.experiment.controllers[0].kind,
            "goal": f"{table.goal} {table.metric}",
            "method": self.method,
            "seed": table.seed,
            "tried": len(self.history),
            "machines": len(task.machines),
            "gains": {gain.key: self.best.settings.get(gain.key, _own(task, gain)) for gain in task.gains},
            "before": self.before.to_json(),
            "tuned": self.best.to_json(),
            "held_out": {"machines": len(task.held_out), "before": _json(self.aside, 0), "tuned": _json(self.aside, 1)},
        }

    def __str__(self) -> str:
        table, task = self.task.table, self.task
        rows = [("", "before", "tuned")]
        for gain in task.gains:
            own = _own(task, gain)
            rows.append((gain.key, _said(own, task, gain), _said(self.best.settings.get(gain.key, own), task, gain)))
        goal = f"{table.goal} {table.metric}"
        counts = (len(task.machines), len(task.held_out))
        rows.append((f"{goal}, {counts[0]} machine{'s' * (counts[0] > 1)}", _goal(self.before), _goal(self.best)))
        if self.aside:
            label = f"{goal}, {counts[1]} machine{'s' * (counts[1] > 1)} held out"
            rows.append((label, _goal(self.aside[0]), _goal(self.aside[1])))
        for name, unit in (("saturated", "1"), ("force", "N"), ("overshoot", "m")):
            limit = getattr(table, name)
            label = name if limit is None else f"{name} (limit {_quantity(limit, unit)})"
            rows.append((label, *(_quantity(getattr(one, name), unit) for one in (self.before, self.best))))
        widths = [max(len(row[k]) for row in rows) for k in range(3)]
        lines = [f"{a.ljust(widths[0])}  {b.rjust(widths[1])}  {c.rjust(widths[2])}".rstrip() for a, b, c in rows]
        lines.append(f"{len(self.history)} candidates, {self.method}, seed {table.seed}")
        for one, told in ((self.before, "before"), *((s, "tuned, machines held out") for s in self.aside[1:])):
            if one.status != "held":
                lines.append(f"{told}: {one.reason}")
        if self.best is self.before:
            lines.append("nothing that was tried is better than the experiment as it stands")
        return "\n".join(lines)

    __repr__ = __str__


def _own(task: Task, gain: Any) -> Any:
    """A gain of the experiment as it stands: SI; None where it has none."""
    found = gain.of(task.experiment.controllers[0].law)
    return found.tolist() if isinstance(found, np.ndarray) else found


def _said(value: Any, task: Task, gain: Any) -> str:
    """A gain as a person reads it: texts as they are, SI numbers in the unit of the ends."""
    if value is None:
        return "none"
    if isinstance(value, str) or not isinstance(value, int | float):
        return str(value)
    if gain.unit == "x":
        return f"{value:.6g}"
    factor = units.parse(f"1 {gain.unit}")[0] if gain.unit else 1.0
    return f"{value / factor:.6g} {gain.unit}".rstrip()


def _goal(score: Score) -> str:
    return score.status if score.goal is None else units.show(score.goal, "m")


def _quantity(value: float | None, unit: str) -> str:
    if value is None:
        return ""
    return f"{100 * value:.3g} %" if unit == "1" else units.show(value, unit)


def _json(scores: list[Score], i: int) -> dict[str, Any] | None:
    return scores[i].to_json() if len(scores) > i else None
