"""Program: what the tool should do, on any machine.  `plan(machine)` gives the Motion that the machine makes of it."""

from __future__ import annotations

import functools
import threading
from abc import abstractmethod
from typing import Literal

import numpy as np
from pydantic import Field, model_validator

from ..declare import Array, Part, quantity
from ..errors import ExperimentError
from ..frames import rotation_of_abc_np
from .course import Rules, course_of
from .feed import Feed, Limits
from .path import Path
from .path_check import check_one_axis, check_upright
from .progress import tell
from .reference import Motion, Reference
from .shaper import Shaper, shaper_of


class Program(Part):
    """Base of all programs: a path in the program's frame, and how to run along it.

    The frame's zero is the machine's home pose, or `origin`: the pose of program zero in W.  The angles of the program
    then turn about its own axes: R_WT = R_WO R(abc).
    """

    acceleration: float | None = quantity(
        "m/s2", "acceleration along the path; else the machine's", default=None, above=0
    )
    corner: Literal["stop", "constant", "blend"] | None = Field(
        None,
        description="stop at every corner, pass it at constant feed, or round it within `tolerance`; else what an "
        "NC program says (G61, G61.1, G64), else stop",
    )
    tolerance: float = quantity(
        "m", 'how far a rounded corner may leave the path: with corner = "blend", and for G64 without P',
        default=20e-6, above=0, at_most=0.1,
    )  # fmt: skip
    axis_tolerance: float | None = quantity(
        "rad", "how far the tool axis may leave that of the path; else what turns a tool of 100 mm by the tolerance",
        default=None, above=0, at_most=1,
    )  # fmt: skip
    spline: bool = Field(False, description="run short lines as one smooth curve, where that stays in the tolerance")
    profile: Literal["trapezoid", "jerk_limited"] = Field("trapezoid", description="how the feed changes its speed")
    jerk: float | None = quantity(
        "m/s3", "jerk along the path, if jerk limited; else the machine's", default=None, above=0
    )
    joint_limits: bool = Field(False, description="slow down where a joint would exceed its speed or acceleration")
    shaper: Literal["zv", "zvd", "ei"] | None = Field(
        None, description="run each stretch between rests so that it leaves a mode of the machine at rest"
    )
    shaper_frequency: float | Array | None = quantity(
        "Hz", "natural frequency of that mode; up to four", default=None, above=0, shape=(-1,)
    )
    shaper_damping: float = quantity("1", "damping ratio of that mode", default=0.0, at_least=0, below=1)
    settle: float = quantity("s", "rest behind the end", default=0.25, at_least=0, at_most=3600)
    lead_in: float = quantity("s", "rest before the start", default=0.0, at_least=0, at_most=3600)
    origin: Array | None = quantity(
        "m, m, m, rad, rad, rad", "pose of program zero in W; else the machine's home", default=None, shape=(6,)
    )

    @model_validator(mode="after")
    def _shaped(self):
        if self.shaper is None and self.shaper_frequency is not None:
            raise ExperimentError("is for a shaper", key="shaper_frequency", cure='write shaper = "zvd" beside it')
        if self.shaper is not None:
            if self.shaper_frequency is None:
                raise ExperimentError("is missing", key="shaper_frequency", cure='write shaper_frequency = "49 Hz"')
            self.shaping()  # refused here, with its key
        return self

    def shaping(self) -> Shaper | None:
        """The impulses of `shaper`; None without."""
        return shaper_of(self.shaper, self.shaper_frequency, self.shaper_damping) if self.shaper is not None else None

    @abstractmethod
    def path(self) -> Path:
        """The path in the program's frame."""

    def plan(self, machine) -> Motion:
        """The motion of `machine` along this program.  The last one is kept: two laws on one program plan once.

        Raises
        ------
        ProgramError
            if the path cannot be followed.
        """
        with _PLANNING:
            return _planned(self, machine)

    @property
    def rules(self) -> Rules:
        """What may happen at corners, as options of the course."""
        smooth = self.profile == "jerk_limited"  # its speed knows no jump of the acceleration towards the centre
        return Rules(self.corner, self.tolerance, self.axis_tolerance, self.spline, smooth)

    def sample(self, Ts: float, machine) -> Reference:
        """The whole reference at the period Ts s, the rest at the end included."""
        motion = self.plan(machine)
        return motion.sample(0, motion.count(Ts), Ts)


_PLANNING = threading.RLock()  # two runs of one program that start together plan it once


@functools.lru_cache(maxsize=1)
def _planned(program: Program, machine) -> Motion:
    origin = np.asarray(machine.program_zero if program.origin is None else program.origin, float)
    feed = machine.feed
    limits = Limits(
        feed.rapid,
        program.acceleration or feed.acceleration,
        feed.angular_rate,
        feed.angular_acceleration,
        program.jerk or feed.jerk,
    )
    path = program.path().placed(origin[:3], rotation_of_abc_np(origin[3:]))
    if len(machine.task) < 6:
        check_upright(path, machine)
    if len(machine.task) == 1:
        check_one_axis(path, machine)
    tell("planning", 0.0)
    limits = limits if program.profile == "jerk_limited" else limits._replace(jerk=None)
    course = course_of(path, program.rules, limits)
    tell("planning", 0.5)
    jointed = machine if program.joint_limits else None
    planned = Feed(course.path, limits, program.corner, program.profile, jointed, program.shaping())
    tell("planning", 1.0)
    return Motion(path, course, planned, machine, program.settle, program.lead_in)
