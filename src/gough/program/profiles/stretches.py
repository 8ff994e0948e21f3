"""The jerk-limited profile of a chain of cells: seven phases where nothing is in the way, more where caps are.

The speed has a cap in each cell, the acceleration a limit in each cell, the jerk a limit in each run between stops.
Two passes find the *nodes*, where the speed is at a cap and the acceleration is zero:

  backwards   from the end of a run a Climb (climb.py) rises through the cells.  Where it can be at a cap with a = 0
              before the cell is left behind, there is a node, and the next climb starts from it.
  forwards    the same, with the nodes as caps.  A node that the climb passes beneath, or cannot reach with a = 0, is
              none; the others stay.

Between two neighbouring nodes the profile is the forward climb tapered at the peak V, a stretch of constant V, and the
backward climb tapered at V, with the largest V for which they fit,

    r_up(V) + r_down(V) <= S                                                                                       (6)

and V at most the cap that the backward climb ended on.  docs/theory/feed.md, section 5, shows that no limit is
exceeded anywhere.
"""

from __future__ import annotations

from array import array
from math import inf
from typing import NamedTuple

import numpy as np

from .climb import Climb
from .phases import Cells


class Stretches(NamedTuple):
    """What lies between neighbouring nodes, m of them, in order.  Pieces are rows (d, v, a, j) of climbs."""

    cell: np.ndarray  # (m + 1,) at the start of which cell each begins, and n
    first: np.ndarray  # (m,) speeds at both ends
    last: np.ndarray
    top: np.ndarray  # the highest speed
    length: np.ndarray
    ups: np.ndarray  # pieces of all forward climbs, (., 4), and where those of each stretch begin and end
    up: np.ndarray  # (m, 2)
    downs: np.ndarray
    down: np.ndarray


def stretches(cells: Cells) -> Stretches:
    """The two passes over merged cells without pauses."""
    node, top, down, downs = _backwards(cells)
    return _forwards(cells, node, top, down, downs)


def _backwards(cells):
    n = len(cells.length)
    node, top = array("d", [inf]) * (n + 1), array("d", [inf]) * (n + 1)  # top: of the stretch that ends there
    down = np.zeros((n + 1, 2), np.int64)
    pieces, count = array("d"), 0
    L, V, A, J, stop = _columns(cells)
    climb, right, D = Climb(), n, 0.0

    def close(boundary, speed, cap):
        """A node at a boundary; the climb so far belongs to the stretch that ends at `right`."""
        nonlocal right, D, count
        for piece in climb.stack:
            pieces.extend(piece)
        down[right] = count, count + len(climb.stack)
        count += len(climb.stack)
        top[right], right, D = cap, boundary, 0.0
        node[boundary] = speed

    for k in range(n - 1, -1, -1):
        length, speed, a, j = L[k], V[k], A[k], J[k]
        if stop[k + 1]:
            if k + 1 < n:
                close(k + 1, 0.0, inf)
            node[k + 1], right, D = 0.0, k + 1, 0.0
            climb.start(0.0, a, j)
        elif a != climb.A:
            climb.limit(D, a)
        end = D + length
        climb.extend(end)
        if climb.beneath(end, speed):
            D = end
            continue
        reached = climb.reach(speed) if speed >= climb.speed else 0.0
        if reached > end:
            climb.touch(end, speed)
            D = end
            continue
        if reached <= D:
            if D > 0:
                close(k + 1, speed, inf)
            node[k + 1] = speed
            climb.start(speed, a, j)
        close(k, speed, speed)
        climb.start(speed, a, j)
    close(0, 0.0, inf)
    return node, top, down, np.frombuffer(pieces).reshape(-1, 4)


def _forwards(cells, node, top, down, downs):
    L, _, A, J, stop = _columns(cells)
    pieces, count = array("d"), 0
    cell, up = array("q", [0]), array("q")
    first, last, length = (array("d") for _ in range(3))
    climb, D = Climb(), 0.0
    for k in range(len(L)):
        a = A[k]
        if stop[k]:
            climb.start(0.0, a, J[k])
            D = 0.0
        elif a != climb.A:
            climb.limit(D, a)
        D += L[k]
        climb.extend(D)
        speed = 0.0 if stop[k + 1] else node[k + 1]
        if speed == inf or climb.beneath(D, speed):
            continue
        if speed > climb.speed and climb.reach(speed) > D:
            climb.touch(D, speed)
            continue
        cell.append(k + 1)
        first.append(climb.speed)
        last.append(speed)
        length.append(D)
        for piece in climb.stack:
            pieces.extend(piece)
        up.extend((count, count + len(climb.stack)))
        count += len(climb.stack)
        climb.start(speed, a, J[k])
        D = 0.0
    cell = np.frombuffer(cell, np.int64)
    return Stretches(
        cell, *(np.frombuffer(column) for column in (first, last)), np.frombuffer(top)[cell[1:]],
        np.frombuffer(length), np.frombuffer(pieces).reshape(-1, 4), np.frombuffer(up, np.int64).reshape(-1, 2),
        downs, down[cell[1:]],
    )  # fmt: skip


def _columns(cells):
    """Columns whose entries are plain numbers: a list of them would take four times the memory."""
    columns = cells.length, cells.speed, cells.acceleration, cells.jerk, cells.stop
    return [memoryview(np.ascontiguousarray(column)) for column in columns]
