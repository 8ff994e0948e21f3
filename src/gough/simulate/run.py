"""simulate(): a machine, a law and a program in, a Log out; lists of plants, laws or seeds are runs side by side."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from pydantic import Field

from ..control.base import Controller
from ..declare import Part, quantity
from ..errors import ExperimentError
from ..log import Log
from ..machine.base import Machine
from ..observe.base import Observer
from ..program.base import Program
from ..quantities import brief
from .batch import Batch
from .leaning import Compensation
from .plant import Plant
from .single import Single

_MAKE = {
    "machine": 'gk.load_machine("nist-octahedral")',
    "controller": "gk.PID(bandwidth=10.0)",
    "compensation": "Compensation(height=18e-3, air=[0.0, 0.01]) of gough.simulate.leaning",
    "observer": "gk.DisturbanceObserver(bandwidth=20.0)",
    "program": 'gk.load_program("part.ngc") or gk.Circle(radius=0.1, feed=0.05)',
    "plant": "gk.Plant(machine=machine, payload=20.0), or a machine",
}
LANES = ("auto", 1, 2, 4, 8)


class Run(Part):
    """How a simulation is computed: the [run] table of an experiment."""

    period: float = quantity("s", "sample period of the controllers", default=1e-3, above=0, at_most=1)
    substeps: int | None = Field(
        None, ge=1, le=10_000, description="steps of the plant a period; chosen where left out"
    )
    seed: int = Field(0, ge=0, lt=2**63, description="of the noise")
    log_every: int = Field(1, ge=1, description="the log keeps one of so many samples; metrics use all")
    signals: list[str] | None = Field(None, description="variables of the log; all where left out")
    ferror: float | None = quantity(
        "m", "following error of a joint that ends the run; at the joint's greatest speed if min_ferror is given",
        default=None, above=0,
    )  # fmt: skip
    min_ferror: float | None = quantity("m", "the same of a joint at rest", default=None, above=0)
    encoder_check: float | None = quantity(
        "N", "force on a joint that nobody knows; an encoder that reads what takes more is flagged", default=None,
        above=0,
    )  # fmt: skip
    stop_ramp: float | None = quantity(
        "m/s2", "at a flag or following error the tool brakes so hard along its path before the run ends",
        default=None, above=0,
    )  # fmt: skip


def simulate(
    machine: Machine,
    controller: Controller | Sequence[Controller],
    program: Program,
    plant: Plant | Machine | Sequence[Plant | Machine] | None = None,
    seed: int | Sequence[int] = 0,
    period: float = 1e-3,
    substeps: int | None = None,
    log_every: int = 1,
    signals: Sequence[str] | None = None,
    ferror: float | None = None,
    min_ferror: float | None = None,
    encoder_check: float | None = None,
    stop_ramp: float | None = None,
    *,
    observer: Observer | None = None,
    compensation: Compensation | None = None,
    keep: str = "rows",
    labels: Sequence[str] | None = None,
    lanes: int | str = "auto",
    progress: Callable[[float, float], None] | None = None,
    on_fail: str = "return",
    strict: bool = False,
) -> Log:
    """Run `program` on `plant` (default: `machine` itself) under `controller`, which believes `machine`.

    An `observer` runs beside the law and changes nothing of the run; what it finds is in the log.  With a
    `compensation` the tool leans against the cut by the force that the observer finds (simulate.leaning).

    `progress(simulated, total)` is called after every chunk, in seconds.  A run that leaves the machine's limits,
    diverges or trips (`ferror`, `min_ferror`: simulate.trip) ends there: its log has status "failed" and the reason;
    `on_fail="raise"` raises the error instead, with the log as its attribute `log`.  With `encoder_check` encoders are
    flagged that read what no force explains (observe.encoders); with `stop_ramp` a flag or a trip brings the tool to
    rest along its path before the run ends (simulate.safe_stop).  `strict` turns the warning about
    an unstable loop into an error.

    Lists of plants, of controllers of one kind or of seeds, all of one length, are a batch: runs side by side in
    `lanes`, one Log with the dimension `run`; what is no list is the same in every run.  A run that fails ends alone.
    With one seed for all, every run has noise of its own, and run 0 that of the single run.  `labels` name the runs;
    `log.run(i)` is the Log of one.  `keep="metrics"` keeps no rows, only the metrics of every run, in memory that does
    not grow with the program.  A run of a batch gives the same bits in every batch; against the single run it is
    rounded otherwise (lanes=1: not even that).

    Returns
    -------
    Log
        as CONTRACT.md 3 describes it; `log.dataset` is an xarray dataset.

    Raises
    ------
    InputError
        what was handed in does not fit together.
    RunError
        only with on_fail="raise".
    """
    many = [name for name, value in (("controller", controller), ("plant", plant), ("seed", seed)) if _listed(value)]
    run = Run(
        period=period,
        substeps=substeps,
        seed=0 if "seed" in many else seed,
        log_every=log_every,
        signals=signals if signals is None or isinstance(signals, str) else list(signals),
        ferror=ferror,
        min_ferror=min_ferror,
        encoder_check=encoder_check,
        stop_ramp=stop_ramp,
    )
    for name, value, known in (("on_fail", on_fail, ("return", "raise")), ("keep", keep, ("rows", "metrics"))):
        if value not in known:
            raise ExperimentError(f'{name} must be "{known[0]}" or "{known[1]}"', value=repr(value))
    if isinstance(lanes, bool) or lanes not in LANES:
        raise ExperimentError('lanes must be 1, 2, 4, 8 or "auto"', value=brief(lanes))
    _check("machine", machine, Machine)
    if machine.rigid is not machine:
        raise ExperimentError(
            "laws believe the rigid machine", key="machine", value=f"a flexible {machine.name}",
            cure="give machine.rigid, and plant=gk.Plant(machine=machine.rigid, flexible=True)",
        )  # fmt: skip
    _check("program", program, Program)
    _check("observer", observer, Observer | None)
    _check("compensation", compensation, Compensation | None)
    if not many:
        _check_single(keep, labels)
        _check("controller", controller, Controller)
        _check("plant", plant, Plant | Machine | None)
        job = Single(machine, controller, program, _plant(machine, plant), run, strict, observer, compensation)
    else:
        count = _count({"controller": controller, "plant": plant, "seed": seed}, many)
        laws = _each("controller", controller, count, Controller)
        given = _each("plant", plant, count, Plant | Machine | None)
        made = {id(value): _plant(machine, value) for value in given}  # what is the same object stays one
        plants = [made[id(value)] for value in given]
        seeds = [Run(seed=_whole(value)).seed for value in seed] if "seed" in many else None
        job = Batch(
            machine, laws, program, plants, seeds, _labels(labels, count), run, keep, lanes, strict, observer,
            compensation,
        )  # fmt: skip
    log, error = job.run(progress)
    if error is not None and on_fail == "raise":
        error.log = log
        raise error
    return log


def _listed(value: Any) -> bool:
    return isinstance(value, list | tuple | range) or (isinstance(value, np.ndarray) and value.ndim == 1)


def _plant(machine: Machine, value: Plant | Machine | None) -> Plant:
    if isinstance(value, Machine) and value.rigid is not value:
        raise ExperimentError(
            "a plant makes its machine flexible itself", key="plant", value=f"a flexible {value.name}",
            cure="give gk.Plant(machine=machine.rigid, flexible=True)",
        )  # fmt: skip
    return value if isinstance(value, Plant) else Plant(machine=machine if value is None else value)


def _whole(value: Any) -> Any:
    return int(value) if isinstance(value, np.integer) else value


def _check(name: str, value: Any, kind: Any, key: str | None = None) -> Any:
    if not isinstance(value, kind):
        raise ExperimentError(f"must be a {name.capitalize()}", key=key or name, value=brief(value), cure=_MAKE[name])
    return value


def _check_single(keep: str, labels: Any) -> None:
    for name, given in (('keep="metrics"', keep == "metrics"), ("labels", labels is not None)):
        if given:
            raise ExperimentError(f"{name} is for batches", cure="give a list of plants, controllers or seeds")


def _count(values: dict[str, Any], many: list[str]) -> int:
    """The number of runs that the lists agree on."""
    found = {name: len(values[name]) for name in many}
    if len(set(found.values())) > 1:
        text = ", ".join(f"{n} of {name}" for name, n in found.items())
        raise ExperimentError("the lists must have equally many runs", value=text)
    count = found[many[0]]
    if not count:
        raise ExperimentError("the list is empty: a batch needs a run", key=many[0])
    return count


def _each(name: str, value: Any, count: int, kind: Any) -> list:
    if not _listed(value):
        return [_check(name, value, kind)] * count
    return [_check(name, one, kind, f"{name}.{i}") for i, one in enumerate(value)]


def _labels(labels: Any, count: int) -> list[str]:
    """The names of the runs: given, or their numbers."""
    if labels is None:
        return [str(i) for i in range(count)]
    if not _listed(labels) or not all(isinstance(label, str) and label for label in labels):
        raise ExperimentError("labels must be a list of texts", key="labels", value=brief(labels))
    if len(labels) != count:
        raise ExperimentError(f"{count} labels are needed", key="labels", value=str(len(labels)))
    twice = [label for label in labels if labels.count(label) > 1]
    if twice:
        raise ExperimentError("every run needs a label of its own", key="labels", value=brief(twice[0]))
    return list(labels)
