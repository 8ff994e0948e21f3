"""Plant: what the machine really is, and what the controller was not told."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from ..declare import Array, Part, quantity
from ..machine.base import Machine
from .faults import EncoderFault


class Plant(Part):
    """A machine with its true numbers, a payload and a steady force on the tool."""

    machine: Machine
    payload: float | None = quantity("kg", "point mass that the tool carries", default=None, above=0)
    payload_center: Array = quantity("m", "where the payload sits, in T", default=[0.0, 0.0, 0.0], shape=(3,))
    wrench: Array = quantity(
        "N, N, N, N m, N m, N m", "steady force and moment on the tool tip, in W", default=[0.0] * 6, shape=(6,)
    )
    offset: Array | None = quantity(
        "m", "how far the tool stands from the program's first place when a run starts, in W", default=None,
        shape=(3,),
    )  # fmt: skip
    friction_drift: float | None = quantity(
        "1/s",
        "all friction grows by so much of its first size a second; below 0 it falls",
        default=None,
        at_least=-1,
        at_most=1,
    )
    faults: list[EncoderFault] = Field(default_factory=list, max_length=32, description="faults of the encoders")

    @property
    def true_machine(self) -> Machine:
        """The machine with its payload."""
        return self.machine if self.payload is None else self.machine.carrying(self.payload, self.payload_center)

    def to_file(self) -> dict[str, Any]:
        """The table that `from_file` reads back; faults are tables of their own."""
        table = super().to_file()
        faults = table.pop("faults")
        return table | ({"faults": [fault.to_file() for fault in faults]} if faults else {})
