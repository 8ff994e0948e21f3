"""The [observer] table of an experiment: what watches every run and changes nothing of it.

One observer stands beside every law of the file; it believes the machine of [machine], as they do.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any

from ..errors import ExperimentError, InputError, Problem, did_you_mean

if TYPE_CHECKING:
    from ..machine.base import Machine
    from ..observe.base import Observer
    from ..simulate.run import Run

OBSERVERS = {"disturbance": "gough.observe.disturbance:DisturbanceObserver"}
EXAMPLE = 'write [observer] and kind = "disturbance"'


def observer_of(table: Mapping[str, Any]) -> Observer:
    """The observer that an [observer] table describes.

    Raises
    ------
    InputError
        no such kind, or a wrong key; `key` is set, file and line are not.
    """
    kind = table.get("kind")
    if not isinstance(kind, str) or kind not in OBSERVERS:
        if "kind" not in table:
            raise ExperimentError("is missing", key="kind", cure=f"one of {', '.join(OBSERVERS)}")
        cure = did_you_mean(kind, OBSERVERS) if isinstance(kind, str) else f"one of {', '.join(OBSERVERS)}"
        raise ExperimentError("no such observer", key="kind", value=ascii(kind)[:60], cure=cure)
    if "machine" in table:
        raise ExperimentError("no such key", key="machine", cure="an observer believes the machine of [machine]")
    return _class(kind).from_file(table)


def check_observer(observer: Observer | None, machine: Machine, run: Run) -> None:
    """Refuse an observer that the machine or the period cannot serve.

    Raises
    ------
    InputError
        its numbers do not fit the machine, or its period is no multiple of the run's; keys begin with "observer".
    """
    from ..kernel import period_ticks

    if observer is None:
        return
    try:
        period_ticks(observer.on(machine, run.period).period, run.period)
    except InputError as error:
        told = [problem.key for problem in error.problems]
        if any(told):
            problems = [Problem(**{**p.__dict__, "key": f"observer.{p.key}"}) for p in error.problems]
            raise ExperimentError(problems=problems) from None
        raise ExperimentError(
            "must be a multiple of run.period", key="observer.period", value=f"{observer.period:g} s",
            limit=f"{run.period:g} s", cure="leave it out: then it is run.period",
        ) from None  # fmt: skip


def check_signals(signals: Sequence[str] | None, controllers: Sequence[Any]) -> None:
    """Refuse variables of the log that only an observer finds; for files without one.

    Raises
    ------
    ExperimentError
        with every such name.
    """
    from ..simulate.observed import logged

    own = {name for one in controllers for name in one.law.states}  # a law may have an observer inside
    only = {name for kind in OBSERVERS for name in logged(_class(kind)())} - own
    wrong = [
        Problem("only an observer finds this variable", key=f"signals.{i}", value=repr(name), cure=EXAMPLE)
        for i, name in enumerate(signals or ())
        if name in only
    ]
    if wrong:
        raise ExperimentError(problems=wrong)


def _class(kind: str) -> type[Observer]:
    module, _, name = OBSERVERS[kind].partition(":")
    return getattr(import_module(module), name)
