"""What every experiment of this study has in common: the machine believed, the machine that is true, what is read.

- Circles: centre (0, 100, -1008) mm, 1000 mm/min and 144 mm are printed, tilts (A, B) = (0, 0) and (-23, 0) deg; A
  is a, about x of W.
- f_0 of 90 N and t_0 of some 8 N m are chosen (MACHINES.md 5.3).  The true friction of a strut is that with bristles,
  a fifth more when it breaks away, 150 N s/m of viscous friction, and up to 10 % more or less than f_0 each; that of
  a joint is 0.2 of the force in it on a radius of 60 mm (base: t_0 at the 700 N of a strut; 2 to 21 N m) and 5 mm.
- The platform's 5 mm and the bristles' 1e8 N/m are chosen.  The paper has no friction in its platform joints, so 0.2 on
  5 mm, a twelfth of the base's; plain spherical joints of 20 to 40 mm can have four times as much, rolling ones a
  twentieth.  1e8 N/m is a presliding of 1 um, as of the preloaded rolling parts of eth-hexaglide; ball screws have 1 to
  10 um.  The page of the study says what comes out over these ranges (tests/study/sensitivity.py).
- The joints' cones are opened to 70 deg: the tilted circle asks for 52 deg of the platform joints, the sheet has 45.
- Torques are read in steps of 0.03 N m, 12 bits of +-60 N m, with noise of 0.05 N m.
"""

from __future__ import annotations

import numpy as np

from ...control.pid import PID
from ...machine.hexapod import Hexapod
from ...machine.hexapod_parts import JointFriction
from ...machine.sheet import load_machine
from ...mechanics.friction import LuGre
from ...program.standard.circle import Circle

PERIOD = 1e-3  # s
CENTER = (0.0, 0.1, -1.008)  # m
FEED = 1.0 / 60  # m/s
RADIUS, TAUGHT = 0.144, 0.1  # m: of the figure, and of the circles to learn from
TILTS = {"0 deg": 0.0, "-23 deg": np.radians(-23.0)}
F_0 = 90.0  # N
SPREAD = np.array([1.0, 0.9, 1.1, 0.95, 1.05, 0.92])  # of f_0, strut by strut
CONE = np.radians(70.0)
STEP, NOISE = 0.03, 0.05  # N m
SETTLE = 0.5  # s, before and behind a circle


def machine() -> Hexapod:
    """What is believed, by design: gough show okuma-pm600, its joints free to CONE."""
    return load_machine("okuma-pm600").replace(**{"limits.cone": CONE})


def true() -> Hexapod:
    """The machine as it is."""
    friction = LuGre(
        coulomb=F_0 * SPREAD, static=1.2 * F_0 * SPREAD, stribeck=2e-3, viscous=150.0, stiffness=1e8, damping=2e5
    )
    joints = machine().joints.replace(
        friction=JointFriction(coefficient=0.2, platform_radius=0.005, base_radius=0.06, smoothing=2e-3)
    )
    return machine().replace(friction=friction, joints=joints)


def planted() -> Hexapod:
    """A machine with the friction of the paper's model and no other, for the limit case; t_0 is 0."""
    return machine().replace(friction=LuGre(coulomb=F_0 * SPREAD, stiffness=1e8, damping=2e5))


def law() -> PID:
    """The loops of the drives."""
    return PID(bandwidth=8.0)


def circle(radius: float, tilt: float, direction: str = "ccw") -> Circle:
    """A circle about CENTER in the plane of x and y, the tool tilted by a = `tilt` rad."""
    origin = np.array([*CENTER, 0.0, 0.0, 0.0])
    return Circle(
        radius=radius, feed=FEED, abc=[tilt, 0.0, 0.0], origin=origin, direction=direction, settle=SETTLE
    )  # fmt: skip


def radius_of(lead: float) -> float:
    """R of eq. (3): force times R is torque, m."""
    return lead / (2 * np.pi)


def read(u, lead: float, seed: int) -> np.ndarray:
    """Motor torques as the current tells them, of forces u (N, n) N: with noise, in steps.  (N, n) N m."""
    noise = NOISE * np.random.default_rng(seed).normal(size=np.shape(u))
    return np.round((np.asarray(u) * radius_of(lead) + noise) / STEP) * STEP
