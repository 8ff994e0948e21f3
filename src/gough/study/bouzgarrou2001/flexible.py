"""The flexible rows: both laws at both gains on the machine with elastic slides, with and without gravity compensation.

The laws believe the rigid machine; the encoders are on the motors.  Where rest is asked for, runs go on until REST: the
first mode of the cascade's loop at high gains fades with 5 1/s.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...control.base import Controller
from ...control.gravity_compensation import GravityCompensation
from ...control.pid import PID
from ...simulate.loop import closed_loop
from ...simulate.plant import Plant
from ...simulate.run import simulate
from ...simulate.stability import choose_substeps
from ..study import Tick, parts
from .rigid import GAINS, Course
from .setup import END, LAWS, PERIOD, TIME, law, machine, move

REST = 3.0  # s
LEAD = 0.25  # s of rest before the move, in which a compensation sets in
NEAR = 0.1  # m from the target, where the paper's compensation sets in (Fig. 9: "close to desired final position")
WINDOW = 0.2  # s, of the mean at the end
ONE_MASS = "PID, one mass"


class Mode(NamedTuple):
    """The slowest mode of a closed loop that the springs make."""

    frequency: float  # Hz
    damping: float


def follow(control: Controller, program=None, tick: Tick | None = None) -> Course:
    """A motion, by default the paper's move, on the flexible machine."""
    m = machine()
    signals = ["q", "q_r", "x", "x_r", "u"]
    log = simulate(
        m, control, program or move(), plant=Plant(machine=m, flexible=True), period=PERIOD, signals=signals,
        progress=tick, on_fail="raise",
    )  # fmt: skip
    q, q_r, x, x_r, u = (log.dataset[key].values for key in signals)
    return Course(np.arange(len(q)) * PERIOD, q_r - q, (x_r - x)[:, :3], u)


def one_mass(gains) -> PID:
    """The cascade of setup.py with the mean of its three masses at every slide."""
    cascade = law("PID", gains)
    return cascade.replace(mass=float(np.mean(cascade.mass)))


def plain(tick: Tick | None) -> dict[tuple[str, str], Course]:
    """Without compensation, by gains and law."""
    jobs = [(key, name, law(name, gains)) for key, gains in GAINS.items() for name in LAWS]
    jobs += [(key, ONE_MASS, one_mass(gains)) for key, gains in GAINS.items()]
    ticks = parts(tick, [1.0] * len(jobs))
    return {(key, name): follow(control, tick=t) for (key, name, control), t in zip(jobs, ticks, strict=True)}


def compensated(tick: Tick | None) -> dict[tuple[str, str, str], Course]:
    """Under gravity compensation, and without, to rest: by gains, law and how."""
    ways = {"none": None, "target": {"where": "target", "target": END, "distance": NEAR}, "path": {"where": "path"}}
    program = move().replace(lead_in=LEAD, settle=REST - move().times.max())
    jobs = [(key, name, way) for key in GAINS for name in LAWS for way in ways]
    ticks, out = parts(tick, [1.0] * len(jobs)), {}
    for (key, name, way), t in zip(jobs, ticks, strict=True):
        control = law(name, GAINS[key])
        if ways[way] is not None:
            control = GravityCompensation(law=control, **ways[way])
        out[key, name, way] = follow(control, program, t)
    return out


def loop_modes(tick: Tick | None) -> dict[tuple[str, str], Mode]:
    """The first mode of the closed loop at the end of the move that the springs make, by gains and law."""
    true, out = machine().flexible(), {}
    first = true.modes(END).frequency[0]  # with the joints held
    substeps = choose_substeps(true, PERIOD)
    for i, (key, name) in enumerate([(key, name) for key in GAINS for name in LAWS]):
        A = closed_loop(true, law(name, GAINS[key]), PERIOD, substeps, x=END).A
        z = np.linalg.eigvals(A)
        poles = np.log(z[np.abs(z) > 1e-12]) / PERIOD
        poles = poles[poles.imag > 1]
        s = poles[np.argmin(np.abs(np.abs(poles) / (2 * np.pi) - first))]  # the one that held joints would leave
        out[key, name] = Mode(float(np.abs(s) / (2 * np.pi)), float(-s.real / np.abs(s)))
        if tick is not None:
            tick(i + 1, 2 * len(LAWS))
    return out


def at_rest(course: Course) -> np.ndarray:
    """The tip's error x_d - x at the end, mean over WINDOW, m.  (3,)."""
    return course.tip[course.t > course.t[-1] - WINDOW].mean(0)


def swinging(course: Course, since: float = TIME / 2) -> float:
    """Largest distance m of the tip from where it comes to rest, later than `since` s."""
    return float(np.linalg.norm(course.tip - at_rest(course), axis=1)[course.t > since].max())


JOBS: dict[str, Callable[[Tick | None], Any]] = {
    "flexible": plain,
    "flexible, gravity compensated": compensated,
    "flexible, modes of the loop": loop_modes,
}
