"""What every experiment of this study has in common: the machine, what is uncertain, the law as printed.

The printed gains b = 40, c = 400, mu_1 = 8, mu_2 = 5, k = 0.5, delta = 0.1 give K = 26 in the unit of each error / s2:
m2 on the circle, 1 on the ellipse, m for the height, m2 / s for the tangential error.  The tangential error along the
path has p_r' as its direction, in those units too.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...control.equivalent_error import EquivalentError
from ...control.path_equations import Conic
from ...machine.sheet import load_machine
from ...machine.tripod import Tripod
from ...simulate.plant import Plant
from ...simulate.run import simulate
from ..study import Tick
from .harmonic import Harmonic

PERIOD, TIME, RATE = 1e-3, 2.0, 6.0  # s, s, rad/s
STEADY = 0.5  # s at the end that count as steady
CENTER = (0.0, 0.1745, -1.4)
CIRCLE, ELLIPSE = (0.05, 0.05), (0.05, 0.03)
CASES = (1.0, 1.25, 1.5)  # true over believed
GAIN, LAYER = (8 + 5) / (1 - 0.5), 0.1  # K and delta as printed
INERTIAS = ("platform.mass", "platform.inertia", "slider.mass", "link.mass")
SCREWS = ("drive.inertia",)


class Course(NamedTuple):
    """One run."""

    t: np.ndarray  # s
    contour: np.ndarray  # m
    x: np.ndarray  # tool tip, (n, 3) m
    torque: float  # greatest of a motor, N m

    @property
    def average(self) -> float:
        """The paper's average contour error, m."""
        return float(self.contour.mean())

    @property
    def steady(self) -> float:
        """Largest contour error of the last STEADY s, m."""
        return float(self.contour[self.t > self.t[-1] - STEADY].max())

    @property
    def settled(self) -> float:
        """When the contour error was above twice its steady largest for the last time, s."""
        above = np.flatnonzero(self.contour > 2 * self.steady)
        return float(self.t[above[-1] + 1]) if len(above) else 0.0


def machine() -> Tripod:
    """`ccu-3prs` as the paper simulates it: no encoder steps, no torque limit."""
    m = load_machine("ccu-3prs")
    return m.replace(drive=m.drive.perfect())


def scaled(m: Tripod, times: float, names=INERTIAS + SCREWS) -> Tripod:
    """The machine with so many times the numbers of `names`."""
    changes = {}
    for name in names:
        part, _, key = name.partition(".")
        changes[name] = times * getattr(getattr(m, part), key)
    return m.replace(**changes)


def law(semi, form: str = "", **options: Any) -> EquivalentError:
    """The law as printed: `form` area on the circle, dimensionless on the ellipse where it is left open."""
    form = form or ("area" if semi[0] == semi[1] else "dimensionless")
    given = {
        "path": Conic(center=CENTER, semi=semi, form=form), "tangential": "power", "strength": GAIN, "boundary": LAYER,
        "coordinates": "linear", "bumpless": False,
    }  # fmt: skip
    return EquivalentError(**{**given, **options})


def program(semi, time: float = TIME) -> Harmonic:
    """The paper's path, at full speed from the first instant on."""
    return Harmonic(semi=semi, rate=RATE, time=time, origin=[*CENTER, 0.0, 0.0, 0.0])


def run(semi, plant: Plant | Tripod, control: Any, tick: Tick | None = None, believed: Tripod | None = None) -> Course:
    """One run of `program(semi)`."""
    signals = ["contour_error", "x", "u"]
    log = simulate(believed or machine(), control, program(semi), plant=plant, signals=signals, progress=tick,
                   on_fail="raise")  # fmt: skip
    return course(log["contour_error"], log["x"], log["u"])


def course(contour, x, u) -> Course:
    """The Course of one run's columns."""
    lead = machine().drive.lead
    return Course(
        np.arange(len(x)) * PERIOD, np.asarray(contour), np.asarray(x), float(np.abs(u).max() * lead / 2 / np.pi)
    )
