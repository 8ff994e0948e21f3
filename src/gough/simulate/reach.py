"""Whether a machine can stand where a motion wants it, sample by sample, said with time and NC line."""

from __future__ import annotations

from ..errors import RunError
from ..machine.workspace import check_poses
from ..program.reference import Motion

THIN = 16  # the condition number is looked at every so many samples; the struts hardly turn meanwhile
CHUNK = 8192
MOST = 500_000  # poses that are looked at before a run; a longer motion is looked at in larger steps


def reachable(machine, motion: Motion, k: int, x, period: float) -> tuple[int, RunError | None]:
    """How many poses x (n, d), samples k ... of `motion`, are within the limits; what is wrong with the next."""
    bad = []

    def place(row):
        bad.append(row)
        line = int(motion.book(k + row, k + row + 1, period).line[0])
        return f"t = {(k + row) * period:.6g} s" + (f", NC line {line}" if line else "")

    try:
        check_poses(machine, machine.tool_pose(x), place, THIN)
    except RunError as error:
        return bad[-1], error
    return len(x), None


def check_motion(machine, motion: Motion, period: float) -> None:
    """Refuse a motion that leaves the machine's limits anywhere.

    Raises
    ------
    WorkspaceError, SingularityError
        for the first such sample, with time and NC line.
    """
    period = max(period, motion.duration / MOST)
    ticks = motion.count(period)
    for k in range(0, ticks, CHUNK):
        x = motion.sample(k, min(k + CHUNK, ticks), period).x
        _, error = reachable(machine, motion, k, x, period)
        if error is not None:
            raise error
