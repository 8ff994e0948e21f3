"""What to do about a limit that is exceeded: the feed that is fit, the acceleration that is, or another place.

With V the speed along the path and a its change, at the place where the limit is exceeded most: whichever is the first
of these that helps,

    V* <= V with  use(V*, a) <= 1  here, and  use(V*, 0) <= 1  along all of the block         a slower F             (1)
    a* <= a with  use(0, a*) <= 1      a lower acceleration along the path, where (1) has no answer                  (2)

and neither where the machine cannot even stand: then the work must be clamped elsewhere.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..program.blocks import REST
from .course import state
from .demand import ACCELERATION, FORCE, POSE, Demand
from .judge import Beyond

_HALVINGS = 30
_PLACES = 33  # of a block that a slower F is asked for at
_SPARE = 1e-3  # kept below what is fit, so that the number as printed is fit too
ELSEWHERE = "clamp the work elsewhere: --place finds where"


def fitting(ask, high: np.ndarray) -> np.ndarray:
    """The greatest share (n,) of `high` for which `ask(value)` (n,) is at most 1, by bisection; 0 where none is."""
    low, top = np.zeros(len(high)), np.ones(len(high))
    for _ in range(_HALVINGS):
        middle = (low + top) / 2
        fits = ask(middle * high) <= 1
        low, top = np.where(fits, middle, low), np.where(fits, top, middle)
    return low


def advise(motion, demand: Demand, beyond: Sequence[Beyond]) -> list[str]:
    """What to do about each of `beyond`, in words."""
    if not beyond:
        return []
    columns = np.array([b.column for b in beyond])
    block = np.array([b.block for b in beyond])
    u, ud, udd = (np.array([getattr(b, name) for b in beyond]) for name in ("u", "ud", "udd"))
    every = np.arange(len(beyond))

    def ask(v, a):
        here = state(motion, block, u, v, a)
        return demand.uses(here.x, here.xd, here.xdd)[0][every, columns]

    zero = np.zeros(len(beyond))
    standing, starting = ask(zero, zero), ask(zero, udd)
    feed = np.minimum(fitting(lambda v: ask(v, udd), ud) * ud, _along(motion, demand, block, columns, ud)) * (
        1 - _SPARE
    )
    ramp = fitting(lambda a: ask(zero, a), udd) * np.abs(udd) * (1 - _SPARE)
    path = motion.course.path
    out = []
    for i, b in enumerate(beyond):
        j = b.block
        if demand.kinds[b.column] == POSE:
            out.append(ELSEWHERE)
        elif demand.kinds[b.column] == FORCE and standing[i] > 1:
            out.append(f"the drives cannot hold it here: {ELSEWHERE}")
        elif demand.kinds[b.column] in (ACCELERATION, FORCE) and starting[i] > 1:
            unit = "rad/s2" if path.kind[j] == REST else "m/s2"
            out.append(f"no F helps: an acceleration of {_rounded(ramp[i]):g} {unit} along the path is fit")
        else:
            turning = bool(path.turning_at_rest[j])
            number = np.degrees(feed[i]) * 60 if turning else 60e3 * feed[i]
            text = f"F{_rounded(number):g} {'deg/min' if turning else 'mm/min'} is fit"
            out.append(f"it is a rapid: with G1, {text}" if path.rapid[j] else text)
    return out


def _along(motion, demand: Demand, block, columns, ud) -> np.ndarray:
    """The greatest steady rate, at most ud (n,), at which all along blocks (n,) the limits `columns` (n,) are kept."""
    n = len(block)
    j, share = np.repeat(block, _PLACES), np.tile(np.linspace(0, 1, _PLACES), n)
    u, still = share * motion.course.path.extent[j], np.zeros(n * _PLACES)

    def ask(v):
        here = state(motion, j, u, v, still)
        return demand.uses(here.x, here.xd, here.xdd)[0][np.arange(len(j)), np.repeat(columns, _PLACES)]

    return (fitting(ask, np.repeat(ud, _PLACES)) * np.repeat(ud, _PLACES)).reshape(n, _PLACES).min(1)


def _rounded(value: float) -> float:
    """Rounded down to three digits."""
    if not value > 0:
        return 0.0
    unit = 10.0 ** (np.floor(np.log10(value)) - 2)
    return float(np.floor(value / unit) * unit)
