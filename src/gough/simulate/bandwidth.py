"""Bandwidth of a closed loop, and the gains that give a wanted one.

    |G(2 pi i f)| = |G(0)| / sqrt(2),   G from the reference pose to the pose of the tool along one axis            (1)

at the lowest such f: the -3 dB of the linearised loop at home (loop.py), without friction, with adaptation frozen.
Only x_r moves, the reference's rates stay 0, so feedforward of a moving reference counts for nothing: (1) compares what
feedback is worth.
"""

from __future__ import annotations

import math

import numpy as np

from ..errors import ExperimentError, did_you_mean
from .law_tasks import cycle
from .loop import closed_loop
from .stability import choose_substeps

AXES = ("x", "y", "z", "rx", "ry", "rz")  # displacement of the tool: along and about the axes of W
LOWEST = 1e-2  # Hz; where the search begins
FINE = 60  # points a decade


def bandwidth_of(machine, law, period: float, axis: str = "x", substeps: int | None = None) -> float:
    """Bandwidth of `law` on `machine` along a task axis at home, Hz, eq. (1); `period` s is that of the sample.

    Raises
    ------
    ExperimentError
        no such axis; the loop is unstable; no bandwidth below half the sampling rate.
    """
    law = law.on(machine, period)
    if substeps is None:
        substeps = choose_substeps(machine, period)
    return _bandwidth(machine, law, period, _index(machine, axis), substeps)


def with_bandwidth(machine, law, wanted: float, period: float, axis: str = "x", substeps: int | None = None):
    """`law` with its `tuned` numbers all times one factor, so that `bandwidth_of` is `wanted` Hz to 1 part in 1e6.

    For laws with a slope and a damping their ratio stays what it is.

    Raises
    ------
    ExperimentError
        the law says nothing of what tunes it; no gains give the bandwidth before the loop is unstable.
    """
    names = [name for name in law.tuned if getattr(law, name) is not None]
    if not names:
        raise ExperimentError("the law does not say which numbers tune it", key="controller", value=type(law).__name__,
                              cure='name them in its class: tuned: ClassVar = ("bandwidth",)')  # fmt: skip
    index = _index(machine, axis)
    if substeps is None:
        substeps = choose_substeps(machine, period)

    def times(factor):
        return law.replace(**{name: np.multiply(getattr(law, name), factor) for name in names})

    def excess(log_factor):
        try:
            found = _bandwidth(machine, times(math.exp(log_factor)).on(machine, period), period, index, substeps)
        except ExperimentError:
            return 1.0  # too fast for the period
        return min(math.log(found / wanted), 1.0)

    low = high = 0.0
    while excess(low) > 0 and low > -12:
        low -= 0.5
    while excess(high) < 0 and high < 12:
        high += 0.5
    best = _root(excess, low, high) if excess(low) <= 0 <= excess(high) else high
    if not abs(excess(best)) < 1e-6:
        raise ExperimentError(
            f"{law.kind}: no gains give this bandwidth along {axis} at a period of {period * 1e3:g} ms",
            key="controller", value=f"{wanted:g} Hz", cure="ask for less, or shorten the period",
        )  # fmt: skip
    return times(math.exp(best))


def response(space, period: float, f, index: int) -> np.ndarray:
    """G of a discrete state space at the frequencies f (n,) Hz, from input to output `index`.  (n,) complex."""
    A, B, C, D = space
    z = np.exp(2j * np.pi * np.asarray(f) * period)
    found = np.linalg.solve(z[:, None, None] * np.eye(len(A)) - A, np.broadcast_to(B[:, [index]], (len(z), len(A), 1)))
    return (C[index] @ found)[:, 0] + D[index, index]


def _bandwidth(machine, law, period, index, substeps) -> float:
    space = closed_loop(machine, law, period, substeps)
    radius = np.abs(np.linalg.eigvals(space.A)).max()
    if radius > 1 + 1e-6:  # stability.check_loop's margin
        raise ExperimentError(
            f"{law.kind}: a loop that is unstable at a period of {law.period * 1e3:g} ms has no bandwidth",
            key="controller", value=f"spectral radius {radius:.6g} a sample", limit="1", cure="lower the gains",
        )  # fmt: skip
    step = cycle(law, period)
    nyquist = 0.5 / step
    f = np.geomspace(LOWEST, nyquist, max(2, math.ceil(FINE * math.log10(nyquist / LOWEST))))
    still = abs(response(space, step, [0.0], index)[0])
    low = np.flatnonzero(np.abs(response(space, step, f, index)) < still / math.sqrt(2))
    if not len(low) or low[0] == 0:
        raise ExperimentError(
            f"{law.kind}: no bandwidth between {LOWEST:g} Hz and half the sampling rate", key="controller",
            limit=f"{nyquist:g} Hz",
        )  # fmt: skip

    def excess(log_f):
        return math.log(abs(response(space, step, [math.exp(log_f)], index)[0]) * math.sqrt(2) / still)

    return math.exp(_root(excess, *np.log(f[low[0] - 1 : low[0] + 1])))


def _root(f, low, high) -> float:
    """Where f is 0, to 1e-8."""
    from scipy.optimize import brentq

    return brentq(f, low, high, xtol=1e-8)


def _index(machine, axis: str) -> int:
    known = AXES if len(machine.task) == 6 else tuple(name for name, _ in machine.task)
    if axis not in known:
        raise ExperimentError("the tool has no such axis", key="axis", value=repr(axis), cure=did_you_mean(axis, known))
    return known.index(axis)
