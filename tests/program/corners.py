"""Random paths with corners, and distances by brute force, for the tests of blends and splines."""

from __future__ import annotations

import numpy as np

from gough.frames import rotation_of_vector_np
from gough.program.blocks import Arc, Block, Line
from gough.program.path import Path


def random_path(seed, n, kinds=("line", "arc", "helix"), tilt=0.0, size=5e-3, turn=3.0, straight=0.0):
    """A path of n blocks with turns of up to `turn` rad between them; a share `straight` of the junctions is tangent.

    The angles change by about `tilt` rad along every second block.
    """
    rng = np.random.default_rng(seed)
    at, abc, heading, blocks = np.zeros(3), np.zeros(3), np.array([1.0, 0, 0]), []
    for k in range(n):
        if rng.random() >= straight:
            heading = rotation_of_vector_np(_across(rng, heading) * rng.uniform(0, turn)) @ heading
        after = abc + tilt * rng.normal(size=3) * rng.integers(0, 2)
        kind = kinds[rng.integers(len(kinds))]
        if kind == "line":
            segment = Line(tuple(at), tuple(at + heading * size * rng.uniform(0.2, 2)))
        else:
            r, normal = size * 10 ** rng.uniform(-0.5, 1), _across(rng, heading)
            rise = r * rng.normal() * 0.3 if kind == "helix" else 0.0
            sense = rng.choice([1, -1])
            centre = at - sense * r * np.cross(heading, normal)
            segment = Arc(tuple(at), tuple(centre), tuple(normal), sense * rng.uniform(0.2, 1.5), rise)
        blocks.append(Block(segment, tuple(abc), tuple(after), 0.05, line=k + 1))
        last, first = Path(blocks[-1:]), np.zeros(1, int)
        at, heading, abc = last.point(first, last.length)[0], last.tangent(first, last.length)[0], after
    return Path(blocks)


def _across(rng, heading):
    axis = np.cross(heading, rng.normal(size=3))
    return axis / np.linalg.norm(axis)


def distance_to_chain(p, q):
    """Distances of points p (n, 3) to the chain of straight lines through q (k, 3).  (n,)."""
    out = np.full(len(p), np.inf)
    for a, b in zip(q[:-1], q[1:], strict=True):
        step = b - a
        x = np.clip((p - a) @ step / (step @ step), 0, 1)
        out = np.minimum(out, np.linalg.norm(p - a - x[:, None] * step, axis=1))
    return out


def chain_of(points, feed=0.05, abc=None, **more):
    """Blocks of straight lines through points (n, 3)."""
    points = np.asarray(points, float)
    abc = np.zeros_like(points) if abc is None else abc
    return [
        Block(Line(tuple(points[k]), tuple(points[k + 1])), tuple(abc[k]), tuple(abc[k + 1]), feed, line=k + 1, **more)
        for k in range(len(points) - 1)
    ]


def surface(n, tilt=0.0, digits=4):
    """Points (n, 3) m and angles of a wavy surface milled in rows there and back, rounded as a CAM system writes mm."""
    rows = int(np.sqrt(n / 2.5))
    y = np.linspace(0, 0.1, rows)
    points = []
    for k in range(rows):
        x = np.linspace(0, 0.1, n // rows + 1)[:: 1 - 2 * (k % 2)]
        points.append(np.stack([x, 0 * x + y[k], 0.005 * np.sin(40 * x) * np.cos(30 * y[k])], 1))
    points = np.round(np.concatenate(points) * 1e3, digits) * 1e-3
    turn = tilt * np.stack([np.sin(20 * points[:, 1]), np.cos(25 * points[:, 0]), 0 * points[:, 0]], 1)
    return points, turn
