"""The folder of an export: C files, headers, a self-test, a Makefile and a README, as texts by name."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...errors import ExperimentError
from ...kernel.pack import flatten
from ...machine.base import Machine
from ...program.reference import Reference
from .check_text import check_text, step_rows
from .machine_text import machine_text
from .names import distinct, identifier, suggested
from .readme import makefile, readme
from .step_text import law_stepped, observer_stepped, step_text


def c_files(what: Any, name: str | None = None, theta: str = "constant") -> dict[str, str]:
    """File name -> text of a Machine, or of an Experiment: its believed machine, its laws and its observer.

    `name` begins every function; the machine's own if it is None, with _ for what C does not take.  Laws and observer
    start at rest at the first reference of the program.  `theta`: whether numbers are "constant", or an "argument".

    Raises
    ------
    ExperimentError
        the name is no C identifier; a law is plain Python.
    InputError
        what cannot be printed.
    """
    experiment = None if isinstance(what, Machine) else what  # a room upstairs, so it is told by what it has
    if experiment is not None and not all(hasattr(what, key) for key in ("machine", "program", "controllers", "run")):
        raise ExperimentError("only machines and experiments go into C", value=type(what).__name__)
    machine = what if experiment is None else experiment.machine
    name = identifier(suggested(machine.name) if name is None else name)
    stepped = [] if experiment is None else _stepped(name, experiment, theta)
    files = dict(zip((f"{name}.c", f"{name}.h"), machine_text(name, machine, theta), strict=True))
    for one, _ in stepped:
        files |= dict(zip((f"{one.name}.c", f"{one.name}.h"), step_text(one), strict=True))
    files[f"{name}_test.c"] = check_text(name, machine, stepped, theta == "argument")
    files["Makefile"] = makefile(name, [one.name for one, _ in stepped])
    files["README.md"] = readme(name, machine, [one for one, _ in stepped], theta == "argument")
    return files


def _stepped(name: str, experiment: Any, theta: str) -> list[tuple[Any, list]]:
    """Laws and observer of an experiment, each with recorded steps."""
    machine, period = experiment.machine, experiment.run.period
    reference = first_row(experiment)
    u0 = machine.at_rest(reference.x)[1]
    out = []
    # NAME_test.c and NAME_observer.c are taken
    labels = distinct(["test", "observer", *experiment.labels])[2:]
    for label, one in zip(labels, experiment.controllers, strict=True):
        law = one.law.on(machine, period)
        out.append(law_stepped(f"{name}_{label}", law, reference, u0, theta))
    if experiment.observer is not None:
        observer = experiment.observer.on(machine, period)
        out.append(observer_stepped(f"{name}_observer", observer, reference.x, theta))
    row, q = flatten(reference), np.ravel(reference.q)
    return [(one, step_rows(one, row, q, u0)) for one in out]


def first_row(experiment: Any) -> Reference:
    """The first sample of what the tool should do."""
    period = experiment.run.period
    columns = experiment.program.plan(experiment.machine).sample(0, 1, period)
    return Reference(*(np.asarray(column)[0] for column in columns))
