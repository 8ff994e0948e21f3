"""Drives of joints: a motor on a screw, or a linear motor, each with an encoder."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..declare import Part, quantity
from ..errors import SheetError


class Drive(Part):
    """What every drive has: an encoder, and perhaps a delay."""

    input_error = SheetError

    encoder: float | None = quantity(
        "m", "resolution of the encoder, at the joint", default=None, above=0, at_most=1e-3
    )
    noise: float | None = quantity(
        "m", "standard deviation of the encoder's noise", default=None, above=0, at_most=1e-2
    )
    delay: float = quantity("1", "samples between a command and its force, 0 or 1", default=0.0, theta=False)

    def model_post_init(self, _context: Any) -> None:
        if self.delay not in (0, 1):
            raise SheetError("must be 0 or 1 samples", key="delay", value=f"{self.delay:g}")


class Screw(Drive):
    """Screw, motor and encoder of each joint."""

    lead: float = quantity("m", "travel a turn of the screw", above=0, at_most=1)
    inertia: float | None = quantity("kg m2", "motor and screw, about the screw", default=None, at_least=0)
    torque_limit: float | None = quantity("N m", "greatest motor torque", default=None, above=0)

    @staticmethod
    def limit_of(p):
        """Greatest joint force, torque_limit 2 pi / lead.  N; None without a limit."""
        return None if p.torque_limit is None else p.torque_limit * 2 * np.pi / p.lead

    def perfect(self) -> Screw:
        """This drive without a limit, and its encoder without steps and noise."""
        return self.replace(encoder=None, noise=None, torque_limit=None)


class LinearMotor(Drive):
    """Linear motor and encoder of each joint; its moving mass is the carriage's."""

    force_limit: float | None = quantity("N", "greatest force of a motor", default=None, above=0)

    @staticmethod
    def limit_of(p):
        """Greatest joint force, N; None without a limit."""
        return p.force_limit

    def perfect(self) -> LinearMotor:
        """This drive without a limit, and its encoder without steps and noise."""
        return self.replace(encoder=None, noise=None, force_limit=None)


def reflected_mass(drive) -> Any:
    """Mass that the turning parts of a screw's drive add to a joint, J (2 pi / lead)^2.  kg."""
    return 0.0 if drive.inertia is None else drive.inertia * (2 * np.pi / drive.lead) ** 2


def force_limit(drive) -> Any:
    """Greatest joint force of a drive or its view.  N; None without a limit."""
    return drive.limit_of(drive)
