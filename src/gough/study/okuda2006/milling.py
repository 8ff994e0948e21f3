"""Second half of the paper: end milling, the force told from the drives, and leaning the spindle against it.

Printed (table 2): A5052, carbide tool of two flutes and 12 mm, 12 000 1/min, 6000 mm/min, down cut, 18 mm axially.
Chosen: 30 deg of helix, and the material (cutting/coefficients.py, A5052: calibrated on table 3).

What the plant knows and the observer does not: all of setup.true() (friction with bristles, viscous, 10 % apart from
strut to strut; friction of the joints under load), torques read in steps with noise, a runout of 5 um, and a tool whose
law is not the one that is believed: of f(d) of the paper its linear part is 10 % more and its quadratic 10 % less.
The believed machine is the data sheet as it is: nothing was learned from circles, the air cut is subtracted.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...control.pid import PID
from ...cutting import Cutting, EndMill, Leaning, Wall
from ...cutting.compensation import Corrected, command
from ...cutting.surface import CutWall, Ran, cut_wall
from ...log import Log
from ...observe.disturbance import DisturbanceObserver
from ...observe.recorded import Recorder
from ...program.standard.line import Line
from ...simulate.leaning import Compensation
from ...simulate.plant import Plant
from ...simulate.run import simulate
from ..study import Experiment, Tick, parts
from . import setup

FEED, SPEED = 0.1, 12_000 * 2 * np.pi / 60  # m/s, rad/s
HEIGHT = 18e-3  # m, axial depth
AIR, LENGTH = 0.04, 0.12  # m: the way to the wall, and along it
DEPTHS = np.array([1.0, 2.0, 2.5, 3.5, 4.0]) * 1e-3  # m, table 2
SHALLOW = np.array([0.1, 0.3, 0.5, 1.0, 2.0]) * 1e-3  # m, figure 9
STAIRS = np.array([0.3, 0.6, 0.9]) * 1e-3  # m, table 3
STEPS = AIR + np.array([0.0, 0.04, 0.08, 0.12])  # m along the path: the wall, its steps, its end
BELIEVED = Leaning()
TRUE = Leaning(linear=1.1 * BELIEVED.linear, quadratic=0.9 * BELIEVED.quadratic)
BANDWIDTH = 10.0  # Hz, of the estimate
SETTLED = 0.012  # m behind a step of the depth, before means are taken: 0.12 s at the feed
TARED = (0.015, AIR - 0.002)  # m of the air cut
DIRECTIONS = {"-Y": np.array([0.0, -1.0, 0.0]), "-X": np.array([-1.0, 0.0, 0.0])}


def law() -> PID:
    """The loops of the drives while the machine cuts."""
    return PID(bandwidth=20.0)


def mill() -> EndMill:
    """The tool, with what nobody measured of it."""
    return EndMill(diameter=12e-3, teeth=2, helix=np.radians(30), extension=0.13, runout=5e-6)


def cut(places, radial) -> Cutting:
    """The cut of a wall in stairs."""
    wall = Wall(axial_depth=HEIGHT, places=np.asarray(places), radial=np.asarray(radial))
    return Cutting(tool=mill(), coefficients="A5052", wall=wall, spindle_speed=SPEED, deflection=TRUE)


def line(direction: str) -> Line:
    """Straight through air, along the wall and out again."""
    way = DIRECTIONS[direction]
    begin = -way * (AIR + LENGTH / 2)
    return Line(begin=begin, to=begin + way * (AIR + LENGTH + 0.02), feed=FEED, settle=0.1)


class Milled(NamedTuple):
    """A run along a wall: what the dynamometer shows, and what the drives tell."""

    s: np.ndarray  # (n,) m along the path
    measured: np.ndarray  # (n, 3) N, on the tool
    estimated: np.ndarray  # (n, 3) N, tared
    wall: CutWall

    def mean(self, what: str, first: float, last: float) -> np.ndarray:
        """Mean force, `measured` or `estimated`, from `first` to `last` m of the path.  (3,) N."""
        return getattr(self, what)[(self.s > first) & (self.s < last)].mean(0)


def milled(direction: str, cutting: Cutting, seed: int, tick: Tick | None = None, **changes) -> Milled:
    """Cut the wall; `changes` are other arguments of simulate, `program` among them."""
    believed, true, nominal = setup.machine(), setup.true(), line(direction)
    log = simulate(
        believed, law(), changes.pop("program", nominal), Plant(machine=true, cutting=cutting), period=setup.PERIOD,
        progress=tick, on_fail="raise", **changes,
    )  # fmt: skip
    s = log["s_r"]
    estimate = told(believed, log, seed)
    estimate -= estimate[(s > TARED[0]) & (s < TARED[1])].mean(0)
    places = np.arange(AIR, AIR + LENGTH, 2.5e-4)
    wall = cut_wall(cutting, nominal.plan(believed).path, Ran.of(_Rows(log)), places)
    return Milled(s, log["cutting_force"][:, :3], estimate, wall)


class _Rows:
    """A Log with its time among its variables."""

    def __init__(self, log: Log):
        self.log = log

    def __getitem__(self, name: str) -> np.ndarray:
        return self.log.t if name == "t" else self.log[name]


def told(believed, log: Log, seed: int) -> np.ndarray:
    """The force on the tool out of readings and torques, by the static form of the paper.  (n, 3) N."""
    lead = believed.drive.lead
    u = setup.read(log["u"], lead, seed) / setup.radius_of(lead)
    observer = DisturbanceObserver(form="static", bandwidth=BANDWIDTH).on(believed, setup.PERIOD)
    before = np.concatenate([u[:1], u[:-1]])
    return Recorder(observer, log["x_r"][0]).rows(log["q_m"], before)["wrench_hat"][:, :3]


def depths(tick: Tick | None) -> dict[str, list[Milled]]:
    """Figures 7 and 8: walls of one depth each, towards -Y and -X."""
    ticks = parts(tick, [1.0] * (len(DEPTHS) * len(DIRECTIONS)))
    out = {}
    for i, direction in enumerate(DIRECTIONS):
        out[direction] = [
            milled(direction, cut(STEPS[[0, -1]], [depth]), 10 * i + j, ticks[i * len(DEPTHS) + j])
            for j, depth in enumerate(DEPTHS)
        ]
    return out


class Relation(NamedTuple):
    """Figures 9 and 10: forces and inclinations of walls of one depth each."""

    force: np.ndarray  # (5,) N, estimated, across the feed
    measured: np.ndarray  # (5,) N
    inclination: np.ndarray  # (5,) rad
    profiles: list[np.ndarray]  # (m,) m each
    z: np.ndarray


def relation(tick: Tick | None) -> Relation:
    """Walls of 0.1 to 2.0 mm towards -Y: how much they lean, and under what force."""
    ticks = parts(tick, [1.0] * len(SHALLOW))
    runs = [milled("-Y", cut(STEPS[[0, -1]], [depth]), 50 + i, ticks[i]) for i, depth in enumerate(SHALLOW)]
    within = AIR + SETTLED, AIR + LENGTH
    return Relation(
        np.array([run.mean("estimated", *within)[0] for run in runs]),
        np.array([run.mean("measured", *within)[0] for run in runs]),
        np.array([run.wall.inclination(*within) for run in runs]),
        [run.wall.along_z(*within) for run in runs],
        runs[0].wall.z,
    )


class Stairs(NamedTuple):
    """The test of table 3: without compensation, with commands from its forces, and leaning in the loop."""

    plain: Milled
    forces: np.ndarray  # (3,) N estimated, across the feed
    tilt: np.ndarray  # (3,) rad
    shift: np.ndarray  # (3,) m
    commanded: Milled
    in_loop: Milled


def stairs(tick: Tick | None) -> Stairs:
    """Stairs of 0.3, 0.6, 0.9 mm towards -Y: cut, told, compensated."""
    ticks = parts(tick, [1.0] * 3)
    cutting = cut(STEPS, STAIRS)
    plain = milled("-Y", cutting, 70, ticks[0])
    forces = np.array([plain.mean("estimated", *within)[0] for within in steps()])
    asked = command(BELIEVED, forces, HEIGHT)
    program = Corrected(program=line("-Y"), places=STEPS, tilt=asked.tilt, height=HEIGHT)
    commanded = milled("-Y", cutting, 71, ticks[1], program=program)
    observer = DisturbanceObserver(form="static", bandwidth=BANDWIDTH)
    leaning = Compensation(height=HEIGHT, law=BELIEVED, air=TARED)
    in_loop = milled("-Y", cutting, 72, ticks[2], observer=observer, compensation=leaning)
    return Stairs(plain, forces, asked.tilt, asked.shift, commanded, in_loop)


def steps() -> list[tuple[float, float]]:
    """From where to where on each step means are taken, m."""
    return [(a + SETTLED, b) for a, b in zip(STEPS[:-1], STEPS[1:], strict=True)]


EXPERIMENTS = (
    Experiment("end milling", depths),
    Experiment("force and inclination", relation),
    Experiment("stairs", stairs),
)
