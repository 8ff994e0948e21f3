"""Plant: what the machine really is, and what the controller was not told."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..declare import Array, Part, quantity
from ..errors import InputError
from ..machine.base import Machine


class Plant(Part):
    """A machine with its true numbers, a payload and a steady force on the tool."""

    machine: Machine
    payload: float | None = quantity("kg", "point mass carried by the platform", default=None, above=0)
    payload_center: Array = quantity("m", "where the payload sits, in T", default=[0.0, 0.0, 0.0], shape=(3,))
    wrench: Array = quantity(
        "N, N, N, N m, N m, N m", "steady force and moment on the tool tip, in W", default=[0.0] * 6, shape=(6,)
    )

    @classmethod
    def of(cls, machine: Machine, changes: Mapping[str, Any]) -> Plant:
        """The plant of an experiment's [plant] table: a dotted key of the machine is changed, "1.2 x" is a factor.

        Raises
        ------
        InputError
            with a problem for every wrong key.
        """
        own = {key: value for key, value in changes.items() if key in cls.model_fields and key != "machine"}
        rest = {key: value for key, value in changes.items() if key not in own}
        wrong = []
        try:
            machine = machine.replace_from_file(rest)
        except InputError as error:
            wrong += error.problems
        try:
            plant = cls(machine=machine).replace_from_file(own)
        except InputError as error:
            wrong += error.problems
        if wrong:
            raise cls.input_error(problems=wrong)
        return plant

    @property
    def true_machine(self) -> Machine:
        """The machine with the payload in its platform."""
        if self.payload is None:
            return self.machine
        center = np.asarray(self.payload_center)
        tool = getattr(self.machine, "tool", None)
        if tool is not None:  # the platform's numbers are in P
            from ..frames import rotation_of_abc_np

            center = tool.position + rotation_of_abc_np(tool.angles) @ center
        return self.machine.replace(platform=self.machine.platform.joined(self.payload, center))
