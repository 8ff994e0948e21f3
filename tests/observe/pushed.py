"""A machine held by a law while forces of any course act on its tool, with an observer beside the law."""

from __future__ import annotations

import dataclasses

import numpy as np

from gough import kernel as kernels
from gough.simulate import observed, start, tick
from gough.simulate.plant import Plant


def pushed(machine, law, observer, wrench, plant=None, x=None, period=1e-3):
    """Rows {signal: (n, size)} of n samples at rest at the pose x under wrench (n, 6), each held for a sample."""
    true = machine if plant is None else plant
    x = machine.home if x is None else x
    law, observer = law.on(machine, period), observer.on(machine, period)
    row = tick.rest_row(machine, x)
    first = start.at_rest(machine, true, law, Plant(machine=true), row)
    schedule = observed.with_observer(tick.build(true, law, first.law, row, period, 4), observer)
    signals = [dataclasses.replace(s, kind="input") if s.name == "wrench" else s for s in schedule.signals]
    kernel = kernels.compile(dataclasses.replace(schedule, signals=tuple(signals)))
    numbers = {"theta_plant": true.theta, "theta_law": law.theta, "theta_observer": observer.theta}
    states = tick.first_states(schedule, first.z, first.law, first.u) | observed.states(observer, row.x)
    simulation = kernel.start(numbers, states)
    n = len(wrench)
    reference = np.concatenate([np.broadcast_to(np.ravel(part), (n, np.size(part))) for part in row], axis=1)
    out = simulation.advance(n, {"reference": reference, "wrench": wrench})[:, 0]
    return {name: out[:, where] for name, where in kernel.columns.items()}
