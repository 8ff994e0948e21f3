"""What every experiment of this study has in common: the machine, its sample times and its two laws.

- 300 us for the loop and 900 us for the model are printed; the adaptation runs "every few ms": 3 ms here.
- PD: 20 N/um are printed; the damping is critical for what a motor feels in the mean, 97.6 + 118.7 / 6 = 118 kg.
- Computed torque: w = sqrt(20 N/um / 118 kg) = 412 1/s gives it the stiffness of the PD; w_0 = 1000 1/s is chosen.
- The observer is sampled by Euler's method: the paper prints a differential equation (23) and 300 us, and says no more.
  The exact one is beside it in the table of what goes beyond the paper.
"""

from __future__ import annotations

import numpy as np

from ...control.axis_pd import AxisPD
from ...control.desired_torque_adaptive import DesiredTorqueAdaptive
from ...machine.hexaglide import Hexaglide
from ...machine.sheet import load_machine

PERIOD, MODEL, ADAPTATION = 3e-4, 9e-4, 3e-3  # s
STIFFNESS = 20e6  # N/m
FELT = 97.6 + 118.7 / 6  # kg, a motor and its share of the platform
DAMPING = 2 * np.sqrt(STIFFNESS * FELT)  # N s/m
POLE, OBSERVER_POLE = round(np.sqrt(STIFFNESS / FELT)), 1000.0  # 1/s
WEAK = 0.92  # feed-forward "8 % off"

# Table 1 of the paper as parameters of the machine; learned are these and what the tool axis is assumed to have none of
TRANSLATED = ("carriage.m", "platform.m", "platform.m cz", "friction.coulomb", "friction.viscous")
TURNED = ("platform.Ixx", "platform.Iyy", "platform.Izz")
LEARNED = (*TRANSLATED, "platform.m cx", "platform.m cy", *TURNED)


def machine() -> Hexaglide:
    """The machine of the paper as far as it is known: gough show eth-hexaglide."""
    return load_machine("eth-hexaglide")


def axis_pd() -> AxisPD:
    """The linear axis controllers."""
    return AxisPD(stiffness=STIFFNESS, damping=DAMPING)


def computed_torque(**options) -> DesiredTorqueAdaptive:
    """The nonlinear law with its three rates; it learns nothing unless `options` say so."""
    given = {"observer": "euler", "model_period": MODEL, "adaptation_period": ADAPTATION, "learn": [], **options}
    return DesiredTorqueAdaptive(pole=POLE, observer_pole=OBSERVER_POLE, **given)
