"""Plant: what the machine really is, and what the controller was not told."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field, model_validator

from ..cutting.cutting import Cutting
from ..declare import Array, Part, quantity
from ..errors import ExperimentError
from ..machine.base import Machine
from .faults import EncoderFault


class Plant(Part):
    """A machine with its true numbers, a payload and a steady force on the tool."""

    machine: Machine
    payload: float | None = quantity("kg", "point mass that the tool carries", default=None, at_least=0)
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
    flexible: bool = Field(False, description="whether the joints of [[compliance]] are elastic")
    measured: Literal["motor", "joint"] | None = Field(
        None, description="where encoders of a flexible machine are: at the motors, or at the joints behind the springs"
    )
    stiffness: float | None = quantity("1", "factor on all stiffness of [[compliance]]", default=None, above=0)
    cutting: Cutting | None = Field(None, description="the cut that the tool makes along the program's path")
    faults: list[EncoderFault] = Field(default_factory=list, max_length=32, description="faults of the encoders")

    @model_validator(mode="after")
    def _elastic(self):
        if self.machine.rigid is not self.machine:
            raise ExperimentError(
                "a plant makes its machine flexible itself", key="machine", cure="give machine.rigid and flexible=True"
            )
        for key in ("measured", "stiffness"):
            if getattr(self, key) is not None and not self.flexible:
                raise ExperimentError("is for flexible machines", key=key, cure="write flexible = true beside it")
        if self.flexible:
            self._elastic_of(self.machine)  # refused here, with its key
        return self

    def _elastic_of(self, machine: Machine) -> Machine:
        return machine.flexible(self.measured or "motor", self.stiffness or 1.0)

    @property
    def true_machine(self) -> Machine:
        """The machine with its payload, and with its elastic joints where it is flexible."""
        loaded = self.machine if self.payload is None else self.machine.carrying(self.payload, self.payload_center)
        return self._elastic_of(loaded) if self.flexible else loaded

    def to_file(self) -> dict[str, Any]:
        """The table that `from_file` reads back."""
        return {key: value for key, value in super().to_file().items() if value not in ([], False)}
