"""The gradient of a run's contour error by the gains of its law, from one run with sensitivities.

    rms^2 = 1/N sum e_k^2,   e_k = |p_k - P(s_k)|, s_k the closest point of the path (measure/contour.py)          (1)
    d rms / dg = 1/(N rms) sum (p_k - P(s_k)) . dp_k/dg                                                            (2)

The closest point moves with g too, but along the path, at right angles to p - P (or it stays on a corner), so it adds
nothing to (2).  dp_k/dg comes of the tick itself (kernel/sensitivity.py), its directions d theta_law/dg and the law's
first state from central differences of what the law makes of its gains when it is bound: a few operations of algebra.

Exact where the run is smooth: friction of curves that fade through zero speed, no rounding of encoders, no drive at
its limit.  What is not is refused by its name.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from .. import kernel as kernels
from ..errors import ExperimentError, InputError, RunError
from ..kernel import noise
from ..kernel.building import BUILDING
from ..kernel.pack import flatten
from ..kernel.sensitivity import named, with_sensitivities
from ..measure.contour import ContourMeter
from ..program.reference import Reference
from . import stability, start
from .columns import tool_rows
from .notes import Notes
from .plant import Plant
from .reach import Reach
from .single import CHUNK
from .supervise import Supervision

STEP = 1e-5  # relative, of the differences of algebra: errors of 1e-10 by curvature and by rounding


class Gradient(NamedTuple):
    """Contour error of a run, rms over its feed moves, m, and its derivative by each gain, m by the gain's SI unit."""

    rms: float
    by_gain: np.ndarray  # (gains,)


def contour_gradient(
    machine, controller, program, plant=None, gains: Sequence[str] = ("bandwidth",), period: float = 1e-3,
    substeps: int | None = None, seed: int = 0,
) -> Gradient:  # fmt: skip
    """The rms contour error of `simulate(...)` and its gradient by `gains`, dotted names of numbers of `controller`.

    Raises
    ------
    ExperimentError
        the run is not smooth: an encoder with a resolution, a drive at its limit, friction or a law that jumps, faults
        of encoders, a cut; a gain that is no single number of the law; a law in plain NumPy.
    RunError
        the run does not come to its end.
    """
    plant = plant if isinstance(plant, Plant) else Plant(machine=machine if plant is None else plant)
    with BUILDING:
        run = _Smooth(machine, controller, program, plant, tuple(gains), period, substeps, seed)
    return run.gradient()


class _Smooth:
    def __init__(self, machine, controller, program, plant, gains, period, substeps, seed):
        self.period, self.machine, self.plant = period, machine, plant
        self.motion = program.plan(machine)
        true = plant.true_machine
        _refuse(true, plant, controller, self.motion)
        self.law = controller.on(machine, period)
        self.ticks = self.motion.count(period)
        first = self.motion.sample(0, 1, period)
        row = Reference(*(column[0] for column in first))
        wanted = stability.choose_substeps(true, period, substeps)
        asked = Supervision(None, None, 0.0, None)
        begun = start.at_rest(machine, true, self.law, plant, row)
        theta, law_state = _directions(controller, machine, period, gains, row, begun.u)
        schedule = start.schedule_of(machine, true, self.law, begun.law, row, period, wanted, 0, asked)
        tool = "z" if true.pose_is_state else "tool"
        try:
            schedule = _with(schedule, len(gains), (tool,))
        except InputError as error:
            raise ExperimentError(
                "the run is not smooth",
                key="controller",
                value=str(error.problems[0].where),
                cure=error.problems[0].cure,
            ) from None
        self.kernel, self.tool = _kernel(schedule), tool
        values = start.parameters(machine, true, self.law, plant, period, 0, asked)
        values[named("theta_law")] = theta.ravel(order="F")
        states = start.states(schedule, begun, row)
        for signal in schedule.of_kind("state"):
            if signal.name not in states:
                states[signal.name] = np.zeros(signal.size)
        if named("law") in states:
            states[named("law")] = law_state.ravel(order="F")
        self.simulation = self.kernel.start(values, states, runs=1, keys=[noise.run_key(seed, 0)])
        self.reach = Reach(machine, self.motion, period, Notes())
        self.gains = gains

    def gradient(self) -> Gradient:
        meter, path, k = ContourMeter(self.motion), self.motion.path, 0
        squares, slopes, count = 0.0, np.zeros(len(self.gains)), 0
        while k < self.ticks:
            n = min(CHUNK, self.ticks - k)
            reference = self.motion.sample(k, k + n, self.period)
            good, error = self.reach.of(k, reference.x)
            if error is not None:
                raise error
            rows = self.simulation.advance(n, start.inputs(reference, k, self.kernel.schedule))
            if not self.simulation.alive.all():
                stop = self.simulation.stops[0]
                raise RunError("the run ends before its program", where=stop.label, value=f"at t = {stop.time:.4g} s")
            row = {name: rows[:, 0, where] for name, where in self.kernel.columns.items()}
            if row["saturated"].any():
                raise ExperimentError(
                    "the run is not smooth: a drive is at its limit", key="controller",
                    value=f"at t = {(k + int(np.argmax(row['saturated'].any(1)))) * self.period:.4g} s",
                    cure="lower the gains or the feed",
                )  # fmt: skip
            book = self.motion.book(k, k + n, self.period)
            p = tool_rows(row)[:, :3]
            distance, at, s = meter.closest(p, book.s, book.window, book.block)
            across = p - path.point(at, s - path.s0[at])
            size = self.kernel.schedule.by_name[self.tool].size
            dp = row[named(self.tool)].reshape(n, len(self.gains), size)[:, :, :3]
            counted = np.asarray(book.counted, bool)
            squares += float((distance[counted] ** 2).sum())
            slopes += np.einsum("ki,kgi->g", across[counted], dp[counted])
            count += int(counted.sum())
            k += n
        rms = float(np.sqrt(squares / count)) if count else 0.0
        if not rms:
            raise ExperimentError(
                "has no gradient: the tool is on its path in every sample", key="program",
                cure="run a path that can be left, with feed moves",
            )  # fmt: skip
        return Gradient(rms, slopes / (count * rms))


@lru_cache(maxsize=16)
def _with(schedule, directions: int, log: tuple[str, ...]):
    return with_sensitivities(schedule, "theta_law", directions, log)


@lru_cache(maxsize=16)
def _kernel(schedule):
    return kernels.compile(schedule, lanes=1)


def _refuse(true, plant, controller, motion) -> None:
    """Refuse by name what makes a run jump, or what is not carried through."""
    found = None
    if true.drive.encoder is not None:
        found = "plant.drive.encoder", "an encoder that counts", 'write "drive.encoder" = "none" in [plant]'
    elif not controller.symbolic:
        found = "controller", "a law in plain NumPy", "write the step in CasADi's operations"
    elif plant.faults:
        found = "plant.faults", "faults of encoders", "leave them out"
    elif plant.cutting is not None:
        found = "plant.cutting", "teeth that enter and leave", "leave the cut out"
    elif plant.friction_drift is not None:
        found = "plant.friction_drift", "friction that drifts", "leave it out"
    elif motion.path.tool.any():
        found = "tools", "another tool than T", "measure at T"
    if found is not None:
        raise ExperimentError("has no gradient: the run is not smooth", key=found[0], value=found[1], cure=found[2])


def _directions(controller, machine, period, gains, row, u0):
    """d theta_law / d gain and d(first state) / d gain: (theta, gains), (state, gains)."""
    thetas, states = [], []
    for name in gains:
        part = controller
        for key in name.split("."):
            part = getattr(part, key, None)
        if not isinstance(part, int | float) or isinstance(part, bool):
            raise ExperimentError("is no single number of the law", key=f"controller.{name}")

        def numbers(value, name=name):
            law = controller.replace(**{name: value}).on(machine, period)
            return law.theta, np.asarray(flatten(law.init(row, u0)), float).ravel()

        h = STEP * (abs(part) or 1.0)
        try:
            ends = [(1, numbers(part + h)), (-1, numbers(part - h))]
        except InputError:  # at a bound of the number: inwards, to the same order
            side = 1 if _may_be(controller, name, part + 2 * h) else -1
            ends = [
                (-3 * side, numbers(part)),
                (4 * side, numbers(part + side * h)),
                (-side, numbers(part + 2 * side * h)),
            ]
        thetas.append(sum(weight * end[0] for weight, end in ends) / (2 * h))
        states.append(sum(weight * end[1] for weight, end in ends) / (2 * h))
    return np.array(thetas).T, np.array(states).T


def _may_be(controller, name: str, value: float) -> bool:
    try:
        controller.replace(**{name: value})
    except InputError:
        return False
    return True
