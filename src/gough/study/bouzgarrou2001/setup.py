"""What every experiment of this study has in common: the machine, the move, both laws by the printed gains.

- Both laws have the same poles, those of s^3 + k_d s^2 + k_p s + k_i.  Computed torque takes k_d, k_p, k_i; the cascade
  k_P = k_d, k_V and k_I = k_i / k_V of them (control/pid.py), s_d' fed forward, s_d'' not: Fig. 2 shows s_d and s_d'.
- Its mean mass is the diagonal of M_S at the start, chosen: the paper says "a mean mass value".
- The printed low k_p = 2.25e3 is taken for 2.25e4: (300, 2.25e4, 3.75e5) is (600, 9e4, 3e6) at half the pace, and no
  cascade has the poles of the printed one.
- 50 us: the paper simulates laws in continuous time.  Held for a sample, and with speeds of the sample's mean, computed
  torque is some k_d a Ts / 2 k_p behind, 7 um at 20 m/s2 with the low gains; continuous.py has neither.
- Fig. 1 is lost, and with it the side on which arm 1 stands.  The sheet has it at -x; here it is at +x (`mirrored`),
  where slide 1 is the one that the move loads most: the published errors of s21 come out, and else a tenth of them.
- Centres of mass are off in their links' frames, the ram's in that of link 2, which carries it: 20 % of 0.9 m.
"""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np

from ...control.base import Controller
from ...control.computed_torque import ComputedTorque
from ...control.pid import PID
from ...machine.hybrid import Hybrid
from ...machine.sheet import load_machine
from .move import SinusoidalMove


class Gains(NamedTuple):
    """k_d, k_p, k_i of eq. (8), 1/s, 1/s2, 1/s3 (the paper's units lack a newton here and there)."""

    k_d: float
    k_p: float
    k_i: float

    @property
    def roots(self) -> np.ndarray:
        """Of s^3 + k_d s^2 + k_p s + k_i, 1/s."""
        return np.roots([1.0, *self])


LOW, HIGH, PRINTED = Gains(3e2, 2.25e4, 3.75e5), Gains(6e2, 9e4, 3e6), Gains(3e2, 2.25e3, 3.75e5)
PERIOD, TIME = 5e-5, 1.0  # s
START, END = np.array([0.0, 1.2, 0.0]), np.array([-0.315, 1.83, 0.55])  # m
AMPLITUDE = np.array([10.0, 20.0, 20.0])  # m/s2
OFF = 0.2  # of the centres' places


def sheet() -> Hybrid:
    """`ifma-hsm` as the paper simulates it: no encoder steps; forces are looked at, and not limited."""
    m = load_machine("ifma-hsm")
    return m.replace(drive=m.drive.perfect())


def machine() -> Hybrid:
    """The machine of this study: the sheet's, with arm 1 on the other side."""
    return mirrored(sheet())


def move() -> SinusoidalMove:
    """From START to END, then at rest until TIME."""
    made = SinusoidalMove(distance=END - START, amplitude=AMPLITUDE)
    return made.replace(settle=TIME - made.times.max())


def computed_torque(gains: Gains) -> ComputedTorque:
    """Eqs. (7), (8) with the rigid model."""
    return ComputedTorque(error_gains=np.array(gains))


def cascade(gains: Gains) -> PID:
    """Fig. 2 with the same poles."""
    return PID(poles=np.sort(-gains.roots.real), mass=mean_mass())


def mean_mass() -> np.ndarray:
    """The diagonal of M_S at the start.  (3,) kg."""
    return np.diag(machine().velocity_mass(START)).copy()


LAWS = {"computed torque": computed_torque, "PID": cascade}


def law(name: str, gains: Gains) -> Controller:
    """One of LAWS."""
    return LAWS[name](gains)


def perturbed(m: Hybrid) -> list[Hybrid]:
    """The machine with the centres of arms, link 2, link 5 and ram off by OFF, each to both sides: 16 machines."""
    found = []
    for arm, two, five, ram in product((1 - OFF, 1 + OFF), repeat=4):
        aside = np.array([(ram - 1) * m.base.half_width, 0.0, 0.0])
        found.append(m.replace(
            **{
                "arm.center": arm * m.arm.center, "link2.center": two * m.link2.center,
                "link5.center": five * m.link5.center, "ram.center": m.ram.center + aside,
            }
        ))  # fmt: skip
    return found


def mirrored(m: Hybrid) -> Hybrid:
    """The machine with arm 1 on the other side, everything else its mirror image in the plane x = 0."""
    flip = np.array([-1.0, 1.0, 1.0])
    changes = {f"{name}.center": flip * getattr(m, name).center for name in ("link2", "link5", "ram")}
    changes |= {
        f"{name}.inertia": np.outer(flip, flip) * getattr(m, name).inertia for name in ("link2", "link5", "ram")
    }
    return m.replace(
        **changes, home=flip * m.home,
        **{
            "base.half_width": -m.base.half_width, "limits.angle": -m.limits.angle[::-1],
            "limits.passive": -m.limits.passive[::-1],
        },
    )  # fmt: skip
