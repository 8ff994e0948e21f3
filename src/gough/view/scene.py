"""A scene: all that is drawn of a run, as plain arrays; it knows no browser.

Every machine draws itself at a pose as polylines by name (`Machine.drawing`); here they are asked for at some rows of
the log.  The path is drawn with its deviations magnified about the programmed one: along the direction in which the
tool is beside its reference, as far as the contour error says.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..errors import LogError, RunError
from ..log import Log
from ..machine.sheet import machine_class
from ..report.prepare import magnification, path_rows, reversals, tip

LEG = re.compile(r"(?:leg|link) (\d+)$")


class Part(NamedTuple):
    """One polyline of the drawing, and the joint whose force colours it (None: it has its own colour)."""

    name: str
    joint: int | None
    closed: bool


class Reversal(NamedTuple):
    """A reversal of a joint's velocity: when, which (from 0), where the tool was."""

    time: float
    joint: int
    place: np.ndarray  # (3,) m


@dataclass(frozen=True)
class Scene:
    """A run as it is drawn.  Rows are those of the log; `path` are the rows that the path is drawn through."""

    title: str
    word: str  # what a driven joint is called
    t: np.ndarray  # (N,) s
    parts: tuple[Part, ...]
    points: tuple[np.ndarray, ...]  # of each part at home, (k, 3) m: how many it has
    u: np.ndarray  # (N, n) N
    error: np.ndarray  # (N,) m
    path: np.ndarray  # (M,) rows
    programmed: np.ndarray  # (M, 3) m
    deviation: np.ndarray  # (M, 3) m, across the path
    reversals: tuple[Reversal, ...]
    machine: object
    x: np.ndarray  # (N, d) true task coordinates

    @property
    def duration(self) -> float:
        return float(self.t[-1] - self.t[0])

    @property
    def force(self) -> float:
        """The largest force of a joint, N: the end of the colours."""
        finite = np.abs(self.u[np.isfinite(self.u)])
        return float(finite.max()) if finite.size and finite.max() > 0 else 1.0

    @property
    def largest_error(self) -> float:
        """The largest contour error of the drawn path, m: the end of the colours."""
        finite = self.error[np.isfinite(self.error)]
        return float(finite.max()) if finite.size and finite.max() > 0 else 1e-6

    @property
    def extent(self) -> float:
        """How large the machine is, m."""
        return float(np.ptp(np.concatenate(self.points), axis=0).max())

    @property
    def fitting(self) -> float:
        """The magnification that makes the largest deviation a tenth of the path's own size; 1 at least."""
        size = float(np.ptp(self.programmed, axis=0).max())
        return max(1.0, magnification(size / 3, [np.linalg.norm(self.deviation, axis=1)]))

    def row(self, time: float) -> int:
        """The row nearest to a time of the log."""
        i = int(np.searchsorted(self.t, time))
        if i == 0 or (i < len(self.t) and self.t[i] - time <= time - self.t[i - 1]):
            return min(i, len(self.t) - 1)
        return i - 1

    def at(self, row: int) -> list[np.ndarray] | None:
        """The parts' points (k, 3) m at a row; None where the machine cannot be drawn (a run that left its limits)."""
        x = self.x[row]
        if not np.isfinite(x).all():
            return None
        try:
            return [np.asarray(part["points"], float) for part in self.machine.drawing(x)]
        except RunError:
            return None

    def magnified(self, times: float) -> np.ndarray:
        """The driven path with its deviations `times` as large, (M, 3) m."""
        return self.programmed + times * self.deviation


def scene_of(log: Log) -> Scene:
    """The scene of a log with rows.

    Raises
    ------
    LogError
        the log is a batch, has no rows, or does not hold what is drawn.
    """
    if log.batch:
        raise LogError("holds a batch of runs", key="run", cure="pick one: log.run(0).save(...)")
    missing = [name for name in ("x", "x_r", "contour_error", "u") if name not in log]
    if missing or len(log) < 2:
        raise LogError(
            "holds nothing to draw", key=", ".join(missing) or "t", value=f"{len(log)} rows",
            cure="run it with all signals: remove run.signals" if missing else None,
        )  # fmt: skip
    machine = machine_of(log)
    drawn = machine.drawing(machine.home)
    points = tuple(np.asarray(part["points"], float) for part in drawn)
    parts = _parts(machine, [part["name"] for part in drawn], points)
    rows = path_rows(log["contour_error"])
    place, reference = tip(log)[rows], tip(log, "x_r")[rows]
    across = _across(place - reference, reference)
    error = log["contour_error"]
    length = np.linalg.norm(across, axis=1, keepdims=True)
    size = np.nan_to_num(error[rows])[:, None]
    deviation = np.where(length > 0, across / np.where(length > 0, length, 1), 0) * size
    program = log.info.get("program")
    told = [program.get(key) for key in ("name", "kind")] if isinstance(program, dict) else []
    title = next((str(text) for text in told if text), "run")
    all_tips = tip(log)
    marks = tuple(
        Reversal(float(one["time"]), int(one.get("joint") or 0), all_tips[np.searchsorted(log.t, one["time"]) - 1])
        for one in reversals(log, 400)
        if log.t[0] < one["time"] <= log.t[-1]
    )
    return Scene(
        f"{machine.name}, {title}", log.joint_word, log.t, parts, points, log["u"], error, rows, place - deviation,
        deviation, marks, machine, log["x"],
    )  # fmt: skip


def machine_of(log: Log):
    """The machine that a log's laws believed.

    Raises
    ------
    LogError
        the log does not say.
    """
    told = log.info.get("machine")
    if not isinstance(told, dict) or "kind" not in told:
        raise LogError("does not say which machine it is of", key="gough.machine", cure="give a log of gough run")
    data = {name: value for name, value in told.items() if name != "schema"}
    return machine_class(str(told["kind"])).from_file(data)


def _parts(machine, names: list[str], points) -> tuple[Part, ...]:
    """The parts and their joints: by the joint's own name, or as its leg where every joint has one."""
    legs = {name: int(found.group(1)) - 1 for name in names if (found := LEG.match(name))}
    if sorted(legs.values()) != list(range(machine.joints_count)):
        legs = {}
    joints = {name: i for i, name in enumerate(machine.joint_names)} | legs
    closed = [len(at) > 3 and bool(np.allclose(at[0], at[-1])) for at in points]
    return tuple(Part(name, joints.get(name), ring) for name, ring in zip(names, closed, strict=True))


def _across(apart: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """What of (M, 3) is across the path through the references (M, 3)."""
    along = np.gradient(reference, axis=0) if len(reference) > 1 else np.zeros_like(reference)
    size = np.linalg.norm(along, axis=1, keepdims=True)
    along = np.where(size > 0, along / np.where(size > 0, size, 1), 0)
    return apart - (apart * along).sum(1, keepdims=True) * along
