"""What came of the supervision of a run: which encoders were flagged, why a stop began, and what its rows belong to."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..errors import EncoderError, FollowingError, RunError
from ..program.reference import Book
from . import supervise, trip
from .notes import EncoderWarning

_CURE = "look at the encoder, its head and its cable; if nothing is wrong, allow more unknown force in encoder_check"


class End(NamedTuple):
    """What supervision says of a run that is over."""

    flags: tuple[tuple[int, float], ...]  # (joint from 0, time s) of each encoder that was flagged, in order of time
    error: RunError | None  # of a stop, whether it came to its end or not


def end_of(asked, simulation, run: int, ticks: int, machine, motion, period: float) -> End:
    """What supervision says of run number `run` of a simulation that had `ticks` good samples."""
    flags: list[tuple[int, float]] = []
    if asked.check is not None:
        since = simulation.state("flagged")[run]
        flags = [(j, (ticks - since[j]) * period) for j in np.flatnonzero(since > 0)]
        flags.sort(key=lambda flag: flag[1])
    error = None
    if asked.ramp is not None and simulation.state("stopping")[run, 0] > 0:
        began = ticks - int(simulation.state("stopping")[run, 0])
        stop = simulation.stops[run]
        ended = stop is not None and stop.label == supervise.AT_REST
        error = _told(simulation.state("cause")[run], began, ticks, ended, machine, motion, period)
    return End(tuple(flags), error)


def first(end: End, error: RunError | None, stop) -> RunError | None:
    """What ended a run: a limit in the middle of a stop, else the stop, else `error`.

    `stop` is the kernel's; without one, `error` is of what the program would have asked for.
    """
    in_the_way = stop is not None and stop.label != supervise.AT_REST
    return error if end.error is None or in_the_way else end.error


def _told(cause, began: int, ticks: int, ended: bool, machine, motion, period: float) -> RunError:
    joint = int(abs(cause[0])) - 1
    how = "brought to rest" if ended else "not yet at rest at the end"
    how = f"{how} in {(ticks - began) * period * 1e3:.4g} ms, the drives are off"
    line = int(motion.book(began, began + 1, period).line[0])
    following = cause[0] < 0
    what = "following error" if following else "its encoder reads what no force explains"
    return (FollowingError if following else EncoderError)(
        f"{machine.joint_names[joint]}: {what}; {how}",
        where=f"NC line {line}" if line else None,
        value=f"{cause[1] * 1e3:.6g} mm",
        limit=f"{cause[2] * 1e3:.6g} mm",
        time=began * period,
        cure=trip.CURE if following else _CURE,
    )


def warn(notes, machine, ends: list[End], labels: list[str] | None = None) -> None:
    """Tell the notes of a run, or of runs with `labels`, which encoders were flagged."""
    hit = [i for i, end in enumerate(ends) if end.flags]
    if not hit:
        return
    joint, time = ends[hit[0]].flags[0]
    text = f"the encoder of {machine.joint_names[joint]} is flagged from t = {time:.6g} s on: it reads what no force "
    text += "explains"
    others = sorted({j for j, _ in ends[hit[0]].flags} - {joint})
    if others:
        text += f"; later those of {', '.join(machine.joint_names[j] for j in others)}"
    if labels is not None:
        text = f"encoders are flagged in {len(hit)} of {len(ends)} runs; in run {labels[hit[0]]} {text}"
    notes.warn(text, EncoderWarning)


def held(book: Book, stopping: np.ndarray, ramp: float, motion, k: int, period: float) -> Book:
    """The book of samples k ..., as it is for runs of which some are `stopping` (n,) or (n, runs).

    From where a stop began its rows belong to that place on the path, and are not counted; the closest point is sought
    as far around it as the way to rest is long.
    """
    if not (stopping > 0).any():
        return book
    lanes = stopping.reshape(len(stopping), -1)
    wide = {name: np.repeat(column[:, None], lanes.shape[1], 1) for name, column in book._asdict().items()}
    for lane in np.flatnonzero((lanes > 0).any(0)):
        first = int(np.argmax(lanes[:, lane] > 0))
        began = k + first - int(lanes[first, lane]) + 1
        there, way = _place(motion, began, period, ramp)
        for name, column in wide.items():
            column[first:, lane] = getattr(there, name)[0]
        wide["window"][first:, lane] += way
        wide["counted"][first:, lane] = False
    return Book(**{name: column.reshape(stopping.shape) for name, column in wide.items()})


def _place(motion, tick: int, period: float, ramp: float) -> tuple[Any, float]:
    """The book of a sample, and the way from its speed to rest, m."""
    speed = np.linalg.norm(motion.sample(tick, tick + 1, period).xd[0, :3])
    return motion.book(tick, tick + 1, period), float(speed**2 / (2 * ramp))
