"""Motions that show the parameters: a finite Fourier series in task coordinates, from rest to rest, by optimisation.

With X the base columns of the regressor at m times of the period, each times its parameter's size, M = X' X / m, and c
the coefficients of the series with K harmonics,

    minimise f(M) over c, close to the logarithm of the condition number of X                                      (1)
    subject to g_j(t) >= KEEP at all times t, for all limits j                                                     (2)
               sum over k of k sine_k = 0,   sum over k of k^2 cosine_k = 0                                        (3)

with g_j the workspace, strokes, cones, distance from a singularity, speed, acceleration and force of every joint, and
the speed of the tool, as shares.  The size of a parameter is its value; of a first moment or an inertia that is 0, what
its body's mass makes usual (base.py): so the condition number is how many times surer the best known combination is
than the worst, as shares.  f is that of criterion.py, c is written in a basis of (3) (series.py), and search.py has
IPOPT solve it from a start that a seed decides; what it does not call solved is an error.
Swevers et al., IEEE Trans. Robotics and Automation 13(5), 1997, for the series; docs/theory/identification.md.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import ExperimentError, WorkspaceError, did_you_mean
from ..kernel.building import BUILDING
from ..machine.base import Machine
from ..program.standard.fourier import Fourier
from ..simulate.reach import check_motion
from .base import BaseParameters, base_parameters
from .criterion import CRITERIA
from .design import Design, design_of, speed_of, structural
from .regress import chosen_of
from .rows import rows_of_motion
from .search import Times, limits_at, search
from .series import moments, program_of, times

_POINTS = 8  # times in the shortest period: the forces have harmonics up to about three times the pose's
_CHECKED = 56  # times at which limits are looked at: a sine is 0.2 % from its peak between them
_SHRINK = 0.7
_ROOM = 0.15  # of each limit, left by the start
_CROSSINGS = 5  # of the workspace at full speed, in the period that is taken where none is given
_SHORTEST, _LONGEST = 1.0, 10.0  # s, of that period


def excite(
    machine: Machine,
    period: float | None = None,
    cycles: int = 1,
    harmonics: int = 5,
    free: Sequence[str] | None = None,
    friction: Sequence[str] = ("coulomb", "viscous"),
    seed: int = 0,
    *,
    criterion: str = "condition",
    tool_speed: float | None = None,
) -> Fourier:
    """A periodic motion of `machine` about its home that shows its parameters best, eqs. (1)-(3).

    period      s; left out, five times as long as the tool takes across its workspace, from 1 to 10 s
    free        the parameters that matter, as for `identify`
    seed        of the start of the search.  The same arguments give the same motion
    criterion   "condition": the least condition number, all parameters about equally sure; "volume": the least volume
                of the estimate's ellipsoid, whatever the parameters' sizes
    tool_speed  m/s, the greatest speed of the tool's tip; left out, feed.rapid of the machine

    Raises
    ------
    ExperimentError
        arguments out of bounds, `free` names nothing.
    WorkspaceError
        no motion about home is within the limits.
    RunError
        the optimiser did not converge, or what it found leaves a limit between its times: no motion is given.
    """
    if criterion not in CRITERIA:
        cure = did_you_mean(str(criterion), tuple(CRITERIA))
        raise ExperimentError("no such criterion", key="criterion", value=str(criterion)[:60], cure=cure)
    if tool_speed is not None and not (np.isfinite(tool_speed) and tool_speed > 0):
        raise ExperimentError("must be above 0 m/s", key="tool_speed", value=f"{tool_speed}")
    period = usual_period(machine, tool_speed) if period is None else period
    if not (np.isfinite(period) and period > 0 and 2 <= harmonics <= 32):
        raise ExperimentError("period must be above 0 s and harmonics from 2 to 32", value=f"{period}, {harmonics}")
    names = structural(machine, friction)[2].names
    design = design_of(machine, None if free is None else chosen_of(names, free), friction, tool_speed)
    columns, count = len(machine.task), _CHECKED * harmonics
    seen, dense = (moments(times(period, n), period, harmonics, columns) for n in (_POINTS * harmonics, count))
    start = start_of(design, dense, harmonics, seed)
    with BUILDING:
        best = CRITERIA[criterion](len(design.kept))
    found = search(design, Times(seen, dense, period / count), start, best)
    program = program_of(found, period, cycles, harmonics, columns)
    check_motion(machine, program.plan(machine), period / count)
    return program


def shown(machine: Machine, program, friction: Sequence[str] = ("coulomb", "viscous"), period: float = 0.01):
    """What a planned program shows if only rounding limits it: BaseParameters, with the condition number."""
    motion = program.plan(machine)
    r = motion.sample(0, motion.count(period), period)
    rows = rows_of_motion(machine, r.x, r.xd, r.xdd, np.zeros((len(r.x), machine.joints_count)), friction)
    size = structural(machine, friction)[1]
    found: BaseParameters = base_parameters(
        rows.Y.reshape(-1, len(size)) * size, rows.names, rows.units, size, noise=False
    )
    return found


def usual_period(machine: Machine, tool_speed: float | None = None) -> float:
    """The period that is taken where none is given.  s."""
    space, travel = machine.limits.workspace, getattr(machine.limits, "travel", None)
    if space is not None:
        across = 2 * space.radius if space.size is None else float(np.min(space.size))
    elif travel is not None:
        across = float(np.ptp(travel))
    else:
        return _LONGEST
    speed = min(speed_of(machine), tool_speed or machine.feed.rapid)
    return float(np.clip(_CROSSINGS * across / speed, _SHORTEST, _LONGEST))


def start_of(design: Design, G, K: int, seed: int) -> np.ndarray:
    """Random free numbers, made smaller until every limit holds at the times of G (m, 18, k).  (k,).

    Raises
    ------
    WorkspaceError
        however small they are, a limit does not.
    """
    f = 2 * (K - 1)
    c = 0.1 * np.random.default_rng(seed).standard_normal((G.shape[-1] // f, f)) / np.tile(np.arange(2, K + 1), 2)
    c = c.reshape(-1)
    for _ in range(60):
        g = limits_at(design, G, c)
        if g.min() > _ROOM:
            return c
        c = c * _SHRINK
    worst = design.limits[int(np.argmin(g.min(1)))]
    raise WorkspaceError(
        "no motion about home is within the limits", where=worst, cure="check home, limits and feed of the machine"
    )
