"""The circles on a path, each with a polar plot of its own."""

from __future__ import annotations

import numpy as np

from .blocks import ARC, CircleOfPath
from .segments import dot, norm

_MOST = 32_000  # the number of a circle is logged as int16


def find_circles(path, circle_from: float) -> tuple[np.ndarray, list[int]]:
    """Number of the circle of each block, (m,), 0: none; and the first block of each circle.

    Consecutive arcs on one circle are one circle, if they turn by `circle_from` rad together.
    """
    circle, found = np.zeros(len(path), np.int16), []
    arcs = path.batches[ARC]
    blocks = np.flatnonzero(path.kind == ARC)
    if not len(blocks):
        return circle, found
    joined = np.zeros(len(blocks), bool)  # to the arc before
    joined[1:] = _on_one(path, blocks[:-1], blocks[1:])
    starts = np.flatnonzero(~joined)
    flat = arcs.rise[path.index[blocks[starts]]] == 0
    sweep = np.add.reduceat(arcs.sweep[path.index[blocks]], starts)
    stops = np.append(starts[1:], len(blocks))
    for k in np.flatnonzero(flat & ~path.rapid[blocks[starts]] & (sweep >= circle_from))[:_MOST]:
        found.append(int(blocks[starts[k]]))
        circle[blocks[starts[k] : stops[k]]] = len(found)
    return circle, found


def _on_one(path, i, j):
    """Whether the arcs of blocks j continue the circles of the blocks i, at the same feed."""
    arcs = path.batches[ARC]
    a, b = path.index[i], path.index[j]
    near = (norm(arcs.center[a] - arcs.center[b]) < 1e-7) & (np.abs(arcs.radius[a] - arcs.radius[b]) < 1e-7)
    same = (path.feed[i] == path.feed[j]) & ~path.rapid[i] & ~path.rapid[j] & (i + 1 == j)
    flat = (arcs.rise[a] == 0) & (arcs.rise[b] == 0)
    return near & same & flat & (dot(arcs.normal[a], arcs.normal[b]) > 1 - 1e-12)


def circles_of(path, found: list[int]) -> list[CircleOfPath]:
    """The circles that begin with the blocks `found`, as the path is placed."""
    arcs = path.batches[ARC]
    return [
        CircleOfPath(
            number + 1,
            int(path.line[i]),
            arcs.center[a],
            float(arcs.radius[a]),
            arcs.normal[a],
            float(path.feed[i]),
            bool(arcs.normal[a][2] > 0),
        )
        for number, i in enumerate(found)
        for a in [path.index[i]]
    ]
