"""What a path refuses: numbers that are not finite, moves without length or feed, gaps, jumps of the angles."""

from __future__ import annotations

import numpy as np

from ..errors import ProgramError
from .blocks import REST
from .segments import norm, rotated

_SHORTEST = 1e-9  # m, as long as no machine can resolve: shorter moves have no direction
_LONGEST = 1e6  # m of a whole path: a month at a metre a second, and where 0.1 nm are still told apart


def check(path, abc1) -> None:
    """Refuse what cannot be run; abc1 (m, 3) are the angles at the blocks' ends.

    Raises
    ------
    ProgramError
        with the NC line of the first such block.
    """
    if not len(path):
        raise ProgramError("a path has at least one block")
    _check_numbers(path)
    every = np.arange(len(path))
    first, last = path.point(every, np.zeros(len(path))), path.point(every, path.length)
    # with another tool the tip stands elsewhere while the machine stays: T is where it was
    changed = np.flatnonzero((path.tool[1:] != path.tool[:-1]).any(1))
    if len(changed):
        last[changed] += rotated(path.rotation(abc1[changed]), path.tool[changed] - path.tool[changed + 1])
    gap = norm(first[1:] - last[:-1])
    wrong = np.flatnonzero(~(gap <= 1e-9 + 1e-12 * np.abs(last[:-1]).max(1)))  # rounding of long paths
    if len(wrong):
        raise ProgramError(
            "a block must start where the last one ended",
            value=f"a gap of {gap[wrong[0]]:.3g} m",
            line=_line(path, wrong[0] + 1),
        )
    jump = np.abs(path.abc0[1:] - abc1[:-1]).max(1, initial=0.0)
    if (jump > 1e-9).any():
        i = int(np.argmax(jump)) + 1
        raise ProgramError("a block must start with the angles the last one ended with", line=_line(path, i))


def _check_numbers(path):
    numbers = np.column_stack(
        [path.length, path.extent, path.turn, path.abc0, path.feed, path.dwell, path.tool, path.spindle]
    )
    wrong = np.flatnonzero(~np.isfinite(numbers).all(1))
    if len(wrong):
        raise ProgramError("a block must have finite numbers", line=_line(path, wrong[0]))
    moves = path.kind != REST
    wrong = np.flatnonzero(moves & (path.length < _SHORTEST))
    if len(wrong):
        i = wrong[0]
        raise ProgramError("a move has no length", value=f"{path.length[i]:.3g} m", line=_line(path, i))
    total = path.s0[1:]
    if not total[-1] <= _LONGEST:
        i = int(np.argmax(~(total <= _LONGEST)))
        raise ProgramError("a path is at most 1000 km long", value=f"{total[-1] / 1e3:.6g} km", line=_line(path, i))
    slow = np.flatnonzero(~path.rapid & (moves | path.turning_at_rest) & ~(path.feed > 0))
    if len(slow):
        raise ProgramError("the feed must be above 0", value=f"{path.feed[slow[0]]:g}", line=_line(path, slow[0]))


def _line(path, i):
    return int(path.line[i]) or None


def check_upright(path, machine) -> None:
    """Refuse a path that turns the tool, or takes a tool of its own, on a machine whose tilt follows from the place.

    Raises
    ------
    ProgramError
        with the first such line.
    """
    every = np.arange(len(path))
    turning = (np.abs(path.angle_rate(every, np.zeros(len(path)))) > 0).any(1) | path.turning_at_rest
    rules = (
        (
            turning,
            f"{machine.name} cannot turn its tool: tilt and turn follow from the place",
            "leave A, B and C alone",
        ),
        (
            path.tool.any(1),
            f"a tool offset needs the axis of the tool, which {machine.name} tilts by itself",
            "leave G43 out",
        ),
    )
    for bad, rule, cure in rules:
        if bad.any():
            raise ProgramError(rule, line=int(path.line[np.argmax(bad)]) or None, cure=cure)


def check_one_axis(path, machine) -> None:
    """Refuse a path that leaves the line of a machine of one axis, x.

    Raises
    ------
    ProgramError
        with the first such line.
    """
    every, moving = np.arange(len(path)), path.length > 0
    across = np.zeros(len(path), bool)
    for share in (0.0, 0.25, 0.5, 1.0):  # an arc that runs along x somewhere does not do so everywhere
        across |= moving & (np.abs(path.tangent(every, share * path.length)[:, 1:]) > 1e-9).any(1)
    if across.any():
        raise ProgramError(
            f"{machine.name} has one axis and moves along X only",
            line=int(path.line[np.argmax(across)]) or None, cure="leave Y and Z as they are",
        )  # fmt: skip
