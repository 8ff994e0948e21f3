"""Forces in the joints of the plant as variables of the log, for runs that ask for them by `signals`.

They are those of the sample itself: the twist rate is that of the equations of motion under the forces of this sample,
not the one of the sub-step before, by which friction is scaled; the two differ by one sub-step.
"""

from __future__ import annotations

import dataclasses
from functools import lru_cache
from typing import NamedTuple

import casadi as ca

from ..declare import Shape
from ..kernel import Schedule, Signal, Task
from ..machine.reactions import Reactions
from . import tick


class Told(NamedTuple):
    """What the log says of a variable."""

    dims: tuple[str, ...]
    units: str
    meaning: str


VECTOR = ("joint", "axis")
FORCES = {  # name: (field of Reactions, what is said of it)
    "plant.reaction": ("platform_joint", Told(VECTOR, "N", "force of the platform on each strut, x y z in W")),
    "plant.base_reaction": ("base_joint", Told(VECTOR, "N", "force of the base on each strut, x y z in W")),
    "plant.bushing_mouth": ("mouth", Told(VECTOR, "N", "force of the sleeve's mouth on each tube, x y z in W")),
    "plant.bushing_end": ("end", Told(VECTOR, "N", "force of the sleeve on the end of each tube, x y z in W")),
    "plant.normal_force": ("normal", Told(("joint",), "N", "normal force between tube and sleeve, of both bushings")),
    "plant.multiplier": (
        "multiplier",
        Told(("closure",), "N", "multipliers of the closure: forces along what closes it"),
    ),
}


def available(machine) -> list[str]:
    """The names of FORCES that a machine has."""
    has = getattr(machine, "reaction_fields", ())
    return [name for name in FORCES if FORCES[name][0] in has]


def asked(signals) -> tuple[str, ...]:
    """Those of FORCES among the variables that a run asked for (None: all others)."""
    return tuple(name for name in FORCES if signals is not None and name in signals)


def with_reactions(schedule: Schedule, machine, names: tuple[str, ...]) -> Schedule:
    """The tick of `tick.build` for `machine`, with the forces `names` computed and logged."""
    return _with(schedule, Shape(machine), names) if names else schedule


@lru_cache(maxsize=64)
def _with(schedule: Schedule, shape: Shape, names: tuple[str, ...]) -> Schedule:
    function = _function(shape, names)
    signals = [Signal(name, function.size1_out(i), "wire") for i, name in enumerate(names)]
    held = ("loads",) if shape.part.load_count else ()
    task = Task("reactions", function, ("theta_plant", "z", "v", "memory", "u", "wrench", *held), names)
    return dataclasses.replace(
        schedule,
        signals=(*schedule.signals, *signals),
        tasks=(*schedule.tasks, task),
        log=(*schedule.log, *names),
    )


def _function(shape: Shape, names: tuple[str, ...]) -> ca.Function:
    m = shape.part
    p, theta, z, v, memory = tick.symbols_of(m)
    u, w, loads = ca.SX.sym("u", m.joints_count), ca.SX.sym("w", 6), tick.loads_symbol(m)
    _, vd = tick.rate(m, p, z, v, memory, u, w, loads)
    net = u - m.strut_friction(p, m.jacobian_of(p, z) @ v, memory, loads)
    found: Reactions = m.reactions_of(p, z, v, vd, net, loads, w)
    out = [ca.vec(getattr(found, FORCES[name][0])) for name in names]
    return ca.Function("reactions", [theta, z, v, memory, u, w] + ([loads] if m.load_count else []), out)


def columns(row, part, names) -> dict:
    """The logged forces of a chunk, thinned by the slice `part`: vectors (..., joint, axis)."""
    found = {}
    for name in names:
        values = row[name][part]
        vector = FORCES[name][1].dims == VECTOR
        found[name] = values.reshape(*values.shape[:-1], -1, 3) if vector else values
    return found
