"""Feeds that every joint can follow: an NC program again, F as fast as the joints' speed, acceleration, force allow.

The caps of caps.py become pieces of constant feed, the program is written with them and judged as it would be driven;
what its ramps still exceed is taken from the caps, and so on until nothing exceeds a limit.  A program that passes is
left as it is, so fixing twice is fixing once.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..errors import ProgramError, RunError, WorkspaceError
from ..program.nc import NCProgram
from .advice import advise, fitting
from .caps import Caps, excess
from .course import state
from .demand import POSE, Demand
from .judge import Found, judge
from .pieces import pieces_of
from .preflight import CARTESIAN, Preflight, planned
from .rewrite import Changed, rewritten

if TYPE_CHECKING:
    from ..simulate.plant import Plant

_ROUNDS = 25
_LOCAL = 6  # rounds in which only what exceeds a limit is slowed; then whole moves are
_COSTS = 0.02  # of the time: ramps that cost more are told of
_LITTLE = 1e-4  # of a speed, that each round takes away at least


class Fixed(NamedTuple):
    """A program whose feeds the joints can follow, the lines that changed, and what both programs ask for.

    `note` says what it costs where the controller's acceleration, which no F changes, is too much for the joints.
    """

    program: NCProgram
    changes: list[Changed]
    before: Preflight
    after: Preflight
    note: str | None = None


def fix_feed(
    machine, program: NCProgram, tell: Callable[[str], None] | None = None, plant: Plant | None = None
) -> Fixed:
    """The program with F words that keep every joint below its greatest speed, acceleration and force.

    It is judged as a controller drives it that knows the limits of the tool and none of the joints ("cartesian"), and
    on the plant where one is given (preflight.py).

    Raises
    ------
    ProgramError
        not an NC program; lines that cannot be changed.
    SheetError
        a machine without limits of its joints.
    WorkspaceError
        a pose outside the limits, which no feed cures, or an acceleration of the controller that the joints cannot
        follow at any feed.
    """
    if not isinstance(program, NCProgram):
        raise ProgramError("only an NC program has feed words", cure="write it as one: gough.program.write.to_gcode")
    demand = Demand(machine, driven=True, plant=plant)
    motion = planned(machine, program, CARTESIAN)
    before = Preflight(motion, demand, judge(motion, demand), program.name, CARTESIAN)
    poses = [finding for finding in before.findings if finding.kind == POSE]
    if poses:
        raise WorkspaceError(problems=[finding.problem(program.name) for finding in poses])
    if before.passed:
        return Fixed(program, [], before, before)
    caps, path = Caps(motion, demand), motion.course.programmed
    at, _ = _excess(motion, demand, before.found)
    slowed = np.unique(motion.course.place(*at).block)  # blocks; those that keep the limits as they are stay
    caps.ask(slowed)
    steady = ramps = None  # how long it would take if only steady feeds counted, and what ramps are fit then
    for round_ in range(_ROUNDS):
        if not (caps.speed[caps.moving] > 0).all():
            raise _no_feed(motion, demand, program, before.found.beyond)
        made = rewritten(program, pieces_of(caps, path, slowed, program.tolerance))
        moved = planned(machine, made.program, CARTESIAN)
        found = judge(moved, demand)
        if tell is not None:
            tell(f"round {round_ + 1}: {len(made.changes)} lines changed, {found.exceeded} limits exceeded")
        if not found.beyond:
            after = Preflight(moved, demand, found, program.name, CARTESIAN)
            return Fixed(made.program, made.changes, before, after, _note(after.duration, steady, ramps))
        if steady is None:
            steady, ramps = moved.duration, _ramps(moved, demand, found)
        at, speed = _excess(moved, demand, found)
        place = moved.course.place(*at)
        block, along = made.back(place.block, place.u)
        known = np.isin(block, slowed)
        caps.lower(block[known], along[known], speed[known])
        if round_ >= _LOCAL:
            caps.ramps(np.unique(block[known]))
        slowed = np.union1d(slowed, block)
        caps.ask(slowed)
    raise _no_feed(moved, demand, program, found.beyond)


def _note(duration: float, steady: float | None, ramps: float | None) -> str | None:
    """What ramps cost, where that is much."""
    if steady is None or duration <= (1 + _COSTS) * steady:
        return None
    return (
        f"{duration - steady:.2f} s are lost to ramps: with an acceleration of {ramps:.3g} m/s2 along the path in the "
        "controller the joints could follow faster feeds"
    )


def _excess(motion, demand: Demand, found: Found):
    """Where the joints exceed a limit: (block, extent) on the course (n,), and the speed at which they do not (n,)."""
    block, u, ud, _, speed = excess(motion, demand)
    more = [np.array([getattr(one, name) for one in found.beyond]) for name in ("block", "u", "ud", "use")]
    block, u, ud = (np.concatenate([a, b]) for a, b in zip((block, u, ud), more, strict=False))
    speed = np.minimum(np.concatenate([speed, more[2] / more[3]]), ud * (1 - _LITTLE))
    moving = ud > 0
    return (block[moving].astype(int), u[moving]), speed[moving]


def _ramps(motion, demand: Demand, found) -> float:
    """The acceleration along the path that the joints can follow at the worst places found.  m/s2."""
    b = [one for one in found.beyond if one.udd]
    if not b:
        return float("inf")
    block, u, ud, udd = (np.array([getattr(one, name) for one in b]) for name in ("block", "u", "ud", "udd"))

    def ask(a):
        here = state(motion, block, u, ud, a)
        return demand.uses(here.x, here.xd, here.xdd)[0][:, demand.pose_count :].max(1)

    return float((fitting(ask, udd) * np.abs(udd)).min())


def _no_feed(motion, demand: Demand, program, beyond) -> RunError:
    """The error that no feed helps, at the places where none does."""
    some = beyond[:20]
    texts = advise(motion, demand, some)
    problems = []
    for b, text in zip(some, texts, strict=True):
        told = demand.told(b.column, b.use)
        problems.append(WorkspaceError(
            f"no feed keeps the {told.kind} within its limit", file=program.name, line=b.line or None,
            where=told.joint, value=told.value, limit=told.limit, time=b.time, cure=text,
        ).problems[0])  # fmt: skip
    return WorkspaceError(problems=problems)
