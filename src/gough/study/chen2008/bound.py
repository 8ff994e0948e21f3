"""Why the printed gains cannot hold the printed ellipse at +50 %: what the law has to hold, on the machine itself.

With all inertias s times the believed ones the drives do 1 / s of what is asked and W stays:

    s E_1'' = (s - 1) W_1 - b E_1' - c E_1 - K sat(.)                                                               (12)
    W_1 = 2 (X'^2 / a^2 + Y'^2 / b^2) + F_p p_0'' >= A psi'^2 - B          within TUBE of the ellipse               (13)
    mean of |E_1| over a long time >= ((s - 1) (A w^2 - B) - K) / c        if it stays within TUBE                  (14)

psi is the ellipse's parameter, p_0'' the tool's acceleration when no drive pushes.  docs/theory/equivalent_error.md has
the proof; A and B are found here, on random states of the tube: no bound by interval arithmetic.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ...control.path_equations import frame_at
from ...kernel.building import BUILDING
from ...kernel.pack import flatten
from ...simulate.plant import Plant
from ...simulate.run import simulate
from ..study import Tick
from .setup import CENTER, ELLIPSE, PERIOD, RATE, STEADY, law, machine, program, scaled

TUBE = 80e-6  # m, beside the ellipse and above or below it
ACROSS = 0.02  # m/s, speeds across it
STATES = 2000
A = 1.98  # of eq. (13): 2, less what the tube, F_p and the squares of the speeds in p_0'' take
EDGE = np.arange(1.425, 1.4601, 0.005)  # true over believed
LOST = 10e-6  # m


class Drift(NamedTuple):
    """W_1 at states of the machine."""

    rate: np.ndarray  # psi', rad/s
    value: np.ndarray  # W_1, 1/s2
    free: np.ndarray  # F_p p_0'', the part of it that is the machine's


@lru_cache(maxsize=1)
def _dynamics():
    """The function of W, and a row of the reference to fill in."""
    m = machine()
    control = law(ELLIPSE).on(m, PERIOD)
    row = program(ELLIPSE).sample(PERIOD, m)
    first = type(row)(*(column[0] for column in row))
    with BUILDING:
        return m, control, first, control.error_dynamics(first)


def drift(psi, rate, rho=1.0, height=0.0, swelling=0.0, rising=0.0) -> Drift:
    """W_1 with the tool at X = a rho cos psi, Y = b rho sin psi, Z = height (m), psi (n,) rad.

    It moves with psi' = `rate` rad/s, rho' = `swelling` 1/s and Z' = `rising` m/s.
    """
    m, control, first, function = _dynamics()
    psi, rate, rho, height, swelling, rising = np.broadcast_arrays(psi, rate, rho, height, swelling, rising)
    a, b = ELLIPSE
    cos, sin = np.cos(psi), np.sin(psi)
    x = CENTER + np.stack([a * rho * cos, b * rho * sin, height], -1)
    xd = np.stack([a * (swelling * cos - rho * rate * sin), b * (swelling * sin + rho * rate * cos), rising], -1)
    z, v = m.coordinates(x), (m.jacobian(x) @ xd[..., None])[..., 0]
    frame, row = flatten(frame_at(first.tangent)), flatten(first)
    W = np.array([
        np.array(function(control.theta, one, speed, row, frame, first.xdd[:3])[0])[0, 0]
        for one, speed in zip(z, v, strict=True)
    ])  # fmt: skip
    return Drift(rate, W, W - 2 * (swelling**2 + (rho * rate) ** 2))


@lru_cache(maxsize=1)
def on_the_ellipse() -> np.ndarray:
    """W_1 of a tool that is where the paper's reference is, around the ellipse, 1/s2."""
    return drift(np.linspace(0, 2 * np.pi, 200, endpoint=False), RATE).value


@lru_cache(maxsize=1)
def least() -> float:
    """B of eq. (13), 1/s2: the greatest of A psi'^2 - W_1 over random states of the tube, psi' from 0 to 2 w."""
    rng, beside = np.random.default_rng(0), TUBE / min(ELLIPSE)
    psi, rate = rng.uniform(0, 2 * np.pi, STATES), rng.uniform(0, 2 * RATE, STATES)
    rho, height = 1 + rng.uniform(-beside, beside, STATES), rng.uniform(-TUBE, TUBE, STATES)
    swelling, rising = rng.uniform(-ACROSS, ACROSS, (2, STATES)) / [[min(ELLIPSE)], [1.0]]
    found = drift(psi, rate, rho, height, swelling, rising)
    return float((A * found.rate**2 - found.value).max())


def left_over(times: float) -> float:
    """The right of eq. (14): the mean of |E_1| that the printed gains cannot but leave; below 0 none."""
    control = law(ELLIPSE)
    return ((times - 1) * (A * RATE**2 - least()) - control.strength) / control.stiffness


def of_the_tube() -> float:
    """The largest |E_1| within TUBE of the ellipse: at the ends of the shorter axis."""
    return (1 + TUBE / min(ELLIPSE)) ** 2 - 1


def shares(times: float) -> tuple[float, float]:
    """Least and greatest (s - 1) W_1 over K on the ellipse: above 1 nothing is left to hold E_1 at 0."""
    found = (times - 1) * on_the_ellipse() / law(ELLIPSE).strength
    return float(found.min()), float(found.max())


def edges() -> tuple[float, float]:
    """s from which some of the ellipse, and all of it, cannot be held: 1 + K / W_1."""
    found = 1 + law(ELLIPSE).strength / on_the_ellipse()
    return float(found.min()), float(found.max())


def lost(tick: Tick | None) -> float:
    """The first s of EDGE at which a simulation of the printed ellipse has a steady contour error above LOST."""
    plants = [Plant(machine=scaled(machine(), s)) for s in EDGE]
    log = simulate(machine(), law(ELLIPSE), program(ELLIPSE), plant=plants, signals=["contour_error"], progress=tick)
    error, t = log.dataset["contour_error"].values, log.dataset["t"].values
    above = error[t > t[-1] - STEADY].max(0) > LOST
    return float(EDGE[int(above.argmax())]) if above.any() else float("nan")
