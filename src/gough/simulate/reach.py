"""Whether a machine can stand where a motion wants it, sample by sample, said with time and NC line.

Stroke, cones and singularities end a run; the declared workspace and a poor condition number are warned of, once each.
"""

from __future__ import annotations

import numpy as np

from ..errors import RunError, SingularityError
from ..machine.workspace import check_poses, outside_workspace, workspace_margins
from ..program.reference import Motion
from .notes import Notes, ReachWarning

THIN = 16  # what changes slowly along a path is looked at every so many samples
CHUNK = 8192
MOST = 500_000  # poses that are looked at before a run; a longer motion is looked at in larger steps


class Reach:
    """Looks at the poses of one motion, chunk by chunk."""

    def __init__(self, machine, motion: Motion, period: float, notes: Notes | None = None):
        self.machine, self.motion, self.period = machine, motion, period
        self.notes = Notes() if notes is None else notes
        self._warned: set[str] = set()

    def of(self, k: int, x) -> tuple[int, RunError | None]:
        """How many poses x (n, d), samples k ..., are within the limits; what is wrong with the next."""
        bad = []

        def place(row):
            bad.append(row)
            return self._place(k + row)

        try:
            row, number = check_poses(self.machine, x, place, THIN)
        except RunError as error:
            return bad[-1], error
        limit = self.machine.limits.condition_warning
        if number > limit:
            rule = "near a singularity: condition number of J"
            self._warn(
                rule, SingularityError(rule, where=self._place(k + row), value=f"{number:.3g}", limit=f"{limit:g}")
            )
        self._within_workspace(k, x[::THIN])
        return len(x), None

    def _within_workspace(self, k, x):
        found = workspace_margins(self.machine, self.machine.standing(x))
        for index in np.flatnonzero((found < 0).any(0)):
            row = int(np.argmax(found[:, index] < 0))
            error = outside_workspace(self.machine, int(index), found[row, index], self._place(k + row * THIN))
            self._warn(error.problems[0].rule, error)

    def _warn(self, what: str, error: RunError):
        if what not in self._warned:
            self._warned.add(what)
            self.notes.warn(str(error), ReachWarning)

    def _place(self, k):
        line = int(self.motion.book(k, k + 1, self.period).line[0])
        return f"t = {k * self.period:.6g} s" + (f", NC line {line}" if line else "")


def check_motion(machine, motion: Motion, period: float) -> None:
    """Refuse a motion that leaves the machine's limits anywhere; warn where it leaves the declared workspace.

    Raises
    ------
    WorkspaceError, SingularityError
        for the first such sample, with time and NC line.
    """
    period = max(period, motion.duration / MOST)
    reach, ticks = Reach(machine, motion, period), motion.count(period)
    for k in range(0, ticks, CHUNK):
        _, error = reach.of(k, motion.sample(k, min(k + CHUNK, ticks), period).x)
        if error is not None:
            raise error
