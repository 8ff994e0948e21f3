"""How the time of a piece of work grows with its size: what can be tested of speed without a clock of one machine."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

TIMES = 8


def growth(make: Callable[[int], Any], work: Callable[[Any], Any], small: int) -> float:
    """How much longer `work(make(n))` takes for a size eight times `small`, in eighths: 1 is in proportion.

    The least of three times each, of processor time: what else runs on the machine makes times longer only.
    """
    return _least(work, make(TIMES * small)) / _least(work, make(small)) / TIMES


def _least(work, given):
    found = []
    for _ in range(3):
        began = time.process_time()
        work(given)
        found.append(time.process_time() - began)
    return min(found)
