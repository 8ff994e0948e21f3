"""What a control loop adds to what a motion asks of the drives: the run itself, with the law and the sample time given.

Inverse dynamics (demand.py) tell the force of the motion; a law of finite bandwidth that is late by its sample time
asks for more behind every step of the acceleration, and encoders with steps for more all along.  How much follows from
no limit of the sheet but from the law, so it is not estimated: the law runs, in the closed loop, on the motion judged.
"""

from __future__ import annotations

import warnings
from typing import Any, NamedTuple

import numpy as np

from ..errors import Problem
from ..machine.drives import force_limit
from .preflight import JOINTS, Preflight

CURE = "a lower acceleration or a jerk_limited profile has no such steps; or a law of less bandwidth"
SIGNALS = ("line", "u_c", "saturated")


class Hit(NamedTuple):
    """A drive that was at its limit on one line."""

    line: int  # of the program; 0: none
    joint: str
    samples: int
    time: float  # s, of the first
    wanted: float  # N, greatest force that the law asked for
    limit: float  # N


class Loop(NamedTuple):
    """How one law drove the program: the drives at their limit, the greatest share of a limit asked for, by which joint
    and on which line; and why the run ended before its time, if it did."""

    law: str
    period: float  # s
    hits: list[Hit]
    use: float | None  # None: the drives have no limit
    joint: str
    line: int
    ended: str | None

    @property
    def passed(self) -> bool:
        """Whether no drive was at its limit and the run came to its end."""
        return not self.hits and self.ended is None

    def problems(self, file: str) -> list[Problem]:
        """What was at its limit as errors tell it."""
        out = [
            Problem(
                f"the drive is at its limit under {self.law}", file=file, line=hit.line or None, where=hit.joint,
                value=f"{hit.wanted:.4g} N wanted", limit=f"{hit.limit:.4g} N", time=hit.time, cure=CURE,
            )
            for hit in self.hits
        ]  # fmt: skip
        if self.ended is not None:
            out.append(Problem(f"the run under {self.law} ended: {self.ended}", file=file))
        return out

    def to_json(self) -> dict[str, Any]:
        """Plain numbers and texts."""
        return {**self._asdict(), "passed": self.passed, "hits": [hit._asdict() for hit in self.hits]}

    def __str__(self) -> str:
        head = f"closed loop, {self.law} at {1e3 * self.period:g} ms: "
        if self.use is None:
            lines = [head + "the drives have no limit of their force"]
        elif not self.hits:
            where = f"line {self.line}, {self.joint}" if self.line else self.joint
            lines = [head + f"no drive reaches its limit; at most {100 * self.use:.1f} % are asked for ({where})"]
        else:
            lines = [head + "drives at their limit, by line:"]
            for hit in self.hits:
                samples = f"{hit.samples} sample{'s' * (hit.samples != 1)}"
                lines.append(
                    f"{hit.line or '':>4}  {hit.joint}  {hit.wanted:.4g} N wanted, {hit.limit:.4g} N is the limit, "
                    f"{samples} from {hit.time:.3f} s on"
                )
        return "\n".join(lines + ([] if self.ended is None else [f"the run ended: {self.ended}"]))


def closed_loop(experiment, found: Preflight) -> list[Loop]:
    """Drive the motion of `found`, the preflight of an experiment's program, under each law of the experiment.

    Raises
    ------
    InputError
        what the experiment says does not fit together.
    """
    from ..simulate.run import simulate

    program, wanted = experiment.program, found.controller == JOINTS
    if getattr(program, "joint_limits", wanted) != wanted:
        program = program.replace(joint_limits=wanted)
    options: dict[str, Any] = {name: getattr(experiment.run, name) for name in type(experiment.run).model_fields}
    options |= {"signals": SIGNALS, "log_every": 1, "on_fail": "return"}
    out = []
    for label, controller in zip(experiment.labels, experiment.controllers, strict=True):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a drive at its limit is told below
            log = simulate(
                experiment.machine, controller.law, program, experiment.plant, observer=experiment.observer,
                compensation=experiment.compensation, **options,
            )  # fmt: skip
        plant = experiment.plant
        machine = experiment.machine if plant is None else plant.machine
        out.append(_told(label, log, machine, experiment.run.period))
    return out


def _told(label: str, log, machine, period: float) -> Loop:
    limit, names = force_limit(machine.drive), machine.joint_names
    ended = None if log.status == "done" else str(log.reason)
    if limit is None:
        return Loop(label, period, [], None, "", 0, ended)
    line, wanted, at_limit = log["line"].astype(int), np.abs(log["u_c"]), log["saturated"].astype(bool)
    hits = []
    for joint in np.flatnonzero(at_limit.any(0)).tolist():
        rows = np.flatnonzero(at_limit[:, joint])
        for number in np.unique(line[rows]).tolist():
            own = rows[line[rows] == number]
            most = float(wanted[own, joint].max())
            hits.append(Hit(number, names[joint], len(own), float(log["t"][own[0]]), most, float(limit)))
    k, joint = np.unravel_index(int(wanted.argmax()), wanted.shape) if wanted.size else (0, 0)
    use = float(wanted.max() / limit) if wanted.size else 0.0
    hits.sort(key=lambda hit: (-hit.wanted, hit.line, hit.joint))
    return Loop(label, period, hits, use, names[joint], int(line[k]) if len(line) else 0, ended)
