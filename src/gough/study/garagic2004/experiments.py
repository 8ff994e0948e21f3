"""The experiments of this study as jobs, and what each of them gives to the claims."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..study import Experiment, Tick, parts
from . import bounds, circle, corner, limit, lyapunov
from .corner import Passed
from .setup import CASES, FAST, SLOW, Case, machine

TORQUES = (40.0, 100.0, 300.0, 600.0, 1200.0)  # N m, of the table; after them motors without a limit
WAITS = (0.0, 0.25, 0.5, 0.75, corner.LAST)  # of a sample, between the corner and the sample that sees it
FINE = 1e-4  # s, the sample time at which previewed corners are driven
# 10 kHz with K_D / M = 5000 1/s of the true mass, which a law that believes 0.8 of it has by 6250 1/s
QUICK = {"slope": 2000.0, "damping": 6250.0, "sliding": 0.0}
NOISY = Case("4 kHz and 1 um", FAST.period, SLOW.encoder, FAST.gains)
RAMP = 6  # samples of FINE: 0.6 ms
KNOWN = {"told": 1.0, "inertia_rate": 0.0, "coulomb_rate": 0.0, "viscous_rate": 0.0}
DURATION = 1.2  # s, of one corner, for the progress


class Corners(NamedTuple):
    """What the corner experiments found."""

    waits: dict[tuple[str, str], list[Passed]]  # (law, case): for each of WAITS
    sharp: dict[float, Passed]  # CDAC at FAST without preview, by torque
    previewed: dict[float, tuple[Passed, float]]  # CDAC with preview, by torque; and eq. (2) of bounds.py
    free: Passed  # CDAC with a previewed turn of RAMP samples and motors without a limit
    quick: dict[str, Passed]  # CDAC and FCDAC at 10 kHz with QUICK


def of_circle(law: str, case: Case, **options) -> Callable[[Tick | None], circle.Turn]:
    """A turn of the circle."""
    return lambda tick: circle.turn(law, case, tick, **options)


def waits(tick: Tick | None) -> dict[tuple[str, str], list[Passed]]:
    """The corner under all laws and both cases, at several times between corner and sample; motors without a limit."""
    jobs = [(law, case, wait) for law in ("CCTPID", "CDAC", "FCDAC") for case in CASES for wait in WAITS]
    found: dict[tuple[str, str], list[Passed]] = {}
    for (law, case, wait), part in zip(jobs, parts(tick, [DURATION] * len(jobs)), strict=True):
        passed = corner.passed(law, case.gains, case.period, part, wait=wait)
        found.setdefault((law, case.name), []).append(passed)
    return found


def torques(tick: Tick | None) -> tuple[dict, dict, Passed]:
    """CDAC at every torque: without preview, and with the shortest ramp of whole samples that the torque allows.

    The ramp goes with a law that is told the truth and learns nothing: it shows what a ramp is worth, and not what
    becomes of a wrong feed-forward.  (A law that learns takes what the ramp leaves of the velocity, whose measurement
    is half a sample late, for a wrong mass: M_a's estimate rises by 0.48 within the ramp, and 15 um become 25.)
    """
    ticks = iter(parts(tick, [DURATION] * (2 * len(TORQUES) + 1)))
    sharp, previewed, true = {}, {}, machine()
    for torque in TORQUES:
        sharp[torque] = corner.passed("CDAC", FAST.gains, FAST.period, next(ticks), torque_limit=torque)
        samples = ramp(true, torque)
        passed = corner.passed("CDAC", FAST.gains, FINE, next(ticks), torque_limit=torque, samples=samples, **KNOWN)
        previewed[torque] = passed, bounds.previewed(bounds.jump() / (samples * FINE))
    free = corner.passed("CDAC", FAST.gains, FINE, next(ticks), samples=RAMP, **KNOWN)
    return sharp, previewed, free


def ramp(true, torque: float) -> int:
    """Samples of FINE in which the velocity can turn at the corner with motors of so many N m.

    Even, because the error is greatest in the middle and is measured at samples.
    """
    return 2 * int(np.ceil(bounds.jump() / bounds.straight(true, torque) / FINE / 2 - 1e-9))


def quick(tick: Tick | None) -> dict[str, Passed]:
    """10 kHz and stiff, without preview, the corner on a sample."""
    ticks = parts(tick, [DURATION] * 2)
    return {law: corner.passed(law, QUICK, FINE, part) for law, part in zip(("CDAC", "FCDAC"), ticks, strict=True)}


def limits(tick: Tick | None) -> dict[str, float]:
    """The limit case of both adaptive laws.  Nothing is simulated."""
    return {law: limit.difference(law) for law in ("CDAC", "FCDAC")}


# name -> job; the long ones first, so that two at a time end together
JOBS: dict[str, Callable[[Tick | None], object]] = {
    "Lyapunov function": lyapunov.course,
    **{f"circle, {law}, {case.name}": of_circle(law, case) for law in ("FCDAC", "CDAC", "CCTPID") for case in CASES},
    "corner, every law": waits,
    "circle, CDAC, noise": of_circle("CDAC", NOISY, told=1.0),
    "circle, CDAC, noise learned": of_circle("CDAC", NOISY, told=1.0, regressor="actual"),
    "circle, CDAC, measured sign": of_circle("CDAC", SLOW, friction_speed="measured"),
    "circle, FCDAC, measured sign": of_circle("FCDAC", SLOW, friction_speed="measured"),
    "corner, torque limits": torques,
    "corner, 10 kHz": quick,
    "limit case": limits,
}
EXPERIMENTS = [Experiment(label, work) for label, work in JOBS.items()]


class Results:
    """The results of EXPERIMENTS by their names."""

    def __init__(self, results):
        self.of = dict(zip(JOBS, results, strict=True))

    def turn(self, law: str, case: Case) -> circle.Turn:
        """The circle of a law in a case."""
        return self.of[f"circle, {law}, {case.name}"]

    @property
    def corners(self) -> Corners:
        """All corners."""
        return Corners(self.of["corner, every law"], *self.of["corner, torque limits"], self.of["corner, 10 kHz"])
