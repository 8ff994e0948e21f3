"""Program: what the tool should do, on any machine.  `plan(machine)` gives the Motion that the machine makes of it."""

from __future__ import annotations

from abc import abstractmethod
from typing import Literal

import numpy as np
from pydantic import Field

from ..declare import Array, Part, quantity
from ..frames import rotation_of_abc_np
from .feed import Feed, Limits
from .path import Path
from .reference import Motion, Reference


class Program(Part):
    """Base of all programs: a path in the program's frame, and how to run along it.

    The frame's zero is the machine's home pose, or `origin`: the pose of program zero in W.  The angles of the program
    then turn about its own axes: R_WT = R_WO R(abc).
    """

    acceleration: float | None = quantity(
        "m/s2", "acceleration along the path; else the machine's", default=None, above=0
    )
    corner: Literal["stop", "constant"] = Field("stop", description="stop at every corner, or pass it at constant feed")
    settle: float = quantity("s", "rest behind the end", default=0.25, at_least=0, at_most=3600)
    lead_in: float = quantity("s", "rest before the start", default=0.0, at_least=0, at_most=3600)
    origin: Array | None = quantity(
        "m, m, m, rad, rad, rad", "pose of program zero in W; else the machine's home", default=None, shape=(6,)
    )

    @abstractmethod
    def path(self) -> Path:
        """The path in the program's frame."""

    def plan(self, machine) -> Motion:
        """The motion of `machine` along this program.

        Raises
        ------
        ProgramError
            if the path cannot be followed.
        """
        origin = np.asarray(machine.home if self.origin is None else self.origin, float)
        feed = machine.feed
        limits = Limits(
            feed.rapid, self.acceleration or feed.acceleration, feed.angular_rate, feed.angular_acceleration
        )
        path = self.path().placed(origin[:3], rotation_of_abc_np(origin[3:]))
        return Motion(path, Feed(path, limits, self.corner), machine, self.settle, self.lead_in)

    def sample(self, Ts: float, machine) -> Reference:
        """The whole reference at the period Ts s, the rest at the end included."""
        motion = self.plan(machine)
        return motion.sample(0, motion.count(Ts), Ts)
