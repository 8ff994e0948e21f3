"""What every experiment of this study has in common: the machine, the two cases, what is believed, and the tuned laws.

Tuning, from the starting gains of the design notes (Lambda 150 and 300 1/s, K_D / M 380 and 760 1/s):

- K_D = sqrt(D) M(home) sqrt(D), by `damping`, and not a diagonal matrix: home's M couples translation and rotation,
  and with the coupling left out the first 25 ms turn the tool twice as far.
- K_D / M times the sample time is 0.4 at 1 kHz, where the encoder's count sets the end (1 um in 1 ms is 1 mm/s), and
  0.19 at 4 kHz.  slope is about half of damping.
- `sliding` 400 N covers what Stribeck's rise adds over Coulomb's level in one strut, 0.06 of 1 to 3 kN, and friction
  of the joints.
- `coulomb_rate` 20 1/J learns a strut's friction within the tenth of a second after its first move.
- `leakage_norm` 1.5: the true factors are 1 / 0.8 = 1.25, and the leak may pull back only what is above the truth.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...control.computed_torque import ComputedTorque
from ...control.fuzzy_friction import FuzzyFriction
from ...control.robust_adaptive import RobustAdaptive
from ...machine.hexapod import Hexapod
from ...machine.sheet import load_machine

WRONG = 0.8  # believed over true: "parameters 20 % off"
LAWS = ("CCTPID", "CDAC", "FCDAC")
TRUTH = 1 / WRONG  # what the estimates, factors on the believed, would have to become

# numbers of the sheet that the adaptive laws are told wrong, all of them by WRONG
TOLD_WRONG = (
    "platform.mass", "platform.inertia", "strut.moving.mass", "strut.moving.transverse", "strut.fixed.mass",
    "strut.fixed.transverse", "drive.inertia", "friction.coulomb", "friction.viscous", "friction.viscous_offset",
)  # fmt: skip


class Case(NamedTuple):
    """A sample time, an encoder, and the gains that go with them."""

    name: str
    period: float  # s
    encoder: float  # m
    gains: dict[str, float]


SLOW = Case("1 kHz and 1 um", 1e-3, 1e-6, {"slope": 200.0, "damping": 400.0, "sliding": 400.0})
FAST = Case("4 kHz and 0.1 um", 2.5e-4, 1e-7, {"slope": 300.0, "damping": 750.0, "sliding": 400.0})
CASES = (FAST, SLOW)


def machine(encoder: float = FAST.encoder, torque_limit: float | None = 40.0) -> Hexapod:
    """`nist-octahedral` with an encoder of so many m and motors of so many N m, None for motors without a limit."""
    changes = {"drive.encoder": encoder, "drive.torque_limit": torque_limit}
    return load_machine("nist-octahedral").replace(**changes)


def believed(true: Hexapod, times: float = WRONG) -> Hexapod:
    """What an adaptive law is told of the machine `true`: its numbers TOLD_WRONG times a factor."""
    known = [name for name in TOLD_WRONG if _has(true, name)]
    return true.replace(**{name: times * np.asarray(_value(true, name)) if np.ndim(_value(true, name))
                           else times * _value(true, name) for name in known})  # fmt: skip


def law(name: str, gains: dict[str, float], **options):
    """A law of LAWS with its tuning; `gains` are those of a case, `options` go over everything."""
    if name == "CCTPID":
        return ComputedTorque(poles=np.array([100.0, 100.0, 200.0]))
    common = {**gains, "inertia_rate": 0.3, "leakage_norm": 1.5}
    if name == "CDAC":
        return RobustAdaptive(**{**common, "coulomb_rate": 20.0, **options})
    return FuzzyFriction(**{**common, "friction_rate": 2e7, **options})


def _value(part, name: str):
    for key in name.split("."):
        part = getattr(part, key)
    return part


def _has(part, name: str) -> bool:
    for key in name.split("."):
        part = getattr(part, key, None)
    return part is not None
