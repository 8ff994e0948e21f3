"""LinuxCNC itself as the planner: an NC program run by it, headless, and simulated as it would be driven."""

from __future__ import annotations

from .program import RecordedProgram
from .record import Recording, record

__all__ = ["RecordedProgram", "Recording", "record"]
