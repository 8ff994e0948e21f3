"""RecordedProgram: an NC program whose motion is that of LinuxCNC, for one machine."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np
from pydantic import PrivateAttr

from ..errors import ExperimentError
from ..frames import rotation_of_abc_np
from ..program.nc import NCProgram
from ..program.path_check import check_upright
from .motion import RecordedMotion
from .record import Recording


class RecordedProgram(NCProgram):
    """An NC program as LinuxCNC drives it: path and lines are gough's reading, the motion is the recording.

    Contour errors are measured against the path that gough reads.  Made by `RecordedProgram.of(program, recording,
    machine)`; it can be run on that machine alone.
    """

    _recording: Recording | None = PrivateAttr(None)
    _machine: Any = PrivateAttr(None)
    _motion: Any = PrivateAttr(None)

    @classmethod
    def of(cls, program: NCProgram, recording: Recording, machine) -> RecordedProgram:
        """`program` with the motion of `recording`, made on `machine`."""
        made = cls(**{name: getattr(program, name) for name in type(program).model_fields})
        made._recording, made._machine = recording, machine
        return made

    def to_file(self) -> dict[str, Any]:
        found = self._recording
        digest = hashlib.sha256(np.ascontiguousarray(found.joint).tobytes()).hexdigest()
        return super().to_file() | {
            "planner": f"LinuxCNC {found.version}",
            "servo_period": found.period,
            "joints": digest,
        }

    def plan(self, machine) -> RecordedMotion:
        """The recorded motion.

        Raises
        ------
        ExperimentError
            another machine than that of the recording.
        """
        if machine.digest() != self._machine.digest():
            raise ExperimentError(
                "LinuxCNC ran the program on another machine", key="machine", value=machine.name,
                limit=self._machine.name,
            )  # fmt: skip
        if self._motion is None:
            zero = np.asarray(machine.program_zero, float)
            path = self.path().placed(zero[:3], rotation_of_abc_np(zero[3:]))
            if len(machine.task) < 6:
                check_upright(path, machine)
            self._motion = RecordedMotion(path, self._recording, machine, self.settle)
        return self._motion
